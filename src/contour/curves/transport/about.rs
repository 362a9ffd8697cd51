//! The surroundings of a vertex: what other edges there would cost.

use super::ears::Ears;
use super::ends::{Ends, Nearness, is_left_turn, squared};
use super::load::{Cost, Load};
use super::planar::{HalfEdge, Planar, next};
use super::star::Star;
use crate::{PlaceMm, SampleId};

/// Triangles within a ring, and the edges between them, by indices into the ring.
#[derive(Default)]
pub(super) struct Filling {
    pub(super) triangles: Vec<[usize; 3]>,
    /// Smaller index first; of a vertex that moves twice the index of each spoke.
    pub(super) inner: Vec<[usize; 2]>,
    open: Vec<usize>,
    ears: Ears,
}

/// A point of the surroundings, and the side of the ring that it is nearest to; of a point on a side that side.
struct Point {
    sample: SampleId,
    place: PlaceMm,
    nearness: Nearness,
    side: Option<usize>,
}

/// The surroundings of a vertex, with memory to work in.
pub(super) struct About<'a> {
    planar: &'a Planar,
    vertex: SampleId,
    place: PlaceMm,
    ring: Vec<u32>,
    spokes: Vec<HalfEdge>,
    /// The sides of the ring; none that end in a corner of the square.
    sides: Vec<Option<Ends>>,
    /// The points of the spokes and of the vertex, then those of the sides.
    points: Vec<Point>,
    /// How many of them lie on no side.
    loose: usize,
    before_mm2: f64,
    edges: Vec<Option<Ends>>,
    /// The points of each edge within, then of each side whose points become others, after the last change that was tried.
    carried: Vec<Vec<PlaceMm>>,
    /// The edge that each point goes to.
    goes_to: Vec<usize>,
    is_changed: Vec<bool>,
    feet: Vec<f64>,
}

