//! The region of the plane that is to be measured.

use std::cmp::Ordering;
use std::f64::consts::PI;

use asphera_geometry::predicates::{Place, orientation};
use asphera_geometry::{RANGE_MM, Sum};
use thiserror::Error;

use super::border::Whereabouts;
use super::simple;

/// A region of the x-y plane, in the frame of the points: what is to be covered by samples. Its
/// border belongs to it.
///
/// Every aperture is sound: finite, of positive area, and a polygon crosses itself nowhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Aperture {
    pub(super) shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    Circle {
        centre_mm: Place,
        radius_mm: f64,
    },
    Annulus {
        centre_mm: Place,
        inner_mm: f64,
        outer_mm: f64,
    },
    Rectangle {
        min_mm: Place,
        max_mm: Place,
    },
    /// The outline counter-clockwise, then the holes clockwise.
    Polygon {
        rings: Vec<Vec<Place>>,
    },
}

/// Why an aperture is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ApertureError {
    /// A size that is not a positive number, or not one a mesh can have.
    #[error("aperture {name} is {value_mm} mm, expected a positive number up to 1e12")]
    Size {
        /// Which size.
        name: &'static str,
        /// Its value in mm.
        value_mm: f64,
    },
    /// A ring whose inner radius is not a positive number below the outer one.
    #[error("aperture ring from {inner_mm} mm to {outer_mm} mm, expected 0 < inner < outer")]
    Ring {
        /// Inner radius in mm.
        inner_mm: f64,
        /// Outer radius in mm.
        outer_mm: f64,
    },
    /// A place that is not finite, or where no mesh can be.
    #[error("aperture place ({}, {}) mm, expected finite numbers up to 1e12", .at_mm[0], .at_mm[1])]
    Place {
        /// The place in mm.
        at_mm: [f64; 2],
    },
    /// A closed line of fewer than three places.
    #[error("closed line {line} of the aperture has {places} different places, expected 3 or more")]
    Places {
        /// Which line: 0 is the outline, 1 the first hole.
        line: usize,
        /// How many places it has, repeated ones left out.
        places: usize,
    },
    /// A closed line without area.
    #[error("closed line {line} of the aperture encloses nothing")]
    Empty {
        /// Which line: 0 is the outline, 1 the first hole.
        line: usize,
    },
    /// Two sides that meet elsewhere than at the corner they share.
    #[error(
        "closed lines {} and {} of the aperture meet beside ({}, {}) mm",
        .lines[0], .lines[1], .near_mm[0], .near_mm[1]
    )]
    Meet {
        /// The lines of the two sides, which may be one: 0 is the outline, 1 the first hole.
        lines: [usize; 2],
        /// The beginning of the first side in mm.
        near_mm: [f64; 2],
    },
    /// A hole that is not inside the outline, or inside another hole.
    #[error("hole {hole} of the aperture does not lie inside it")]
    Hole {
        /// Which hole, from 1 on.
        hole: usize,
    },
}

impl Aperture {
    /// A disc.
    ///
    /// # Errors
    ///
    /// When the radius is not positive or something is not finite.
    pub fn circle(centre_mm: [f64; 2], radius_mm: f64) -> Result<Aperture, ApertureError> {
        admitted(centre_mm)?;
        positive("radius", radius_mm)?;
        Ok(Aperture { shape: Shape::Circle { centre_mm, radius_mm } })
    }

    /// A disc without a smaller disc about the same centre.
    ///
    /// # Errors
    ///
    /// When the radii are not 0 < inner < outer or something is not finite.
    pub fn annulus(
        centre_mm: [f64; 2],
        inner_mm: f64,
        outer_mm: f64,
    ) -> Result<Aperture, ApertureError> {
        admitted(centre_mm)?;
        positive("outer radius", outer_mm)?;
        if inner_mm > 0.0 && inner_mm < outer_mm {
            Ok(Aperture { shape: Shape::Annulus { centre_mm, inner_mm, outer_mm } })
        } else {
            Err(ApertureError::Ring { inner_mm, outer_mm })
        }
    }

