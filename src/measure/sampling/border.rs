//! The aperture of a part, laid with it into the plane in which its points are meshed.
//!
//! The border of an aperture is a line on the nominal. What it encloses in the plane of projection is what
//! samples are to cover: a disc is seen as one where the part's axis stands upright on the plane, else
//! foreshortened, and a little to the side for its height. So the border is taken point by point to where the
//! part lies, and its projection is the aperture of the coverage; areas are right however far askew the plane
//! is.

use std::f64::consts::TAU;

use asphera_form::{Aperture, Nominal, Pose};
use asphera_geometry::outline::{Outline, OutlineError};
use asphera_surface::coverage::{self, ApertureError};

/// The aperture in the plane; none where every point counts.
///
/// # Errors
///
/// When it has no area there: the part stands upright on the plane.
pub(super) fn laid(
    aperture: &Aperture,
    nominal: &Nominal,
    pose: &Pose,
) -> Result<Option<coverage::Aperture>, ApertureError> {
    let border = Border { nominal, pose };
    let laid = match *aperture {
        Aperture::None => return Ok(None),
        Aperture::Circle { radius_mm } => border.disc(radius_mm)?,
        Aperture::Annulus { inner_mm, outer_mm } if inner_mm > 0.0 => {
            border.ring(inner_mm, outer_mm)?
        }
        Aperture::Annulus { outer_mm, .. } => border.disc(outer_mm)?,
        Aperture::Rectangle { width_mm, height_mm } => border.rectangle(width_mm, height_mm)?,
        Aperture::Outline { ref outline, .. } => border.outline(outline)?,
    };
    if laid.area_mm2() < LEAST * aperture.area_mm2() {
        return Err(OutlineError::Empty { line: 0 }.into());
    }
    Ok(Some(laid))
}

struct Border<'a> {
    nominal: &'a Nominal,
    pose: &'a Pose,
}

impl Border<'_> {
    fn disc(&self, radius_mm: f64) -> Result<coverage::Aperture, ApertureError> {
        if self.is_upright() {
            return coverage::Aperture::circle(self.centre_mm(radius_mm), radius_mm);
        }
        coverage::Aperture::polygon(&self.circle(radius_mm), &[])
    }

    fn ring(&self, inner_mm: f64, outer_mm: f64) -> Result<coverage::Aperture, ApertureError> {
        let [inner, outer] = [inner_mm, outer_mm].map(|radius_mm| self.centre_mm(radius_mm));
        let apart_mm = (inner[0] - outer[0]).hypot(inner[1] - outer[1]);
        if self.is_upright() && apart_mm <= UPRIGHT * outer_mm {
            return coverage::Aperture::annulus(outer, inner_mm, outer_mm);
        }
        coverage::Aperture::polygon(&self.circle(outer_mm), &[self.circle(inner_mm)])
    }

    fn rectangle(
        &self,
        width_mm: f64,
        height_mm: f64,
    ) -> Result<coverage::Aperture, ApertureError> {
        let turned = self.pose.rotation();
        if self.is_upright() && turned[0][0] > 0.0 && turned[1][0].abs() <= UPRIGHT {
            let centre = self.centre_mm(0.5 * width_mm.hypot(height_mm));
            return coverage::Aperture::rectangle(centre, width_mm, height_mm);
        }
        let (x, y) = (0.5 * width_mm, 0.5 * height_mm);
        let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
        let sides = corners.into_iter().zip(corners.into_iter().cycle().skip(1));
        let places: Vec<[f64; 2]> = sides
            .flat_map(|(from, to)| steps(from, to, SIDE))
            .map(|place| self.seen(place))
            .collect();
        coverage::Aperture::polygon(&places, &[])
    }

    fn outline(&self, outline: &Outline) -> Result<coverage::Aperture, ApertureError> {
        // Seen askew, a side on a curved surface is no straight one.
        let longest_mm = match self.is_upright() {
            true => f64::INFINITY,
            false => outline.perimeter_mm() / PIECES as f64,
        };
        let laid = |ring: &Vec<[f64; 2]>| -> Vec<[f64; 2]> {
            let sides = ring.iter().copied().zip(ring.iter().copied().cycle().skip(1));
            sides
                .flat_map(|(from, to)| {
                    let length_mm = (to[0] - from[0]).hypot(to[1] - from[1]);
                    let count = (length_mm / longest_mm).ceil().max(1.0) as usize;
                    steps(from, to, count)
                })
                .map(|place| self.seen(place))
                .collect()
        };
        let mut rings = outline.rings().iter().map(laid);
        let outer = rings.next().unwrap_or_default();
        coverage::Aperture::polygon(&outer, &rings.collect::<Vec<_>>())
    }

    /// Whether the axis stands upright on the plane, but for what changes areas by less than counts.
    fn is_upright(&self) -> bool {
        let [_, _, [rx, ry, rz]] = self.pose.rotation();
        rz > 0.0 && rx.hypot(ry) <= UPRIGHT
    }

    /// A circle about the axis, as a polygon of the same area.
    fn circle(&self, radius_mm: f64) -> Vec<[f64; 2]> {
        let angle = TAU / CIRCLE as f64;
        let wider = (angle / angle.sin()).sqrt();
        (0..CIRCLE)
            .map(|step| {
                let (sin, cos) = (step as f64 * angle).sin_cos();
                self.seen_at([wider * radius_mm * cos, wider * radius_mm * sin], radius_mm)
            })
            .collect()
    }

    /// Where the middle of a circle about the axis is seen.
    fn centre_mm(&self, radius_mm: f64) -> [f64; 2] {
        self.seen_at([0.0; 2], radius_mm)
    }

    /// Where a place of the part is seen.
    fn seen(&self, place: [f64; 2]) -> [f64; 2] {
        self.seen_at(place, place[0].hypot(place[1]))
    }

    /// The same at the height the nominal has at the distance `r_mm` from the axis.
    fn seen_at(&self, [x, y]: [f64; 2], r_mm: f64) -> [f64; 2] {
        let at_mm = if self.nominal.is_rotational() {
            [r_mm, 0.0]
        } else {
            let share = if x == 0.0 && y == 0.0 { 1.0 } else { r_mm / x.hypot(y) };
            [share * x, share * y]
        };
        let height_mm = super::height_mm(self.nominal, at_mm);
        let [u, v, _] = self.pose.to_measured([x, y, height_mm]);
        [u, v]
    }
}

