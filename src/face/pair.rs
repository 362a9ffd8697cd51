//! How two measured faces of a part lie to each other.

use asphera_form::{Nominal, Pose};
use asphera_geometry::PointMm;
use asphera_report::{FacesFigures, ParameterFigures, Report};
use asphera_surface::Plane;

use crate::Face;
use asphera_geometry::vector::{Vector, cross, dot, length, plus, unit};

/// Where a measured face lies, and how well that is known.
#[derive(Clone, Debug)]
pub struct Lying {
    nominal: Nominal,
    plane: Plane,
    /// In the frame of the plane: tx, ty, tz in mm, rx, ry, rz in rad.
    pose: [f64; 6],
    /// Standard covariance of these; 0 of what was not fitted.
    covariance: [[f64; 6]; 6],
    /// Standard uncertainty of its height by the threshold.
    rise_mm: f64,
}

impl Lying {
    /// Of a face with its report; `None` where no fit was made.
    pub fn in_report(face: &Face, nominal: &Nominal, report: &Report) -> Option<Lying> {
        let form = report.form.as_ref()?;
        let plane = Plane::new([0.0; 3], face.along).ok()?;
        let fitted = form.fit.pose;
        let pose = in_plane(&plane, |part_mm| fitted.to_measured(part_mm));
        let mut covariance = [[0.0; 6]; 6];
        let known = form.fit.details.covariance.as_ref();
        for (i, a) in NAMES.into_iter().enumerate() {
            for (j, b) in NAMES.into_iter().enumerate() {
                covariance[i][j] = known
                    .and_then(|known| {
                        let row = known.parameters.iter().position(|name| name == a)?;
                        let column = known.parameters.iter().position(|name| name == b)?;
                        known.covariance.get(row)?.get(column).copied()
                    })
                    .unwrap_or(0.0);
            }
        }
        Some(Lying { nominal: nominal.clone(), plane, pose, covariance, rise_mm: face.rise_mm() })
    }

    /// Whether the surface has an axis, and a place on it.
    fn has_axis(&self) -> bool {
        !matches!(self.nominal, Nominal::Sphere { .. })
    }

    fn has_vertex(&self) -> bool {
        self.has_axis() && self.nominal.slides() == [false; 2]
    }

    fn moved(&self, parameter: usize, by: f64) -> Lying {
        let mut moved = self.clone();
        moved.pose[parameter] += by;
        moved
    }

    fn motion(&self) -> Pose {
        let [tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad] = self.pose;
        Pose { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad }
    }

    /// A place of the part frame in the measured frame.
    fn measured(&self, part_mm: PointMm) -> PointMm {
        self.plane.from_plane(self.motion().to_measured(part_mm))
    }

    fn direction(&self, part: Vector) -> Vector {
        plus(self.measured(part), -1.0, self.measured([0.0; 3]))
    }

    fn axis(&self) -> Vector {
        self.direction([0.0, 0.0, 1.0])
    }

    /// The centre of a sphere.
    fn centre_mm(&self) -> Option<PointMm> {
        match self.nominal {
            Nominal::Sphere { radius_mm } => Some(self.measured([0.0, 0.0, radius_mm])),
            _ => None,
        }
    }

    /// Where a line meets the surface, and the normal there: Newton's steps over the part's plane.
    fn met(&self, line: &Line) -> Option<(PointMm, Vector)> {
        let to_part = |mm: PointMm| self.motion().to_part(self.plane.to_plane(mm));
        let from = to_part(line.through_mm);
        let ahead = plus(to_part(plus(line.through_mm, 1.0, line.towards)), -1.0, from);
        let mut along = -from[2] / ahead[2];
        for _ in 0..STEPS {
            let [x, y, z] = plus(from, along, ahead);
            let jet = self.nominal.jet(x, y)?;
            let [p, q] = jet.gradient;
            along -= (z - jet.z_mm) / (ahead[2] - p * ahead[0] - q * ahead[1]);
        }
        let place = plus(from, along, ahead);
        let jet = self.nominal.jet(place[0], place[1])?;
        let [p, q] = jet.gradient;
        let normal = unit(self.direction([-p, -q, 1.0]))?;
        place.iter().all(|side| side.is_finite()).then(|| (self.measured(place), normal))
    }
}

/// A line that thickness counts along.
struct Line {
    through_mm: PointMm,
    /// Out of the first face.
    towards: Vector,
    of: Along,
}

/// Whose line it is.
#[derive(Clone, Copy, PartialEq)]
enum Along {
    First,
    Second,
    Both,
}

fn line(first: &Lying, second: &Lying) -> Option<Line> {
    let along_axis = |of: &Lying, turn: f64, along: Along| Line {
        through_mm: of.measured([0.0; 3]),
        towards: of.axis().map(|side| turn * side),
        of: along,
    };
    if first.has_vertex() {
        return Some(along_axis(first, 1.0, Along::First));
    }
    if second.has_vertex() {
        return Some(along_axis(second, -1.0, Along::Second));
    }
    let of = Along::Both;
    let line = match (first.centre_mm(), second.centre_mm()) {
        (Some(a), Some(b)) => {
            // Centres in one place leave the line open: then it is that of the first face.
            let apart = plus(a, -1.0, b);
            let is_open = length(apart) < OPEN * length(plus(a, -1.0, first.measured([0.0; 3])));
            let towards = if is_open { first.axis() } else { unit(apart)? };
            // Out of the first face, whichever centre lies ahead.
            let turn = if dot(towards, first.axis()) < 0.0 { -1.0 } else { 1.0 };
            Line { through_mm: a, towards: towards.map(|side| turn * side), of }
        }
        (Some(a), None) => Line { through_mm: a, towards: second.axis().map(|side| -side), of },
        (None, Some(b)) => Line { through_mm: b, towards: first.axis(), of },
        (None, None) => along_axis(first, 1.0, Along::First),
    };
    Some(line)
}

