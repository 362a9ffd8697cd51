//! Shapes that are laid into a part as a whole: plane, sphere, cylinder.

use asphera_form::{Nominal, Parameter, Pose};
use asphera_geometry::PointMm;
use asphera_geometry::vector::{Vector, cross, dot, length, minus, plus, unit};

use crate::Part;
use crate::figures::turns_rad;

/// The kind of a shape; a radius is a size, whichever side the material is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    Plane,
    Sphere {
        radius_mm: f64,
    },
    /// Straight along x of the part frame, or along y.
    Cylinder {
        radius_mm: f64,
        along_x: bool,
    },
}

impl Shape {
    /// The shape of a part, and whether its radius is free.
    ///
    /// # Errors
    ///
    /// Why a part is not laid as a whole, in words.
    pub(super) fn of(part: &Part) -> Result<(Shape, bool), String> {
        if part.reference.is_some() {
            return Err("without a design there is no form in space".to_owned());
        }
        let shape = match &part.nominal {
            Nominal::Plane => Shape::Plane,
            Nominal::Sphere { radius_mm } => Shape::Sphere { radius_mm: radius_mm.abs() },
            other => circular(other).ok_or_else(|| {
                format!(
                    "form in space is worked out of a sphere, a circular cylinder and a plane, found {}: measure it along a \
                     direction in which it projects, with --along or [projection]",
                    other.kind()
                )
            })?,
        };
        let needed: &[Parameter] = match shape {
            Shape::Sphere { .. } => &[Parameter::Tx, Parameter::Ty, Parameter::Tz],
            _ => &Parameter::RIGID,
        };
        if let Some(held) = needed.iter().find(|one| !part.free.contains(one)) {
            return Err(format!(
                "in space a part is laid with all its motions: expected `{held}` among the free parameters of [fit]"
            ));
        }
        let is_radius = |one: &&Parameter| one.name(&part.nominal) == "radius";
        Ok((shape, part.free.iter().any(|one| is_radius(&one))))
    }

    /// Its radius in mm, which is its local feature size everywhere; infinite of a plane.
    pub(super) fn radius_mm(self) -> f64 {
        match self {
            Shape::Plane => f64::INFINITY,
            Shape::Sphere { radius_mm } | Shape::Cylinder { radius_mm, .. } => radius_mm,
        }
    }

    pub(super) fn with_radius(self, radius_mm: f64) -> Shape {
        match self {
            Shape::Plane => Shape::Plane,
            Shape::Sphere { .. } => Shape::Sphere { radius_mm },
            Shape::Cylinder { along_x, .. } => Shape::Cylinder { radius_mm, along_x },
        }
    }
}

/// The circular cylinder that a nominal is, if it is one: by its heights.
fn circular(nominal: &Nominal) -> Option<Shape> {
    let [bend_x, _, bend_y] = nominal.jet(0.0, 0.0)?.hessian_per_mm;
    let along_x = bend_x == 0.0;
    let bend = if along_x { bend_y } else { bend_x };
    let radius_mm = 1.0 / bend;
    if !radius_mm.is_finite() {
        return None;
    }
    let is_it = [-0.9, -0.4, 0.3, 0.7].into_iter().all(|share: f64| {
        let across = share * radius_mm;
        let expected = radius_mm - radius_mm.signum() * (radius_mm.powi(2) - across.powi(2)).sqrt();
        [-3.0 * radius_mm, radius_mm].into_iter().all(|along| {
            let [x, y] = if along_x { [along, across] } else { [across, along] };
            let found = nominal.height_mm(x, y);
            found.is_some_and(|found| (found - expected).abs() <= 1e-9 * radius_mm.abs())
        })
    });
    is_it.then_some(Shape::Cylinder { radius_mm: radius_mm.abs(), along_x })
}

/// A shape where it lies in the measured frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Laid {
    pub(super) shape: Shape,
    /// The centre of a sphere; a place on the axis of a cylinder, or on a plane.
    pub(super) centre_mm: PointMm,
    /// Unit vector along the axis of a cylinder, or along the normal of a plane.
    pub(super) axis: Vector,
}

impl Laid {
    /// How far a place lies outside, and the direction out; of a place on the centre or the axis any.
    pub(super) fn off(&self, place_mm: PointMm) -> (f64, Vector) {
        let way = minus(place_mm, self.centre_mm);
        match self.shape {
            Shape::Plane => (dot(way, self.axis), self.axis),
            Shape::Sphere { radius_mm } => {
                (length(way) - radius_mm, unit(way).unwrap_or([0.0, 0.0, 1.0]))
            }
            Shape::Cylinder { radius_mm, .. } => {
                let way = plus(way, -dot(way, self.axis), self.axis);
                (length(way) - radius_mm, unit(way).unwrap_or_else(|| across(self.axis)[0]))
            }
        }
    }

