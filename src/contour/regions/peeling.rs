//! Peeling: triangles go one by one from the border of a region inwards, by an order and a rule.

use std::collections::{BTreeMap, BinaryHeap};

use crate::inside::Inside;
use crate::triangulation::{EdgeId, TriangleId};
use crate::{Graph, Region, SampleId, Triangulation};

/// A region that is being peeled.
pub(super) struct Peeling<'a> {
    triangulation: &'a Triangulation,
    inside: Inside,
    is_on_border: Vec<bool>,
    removed: Vec<TriangleId>,
}

/// A triangle that can go and leave the region regular: exactly one of its sides lies on the border, and the corner opposite does
/// not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ear {
    pub(super) triangle: TriangleId,
    /// Its side on the border.
    pub(super) side: EdgeId,
    /// The corner opposite.
    pub(super) apex: SampleId,
}

/// What a rule says of an ear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It goes.
    Go,
    /// It stays.
    Stay,
    /// It stays as long as another triangle does.
    StayWith(TriangleId),
}

impl<'a> Peeling<'a> {
    /// All triangles: the border is the convex hull.
    pub(super) fn new(triangulation: &'a Triangulation) -> Peeling<'a> {
        let mut is_on_border = vec![false; triangulation.len()];
        for edge in triangulation.edges().iter().filter(|edge| edge.triangles().contains(&None)) {
            for end in edge.ends {
                is_on_border[end as usize] = true;
            }
        }
        let inside = Inside::of(vec![true; triangulation.triangles().len()]);
        Peeling { triangulation, inside, is_on_border, removed: Vec::new() }
    }

    /// Whether a triangle is still there.
    pub(super) fn holds(&self, triangle: TriangleId) -> bool {
        self.inside.holds(Some(triangle))
    }

    /// Whether a sample lies on the border.
    pub(super) fn is_on_border(&self, sample: SampleId) -> bool {
        self.is_on_border[sample as usize]
    }

    /// The sides of the hull.
    pub(super) fn hull(&self) -> Vec<EdgeId> {
        let edges = (0..).zip(self.triangulation.edges());
        edges.filter(|(_, edge)| edge.triangles().contains(&None)).map(|(id, _)| id).collect()
    }

    /// Takes ears off, that of the side with the largest key first, until the rule lets none go.
    ///
    /// Sides come into a queue when they become border, first those given. An ear that stays is asked about again only where the
    /// rule named a triangle, once that is gone. n·log n time, and that of the rule.
    pub(super) fn peel<K: Ord>(
        &mut self,
        sides: impl IntoIterator<Item = EdgeId>,
        key: impl Fn(EdgeId, TriangleId) -> K,
        rule: impl Fn(&Peeling, Ear) -> Verdict,
    ) {
        let mut queue = BinaryHeap::new();
        let mut waiting: BTreeMap<TriangleId, Vec<EdgeId>> = BTreeMap::new();
        let offer = |queue: &mut BinaryHeap<_>, peeling: &Peeling, side: EdgeId| {
            // Who lies on the border stays there, so what is no ear never becomes one.
            if let Some(ear) = peeling.ear(side) {
                queue.push((key(side, ear.triangle), side));
            }
        };
        for side in sides {
            offer(&mut queue, self, side);
        }
        while let Some((_, side)) = queue.pop() {
            let Some(ear) = self.ear(side) else { continue };
            match rule(self, ear) {
                Verdict::Stay => {}
                Verdict::StayWith(triangle) => waiting.entry(triangle).or_default().push(side),
                Verdict::Go => {
                    self.remove(ear.triangle);
                    let opened = self.triangulation.sides(ear.triangle);
                    let freed = waiting.remove(&ear.triangle).unwrap_or_default();
                    for side in opened.into_iter().chain(freed) {
                        offer(&mut queue, self, side);
                    }
                }
            }
        }
    }

    /// Takes a triangle out, wherever it lies.
    pub(super) fn remove(&mut self, triangle: TriangleId) {
        self.inside.set(triangle, false);
        self.removed.push(triangle);
        for corner in self.triangulation.triangles()[triangle as usize] {
            self.is_on_border[corner as usize] = true;
        }
    }

    /// How many triangles were taken out.
    pub(super) fn removed(&self) -> usize {
        self.removed.len()
    }

    /// The triangles that were taken out after the first `count`.
    pub(super) fn removed_after(&self, count: usize) -> &[TriangleId] {
        &self.removed[count..]
    }

    /// Puts back all that was taken out after the first `count`, if that was within the region: its samples leave the border
    /// unless they lay on it before.
    pub(super) fn restore(&mut self, count: usize, was_on_border: impl Fn(SampleId) -> bool) {
        for triangle in self.removed.split_off(count) {
            self.inside.set(triangle, true);
            for corner in self.triangulation.triangles()[triangle as usize] {
                self.is_on_border[corner as usize] = was_on_border(corner);
            }
        }
    }

    /// The triangle within the region at a side of its border.
    fn within(&self, side: EdgeId) -> Option<TriangleId> {
        let [left, right] = self.triangulation.edges()[side as usize].triangles();
        match [left, right].map(|triangle| self.inside.holds(triangle)) {
            [true, false] => left,
            [false, true] => right,
            _ => None,
        }
    }

    /// The ear at a side of the border.
    fn ear(&self, side: EdgeId) -> Option<Ear> {
        let triangle = self.within(side)?;
        let beyond = self.triangulation.across(triangle);
        let open = beyond.into_iter().filter(|&beyond| !self.inside.holds(beyond)).count();
        let ends = self.triangulation.ends(side);
        let corners = self.triangulation.triangles()[triangle as usize];
        let apex = corners.into_iter().find(|corner| !ends.contains(corner))?;
        (open == 1 && !self.is_on_border(apex)).then_some(Ear { triangle, side, apex })
    }

    /// The border of what is left.
    pub(super) fn border(&self) -> Graph {
        Graph::of_edges(self.triangulation, |edge| self.inside.is_border(self.triangulation, edge))
    }

    /// What is left.
    pub(super) fn region(&self) -> Region {
        Region::of(self.triangulation, &self.inside)
    }
}
