//! Mirrors that image one point into another at grazing incidence: elliptic, hyperbolic, parabolic.

use std::sync::Arc;

use super::argument::{RADIUS, count, parameter, refused};
use super::taylor::{defined, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// A mirror given by its source distance p, its image distance q and its grazing angle θ.
///
/// Frame: origin at the centre of the mirror, x along it in the sense of the light, z along the normal to
/// the side the light comes from. The source is at (−p·cos θ, 0, p·sin θ), the image at
/// (q·cos θ, 0, q·sin θ). A negative distance is that of a virtual point behind the mirror, an infinite one
/// that of parallel light, so that one family holds all figures:
///
/// | p, q | figure |
/// | --- | --- |
/// | both positive | ellipse, concave |
/// | one negative | hyperbola; concave where 1/p + 1/q > 0, else convex |
/// | one infinite | parabola; concave where the other is positive, else convex |
/// | both negative | ellipse, convex |
///
/// With h = 1/(1/p + 1/q) and m = (p − q)/(p + q) every one of them is, through the origin,
///
/// ```text
/// (1 − m²·sin²θ)·z² − 2·sin θ·(2h − m·x·cos θ)·z + x²·sin²θ + y² = 0,
/// ```
///
/// without y² for a cylinder. It follows from the constant sum (or difference) of the distances to the two
/// points, p + q with signs, by squaring twice; the same surfaces, in other coefficients, are in Goldberg,
/// J. Synchrotron Rad. 29 (2022) 991 and in Sanchez del Rio & Goldberg, arXiv:2406.04079.
///
/// ```
/// use asphera_form::shape::{Mirror, Shape};
///
/// // 30 m from the source, focus after half a metre, 3 mrad: 327.87 m of radius at the centre.
/// let mirror = Mirror::cylindrical(30_000.0, 500.0, 3e-3)?;
/// let bend_per_mm = mirror.jet(0.0, 0.0).map(|jet| jet.hessian_per_mm[0]);
/// assert!(bend_per_mm.is_some_and(|bend| (1.0 / bend - 327_869.3).abs() < 0.1));
/// # Ok::<(), asphera_form::shape::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    source_mm: f64,
    image_mm: f64,
    grazing_rad: f64,
    revolved: bool,
    sin: f64,
    cos: f64,
    h_mm: f64,
    m: f64,
    /// 1 − m²·sin²θ.
    a: f64,
}

impl Mirror {
    /// A cylinder: the figure along x, straight along y. Parameters `p` and `q`, those that are finite, and
    /// `theta`. Fails on distances that are 0, NaN, both infinite or opposite (the last two are plane
    /// mirrors), and on a grazing angle outside 0 < θ ≤ π/2.
    pub fn cylindrical(
        source_mm: f64,
        image_mm: f64,
        grazing_rad: f64,
    ) -> Result<Mirror, ShapeError> {
        Mirror::new(source_mm, image_mm, grazing_rad, false)
    }

    /// The figure turned about the line through source and image: ellipsoid, hyperboloid, paraboloid.
    /// Otherwise as [`Mirror::cylindrical`].
    pub fn revolved(source_mm: f64, image_mm: f64, grazing_rad: f64) -> Result<Mirror, ShapeError> {
        Mirror::new(source_mm, image_mm, grazing_rad, true)
    }

    /// Source distance p in mm; negative if virtual, infinite for parallel light.
    pub fn source_mm(&self) -> f64 {
        self.source_mm
    }

    /// Image distance q in mm; negative if virtual, infinite for parallel light.
    pub fn image_mm(&self) -> f64 {
        self.image_mm
    }

    /// Grazing angle θ at the centre in rad.
    pub fn grazing_rad(&self) -> f64 {
        self.grazing_rad
    }

    fn new(p: f64, q: f64, theta: f64, revolved: bool) -> Result<Mirror, ShapeError> {
        let figure = figure(p, q, revolved);
        for (name, distance) in [("p", p), ("q", q)] {
            if distance == 0.0 || distance.is_nan() {
                return Err(refused(figure, name, distance, "a distance other than 0"));
            }
        }
        let in_range = theta > 0.0 && theta <= std::f64::consts::FRAC_PI_2;
        if !in_range {
            return Err(refused(figure, "theta", theta, "a grazing angle above 0, at most pi/2"));
        }
        let (by_source, by_image) = (p.recip(), q.recip());
        let h_mm = (by_source + by_image).recip();
        if !h_mm.is_normal() {
            return Err(refused(figure, "q", q, "other than -p (that mirror is plane)"));
        }
        let m = (by_image - by_source) * h_mm;
        let (sin, cos) = theta.sin_cos();
        let a = (1.0 - m * sin) * (1.0 + m * sin);
        Ok(Mirror { source_mm: p, image_mm: q, grazing_rad: theta, revolved, sin, cos, h_mm, m, a })
    }