    /// The place of the shape that is nearest to a place.
    pub(super) fn foot_mm(&self, place_mm: PointMm) -> PointMm {
        let (off_mm, out) = self.off(place_mm);
        plus(place_mm, -off_mm, out)
    }

    /// The pose of the part: its vertex on the side of the centre that faces against z of the part frame.
    pub(super) fn pose(&self, nominal: &Nominal) -> Pose {
        let toward_centre = nominal.jet(0.0, 0.0).map_or(0.0, |jet| {
            let [bend_x, _, bend_y] = jet.hessian_per_mm;
            (bend_x + bend_y).signum()
        });
        let up = match self.shape {
            Shape::Plane => self.axis,
            Shape::Sphere { .. } => [0.0, 0.0, 1.0],
            Shape::Cylinder { .. } => upward(self.axis),
        };
        let columns = match self.shape {
            Shape::Sphere { .. } => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], up],
            Shape::Plane => {
                let [u, v] = across(up);
                [u, v, up]
            }
            Shape::Cylinder { along_x: true, .. } => [self.axis, cross(up, self.axis), up],
            Shape::Cylinder { .. } => [cross(self.axis, up), self.axis, up],
        };
        let rows = std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]));
        // Plus zero makes a negative zero positive.
        let [rx_rad, ry_rad, rz_rad] = turns_rad(&rows).map(|rad| rad + 0.0);
        let radius_mm = self.shape.radius_mm();
        let below_mm = if radius_mm.is_finite() { toward_centre * radius_mm } else { 0.0 };
        let [tx_mm, ty_mm, tz_mm] = plus(self.centre_mm, -below_mm, up).map(|mm| mm + 0.0);
        Pose { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad }
    }
}

/// Two unit vectors across a third, right-handed with it.
pub(super) fn across(axis: Vector) -> [Vector; 2] {
    let least =
        (0..3).fold(0, |least, at| if axis[at].abs() < axis[least].abs() { at } else { least });
    let mut start = [0.0; 3];
    start[least] = 1.0;
    // At more than 54° to the axis.
    let first = unit(cross(axis, start)).unwrap_or(start);
    [first, cross(axis, first)]
}

/// The direction across an axis that rises most; along x where the axis is upright.
fn upward(axis: Vector) -> Vector {
    let across = |of: Vector| unit(plus(of, -dot(of, axis), axis));
    let upright = axis[2].abs() > 1.0 - 1e-9;
    across(if upright { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] }).unwrap_or([1.0, 0.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nominal::parse;

    fn part(surface: &str) -> Part {
        parse("part.toml", &format!("[surface]\n{surface}")).unwrap()
    }

    #[test]
    fn circular_cylinders_of_both_directions_are_known_and_others_refused() {
        for (axis, along_x) in [("x", true), ("y", false)] {
            for sign in ["", "-"] {
                let text = format!(
                    "kind = \"cylinder\"\nstraight_along = \"{axis}\"\nradius_mm = {sign}5.0\n"
                );
                let (shape, free) = Shape::of(&part(&text)).unwrap();
                assert_eq!(shape, Shape::Cylinder { radius_mm: 5.0, along_x });
                assert!(!free);
            }
        }
        for surface in [
            "kind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = 5.0\nconic = -1.0\n",
            "kind = \"asphere\"\nradius_mm = 5.0\nconic = -1.0\n",
        ] {
            let why = Shape::of(&part(surface)).unwrap_err();
            assert!(why.contains("sphere, a circular cylinder and a plane"), "{why}");
        }
    }

    #[test]
    fn the_pose_takes_the_vertex_of_the_part_onto_the_shape() {
        let surfaces = [
            "kind = \"sphere\"\nradius_mm = 4.0\n",
            "kind = \"sphere\"\nradius_mm = -4.0\n",
            "kind = \"cylinder\"\nstraight_along = \"x\"\nradius_mm = 4.0\n",
            "kind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = -4.0\n",
            "kind = \"plane\"\n",
        ];
        for axis in [[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.48, 0.6, 0.64]] {
            for surface in surfaces {
                let part = part(surface);
                let (shape, _) = Shape::of(&part).unwrap();
                let laid = Laid { shape, centre_mm: [7.0, -3.0, 2.0], axis };
                let pose = laid.pose(&part.nominal);
                for place in [[0.0, 0.0], [0.5, -1.0], [1.5, 2.0]] {
                    let z = part.nominal.height_mm(place[0], place[1]).unwrap();
                    let (off_mm, _) = laid.off(pose.to_measured([place[0], place[1], z]));
                    assert!(off_mm.abs() < 1e-12, "{surface} {axis:?}: {off_mm}");
                }
            }
        }
    }
}
