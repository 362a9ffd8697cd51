//! Edges as lines between two places: distances, projections.

use crate::PlaceMm;

/// The line from one place to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    from: PlaceMm,
    to: PlaceMm,
    /// Unit vector along it; zero if both places are one.
    along: [f64; 2],
    pub(super) length_mm: f64,
}

/// How near a place lies to an edge: the square of its distance, and how far beyond an end it lies, as seen along the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearness {
    pub(super) squared_mm2: f64,
    beyond_mm: f64,
}

impl Nearness {
    /// Farther than all others.
    pub(super) const FAR: Nearness =
        Nearness { squared_mm2: f64::INFINITY, beyond_mm: f64::INFINITY };
}

impl Ends {
    pub(super) fn new(from: PlaceMm, to: PlaceMm) -> Ends {
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        let length_mm = (x * x + y * y).sqrt();
        let along = if length_mm > 0.0 { [x / length_mm, y / length_mm] } else { [0.0; 2] };
        Ends { from, to, along, length_mm }
    }

    /// How near a place lies. Of edges that end in the place nearest to a point, that is nearest which turns to it most.
    pub(super) fn nearness(&self, place: PlaceMm) -> Nearness {
        self.nearer(place, &Nearness::FAR).unwrap_or(Nearness::FAR)
    }

    /// How near a place lies, if that is nearer than something else.
    #[inline]
    pub(super) fn nearer(&self, place: PlaceMm, than: &Nearness) -> Option<Nearness> {
        let across_mm = self.across_mm(place);
        let across_mm2 = across_mm * across_mm;
        // Most edges are too far off as lines already.
        if across_mm2 > than.squared_mm2 {
            return None;
        }
        let along_mm = self.along_mm(place);
        let found = if along_mm <= 0.0 {
            Nearness { squared_mm2: squared(place, self.from), beyond_mm: -along_mm }
        } else if along_mm >= self.length_mm {
            let beyond_mm = along_mm - self.length_mm;
            Nearness { squared_mm2: squared(place, self.to), beyond_mm }
        } else {
            Nearness { squared_mm2: across_mm2, beyond_mm: 0.0 }
        };
        let is_tie = found.squared_mm2 == than.squared_mm2;
        let is_nearer =
            found.squared_mm2 < than.squared_mm2 || (is_tie && found.beyond_mm < than.beyond_mm);
        is_nearer.then_some(found)
    }

    /// Distance from the first end to the foot of a place on the line, in mm.
    pub(super) fn along_mm(&self, place: PlaceMm) -> f64 {
        self.along[0] * (place[0] - self.from[0]) + self.along[1] * (place[1] - self.from[1])
    }

    /// Signed distance of a place from the line in mm.
    pub(super) fn across_mm(&self, place: PlaceMm) -> f64 {
        self.along[0] * (place[1] - self.from[1]) - self.along[1] * (place[0] - self.from[0])
    }

    /// The square of the distance to the nearer end in mm².
    pub(super) fn end_distance_mm2(&self, place: PlaceMm) -> f64 {
        squared(place, self.from).min(squared(place, self.to))
    }
}

/// The square of the distance of two places in mm².
pub(super) fn squared(p: PlaceMm, q: PlaceMm) -> f64 {
    let [x, y] = [p[0] - q[0], p[1] - q[1]];
    x * x + y * y
}

/// Whether three places certainly turn counter-clockwise: what rounding could decide does not count.
///
/// The bound of the error is that of J. R. Shewchuk, Discrete & Computational Geometry 18 (1997) 305-363, with a margin.
pub(super) fn is_left_turn(a: PlaceMm, b: PlaceMm, c: PlaceMm) -> bool {
    let [first, second] = products(a, b, c);
    first - second > 4.0 * f64::EPSILON * (first.abs() + second.abs())
}

/// Twice the signed area of a triangle in mm².
pub(super) fn doubled_area_mm2(a: PlaceMm, b: PlaceMm, c: PlaceMm) -> f64 {
    let [first, second] = products(a, b, c);
    first - second
}

fn products(a: PlaceMm, b: PlaceMm, c: PlaceMm) -> [f64; 2] {
    [(b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0])]
}
