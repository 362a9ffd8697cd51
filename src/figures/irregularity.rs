//! The decomposition of ISO 10110-5 and ISO 14999-4, and its figures.
//!
//! ```text
//! measured ─ piston, tilt ─▶ total ─ sphere ─▶ irregularity ─ azimuthal mean ─▶ rotationally variant
//!                            RMSt    PV: A     PV: B, RMSi    PV: C             RMSa
//! ```

use std::num::NonZeroU16;

use nalgebra::{Matrix4, Vector4};

use super::invariant::{Invariant, usual_rings};
use super::least_squares::least_squares;
use super::{Definition, Figure, Sample, SettingError, Unknown};

/// What the approximating sphere looks like as a deviation along the normal of the nominal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Approximation {
    /// c·r²: the quadratic part, for planes (of which a long radius is one) and aspheres.
    Quadratic,
    /// c·(1 − √(1 − (r/R)²)): what a change of radius and a shift along the axis do to a sphere. Make it
    /// by [`Approximation::sphere`].
    Sphere {
        /// Radius R of the nominal sphere in mm, of either sign.
        radius_mm: f64,
    },
}

impl Approximation {
    /// That of a nominal sphere. Fails unless the radius is finite and not 0.
    pub fn sphere(radius_mm: f64) -> Result<Approximation, SettingError> {
        if radius_mm.is_finite() && radius_mm != 0.0 {
            Ok(Approximation::Sphere { radius_mm })
        } else {
            Err(SettingError::Radius { value_mm: radius_mm })
        }
    }

    /// Piston, both tilts and sphere at a place.
    fn row(self, [x, y]: [f64; 2], reach_mm: f64) -> [f64; 4] {
        [1.0, x / reach_mm, y / reach_mm, self.shape(x.hypot(y), reach_mm)]
    }

    /// Height at a distance from the axis, 0 on the axis and in units that leave it near 1 at `reach_mm`
    /// for flat surfaces.
    fn shape(self, r_mm: f64, reach_mm: f64) -> f64 {
        let u = r_mm / reach_mm;
        match self {
            Approximation::Quadratic => u * u,
            Approximation::Sphere { radius_mm } => {
                // 1 − √(1 − q) = q/(1 + √(1 − q)), in units of (reach/R)²/2.
                let q = (r_mm / radius_mm) * (r_mm / radius_mm);
                2.0 * u * u / (1.0 + (1.0 - q).max(0.0).sqrt())
            }
        }
    }
}

/// The parts of a deviation and their figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregularity {
    /// Surface taken for the sphere.
    pub approximation: Approximation,
    /// Intervals asked for in the azimuthal mean.
    pub rings: NonZeroU16,
    /// Rise of the approximating sphere from the innermost to the outermost place of the aperture in nm:
    /// A with its sign, positive if the rim deviates to +z.
    pub sagitta_nm: f64,
    /// A in nm: the size of that rise.
    pub a_nm: f64,
    /// B in nm.
    pub b_nm: f64,
    /// C in nm.
    pub c_nm: f64,
    /// RMSt in nm.
    pub rms_total_nm: f64,
    /// RMSi in nm.
    pub rms_irregularity_nm: f64,
    /// RMSa in nm.
    pub rms_variant_nm: f64,
    /// Deviation less piston and tilt in nm, one a place of the sample: sphere plus irregularity.
    pub total_nm: Vec<f64>,
    /// The irregularity in nm, one a place.
    pub irregularity_nm: Vec<f64>,
    /// Its rotationally invariant part in nm, one a place.
    pub invariant_nm: Vec<f64>,
    /// Its rotationally variant part in nm, one a place: irregularity less invariant part.
    pub variant_nm: Vec<f64>,
}

impl Irregularity {
    /// A, B, C, RMSt, RMSi and RMSa.
    pub fn figures(&self) -> [Figure; 6] {
        [
            Figure::new(Definition::Sagitta, self.a_nm),
            Figure::new(Definition::Irregularity, self.b_nm),
            Figure::new(Definition::InvariantIrregularity, self.c_nm),
            Figure::new(Definition::RmsTotal, self.rms_total_nm),
            Figure::new(Definition::RmsIrregularity, self.rms_irregularity_nm),
            Figure::new(Definition::RmsVariant, self.rms_variant_nm),
        ]
    }

    /// Heights in nm, one a place, whose mean square is that of the figure; of A those that are left beside it.
    pub(super) fn averaged_nm(self, definition: &Definition) -> Option<Vec<f64>> {
        match definition {
            Definition::RmsTotal => Some(self.total_nm),
            Definition::RmsVariant => Some(self.variant_nm),
            Definition::RmsIrregularity | Definition::Sagitta => Some(self.irregularity_nm),
            _ => None,
        }
    }
}