    /// A rectangle with sides along x and y.
    ///
    /// # Errors
    ///
    /// When a size is not positive or something is not finite.
    pub fn rectangle(
        centre_mm: [f64; 2],
        width_mm: f64,
        height_mm: f64,
    ) -> Result<Aperture, ApertureError> {
        admitted(centre_mm)?;
        positive("width", width_mm)?;
        positive("height", height_mm)?;
        let [x, y] = centre_mm;
        let min_mm = [x - 0.5 * width_mm, y - 0.5 * height_mm];
        let max_mm = [x + 0.5 * width_mm, y + 0.5 * height_mm];
        // Far from the origin a small rectangle has no size any more.
        for (name, axis, value_mm) in [("width", 0, width_mm), ("height", 1, height_mm)] {
            if min_mm[axis] >= max_mm[axis] {
                return Err(ApertureError::Size { name, value_mm });
            }
        }
        Ok(Aperture { shape: Shape::Rectangle { min_mm, max_mm } })
    }

    /// A polygon with holes. Each closed line may run either way, and may or may not repeat its
    /// first place at its end.
    ///
    /// Whether lines meet is decided exactly. Takes time in proportion to the pairs of sides whose
    /// ranges of x overlap, and of holes.
    ///
    /// # Errors
    ///
    /// When a place is not finite; when a line has fewer than three places, or no area, or meets
    /// itself or another one, be it at a corner; when a hole is not inside.
    pub fn polygon(
        outline_mm: &[[f64; 2]],
        holes_mm: &[Vec<[f64; 2]>],
    ) -> Result<Aperture, ApertureError> {
        let lines = std::iter::once(outline_mm).chain(holes_mm.iter().map(Vec::as_slice));
        let mut rings = Vec::with_capacity(1 + holes_mm.len());
        for (line, places) in lines.enumerate() {
            let mut ring: Vec<Place> = Vec::with_capacity(places.len());
            for &place in places {
                admitted(place)?;
                // Adding zero makes negative zero positive.
                let place = place.map(|mm| mm + 0.0);
                if ring.last() != Some(&place) {
                    ring.push(place);
                }
            }
            while ring.len() > 1 && ring.first() == ring.last() {
                ring.pop();
            }
            if ring.len() < 3 {
                return Err(ApertureError::Places { line, places: ring.len() });
            }
            let area_mm2 = signed_area_mm2(&ring);
            if area_mm2 == 0.0 {
                return Err(ApertureError::Empty { line });
            }
            if (area_mm2 > 0.0) != (line == 0) {
                ring.reverse();
            }
            rings.push(ring);
        }
        if let Some((lines, near_mm)) = simple::meeting(&rings) {
            return Err(ApertureError::Meet { lines, near_mm });
        }
        for hole in 1..rings.len() {
            let at = rings[hole][0];
            let elsewhere = |&other: &usize| other != hole && ring_contains(&rings[other], at);
            if !ring_contains(&rings[0], at) || (1..rings.len()).any(|other| elsewhere(&other)) {
                return Err(ApertureError::Hole { hole });
            }
        }
        Ok(Aperture { shape: Shape::Polygon { rings } })
    }

    /// Its area in mm².
    pub fn area_mm2(&self) -> f64 {
        match &self.shape {
            Shape::Circle { radius_mm, .. } => PI * radius_mm * radius_mm,
            Shape::Annulus { inner_mm, outer_mm, .. } => {
                PI * (outer_mm - inner_mm) * (outer_mm + inner_mm)
            }
            Shape::Rectangle { min_mm, max_mm } => {
                (max_mm[0] - min_mm[0]) * (max_mm[1] - min_mm[1])
            }
            Shape::Polygon { rings } => {
                let mut sum = Sum::default();
                rings.iter().for_each(|ring| sum.add(signed_area_mm2(ring)));
                sum.total()
            }
        }
    }