impl<'a> About<'a> {
    pub(super) fn new(planar: &'a Planar) -> About<'a> {
        About {
            planar,
            vertex: 0,
            place: [0.0; 2],
            ring: Vec::new(),
            spokes: Vec::new(),
            sides: Vec::new(),
            points: Vec::new(),
            loose: 0,
            before_mm2: 0.0,
            edges: Vec::new(),
            carried: Vec::new(),
            goes_to: Vec::new(),
            is_changed: Vec::new(),
            feet: Vec::new(),
        }
    }

    /// The vertices about the vertex, counter-clockwise.
    pub(super) fn ring(&self) -> &[u32] {
        &self.ring
    }

    /// Takes up the surroundings of a vertex.
    pub(super) fn turn_to(&mut self, vertex: SampleId) {
        let planar = self.planar;
        self.vertex = vertex;
        self.place = planar.place(vertex);
        planar.spokes(vertex, &mut self.spokes);
        self.ring.clear();
        self.ring.extend(self.spokes.iter().map(|&spoke| planar.origin(next(spoke))));
        let count = self.ring.len();
        self.sides.clear();
        for index in 0..count {
            let ends = [index, (index + 1) % count].map(|index| self.ring[index]);
            let is_inside = !ends.iter().any(|&end| planar.is_corner(end));
            let [p, q] = ends.map(|end| planar.place(end));
            self.sides.push(is_inside.then(|| Ends::new(p, q)));
        }
        self.points.clear();
        self.before_mm2 = 0.0;
        let own = planar.has_own(vertex).then_some(vertex);
        let on_spokes = self.spokes.iter().flat_map(|&spoke| planar.load(spoke).samples.iter());
        for sample in on_spokes.copied().chain(own) {
            let place = planar.points()[sample as usize];
            let (mut nearness, mut side) = (Nearness::FAR, None);
            for (index, ends) in self.sides.iter().enumerate() {
                if let Some(nearer) = ends.as_ref().and_then(|ends| ends.nearer(place, &nearness)) {
                    (nearness, side) = (nearer, Some(index));
                }
            }
            self.points.push(Point { sample, place, nearness, side });
        }
        self.loose = self.points.len();
        for (side, &spoke) in self.spokes.iter().enumerate() {
            let load = planar.load(next(spoke));
            self.before_mm2 += planar.load(spoke).cost_mm2 + load.cost_mm2;
            let Some(ends) = &self.sides[side] else { continue };
            self.points.extend(load.samples.iter().map(|&sample| {
                let place = planar.points()[sample as usize];
                Point { sample, place, nearness: ends.nearness(place), side: Some(side) }
            }));
        }
    }

    /// Lets the vertex lie elsewhere.
    pub(super) fn move_to(&mut self, place: PlaceMm) {
        self.place = place;
    }

    /// Fills the ring from one of its vertices, for which corners that it does not see are cut off before; false if that cannot be.
    pub(super) fn fill(&self, first: usize, filling: &mut Filling) -> bool {
        let count = self.ring.len();
        let Filling { triangles, inner, open, ears } = filling;
        triangles.clear();
        inner.clear();
        open.clear();
        let index = |corner: usize| (first + corner) % count;
        let at = |corner: usize| self.planar.place(self.ring[index(corner)]);
        let from = at(0);
        if (2..count).all(|corner| is_left_turn(from, at(corner - 1), at(corner))) {
            open.extend((0..count).map(index));
        } else {
            // The edge to a corner is flipped.
            let is_seen = ears.cut(count, self.place, at, |corners| {
                let [a, b, c] = corners.map(index);
                triangles.push([a, b, c]);
                inner.push([a.min(c), a.max(c)]);
            });
            if !is_seen {
                return false;
            }
            open.extend(ears.left().map(index));
        }
        for (index, ends) in open[1..].windows(2).enumerate() {
            triangles.push([first, ends[0], ends[1]]);
            if index > 0 {
                inner.push([first.min(ends[0]), first.max(ends[0])]);
            }
        }
        inner.iter().all(|ends| self.planar.is_new(self.ring[ends[0]], self.ring[ends[1]]))
    }

    /// The ends of an edge within the ring, or of a spoke.
    fn ends(&self, [a, b]: [usize; 2]) -> Option<Ends> {
        let [p, q] = [self.ring[a], self.ring[b]];
        if self.planar.is_corner(p) || self.planar.is_corner(q) {
            return None;
        }
        let from = if a == b { self.place } else { self.planar.place(p) };
        Some(Ends::new(from, self.planar.place(q)))
    }

    /// What edges within the ring instead of the spokes add to the cost in mm²; none if that is more than `most_mm2`, or if no edge could
    /// take the points.
    pub(super) fn added_mm2(&mut self, inner: &[[usize; 2]], most_mm2: f64) -> Option<f64> {
        let mut edges = std::mem::take(&mut self.edges);
        edges.clear();
        edges.extend(inner.iter().map(|&ends| self.ends(ends)));
        let added_mm2 = self.distributed_mm2(&edges, most_mm2);
        self.edges = edges;
        added_mm2
    }

    fn distributed_mm2(&mut self, inner: &[Option<Ends>], most_mm2: f64) -> Option<f64> {
        let bound_mm2 = most_mm2 + self.before_mm2 + self.planar.unit_mm2();
        self.is_changed.clear();
        self.is_changed.resize(self.sides.len(), false);
        self.goes_to.clear();
        // No point costs less than the square of its distance.
        let mut least_mm2 = 0.0;
        for (number, point) in self.points.iter().enumerate() {
            let mut nearest = (point.nearness, point.side.map(|side| inner.len() + side));
            for (index, ends) in inner.iter().enumerate() {
                let nearer = ends.as_ref().and_then(|ends| ends.nearer(point.place, &nearest.0));
                if let Some(nearness) = nearer {
                    nearest = (nearness, Some(index));
                }
            }
            let index = nearest.1?;
            least_mm2 += nearest.0.squared_mm2;
            if least_mm2 > bound_mm2 {
                return None;
            }
            // A loose point changes the side that it goes to, a point of a side that which it leaves.
            if let Some(side) = point.side
                && (number < self.loose) == (index >= inner.len())
            {
                self.is_changed[side] = true;
            }
            self.goes_to.push(index);
        }
        let count = inner.len() + self.sides.len();
        if self.carried.len() < count {
            self.carried.resize_with(count, Vec::new);
        }
        self.carried[..count].iter_mut().for_each(Vec::clear);
        for (point, &index) in self.points.iter().zip(&self.goes_to) {
            if index < inner.len() || self.is_changed[index - inner.len()] {
                self.carried[index].push(point.place);
            }
        }
        let mut added_mm2 = -self.before_mm2;
        for (index, ends) in inner.iter().chain(&self.sides).enumerate() {
            let Some(ends) = ends else { continue };
            if index < inner.len() || self.is_changed[index - inner.len()] {
                let carried = self.carried[index].iter().copied();
                added_mm2 += Cost::of(ends, carried, &mut self.feet).least_mm2();
            } else {
                added_mm2 += self.planar.load(next(self.spokes[index - inner.len()])).cost_mm2;
            }
        }
        Some(added_mm2)
    }

    /// The place of least squares for the points on the spokes; none without points.
    pub(super) fn wanted(&self) -> Option<PlaceMm> {
        let points = self.planar.points();
        let (mut sum, mut weight) = ([0.0; 2], 0.0);
        let mut add = |share: f64, place: PlaceMm, other: PlaceMm| {
            // A point whose foot lies this share of the way to the other end.
            let own = 1.0 - share;
            for axis in 0..2 {
                sum[axis] += own * (place[axis] - share * other[axis]);
            }
            weight += own * own;
        };
        for (&spoke, &other) in self.spokes.iter().zip(&self.ring) {
            let load = self.planar.load(spoke);
            let far = self.planar.place(other);
            let ends = Ends::new(self.place, far);
            for place in load.samples.iter().map(|&sample| points[sample as usize]) {
                if load.is_along {
                    add((ends.along_mm(place) / ends.length_mm).clamp(0.0, 1.0), place, far);
                } else if squared(place, self.place) <= squared(place, far) {
                    add(0.0, place, far);
                }
            }
        }
        if self.planar.has_own(self.vertex) {
            add(0.0, points[self.vertex as usize], self.place);
        }
        (weight > 0.0).then(|| sum.map(|sum| sum / weight))
    }

    /// The change that was tried last.
    pub(super) fn star(self, filling: Filling, added_mm2: f64) -> Star {
        let ends = filling.inner.iter().map(|&ends| self.ends(ends));
        let edges: Vec<Option<Ends>> = ends.chain(self.sides.iter().copied()).collect();
        let mut samples: Vec<Vec<SampleId>> = vec![Vec::new(); edges.len()];
        for (point, &index) in self.points.iter().zip(&self.goes_to) {
            samples[index].push(point.sample);
        }
        let loads = edges.iter().zip(samples).map(|(ends, samples)| match ends {
            Some(ends) => Load::new(ends, samples, self.planar.points()),
            None => Load::default(),
        });
        let loads = loads.collect();
        Star {
            vertex: self.vertex,
            place: self.place,
            ring: self.ring,
            spokes: self.spokes,
            triangles: filling.triangles,
            inner: filling.inner,
            loads,
            is_changed: self.is_changed,
            added_mm2,
        }
    }
}
