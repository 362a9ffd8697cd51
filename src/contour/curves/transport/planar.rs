//! The triangulation in which edges collapse, within a wide square.

use super::ends::{is_left_turn, squared};
use super::load::Load;
use super::star::Star;
use crate::{PlaceMm, SampleId, Triangulation};

/// Number of a half-edge: 3·triangle + side.
pub(super) type HalfEdge = u32;

/// Triangles that fill a square about the samples. Samples come first among the vertices, the corners of the square last.
///
/// Places count from the middle of the samples, so that a place far from the origin costs nothing.
pub(super) struct Planar {
    points: Vec<PlaceMm>,
    given: Vec<PlaceMm>,
    middle: PlaceMm,
    /// Costs are compared in whole numbers of this.
    unit_mm2: f64,
    places: Vec<PlaceMm>,
    origins: Vec<u32>,
    /// The other half of each half-edge; none on the square.
    twins: Vec<Option<HalfEdge>>,
    load_of: Vec<u32>,
    loads: Vec<Load>,
    /// A half-edge that leaves each vertex; none of one that is gone.
    leaving: Vec<Option<HalfEdge>>,
    /// Whether the sample of the same number still lies on its vertex.
    has_own: Vec<bool>,
    /// Whether rounding left a triangle without an area: then places do not tell which edges are there.
    is_doubtful: bool,
}

