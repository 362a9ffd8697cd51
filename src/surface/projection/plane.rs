//! The plane of projection: where it lies in space, and the way into it and back.

use std::fmt;

use asphera_geometry::PointMm;
use thiserror::Error;

use super::directions::upwards;
use super::principal::Principal;
use crate::relief::legible;

/// A plane to project on, with a right-handed frame u, v, w: w is its normal.
///
/// In the frame a surface is a height w(u, v), as [`asphera_mesh::Mesh`] takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    origin_mm: PointMm,
    /// Unit vectors of u, v and w.
    axes: [[f64; 3]; 3],
}

/// Why there is no plane.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PlaneError {
    /// The normal has no direction, or a coordinate is not finite.
    #[error("normal {normal:?} at {origin_mm:?} mm is zero or not finite")]
    Normal {
        /// The normal, of any length.
        normal: [f64; 3],
        /// The origin in mm.
        origin_mm: PointMm,
    },
    /// A coordinate of a point is NaN or infinite.
    #[error("a coordinate of {points} points is not finite")]
    NotFinite {
        /// How many points were given.
        points: usize,
    },
    /// Fewer than three points.
    #[error("{points} points do not determine a plane")]
    TooFew {
        /// How many points were given.
        points: usize,
    },
    /// All points lie in one place.
    #[error("{points} points in one place at {at_mm:?} mm do not determine a plane")]
    OnePlace {
        /// How many points were given.
        points: usize,
        /// Where they are in mm.
        at_mm: PointMm,
    },
    /// The points lie on a straight line, but for less than a thousandth of its length: planes turned
    /// about it fit as well.
    #[error(
        "points on a line do not determine a plane: they spread {length_mm} mm along it and {width_mm} mm across"
    )]
    OnLine {
        /// Standard deviation along the line in mm.
        length_mm: f64,
        /// Standard deviation across it in mm, where it is larger.
        width_mm: f64,
    },
    /// The points follow one plane curve, such as a single scan line over a curved surface. The plane
    /// through it stands upright on the surface.
    #[error(
        "points on one curve do not determine the plane of a surface: they spread {length_mm} mm along it and {width_mm} mm across"
    )]
    OnCurve {
        /// Standard deviation along the chord in mm.
        length_mm: f64,
        /// Standard deviation across the chord, in the plane of the curve, in mm.
        width_mm: f64,
    },
}

impl Plane {
    /// The plane z = 0 with the frame of the points: passage to it and back changes no bit.
    pub const XY: Plane =
        Plane { origin_mm: [0.0; 3], axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// The plane through `origin_mm` with a normal of any length.
    ///
    /// u and v depend on the normal alone: they are the axes x and y turned along with z by the
    /// shortest way to the normal, or, below the horizon, x and -y turned along with -z. Formulas of
    /// T. Duff et al., Building an Orthonormal Basis, Revisited, Journal of Computer Graphics
    /// Techniques 6(1) (2017) 1-8, exact to rounding for all normals; a normal along z gives the
    /// axes x, y and z themselves.
    pub fn new(origin_mm: PointMm, normal: [f64; 3]) -> Result<Plane, PlaneError> {
        let largest = normal.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let finite = normal.iter().chain(&origin_mm).all(|coordinate| coordinate.is_finite());
        if !finite || largest == 0.0 {
            return Err(PlaneError::Normal { normal, origin_mm });
        }
        // Scaled first, so that no square over- or underflows.
        let scaled = normal.map(|x| x / largest);
        let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [x, y, z] = scaled.map(|x| x / length);
        let sign = 1.0_f64.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        let axes =
            [[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y], [x, y, z]];
        // Adding zero makes negative zeros positive: equal planes then have equal bits.
        Ok(Plane { origin_mm, axes: axes.map(|axis| axis.map(|x| x + 0.0)) })
    }

    /// The plane through the mean of the points, normal to the direction of their smallest spread
    /// (total least squares). Of the two normals the one with positive z; y and x decide if z is 0.
    ///
    /// It is meant for the first points of a measurement, and refuses those that do not determine a
    /// plane. What it cannot know: whether a surface has been seen widely enough. The first rows of
    /// a strongly curved surface give their own plane. Linear time but for a sort.
    pub fn fitted(points: &[PointMm]) -> Result<Plane, PlaneError> {
        let principal = principal(points)?;
        let [length_mm, width_mm, _] = principal.spread_mm;
        if follow_curve(points, &principal) {
            return Err(PlaneError::OnCurve { length_mm, width_mm });
        }
        Plane::new(principal.centre_mm, upwards(principal.axes[2]))
    }

    /// A point of the plane in mm, where u, v and w are zero.
    pub fn origin_mm(&self) -> PointMm {
        self.origin_mm
    }

    /// The unit vectors of u, v and w, right-handed.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        self.axes
    }

    /// The unit normal: the unit vector of w.
    pub fn normal(&self) -> [f64; 3] {
        self.axes[2]
    }