/// Decomposes a deviation by ISO 10110-5:2015 with the functions of ISO 14999-4:2015.
///
/// Piston, tilt and sphere are fitted together, by area-weighted least squares, so that over a part that
/// is not measured evenly a sphere does not appear as tilt or irregularity. The sphere's mean over the
/// points is taken as 0. A is its range over the aperture, not only over the measured places: a gap at the
/// rim does not make it smaller. The azimuthal mean is a broken line in the radius with `rings` intervals,
/// by default as many as leave some sixteen points in the innermost, 256 at most; where a ring is not measured
/// all around, what varies with the azimuth does not quite average out of it. `O(n)`.
///
/// Unknown with fewer than 5 points or where they do not determine the sphere.
pub fn decompose(
    sample: &Sample,
    approximation: Approximation,
    rings: Option<NonZeroU16>,
) -> Result<Irregularity, Unknown> {
    let Levelled { total_nm, irregular, sagitta_nm } = levelled(sample, approximation)?;
    let rings = rings.unwrap_or_else(|| usual_rings(sample));
    let invariant = Invariant::new(&irregular, rings);
    let radii = sample.places_mm().iter().map(|place| place[0].hypot(place[1]));
    let invariant_nm: Vec<f64> = radii.map(|radius_mm| invariant.at(radius_mm)).collect();
    let irregularity_nm = irregular.values_nm().to_vec();
    let variant_nm: Vec<f64> =
        irregularity_nm.iter().zip(&invariant_nm).map(|(whole, mean)| whole - mean).collect();
    let rms = |values: &[f64]| sample.mean(|i| values[i] * values[i]).sqrt();
    let range = |values: &[f64]| Sample::range(values).map_or(0.0, |[low, high]| high - low);
    Ok(Irregularity {
        approximation,
        rings,
        sagitta_nm,
        a_nm: sagitta_nm.abs(),
        b_nm: range(&irregularity_nm),
        c_nm: range(&invariant_nm),
        rms_total_nm: rms(&total_nm),
        rms_irregularity_nm: rms(&irregularity_nm),
        rms_variant_nm: rms(&variant_nm),
        total_nm,
        irregularity_nm,
        invariant_nm,
        variant_nm,
    })
}

/// The irregularity of [`decompose`] alone, as a sample of the same places. Linear in the deviations. `O(n)`.
pub fn irregular(sample: &Sample, approximation: Approximation) -> Result<Sample, Unknown> {
    levelled(sample, approximation).map(|found| found.irregular)
}

/// What the deviation at each place of a sample is worth to the rise of the sphere ([`Irregularity::sagitta_nm`]): the rise is the
/// mean over the area of deviation times gain. `None` where it is unknown. `O(n)`.
pub fn sagitta_gains(sample: &Sample, approximation: Approximation) -> Option<Vec<f64>> {
    let [near_mm, reach_mm] = sample.reach_mm();
    let row = |place: usize| Vector4::from(approximation.row(sample.places_mm()[place], reach_mm));
    let gram = Matrix4::from_fn(|i, j| sample.mean(|place| row(place)[i] * row(place)[j]));
    let at = |radius_mm| approximation.shape(radius_mm, reach_mm);
    let rise = Vector4::new(0.0, 0.0, 0.0, at(reach_mm) - at(near_mm));
    let weights = gram.cholesky()?.solve(&rise);
    Some((0..sample.len()).map(|place| weights.dot(&row(place))).collect())
}

/// A deviation without piston, tilt and sphere.
struct Levelled {
    /// With the sphere, in nm.
    total_nm: Vec<f64>,
    /// Without it.
    irregular: Sample,
    /// Rise of the sphere in nm.
    sagitta_nm: f64,
}

fn levelled(sample: &Sample, approximation: Approximation) -> Result<Levelled, Unknown> {
    let used = sample.weighted();
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    if used < LEAST_POINTS {
        return Err(Unknown::TooFewPoints { used, needed: LEAST_POINTS });
    }
    let [near_mm, reach_mm] = sample.reach_mm();
    if reach_mm == 0.0 {
        return Err(Unknown::OnePlace);
    }
    if let Approximation::Sphere { radius_mm } = approximation
        && reach_mm > radius_mm.abs()
    {
        return Err(Unknown::BeyondSphere { reach_mm, radius_mm });
    }
    let shape = |[x, y]: [f64; 2]| approximation.shape(x.hypot(y), reach_mm);
    let solution = least_squares(sample, 4, |place, row| {
        row.copy_from_slice(&approximation.row(place, reach_mm));
    });
    let curvature = solution.coefficients[3].ok_or(Unknown::IndeterminateSphere)?;
    let mean_shape = sample.mean(|i| shape(sample.places_mm()[i]));
    let plane = |[x, y]: [f64; 2]| {
        let tilt = solution.or_zero(1) * x + solution.or_zero(2) * y;
        solution.or_zero(0) + tilt / reach_mm + curvature * mean_shape
    };
    let points = || sample.places_mm().iter().zip(sample.values_nm());
    let total_nm: Vec<f64> = points().map(|(&place, value)| value - plane(place)).collect();
    let sphere = |place| curvature * (shape(place) - mean_shape);
    let places = sample.places_mm().iter().zip(&total_nm);
    let irregularity_nm: Vec<f64> = places.map(|(&place, total)| total - sphere(place)).collect();
    let irregular = sample.with_values(irregularity_nm);
    let at = |radius_mm| approximation.shape(radius_mm, reach_mm);
    let sagitta_nm = curvature * (at(reach_mm) - at(near_mm));
    Ok(Levelled { total_nm, irregular, sagitta_nm })
}

/// One more than piston, tilt and sphere have parameters.
const LEAST_POINTS: usize = 5;