/// Figures that have a sign: thickness in mm, wedge and tilt in rad and decentre in mm, the last three by components across the line.
fn figures_of(first: &Lying, second: &Lying) -> Option<[f64; 7]> {
    let line = line(first, second)?;
    let ((a_mm, normal_a), (b_mm, normal_b)) = (first.met(&line)?, second.met(&line)?);
    let thickness_mm = dot(plus(a_mm, -1.0, b_mm), line.towards);
    let [u, v] = across(line.towards)?;
    let components = |of: Vector| [dot(of, u), dot(of, v)];
    let (other, vertex_mm) = match line.of {
        Along::Second => (normal_a, first.measured([0.0; 3])),
        _ => (normal_b.map(|side| -side), second.measured([0.0; 3])),
    };
    let wedge = components(other);
    let tilt = components(plus(second.axis().map(|side| -side), -1.0, first.axis()));
    let decentre = components(plus(vertex_mm, -1.0, line.through_mm));
    Some([thickness_mm, wedge[0], wedge[1], tilt[0], tilt[1], decentre[0], decentre[1]])
}

/// Two directions across another, the same ones for directions close together.
fn across(direction: Vector) -> Option<[Vector; 2]> {
    let least = (0..3).min_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs()))?;
    let mut helper = [0.0; 3];
    helper[least] = 1.0;
    let u = unit(cross(direction, helper))?;
    Some([u, cross(direction, u)])
}

/// How the second face lies to the first. `None` where they do not meet a common line.
///
/// Uncertainties follow from those of the two poses. An error of the threshold moves both faces out of the material, or both into it: of
/// the thickness its parts add up.
pub fn between(first: &Lying, second: &Lying) -> Option<FacesFigures> {
    let values = figures_of(first, second)?;
    let mut variances = [0.0; 7];
    let mut by_height = [[0.0; 7]; 2];
    for (side, lying) in [first, second].into_iter().enumerate() {
        let mut slopes = [[0.0; 7]; 6];
        for (parameter, slope) in slopes.iter_mut().enumerate() {
            let at = |by: f64| {
                let moved = lying.moved(parameter, by);
                if side == 0 { figures_of(&moved, second) } else { figures_of(first, &moved) }
            };
            let (more, less) = (at(STEP)?, at(-STEP)?);
            *slope = std::array::from_fn(|i| (more[i] - less[i]) / (2.0 * STEP));
        }
        by_height[side] = slopes[2];
        for (figure, variance) in variances.iter_mut().enumerate() {
            for (i, row) in lying.covariance.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    *variance += slopes[i][figure] * entry * slopes[j][figure];
                }
            }
        }
    }
    variances[0] += 2.0 * by_height[0][0] * by_height[1][0] * first.rise_mm * second.rise_mm;
    let known = |value: f64, variance: f64, unit: &str, factor: f64| ParameterFigures {
        value: value * factor,
        unit: unit.to_owned(),
        u: Some(variance.max(0.0).sqrt() * factor).filter(|u| u.is_finite()),
        expanded_95: None,
        u_by_form: None,
    };
    let size = |at: usize, unit: &str, factor: f64| {
        let value = values[at].hypot(values[at + 1]);
        known(value, variances[at].max(variances[at + 1]), unit, factor)
    };
    let of = line(first, second)?.of;
    let axes = first.has_axis() && second.has_axis();
    let vertices = first.has_vertex() && second.has_vertex();
    let mut unknown = Vec::new();
    if of == Along::Both {
        unknown.push(
            "wedge: the line is normal to both faces, for neither has an axis of its own"
                .to_owned(),
        );
    }
    if !vertices {
        unknown.push("tilt and decentre: a sphere has no axis, a plane no vertex".to_owned());
    }
    Some(FacesFigures {
        along: match of {
            Along::First => "axis of the first face",
            Along::Second => "axis of the second face",
            Along::Both => "common normal of the two faces",
        }
        .to_owned(),
        centre_thickness: known(values[0], variances[0], "mm", 1.0),
        wedge: (of != Along::Both).then(|| size(1, "arcmin", ARCMIN)),
        tilt: (axes && vertices).then(|| size(3, "arcmin", ARCMIN)),
        decentre: vertices.then(|| size(5, "µm", 1e3)),
        unknown,
    })
}

/// The pose in the frame of a plane of a motion into the measured frame.
fn in_plane(plane: &Plane, to_measured: impl Fn(PointMm) -> PointMm) -> [f64; 6] {
    let at = |part_mm| plane.to_plane(to_measured(part_mm));
    let origin = at([0.0; 3]);
    let column = |axis: usize| {
        let mut part = [0.0; 3];
        part[axis] = 1.0;
        plus(at(part), -1.0, origin)
    };
    let (x, y, z) = (column(0), column(1), column(2));
    // The matrix Rz·Ry·Rx has −sin ry below its first column.
    let ry = (-x[2]).atan2(x[0].hypot(x[1]));
    let (rx, rz) = (y[2].atan2(z[2]), x[1].atan2(x[0]));
    debug_assert!((length(x) - 1.0).abs() < 1e-6);
    [origin[0], origin[1], origin[2], rx, ry, rz]
}

const NAMES: [&str; 6] = ["tx", "ty", "tz", "rx", "ry", "rz"];
/// Centres nearer than this share of the radius are one.
const OPEN: f64 = 0.01;
/// Newton's steps to a surface.
const STEPS: usize = 20;
/// The step of derivatives, mm and rad.
const STEP: f64 = 1e-5;
const ARCMIN: f64 = 60.0 * 180.0 / std::f64::consts::PI;