    /// u, v and w in mm of a point.
    pub fn to_plane(&self, point: PointMm) -> PointMm {
        if *self == Plane::XY {
            return point;
        }
        let [x, y, z] = std::array::from_fn(|axis| point[axis] - self.origin_mm[axis]);
        self.axes.map(|axis| axis[0] * x + axis[1] * y + axis[2] * z)
    }

    /// The point with these u, v and w in mm.
    pub fn from_plane(&self, uvw_mm: PointMm) -> PointMm {
        if *self == Plane::XY {
            return uvw_mm;
        }
        let [u, v, w] = self.axes;
        std::array::from_fn(|axis| {
            self.origin_mm[axis] + (u[axis] * uvw_mm[0] + v[axis] * uvw_mm[1] + w[axis] * uvw_mm[2])
        })
    }

    /// The angle between the normal and z in rad, 0 to π.
    pub fn tilt_rad(&self) -> f64 {
        let [x, y, z] = self.normal();
        x.hypot(y).atan2(z)
    }
}

impl fmt::Display for Plane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nx, ny, _] = self.normal();
        let [x, y, z] = self.origin_mm.map(legible);
        let tilt_deg = self.tilt_rad().to_degrees();
        if nx == 0.0 && ny == 0.0 {
            write!(f, "normal {} z", if tilt_deg < 90.0 { "along" } else { "against" })?;
        } else {
            let azimuth_deg = ny.atan2(nx).to_degrees();
            write!(f, "normal {tilt_deg:.3}° from z towards {azimuth_deg:.3}° from x to y")?;
        }
        write!(f, ", through ({x}, {y}, {z}) mm")
    }
}

/// The principal axes of points that are neither in one place nor on a line.
pub(crate) fn principal(points: &[PointMm]) -> Result<Principal, PlaneError> {
    let count = points.len();
    if count < 3 {
        return Err(PlaneError::TooFew { points: count });
    }
    let principal = Principal::of(points).ok_or(PlaneError::NotFinite { points: count })?;
    let [length_mm, width_mm, _] = principal.spread_mm;
    if points.iter().all(|point| *point == points[0]) {
        Err(PlaneError::OnePlace { points: count, at_mm: points[0] })
    } else if width_mm <= LINE_SHARE * length_mm {
        Err(PlaneError::OnLine { length_mm, width_mm })
    } else {
        Ok(principal)
    }
}

/// Whether the points lie in one plane and go through it on a single curve.
///
/// Taken in the order of the longest axis, the points of an area go up and down across it again and
/// again, once for each column of a raster, while those of a curve do so once or a few times.
fn follow_curve(points: &[PointMm], principal: &Principal) -> bool {
    let [length_mm, width_mm, height_mm] = principal.spread_mm;
    if points.len() < CURVE_POINTS || height_mm > LINE_SHARE * length_mm.min(width_mm) {
        return false;
    }
    let along = |axis: [f64; 3], point: &PointMm| -> f64 {
        (0..3).map(|i| axis[i] * (point[i] - principal.centre_mm[i])).sum()
    };
    let [long, across, _] = principal.axes;
    let mut places: Vec<[f64; 2]> =
        points.iter().map(|point| [along(long, point), along(across, point)]).collect();
    places.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    let gone_mm: f64 = places.windows(2).map(|pair| (pair[1][1] - pair[0][1]).abs()).sum();
    let range = places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| {
        [low.min(place[1]), high.max(place[1])]
    });
    gone_mm < CURVE_TURNS * (range[1] - range[0])
}

/// Points that spread less across than this share of their spread along are on a line.
const LINE_SHARE: f64 = 1e-3;

/// Fewer points are not asked whether they follow a curve.
const CURVE_POINTS: usize = 32;