impl Planar {
    pub(super) fn new(triangulation: &Triangulation) -> Planar {
        let given = triangulation.samples().places().to_vec();
        let range = |axis: usize| {
            let values = given.iter().map(|place| place[axis]);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)])
        };
        let [x, y] = [range(0), range(1)];
        let is_empty = given.is_empty();
        let middle = if is_empty { [0.0; 2] } else { [x, y].map(|[l, h]| 0.5 * (l + h)) };
        let extent_mm = if is_empty { 0.0 } else { (x[1] - x[0]).max(y[1] - y[0]) };
        let points: Vec<PlaceMm> =
            given.iter().map(|[x, y]| [x - middle[0], y - middle[1]]).collect();
        let far = 2.0 * extent_mm;
        let mut places = points.clone();
        places.extend([[-far, -far], [far, -far], [far, far], [-far, far]]);
        let triangles = framed(triangulation);
        let unit_mm2 = power_of_two(extent_mm * extent_mm) * 2_f64.powi(-46);
        let count = points.len();
        let mut planar = Planar {
            points,
            given,
            middle,
            unit_mm2,
            places,
            origins: triangles.as_flattened().to_vec(),
            twins: Vec::new(),
            load_of: Vec::new(),
            loads: Vec::new(),
            leaving: vec![None; count + 4],
            has_own: vec![true; count],
            is_doubtful: false,
        };
        planar.is_doubtful = !triangles.iter().all(|corners| {
            let [a, b, c] = corners.map(|corner| planar.place(corner));
            is_left_turn(a, b, c)
        });
        planar.wire();
        planar
    }

    /// Finds the twins, and gives each edge its load.
    fn wire(&mut self) {
        let count = self.origins.len() as HalfEdge;
        self.twins = vec![None; count as usize];
        self.load_of = vec![0; count as usize];
        let mut sides: Vec<([u32; 2], HalfEdge)> = (0..count)
            .map(|half| {
                let [p, q] = [self.origin(half), self.origin(next(half))];
                ([p.min(q), p.max(q)], half)
            })
            .collect();
        sides.sort_unstable();
        for same in sides.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, first), (_, second)] = same {
                self.twins[first as usize] = Some(second);
                self.twins[second as usize] = Some(first);
            }
            for &(_, half) in same {
                self.load_of[half as usize] = self.loads.len() as u32;
            }
            self.loads.push(Load::default());
        }
        for half in 0..count {
            self.leaving[self.origins[half as usize] as usize] = Some(half);
        }
    }

    /// How many samples there are, and so the number of the first corner of the square.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    pub(super) fn is_corner(&self, vertex: u32) -> bool {
        vertex as usize >= self.points.len()
    }

    pub(super) fn is_there(&self, vertex: SampleId) -> bool {
        self.leaving[vertex as usize].is_some()
    }

    pub(super) fn place(&self, vertex: u32) -> PlaceMm {
        self.places[vertex as usize]
    }

    /// The samples, by their numbers, as places count here.
    pub(super) fn points(&self) -> &[PlaceMm] {
        &self.points
    }

    pub(super) fn has_own(&self, vertex: SampleId) -> bool {
        self.has_own[vertex as usize]
    }

    pub(super) fn origin(&self, half: HalfEdge) -> u32 {
        self.origins[half as usize]
    }

    pub(super) fn load(&self, half: HalfEdge) -> &Load {
        &self.loads[self.load_of[half as usize] as usize]
    }

    pub(super) fn unit_mm2(&self) -> f64 {
        self.unit_mm2
    }

    /// A cost or squared length in whole units: what differs by rounding alone is equal.
    pub(super) fn whole(&self, value_mm2: f64) -> i64 {
        (value_mm2 / self.unit_mm2).round() as i64
    }

    /// Lists the half-edges that leave a vertex, counter-clockwise.
    pub(super) fn spokes(&self, vertex: u32, spokes: &mut Vec<HalfEdge>) {
        spokes.clear();
        let Some(first) = self.leaving[vertex as usize] else { return };
        let mut half = first;
        loop {
            spokes.push(half);
            match self.twins[before(half) as usize] {
                Some(turned) if turned != first => half = turned,
                _ => return,
            }
        }
    }

    /// Whether a new edge is certain to be none that is there already.
    pub(super) fn is_new(&self, from: u32, to: u32) -> bool {
        if !self.is_doubtful {
            return true;
        }
        // Corners of the square have a side without a triangle beyond, so the other end is asked.
        let [at, other] = if self.is_corner(from) { [to, from] } else { [from, to] };
        if self.is_corner(at) {
            return false;
        }
        let mut spokes = Vec::new();
        self.spokes(at, &mut spokes);
        !spokes.iter().any(|&half| self.origin(next(half)) == other)
    }

    /// The square of the length of an edge, and of the distance from its first end to the nearest other neighbour.
    pub(super) fn spacing_mm2(&self, from: SampleId, to: SampleId) -> [f64; 2] {
        let at = self.place(from);
        let mut spokes = Vec::with_capacity(8);
        self.spokes(from, &mut spokes);
        let others = spokes.into_iter().map(|half| self.origin(next(half)));
        let others = others.filter(|&other| other != to && !self.is_corner(other));
        let nearest = others.map(|other| squared(at, self.place(other)));
        [squared(at, self.place(to)), nearest.fold(f64::MAX, f64::min)]
    }

    /// The vertices where they are now, of those that are gone the samples; in mm.
    pub(super) fn samples_mm(&self) -> Vec<PlaceMm> {
        let at = |sample: usize| match self.places[sample] == self.points[sample] {
            true => self.given[sample],
            false => {
                [self.places[sample][0] + self.middle[0], self.places[sample][1] + self.middle[1]]
            }
        };
        (0..self.points.len()).map(at).collect()
    }

    /// The edges that carry points, with their ends.
    pub(super) fn loaded(&self) -> impl Iterator<Item = ([SampleId; 2], &Load)> {
        (0..self.origins.len() as HalfEdge).filter_map(|half| {
            let ends = [self.origin(half), self.origin(next(half))];
            let is_first = self.twins[half as usize].is_some_and(|twin| half < twin);
            let load = self.load(half);
            let is_used = is_first && self.is_used(half) && !load.samples.is_empty();
            is_used.then_some((ends, load))
        })
    }

    /// Whether a triangle is still one of the triangulation.
    fn is_used(&self, half: HalfEdge) -> bool {
        let twin = self.twins[half as usize];
        twin.is_some_and(|twin| self.twins[twin as usize] == Some(half))
    }

    /// Takes a vertex out as a star says, and gives the vertices about which costs changed.
    pub(super) fn collapse(&mut self, star: &Star) -> Vec<SampleId> {
        let count = star.ring.len();
        let outer: Vec<(Option<HalfEdge>, u32)> = star
            .spokes
            .iter()
            .map(|&spoke| (self.twins[next(spoke) as usize], self.load_of[next(spoke) as usize]))
            .collect();
        let free: Vec<u32> =
            star.spokes.iter().map(|&spoke| self.load_of[spoke as usize]).collect();
        let touched = self.changed_about(star);
        for &spoke in &star.spokes {
            for half in [spoke, next(spoke), before(spoke)] {
                self.twins[half as usize] = None;
            }
        }
        let mut inner: Vec<([usize; 2], HalfEdge)> = Vec::with_capacity(2 * count);
        for (corners, &spoke) in star.triangles.iter().zip(&star.spokes) {
            let first = spoke - spoke % 3;
            for side in 0..3 {
                let half = first + side as u32;
                let [a, b] = [corners[side], corners[(side + 1) % 3]];
                self.origins[half as usize] = star.ring[a];
                self.leaving[star.ring[a] as usize] = Some(half);
                if b == (a + 1) % count {
                    let (twin, load) = outer[a];
                    self.twins[half as usize] = twin;
                    self.load_of[half as usize] = load;
                    if let Some(twin) = twin {
                        self.twins[twin as usize] = Some(half);
                    }
                } else if let Some(&(_, twin)) = inner.iter().find(|(ends, _)| *ends == [b, a]) {
                    self.twins[half as usize] = Some(twin);
                    self.twins[twin as usize] = Some(half);
                } else {
                    inner.push(([a, b], half));
                }
            }
        }
        for &load in &free {
            self.loads[load as usize] = Load::default();
        }
        for (&(ends, half), &load) in inner.iter().zip(&free) {
            self.load_of[half as usize] = load;
            if let Some(twin) = self.twins[half as usize] {
                self.load_of[twin as usize] = load;
            }
            let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            if let Some(at) = star.inner.iter().position(|&inner| inner == ends) {
                self.loads[load as usize] = star.loads[at].clone();
            }
        }
        for ((_, load), new) in outer.iter().zip(&star.loads[star.inner.len()..]) {
            self.loads[*load as usize] = new.clone();
        }
        self.leaving[star.vertex as usize] = None;
        self.has_own[star.vertex as usize] = false;
        self.places[star.vertex as usize] = self.points[star.vertex as usize];
        touched
    }

    /// Moves a vertex as a star says, and gives the vertices about which costs changed.
    pub(super) fn relocate(&mut self, star: &Star) -> Vec<SampleId> {
        let touched = self.changed_about(star);
        self.places[star.vertex as usize] = star.place;
        self.has_own[star.vertex as usize] = false;
        let (inner, outer) = star.loads.split_at(star.inner.len());
        for (index, &spoke) in star.spokes.iter().enumerate() {
            let [on_spoke, on_ring] = [spoke, next(spoke)].map(|half| self.load_of[half as usize]);
            self.loads[on_spoke as usize] = inner[index].clone();
            self.loads[on_ring as usize] = outer[index].clone();
        }
        touched
    }

    /// The vertices whose stars hold an edge of this star that changes: those about it, and those beyond sides with other points.
    fn changed_about(&self, star: &Star) -> Vec<SampleId> {
        let beyond = star.spokes.iter().zip(&star.is_changed).filter(|(_, is)| **is);
        let beyond = beyond.filter_map(|(&spoke, _)| self.twins[next(spoke) as usize]);
        let beyond = beyond.map(|twin| self.origin(before(twin)));
        let about = star.ring.iter().copied().chain([star.vertex]).chain(beyond);
        about.filter(|&vertex| !self.is_corner(vertex)).collect()
    }
}

