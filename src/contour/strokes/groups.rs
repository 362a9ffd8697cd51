//! Triangles that belong together, and their labels.

use asphera_geometry::predicates::compare_with_right_angle;

use super::hints::{Found, Hint, HintError, find};
use crate::Triangulation;
use crate::graphs::Sets;
use crate::triangulation::{EdgeId, TriangleId};

/// Sets of triangles; the last member is what lies beyond the hull. The label of a set is that of the member that stands for it.
pub(super) struct Groups<'a> {
    triangulation: &'a Triangulation,
    sets: Sets,
    labels: Vec<Option<u32>>,
}

impl<'a> Groups<'a> {
    /// Each triangle alone, and label 0 beyond the hull.
    pub(super) fn new(triangulation: &'a Triangulation) -> Groups<'a> {
        let count = triangulation.triangles().len();
        let mut labels = vec![None; count + 1];
        labels[count] = Some(0);
        Groups { triangulation, sets: Sets::new(count + 1), labels }
    }

    /// The members on both sides of an edge.
    fn sides(&self, edge: EdgeId) -> [u32; 2] {
        let beyond = self.labels.len() as u32 - 1;
        let triangles = self.triangulation.edges()[edge as usize].triangles();
        triangles.map(|triangle| triangle.unwrap_or(beyond))
    }

    /// Joins the sets beside an edge, unless they have two labels.
    fn join(&mut self, edge: EdgeId) {
        let [p, q] = self.sides(edge).map(|member| self.sets.of(member));
        let labels = [self.labels[p as usize], self.labels[q as usize]];
        if matches!(labels, [Some(one), Some(other)] if one != other) {
            return;
        }
        self.sets.join(p, q);
        let root = self.sets.of(p);
        self.labels[root as usize] = labels[0].or(labels[1]);
    }

    /// Joins across all edges longer than `gap_mm`.
    pub(super) fn join_above(&mut self, gap_mm: f64) {
        self.paint(0.0, gap_mm);
    }

    /// Lets labels spread across edges longer than `gap_mm`, the longest first; an edge between two triangles without a side above
    /// `brush_mm` counts as that long.
    pub(super) fn paint(&mut self, brush_mm: f64, gap_mm: f64) {
        let triangulation = self.triangulation;
        let is_long = |edge: &EdgeId| triangulation.length_mm(*edge) > brush_mm;
        let is_small = |triangle: Option<TriangleId>| {
            triangle.is_some_and(|it| !triangulation.sides(it).iter().any(is_long))
        };
        let lies_between_small = |edge: &EdgeId| {
            let triangles = triangulation.edges()[*edge as usize].triangles();
            triangles.into_iter().all(is_small)
        };
        let longest_first = || triangulation.by_length().iter().rev().copied();
        let long = longest_first().filter(is_long);
        let brushed = longest_first().filter(|edge| !is_long(edge) && lies_between_small(edge));
        let other = longest_first().filter(|edge| !is_long(edge) && !lies_between_small(edge));
        let order: Vec<EdgeId> = if brush_mm > 0.0 {
            long.chain(brushed).chain(other).collect()
        } else {
            longest_first().collect()
        };
        for edge in order {
            if triangulation.length_mm(edge) > gap_mm {
                self.join(edge);
            }
        }
    }

    /// Numbers, from 1, the sets that hold a wanted triangle and have no label, by their first such triangle; says how many.
    pub(super) fn seed_where(&mut self, is_wanted: impl Fn(TriangleId) -> bool) -> u32 {
        let mut count = 0;
        for triangle in 0..self.labels.len() as u32 - 1 {
            let root = self.sets.of(triangle) as usize;
            if self.labels[root].is_none() && is_wanted(triangle) {
                count += 1;
                self.labels[root] = Some(count);
            }
        }
        count
    }

    /// Gives the triangles of hints their labels, numbered from 1 by their first hints; gives the labels. A hint beyond the hull names what lies there.
    pub(super) fn seed(
        &mut self,
        triangulation: &Triangulation,
        hints: &[Hint],
    ) -> Result<Vec<String>, HintError> {
        if hints.is_empty() {
            return Err(HintError::None);
        }
        let mut names: Vec<String> = Vec::new();
        let beyond = self.labels.len() - 1;
        for (hint, number) in hints.iter().zip(1..) {
            let at_mm = hint.at_mm;
            let member = match find(triangulation, at_mm) {
                Found::Within(triangle) => triangle as usize,
                Found::Beyond => beyond,
                Found::OnLine => return Err(HintError::OnLine { number, at_mm }),
            };
            let known = names.iter().position(|name| *name == hint.label);
            let label = known.unwrap_or_else(|| {
                names.push(hint.label.clone());
                names.len() - 1
            });
            let label = label as u32 + 1;
            match self.labels[member].filter(|&other| other != 0 && other != label) {
                Some(other) => {
                    let expected = names[other as usize - 1].clone();
                    let found = hint.label.clone();
                    return Err(HintError::TwoLabels { number, found, expected });
                }
                None => self.labels[member] = Some(label),
            }
        }
        Ok(names)
    }

    /// The label of each triangle.
    pub(super) fn labels(&self) -> Vec<Option<u32>> {
        let members = 0..self.labels.len() as u32 - 1;
        members.map(|member| self.labels[self.sets.find(member) as usize]).collect()
    }
}

/// Whether no angle of a triangle is above 90° and its area is above the square of a length.
pub(super) fn is_fat(triangulation: &Triangulation, triangle: TriangleId, mask_mm: f64) -> bool {
    let corners = triangulation.triangles()[triangle as usize];
    let [a, b, c] = corners.map(|corner| triangulation.place(corner));
    let is_obtuse = [(a, b, c), (b, c, a), (c, a, b)]
        .into_iter()
        .any(|(at, p, q)| compare_with_right_angle(at, p, q).is_lt());
    let doubled_mm2 = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    !is_obtuse && 0.5 * doubled_mm2 > mask_mm * mask_mm
}