/// How often a curve crosses its own range, at most. 32 points of a raster along its longer side
/// cross it at least eleven times: in six columns up and five times back.
const CURVE_TURNS: f64 = 8.0;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    #[test]
    fn the_z_axis_changes_no_bit() {
        assert_eq!(Plane::new([0.0; 3], [0.0, 0.0, 5.0]), Ok(Plane::XY));
        for point in [[-0.0, 1e-300, f64::NAN], [f64::INFINITY, -1e12, 0.1]] {
            assert_eq!(Plane::XY.to_plane(point).map(f64::to_bits), point.map(f64::to_bits));
            assert_eq!(Plane::XY.from_plane(point).map(f64::to_bits), point.map(f64::to_bits));
        }
    }

    #[test]
    fn known_frames() {
        let down = Plane::new([1.0, 2.0, 3.0], [0.0, 0.0, -2.0]).unwrap();
        assert_eq!(down.axes(), [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]);
        assert_eq!(down.to_plane([2.0, 4.0, 6.0]), [1.0, -2.0, -3.0]);
        let along_x = Plane::new([0.0; 3], [1e-200, 0.0, 0.0]).unwrap();
        assert_eq!(along_x.axes(), [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn a_statement_for_people() {
        assert_eq!(Plane::XY.to_string(), "normal along z, through (0, 0, 0) mm");
        let half = 0.5_f64.sqrt();
        let tilted = Plane::new([1.0, 2.0, 3.5], [half * half, half * half, half]).unwrap();
        let said = "normal 45.000° from z towards 45.000° from x to y, through (1, 2, 3.5) mm";
        assert_eq!(tilted.to_string(), said);
        let down = Plane::new([0.0; 3], [0.0, 0.0, -1.0]).unwrap();
        assert!(down.to_string().starts_with("normal against z"));
    }

    #[test]
    fn no_normal_no_plane() {
        for normal in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
            assert!(matches!(Plane::new([0.0; 3], normal), Err(PlaneError::Normal { .. })));
        }
        assert!(Plane::new([f64::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]).is_err());
    }

    #[test]
    fn points_that_do_not_determine_a_plane() {
        let fitted = |points: &[PointMm]| Plane::fitted(points).unwrap_err();
        assert_eq!(fitted(&[]), PlaneError::TooFew { points: 0 });
        assert_eq!(fitted(&[[1.0; 3], [2.0; 3]]), PlaneError::TooFew { points: 2 });
        let at_mm = [0.1, 0.2, 0.3];
        assert_eq!(fitted(&[at_mm; 7]), PlaneError::OnePlace { points: 7, at_mm });
        let line: Vec<PointMm> =
            (0..9).map(|i| [0.1, 0.7, 0.3].map(|x| 1e6 + x * f64::from(i))).collect();
        assert!(matches!(fitted(&line), PlaneError::OnLine { .. }));
        assert_eq!(fitted(&[[f64::NAN; 3]; 3]), PlaneError::NotFinite { points: 3 });
        // One scan line over a sphere lies in the plane y = 2.
        let scan = (0..200).map(|i| 0.1 * f64::from(i) - 10.0);
        let scan: Vec<PointMm> = scan.map(|x| [x, 2.0, (900.0 - x * x).sqrt()]).collect();
        assert!(matches!(fitted(&scan), PlaneError::OnCurve { .. }), "{:?}", fitted(&scan));
    }

    #[test]
    fn a_raster_of_a_few_rows_determines_its_plane() {
        for (columns, rows) in [(6, 6), (20, 2), (100, 2), (100, 100), (3, 2)] {
            let nodes =
                (0..rows).flat_map(|j| (0..columns).map(move |i| (f64::from(i), f64::from(j))));
            let points: Vec<PointMm> = nodes.map(|(x, y)| [x, y, 2.0 * x]).collect();
            let plane = Plane::fitted(&points).unwrap();
            let expected = [-2.0, 0.0, 1.0].map(|x| x / 5.0_f64.sqrt());
            assert!(dot(plane.normal(), expected) > 1.0 - 1e-14, "{columns} × {rows}: {plane}");
        }
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn frames_are_right_handed_and_lead_back(
            normal in prop::array::uniform3(-1.0..1.0),
            origin in prop::array::uniform3(-1e3..1e3),
            point in prop::array::uniform3(-1e3..1e3),
        ) {
            let plane = Plane::new(origin, normal).unwrap();
            let [u, v, w] = plane.axes();
            for (a, b, expected) in
                [(u, u, 1.0), (v, v, 1.0), (w, w, 1.0), (u, v, 0.0), (v, w, 0.0), (w, u, 0.0)]
            {
                prop_assert!((dot(a, b) - expected).abs() < 1e-15);
            }
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            prop_assert!((dot(cross, w) - 1.0).abs() < 1e-15);
            let back = plane.from_plane(plane.to_plane(point));
            for axis in 0..3 {
                prop_assert!((back[axis] - point[axis]).abs() < 4e-12);
            }
        }

        #[test]
        fn a_plane_is_found_whatever_the_offset_and_scale(
            normal in prop::array::uniform3(-1.0..1.0),
            offset in prop::array::uniform3(-1e6..1e6),
            power in -6_i32..=6,
        ) {
            let truth = Plane::new([0.0; 3], normal).unwrap();
            let scale = 10.0_f64.powi(power);
            // The offset keeps its ratio to the size: what remains is the rounding of the points.
            let points: Vec<PointMm> = (0..400_u32)
                .map(|i| [10.0 * f64::from(i % 20), 7.0 * f64::from(i / 20), 0.0])
                .map(|uvw| truth.from_plane(uvw))
                .map(|p| std::array::from_fn(|axis| scale * (p[axis] + offset[axis])))
                .collect();
            let plane = Plane::fitted(&points).unwrap();
            let cosine = dot(plane.normal(), truth.normal()).abs();
            prop_assert!(cosine > 1.0 - 1e-15, "{cosine}");
            for &point in &points {
                prop_assert!(plane.to_plane(point)[2].abs() < 1e-9 * scale);
            }
        }
    }
}