    /// Whether a place, in mm, belongs to it. NaN belongs to none. Takes time in proportion to the
    /// sides of a polygon.
    pub fn contains(&self, at_mm: [f64; 2]) -> bool {
        let distance_mm = |centre: Place| (at_mm[0] - centre[0]).hypot(at_mm[1] - centre[1]);
        match &self.shape {
            Shape::Circle { centre_mm, radius_mm } => distance_mm(*centre_mm) <= *radius_mm,
            Shape::Annulus { centre_mm, inner_mm, outer_mm } => {
                (*inner_mm..=*outer_mm).contains(&distance_mm(*centre_mm))
            }
            Shape::Rectangle { min_mm, max_mm } => {
                (0..2).all(|axis| (min_mm[axis]..=max_mm[axis]).contains(&at_mm[axis]))
            }
            Shape::Polygon { rings } => {
                at_mm.iter().all(|mm| mm.is_finite())
                    && (rings.iter().any(|ring| ring_meets(ring, at_mm))
                        || rings.iter().filter(|ring| ring_contains(ring, at_mm)).count() == 1)
            }
        }
    }

    /// Where all lies that is no farther from a place than `reach_mm`; near, too, where that would take
    /// a look at many sides.
    pub(super) fn whereabouts_about(&self, at_mm: Place, reach_mm: f64) -> Whereabouts {
        // A disc is told by the distance from its rim, positive inside; rounding is left to those who look closer.
        let inside_by = |by_mm: f64, size_mm: f64| {
            let reach_mm = reach_mm + ROUNDING * (size_mm + at_mm[0].abs().max(at_mm[1].abs()));
            if by_mm >= reach_mm {
                Whereabouts::Inside
            } else if by_mm <= -reach_mm {
                Whereabouts::Outside
            } else {
                Whereabouts::Near
            }
        };
        let distance_mm = |[x, y]: Place| {
            let (x, y) = (at_mm[0] - x, at_mm[1] - y);
            (x * x + y * y).sqrt()
        };
        match &self.shape {
            Shape::Circle { centre_mm, radius_mm } => {
                inside_by(radius_mm - distance_mm(*centre_mm), *radius_mm)
            }
            Shape::Annulus { centre_mm, inner_mm, outer_mm } => {
                let distance_mm = distance_mm(*centre_mm);
                inside_by((outer_mm - distance_mm).min(distance_mm - inner_mm), *outer_mm)
            }
            Shape::Rectangle { min_mm: [left, low], max_mm: [right, high] } => {
                let [x, y] = at_mm;
                let by_mm = (x - left).min(right - x).min(y - low).min(high - y);
                inside_by(by_mm, left.abs().max(right.abs()).max(low.abs()).max(high.abs()))
            }
            Shape::Polygon { .. } => Whereabouts::Near,
        }
    }

    /// The smallest and the largest x and y in mm.
    pub fn bounds_mm(&self) -> [[f64; 2]; 2] {
        match &self.shape {
            Shape::Circle { centre_mm: [x, y], radius_mm: r }
            | Shape::Annulus { centre_mm: [x, y], outer_mm: r, .. } => {
                [[x - r, y - r], [x + r, y + r]]
            }
            Shape::Rectangle { min_mm, max_mm } => [*min_mm, *max_mm],
            Shape::Polygon { rings } => {
                let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
                rings[0].iter().fold(start, |[low, high], place| {
                    [
                        [low[0].min(place[0]), low[1].min(place[1])],
                        [high[0].max(place[0]), high[1].max(place[1])],
                    ]
                })
            }
        }
    }
}

/// Distances are told to this share of the coordinates at least.
const ROUNDING: f64 = 1e-12;

fn admitted(at_mm: Place) -> Result<(), ApertureError> {
    if at_mm.iter().all(|mm| mm.abs() <= RANGE_MM) {
        Ok(())
    } else {
        Err(ApertureError::Place { at_mm })
    }
}

fn positive(name: &'static str, value_mm: f64) -> Result<(), ApertureError> {
    if value_mm > 0.0 && value_mm <= RANGE_MM {
        Ok(())
    } else {
        Err(ApertureError::Size { name, value_mm })
    }
}

/// The area a closed line encloses, positive if it runs counter-clockwise.
pub(super) fn signed_area_mm2(ring: &[Place]) -> f64 {
    let [x0, y0] = ring[0];
    let mut twice = Sum::default();
    for (p, q) in sides_of(ring) {
        twice.add((p[0] - x0) * (q[1] - y0));
        twice.add(-(p[1] - y0) * (q[0] - x0));
    }
    0.5 * twice.total()
}