/// Places along a side from its beginning, its end left out.
fn steps(from: [f64; 2], to: [f64; 2], count: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..count).map(move |step| {
        let share = step as f64 / count as f64;
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    })
}

/// A sine up to which an axis is upright: it foreshortens by 5e-9.
const UPRIGHT: f64 = 1e-4;
/// Share that is left of an area that is seen from its side.
const LEAST: f64 = 1e-6;
/// Sides of a circle.
const CIRCLE: usize = 720;
/// Places along a side of a rectangle.
const SIDE: usize = 64;
/// Places along an outline at least.
const PIECES: usize = 1024;

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const SPHERE: Nominal = Nominal::Sphere { radius_mm: 20.0 };

    #[test]
    fn an_upright_aperture_only_moves() {
        let pose = Pose { tx_mm: 3.0, ty_mm: -2.0, rz_rad: 0.3, ..Pose::default() };
        let circle = laid(&Aperture::Circle { radius_mm: 5.0 }, &SPHERE, &pose).unwrap();
        assert_eq!(circle, Some(coverage::Aperture::circle([3.0, -2.0], 5.0).unwrap()));
        let ring = Aperture::Annulus { inner_mm: 0.0, outer_mm: 5.0 };
        assert_eq!(laid(&ring, &SPHERE, &pose).unwrap(), circle);
        assert_eq!(laid(&Aperture::None, &SPHERE, &pose).unwrap(), None);
        let rectangle = Aperture::Rectangle { width_mm: 4.0, height_mm: 2.0 };
        let turned = laid(&rectangle, &SPHERE, &pose).unwrap().unwrap();
        assert!((turned.area_mm2() - 8.0).abs() < 1e-9);
        assert!(turned.contains([3.0 + 1.9 * 0.3_f64.cos(), -2.0 + 1.9 * 0.3_f64.sin()]));
    }

    #[test]
    fn an_aperture_askew_is_foreshortened_and_moves_by_its_height() {
        let angle = 0.4_f64;
        let pose = Pose { rx_rad: angle, tz_mm: 1.0, ..Pose::default() };
        let radius_mm = 8.0;
        let found = laid(&Aperture::Circle { radius_mm }, &SPHERE, &pose).unwrap().unwrap();
        let expected_mm2 = PI * radius_mm * radius_mm * angle.cos();
        assert!((found.area_mm2() / expected_mm2 - 1.0).abs() < 1e-9, "{}", found.area_mm2());
        let sag_mm = 20.0 - (400.0_f64 - 64.0).sqrt();
        let [low, high] = found.bounds_mm();
        let middle = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
        assert!(middle[0].abs() < 1e-9 && (middle[1] + sag_mm * angle.sin()).abs() < 1e-3);
        let ring = Aperture::Annulus { inner_mm: 4.0, outer_mm: 8.0 };
        let ring = laid(&ring, &SPHERE, &pose).unwrap().unwrap();
        assert!((ring.area_mm2() / (0.75 * expected_mm2) - 1.0).abs() < 1e-9);
        let upright = Pose { rx_rad: PI / 2.0, ..Pose::default() };
        assert!(laid(&Aperture::Circle { radius_mm }, &Nominal::Plane, &upright).is_err());
    }
}