    /// The height as the root of a·z² − 2b·z + c = 0 that is 0 at the origin.
    fn terms(&self, x: f64, y: f64) -> Option<Terms> {
        let across = if self.revolved { y } else { 0.0 };
        let sx = self.sin * x;
        let b = self.sin * (2.0 * self.h_mm - self.m * self.cos * x);
        let c = sx * sx + across * across;
        let square = b * b - self.a * c;
        // Beyond the end of the sheet through the origin b has changed its sign, unless a < 0, where the
        // sheet has no end.
        let side = self.h_mm.signum();
        let on_sheet = side * b > 0.0 || self.a < 0.0;
        (y.is_finite() && square > 0.0 && on_sheet).then(|| {
            let root = side * square.sqrt();
            // Of the two forms of the root the one that adds numbers of the same sign.
            let z = if side * b > 0.0 { c / (b + root) } else { (b - root) / self.a };
            Terms { across, root, z }
        })
    }
}

struct Terms {
    /// y, or 0 for a cylinder.
    across: f64,
    /// b − a·z, minus half the derivative of the equation by z.
    root: f64,
    z: f64,
}

impl Shape for Mirror {
    fn kind(&self) -> &'static str {
        figure(self.source_mm, self.image_mm, self.revolved)
    }

    /// From the derivatives of the equation, by the implicit function theorem.
    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let Terms { across, root, z } = self.terms(x_mm, y_mm)?;
        let square = self.sin * self.sin;
        let skew = self.sin * self.cos * self.m;
        let z_x = (square * x_mm + skew * z) / root;
        let z_y = across / root;
        let bend_y = if self.revolved { 1.0 } else { 0.0 };
        defined(Jet {
            z_mm: z,
            gradient: [z_x, z_y],
            hessian_per_mm: [
                (square + (2.0 * skew + self.a * z_x) * z_x) / root,
                (skew + self.a * z_x) * z_y / root,
                (bend_y + self.a * z_y * z_y) / root,
            ],
        })
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.terms(x_mm, y_mm).and_then(|terms| number(terms.z))
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let distances = [("p", self.source_mm), ("q", self.image_mm)];
        let finite = distances.iter().filter(|(_, distance)| distance.is_finite());
        finite
            .map(|&(name, distance)| parameter(name, "mm", distance))
            .chain([parameter("theta", "rad", self.grazing_rad)])
            .collect()
    }

    /// With G the left side of the equation: ∂z/∂parameter = ∂G/∂parameter/(2·root).
    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let Terms { root, z, .. } = self.terms(x_mm, y_mm)?;
        let Mirror { sin, cos, h_mm: h, m, .. } = *self;
        let by_h = -4.0 * sin * z;
        let by_m = 2.0 * sin * z * (cos * x_mm - sin * m * z);
        // dh/dp = h²/p², dm/dp = 2h²/(p²·q); with p and q exchanged the latter changes its sign.
        let ratios = [(self.source_mm, self.image_mm, 1.0), (self.image_mm, self.source_mm, -1.0)];
        let distances = ratios.into_iter().filter(|(own, _, _)| own.is_finite());
        let by_distance = distances.map(|(own, other, sign)| {
            let square = (h / own) * (h / own);
            square * (by_h + 2.0 * sign * by_m / other)
        });
        let by_angle = -2.0 * sin * cos * m * m * z * z
            - 2.0 * (2.0 * h * cos - (cos - sin) * (cos + sin) * m * x_mm) * z
            + 2.0 * sin * cos * x_mm * x_mm;
        let all = by_distance.chain([by_angle]);
        derivatives.iter_mut().zip(all).for_each(|(place, value)| *place = value / (2.0 * root));
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        let kind = self.kind();
        let names = self.parameters();
        count(kind, values, names.len())?;
        for (known, &value) in names.iter().zip(values) {
            if !value.is_finite() {
                return Err(refused(kind, known.name.as_str(), value, RADIUS));
            }
        }
        let mut left = values.iter().copied();
        let mut next = |own: f64| if own.is_finite() { left.next().unwrap_or(own) } else { own };
        let (p, q) = (next(self.source_mm), next(self.image_mm));
        let theta = next(self.grazing_rad);
        Ok(Arc::new(Mirror::new(p, q, theta, self.revolved)?))
    }

    /// The place next to the origin where b² = a·c. For a cylinder that is x = 2h/(m·cos θ ± √a). For a
    /// figure of revolution it is the shortest radius r with 2|h|/r = m·cos θ·C + √a·√(C² + (1−C²)/sin²θ)
    /// over the cosines C of its azimuth, in closed form.
    fn domain_mm(&self) -> f64 {
        if self.a < 0.0 {
            return f64::INFINITY;
        }
        let along = self.m.abs() * self.cos;
        if self.revolved && self.m.abs() * self.sin <= self.cos {
            return 2.0 * self.h_mm.abs() * self.sin;
        }
        2.0 * self.h_mm.abs() / (along + self.a.sqrt())
    }
}

fn figure(p: f64, q: f64, revolved: bool) -> &'static str {
    match (p.is_infinite() || q.is_infinite(), p * q > 0.0, revolved) {
        (true, _, false) => "parabolic cylinder",
        (true, _, true) => "paraboloid",
        (false, true, false) => "elliptic cylinder",
        (false, true, true) => "ellipsoid",
        (false, false, false) => "hyperbolic cylinder",
        (false, false, true) => "hyperboloid",
    }
}