/// The sides of a closed line, each with its beginning and its end.
pub(super) fn sides_of(ring: &[Place]) -> impl Iterator<Item = (Place, Place)> + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Whether a closed line runs about a place an odd number of times; of a place on it, whichever.
/// Decided exactly.
pub(super) fn ring_contains(ring: &[Place], at: Place) -> bool {
    sides_of(ring).filter(|&(p, q)| side_right_of(p, q, at)).count() % 2 == 1
}

/// Whether a ray from `at` along +x crosses the side; a side has its lower end and not its upper.
pub(super) fn side_right_of(p: Place, q: Place, at: Place) -> bool {
    if (p[1] > at[1]) == (q[1] > at[1]) {
        return false;
    }
    let turn = orientation(p, q, at);
    if q[1] > p[1] { turn == Ordering::Greater } else { turn == Ordering::Less }
}

/// Whether a place lies on a closed line, exactly.
fn ring_meets(ring: &[Place], at: Place) -> bool {
    sides_of(ring).any(|(p, q)| {
        let between =
            (0..2).all(|axis| p[axis].min(q[axis]) <= at[axis] && at[axis] <= p[axis].max(q[axis]));
        between && orientation(p, q, at) == Ordering::Equal
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Vec<Place> {
        vec![[low, low], [high, low], [high, high], [low, high]]
    }

    #[test]
    fn what_is_about_a_place_is_told_by_the_border() {
        let apertures = [
            Aperture::circle([3.0, -1.0], 2.0).unwrap(),
            Aperture::annulus([3.0, -1.0], 1.0, 2.0).unwrap(),
            Aperture::rectangle([3.0, -1.0], 4.0, 3.0).unwrap(),
        ];
        for aperture in apertures {
            let mut seen = [0; 3];
            for (i, j) in (0..100).flat_map(|i| (0..100).map(move |j| (i, j))) {
                let at = [0.5 + 0.05 * f64::from(i), -3.5 + 0.05 * f64::from(j)];
                let whereabouts = aperture.whereabouts_about(at, 0.1);
                seen[whereabouts as usize] += 1;
                let inside = (0..16).filter(|step| {
                    let (sin, cos) = (f64::from(*step) * PI / 8.0).sin_cos();
                    aperture.contains([at[0] + 0.1 * cos, at[1] + 0.1 * sin])
                });
                match (whereabouts, inside.count()) {
                    (Whereabouts::Inside, 16)
                    | (Whereabouts::Outside, 0)
                    | (Whereabouts::Near, _) => {}
                    other => panic!("{other:?} about {at:?} of {aperture:?}"),
                }
            }
            let clear = seen[Whereabouts::Near as usize] < 2_800;
            assert!(clear && seen.iter().all(|&count| count > 500), "{seen:?}");
        }
        let polygon = Aperture::polygon(&square(0.0, 4.0), &[]).unwrap();
        assert_eq!(polygon.whereabouts_about([2.0; 2], 0.1), Whereabouts::Near);
    }

    #[test]
    fn areas_and_borders() {
        let circle = Aperture::circle([1.0, -2.0], 5.0).unwrap();
        assert!((circle.area_mm2() - 78.539_816_339_744_83).abs() < 1e-13);
        assert!(circle.contains([4.0, 2.0]) && !circle.contains([4.0, 2.000_001]));
        assert_eq!(circle.bounds_mm(), [[-4.0, -7.0], [6.0, 3.0]]);
        let ring = Aperture::annulus([0.0; 2], 3.0, 5.0).unwrap();
        assert!((ring.area_mm2() - 50.265_482_457_436_69).abs() < 1e-13);
        assert!(ring.contains([0.0, 3.0]) && ring.contains([-5.0, 0.0]));
        assert!(!ring.contains([1.0, 1.0]));
        let rectangle = Aperture::rectangle([1.0, 1.0], 4.0, 2.0).unwrap();
        assert_eq!((rectangle.area_mm2(), rectangle.bounds_mm()), (8.0, [[-1.0, 0.0], [3.0, 2.0]]));
        assert!(rectangle.contains([-1.0, 2.0]) && !rectangle.contains([1.0, 2.1]));
        for place in [[f64::NAN, 0.0], [0.0, f64::INFINITY]] {
            assert!(![&circle, &ring, &rectangle].iter().any(|it| it.contains(place)));
        }
    }

    #[test]
    fn a_polygon_may_turn_either_way_and_be_closed_or_not() {
        let mut expected = None;
        for turned in [false, true] {
            let (mut outline, mut hole) = (square(0.0, 4.0), square(1.0, 3.0));
            if turned {
                outline.reverse();
                outline.push(outline[0]);
                hole.reverse();
            }
            let polygon = Aperture::polygon(&outline, &[hole]).unwrap();
            assert_eq!(polygon.area_mm2(), 12.0);
            for (place, inside) in [
                ([0.5, 2.0], true),
                ([2.0, 2.0], false),
                ([1.0, 2.0], true),
                ([4.0, 4.0], true),
                ([2.0, 4.0], true),
                ([2.0, 4.1], false),
                ([f64::NAN, 1.0], false),
            ] {
                assert_eq!(polygon.contains(place), inside, "{place:?}");
            }
            assert_eq!(*expected.get_or_insert(polygon.bounds_mm()), [[0.0; 2], [4.0; 2]]);
        }
    }

    #[test]
    fn what_is_no_aperture() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e13] {
            assert!(matches!(Aperture::circle([0.0; 2], bad), Err(ApertureError::Size { .. })));
            assert!(Aperture::rectangle([0.0; 2], 1.0, bad).is_err());
            assert!(Aperture::rectangle([0.0; 2], bad, 1.0).is_err());
            assert!(Aperture::annulus([0.0; 2], 1.0, bad).is_err());
        }
        assert!(Aperture::rectangle([1e12, 0.0], 1e-9, 1.0).is_err());
        for inner_mm in [0.0, -1.0, 2.0, 3.0, f64::NAN] {
            let found = Aperture::annulus([0.0; 2], inner_mm, 2.0);
            assert!(matches!(found, Err(ApertureError::Ring { .. })));
        }
        let place = Aperture::circle([f64::NAN, 0.0], 1.0);
        assert!(matches!(place, Err(ApertureError::Place { .. })));
        let polygon = |outline: &[Place], holes: &[Vec<Place>]| {
            Aperture::polygon(outline, holes).expect_err("it is none")
        };
        let two = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
        assert_eq!(polygon(&two, &[]), ApertureError::Places { line: 0, places: 2 });
        assert_eq!(polygon(&[], &[]), ApertureError::Places { line: 0, places: 0 });
        let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
        assert_eq!(polygon(&line, &[]), ApertureError::Empty { line: 0 });
        let infinite = [[0.0, 0.0], [1.0, f64::INFINITY], [2.0, 2.0]];
        assert!(matches!(polygon(&infinite, &[]), ApertureError::Place { .. }));
        let bow = [[0.0, 0.0], [2.0, 2.0], [3.0, 0.0], [0.0, 1.0]];
        assert!(matches!(polygon(&bow, &[]), ApertureError::Meet { lines: [0, 0], .. }));
        let spike = [[0.0, 0.0], [4.0, 0.0], [2.0, 0.0], [2.0, 3.0]];
        assert!(matches!(polygon(&spike, &[]), ApertureError::Meet { lines: [0, 0], .. }));
        let outline = square(0.0, 4.0);
        let crossing = polygon(&outline, &[square(3.0, 5.0)]);
        assert!(matches!(crossing, ApertureError::Meet { lines: [0, 1], .. }), "{crossing:?}");
        let touching = polygon(&outline, &[square(0.0, 1.0)]);
        assert!(matches!(touching, ApertureError::Meet { .. }));
        assert_eq!(polygon(&outline, &[square(5.0, 6.0)]), ApertureError::Hole { hole: 1 });
        let nested = polygon(&outline, &[square(1.0, 3.0), square(1.5, 2.5)]);
        assert_eq!(nested, ApertureError::Hole { hole: 2 });
        let message = polygon(&outline, &[square(5.0, 6.0)]).to_string();
        assert_eq!(message, "hole 1 of the aperture does not lie inside it");
    }
}