/// The half-edge that follows in its triangle.
pub(super) fn next(half: HalfEdge) -> HalfEdge {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

/// The half-edge before in its triangle.
fn before(half: HalfEdge) -> HalfEdge {
    if half.is_multiple_of(3) { half + 2 } else { half - 1 }
}

/// The power of two at a value or below; 1 for 0.
fn power_of_two(value: f64) -> f64 {
    if value > 0.0 { f64::from_bits(value.to_bits() & !((1 << 52) - 1)) } else { 1.0 }
}

/// The triangles of the samples and those between them and a square about, whose corners have the next four numbers.
fn framed(triangulation: &Triangulation) -> Vec<[u32; 3]> {
    let corner = |number: usize| (triangulation.len() + number % 4) as u32;
    let hull = hull(triangulation);
    let mut triangles = triangulation.triangles().to_vec();
    let quadrant_of = |[p, q]: [SampleId; 2]| {
        let [p, q] = [p, q].map(|end| triangulation.place(end));
        // What lies on the right of the side looks there.
        quadrant([q[1] - p[1], p[0] - q[0]])
    };
    for (index, &side) in hull.iter().enumerate() {
        let [here, there] = [quadrant_of(side), quadrant_of(hull[(index + 1) % hull.len()])];
        triangles.push([side[0], corner(here), side[1]]);
        let turns = (there + 4 - here) % 4;
        triangles.extend(
            (here..here + turns).map(|number| [side[1], corner(number), corner(number + 1)]),
        );
    }
    triangles
}

/// The corner of the square that lies farthest in a direction.
fn quadrant([x, y]: [f64; 2]) -> usize {
    match (x > 0.0, y > 0.0) {
        (true, _) if y >= 0.0 => 2,
        (false, true) => 3,
        (false, false) if x < 0.0 => 0,
        _ => 1,
    }
}

/// The sides round the samples, counter-clockwise; of samples on a line there and back.
fn hull(triangulation: &Triangulation) -> Vec<[SampleId; 2]> {
    let edges = triangulation.edges();
    if triangulation.triangles().is_empty() {
        let there = edges.iter().map(|edge| edge.ends);
        let back = edges.iter().rev().map(|edge| [edge.ends[1], edge.ends[0]]);
        return there.chain(back).collect();
    }
    let mut after = vec![None; triangulation.len()];
    for edge in edges {
        let [p, q] = edge.ends;
        match edge.triangles() {
            [Some(_), None] => after[p as usize] = Some(q),
            [None, Some(_)] => after[q as usize] = Some(p),
            _ => {}
        }
    }
    let mut sides = Vec::new();
    let Some(first) = after.iter().position(Option::is_some) else { return sides };
    let mut at = first as SampleId;
    while let Some(to) = after[at as usize].take() {
        sides.push([at, to]);
        at = to;
    }
    sides
}
