//! What the places that were taken do to the RMS and to the parameters of a fit.
//!
//! A figure counts points, the part has an area. With w the share of the area that a stratum of neighbours stands for, and
//! v that of a point of the stratum ([`super::strata`]), the mean square over the area is `Σ w·Σ v·r²`, and places scattered
//! within the strata leave it a variance of `Σ w²·s²·Σ v²` (Cochran, Sampling Techniques, 3rd ed., 5.3 and 5A.9), s² being that
//! of r² within a stratum, about an even rise where the weights v take one off (7.3). It is less of a raster, which is no
//! scatter; but so few points do not tell how much less.
//!
//! The fit counts points too. If every point counted by its area, the parameters would be off by H⁻¹·g, where
//! `H = Σ w·J·Jᵀ` and `g = Σ J·Σ (w·v − 1/N)·r`, and the mean square smaller by gᵀ·H⁻¹·g: Σ J·r over the points is
//! nought. As a fit follows what scatters, its mean square is then smaller than that of the area by the trace of
//! H⁻¹·var(g). This difference is known, yet the fit stays what it is: it counts as a standard uncertainty (JCGM 100:2008,
//! F.2.4.5 adds it to the expanded one, which is less).
//!
//! Noise makes a part of the variances within the strata. Whoever counts it apart takes it off.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::strata::{Stratum, strata};
use asphera_form::linear::Model;
use asphera_form::{Aperture, Fit, NM_PER_MM, Parameter, PointMm};

/// How the points of a measurement share the area, and what that does.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    /// Share of the area that each point given stands for; all add up to 1. 0 where a point does not count.
    pub shares: Vec<f64>,
    /// Points that count.
    pub count: usize,
    /// Mean square over the area about its own best fit, with the noise in it, in mm².
    mean_square_mm2: f64,
    /// What the fit took of that by following how the places scatter.
    followed: Variance,
    /// Variance of that.
    square: Variance,
    /// By how much noise of one size for all makes more of the variance of a mean than were all shares alike.
    pub(super) crowding: f64,
    /// What the places do to each estimate of the fit; empty where its points do not count alike.
    pub(super) moved: Vec<Moved>,
    /// Of the points given.
    pub(super) strata: Vec<Stratum>,
}

/// Effect of the places on an estimate, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moved {
    /// From the fit to that of the area.
    pub(super) shift: f64,
    scatter: Variance,
}

/// A variance with the noise in it, less its multiples of σ² and σ⁴.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Variance {
    whole: f64,
    of_square: f64,
    of_fourth: f64,
}

impl Variance {
    fn without(&self, noise_mm2: f64) -> f64 {
        let noise = self.of_square * noise_mm2 + self.of_fourth * noise_mm2 * noise_mm2;
        (self.whole - noise).max(0.0)
    }
}

impl Places {
    /// RMS over the area about its own best fit, the mean square of a noise in nm taken off, in nm; 0 where noise makes all of it.
    pub fn rms_nm(&self, noise_nm: f64) -> f64 {
        (self.mean_square_nm2(noise_nm) - noise_nm * noise_nm).max(0.0).sqrt()
    }

    /// Whether it is known what the places do to the parameters of the fit.
    pub fn is_of_fit(&self) -> bool {
        !self.moved.is_empty()
    }

    /// Mean square over the area with a noise in nm in it, in nm².
    pub(super) fn mean_square_nm2(&self, noise_nm: f64) -> f64 {
        let followed_mm2 = self.followed.without((noise_nm / NM_PER_MM).powi(2));
        (self.mean_square_mm2 + followed_mm2) * NM_PER_MM * NM_PER_MM
    }

    /// What places scattered otherwise would make of the mean square: its variance in nm⁴ beside that by noise.
    pub(super) fn variance_nm4(&self, noise_nm: f64) -> f64 {
        self.square.without((noise_nm / NM_PER_MM).powi(2)) * NM_PER_MM.powi(4)
    }
}

impl Moved {
    /// Variance by the places in the unit of the estimate, beside that by noise of a variance in mm².
    pub(super) fn variance(&self, noise_mm2: f64) -> f64 {
        self.shift * self.shift + self.scatter.without(noise_mm2)
    }
}

/// What the places of `points` do to `fit`, which left `deviations_mm` of them: NaN where a point does not count, as do
/// those outside `aperture`. `areas_mm2` is the area each point stands for, which counts where there is no aperture; all
/// stand for as much without it. `alike`: whether all points count alike in the fit. `None` with fewer than 8 points.
/// `O(n log n)`.
pub fn places(
    points: &[PointMm],
    deviations_mm: &[f64],
    fit: &Fit,
    aperture: &Aperture,
    areas_mm2: Option<&[f64]>,
    alike: bool,
) -> Option<Places> {
    let motion = fit.pose.motion();
    let place = |&point: &PointMm| {
        let [x, y, _] = motion.to_part(point);
        [x, y]
    };
    let places_mm: Vec<[f64; 2]> = points.iter().map(place).collect();
    let counts = |&index: &usize| {
        let [x, y] = places_mm[index];
        deviations_mm[index].is_finite() && aperture.contains(x, y)
    };
    let indices: Vec<usize> = (0..points.len().min(deviations_mm.len())).filter(counts).collect();
    if indices.len() < FEWEST {
        return None;
    }
    let strata = strata(&indices, &places_mm, aperture, areas_mm2);
    let all: Vec<Summed> = strata.iter().map(|of| Summed::new(of, deviations_mm)).collect();
    let mut found = Places {
        shares: vec![0.0; points.len()],
        count: indices.len(),
        mean_square_mm2: all.iter().map(|of| of.share * of.mean_square).sum(),
        followed: Variance::default(),
        square: all.iter().fold(Variance::default(), Summed::add_square),
        crowding: indices.len() as f64 * all.iter().map(|of| of.weight).sum::<f64>(),
        moved: Vec::new(),
        strata: Vec::new(),
    };
    for stratum in &strata {
        for (&index, weight) in stratum.members.iter().zip(&stratum.weights) {
            found.shares[index] = stratum.share * weight;
        }
    }
    if alike {
        let rows = rows(points, &places_mm, &strata, fit);
        if let Some(refit) = rows.and_then(|rows| refit(&all, &rows, indices.len())) {
            found.moved = refit.moved;
            found.mean_square_mm2 -= refit.less_mm2;
            found.followed = refit.followed;
        }
    }
    found.strata = strata;
    Some(found)
}

/// Sums over a stratum.
struct Summed {
    share: f64,
    /// What a variance within the stratum makes of that of a mean over the area.
    weight: f64,
    /// Σ v·r in mm.
    mean: f64,
    /// Σ r in mm.
    sum: f64,
    /// Σ v·r² in mm².
    mean_square: f64,
    /// Variance of r within the stratum in mm².
    variance: f64,
    /// Variance of r² in mm⁴.
    variance_of_square: f64,
}

impl Summed {
    fn new(stratum: &Stratum, deviations_mm: &[f64]) -> Summed {
        let values: Vec<f64> = stratum.members.iter().map(|&at| deviations_mm[at]).collect();
        let squares: Vec<f64> = values.iter().map(|r| r * r).collect();
        let weighted = |of: &dyn Fn(f64) -> f64| {
            values.iter().zip(&stratum.weights).map(|(&r, weight)| weight * of(r)).sum::<f64>()
        };
        Summed {
            share: stratum.share,
            weight: stratum.weight(),
            mean: weighted(&|r| r),
            sum: values.iter().sum(),
            mean_square: weighted(&|r| r * r),
            variance: stratum.variance(&values),
            variance_of_square: stratum.variance(&squares),
        }
    }

    /// Noise makes 4·σ²·⟨e²⟩ + 2·σ⁴ of the variance of r² = (e + z)².
    fn add_square(sum: Variance, of: &Summed) -> Variance {
        let weight = of.weight;
        Variance {
            whole: sum.whole + weight * of.variance_of_square,
            of_square: sum.of_square + 4.0 * weight * of.mean_square,
            of_fourth: sum.of_fourth - 2.0 * weight,
        }
    }
}

/// Derivatives by the estimates at the point of each stratum that lies nearest to its middle.
fn rows(
    points: &[PointMm],
    places_mm: &[[f64; 2]],
    strata: &[Stratum],
    fit: &Fit,
) -> Option<Vec<Vec<f64>>> {
    let free: Vec<Parameter> = fit.estimates.iter().map(|of| of.parameter).collect();
    let model = Model::new(&fit.nominal, &fit.pose, &free);
    let of_stratum = |stratum: &Stratum| {
        let count = stratum.members.len() as f64;
        let middle = [0, 1].map(|axis| {
            stratum.members.iter().map(|&index| places_mm[index][axis]).sum::<f64>() / count
        });
        let apart = |index: usize| {
            let [x, y] = places_mm[index];
            (x - middle[0]).hypot(y - middle[1])
        };
        let nearest = stratum.members.iter().min_by(|&&a, &&b| apart(a).total_cmp(&apart(b)));
        let mut row = vec![0.0; free.len() + 1];
        model.row(points[*nearest?], &mut row)?;
        row.truncate(free.len());
        Some(row)
    };
    strata.iter().map(of_stratum).collect()
}

/// A fit in which points count by their areas.
struct Refit {
    moved: Vec<Moved>,
    /// How much less it leaves of the mean square.
    less_mm2: f64,
    followed: Variance,
}

/// `None` where it is not determined.
fn refit(all: &[Summed], rows: &[Vec<f64>], points: usize) -> Option<Refit> {
    let p = rows.first().map_or(0, Vec::len);
    if p == 0 {
        return None;
    }
    let mut gram = DMatrix::<f64>::zeros(p, p);
    let mut pull = DVector::<f64>::zeros(p);
    for (of, row) in all.iter().zip(rows) {
        let more = of.share * of.mean - of.sum / points as f64;
        for i in 0..p {
            pull[i] += more * row[i];
            (0..p).for_each(|j| gram[(i, j)] += of.share * row[i] * row[j]);
        }
    }
    // Parameters of many units: in units of what each moves the surface by.
    let unit: Vec<f64> = (0..p).map(|i| gram[(i, i)].sqrt().recip()).collect();
    let scaled = DMatrix::from_fn(p, p, |i, j| gram[(i, j)] * unit[i] * unit[j]);
    let root = Cholesky::new(scaled)?;
    let solve = |vector: DVector<f64>| {
        let mut solved = root.solve(&DVector::from_fn(p, |i, _| vector[i] * unit[i]));
        (0..p).for_each(|i| solved[i] *= unit[i]);
        solved
    };
    let shift = solve(pull.clone());
    let mut scatter = vec![Variance::default(); p];
    let mut followed = Variance::default();
    for (of, row) in all.iter().zip(rows) {
        let row = DVector::from_column_slice(row);
        let gain = solve(row.clone());
        let add = |to: &mut Variance, weight: f64| {
            to.whole += weight * of.variance;
            to.of_square += weight;
        };
        for (scatter, gain) in scatter.iter_mut().zip(gain.iter()) {
            add(scatter, of.weight * gain * gain);
        }
        add(&mut followed, of.weight * row.dot(&gain));
    }
    let moved = shift.iter().zip(scatter).map(|(&shift, scatter)| Moved { shift, scatter });
    Some(Refit { moved: moved.collect(), less_mm2: pull.dot(&shift), followed })
}

/// Fewer points share no area.
const FEWEST: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoiseOnly;
    use asphera_form::{Figures, FitSettings, Nominal, deviations, fit};
    use asphera_geometry::Numbers;

    const COUNT: usize = 3000;

    /// A saddle of 30 nm on a plane of 1 mm radius, along a spiral that is denser in the middle: its RMS over the area is
    /// 30/√6 nm, over the points 30/√10.
    fn saddle(noise_nm: f64) -> (Figures, Places) {
        let numbers = Numbers::new(8, 0, 0);
        let point = |i: usize| {
            let radius = (i as f64 + 0.5) / COUNT as f64;
            let (sin, cos) = (137.36 * i as f64).sin_cos();
            let (x, y) = (radius * cos, radius * sin);
            [x, y, 1e-6 * (30.0 * (x * x - y * y) + noise_nm * numbers.normal(i))]
        };
        let points: Vec<PointMm> = (0..COUNT).map(point).collect();
        let aperture = Aperture::Circle { radius_mm: 1.0 };
        let free = vec![Parameter::Tz, Parameter::Rx, Parameter::Ry];
        let settings = FitSettings { free, aperture: aperture.clone(), ..FitSettings::default() };
        let fit = fit(&points, &Nominal::Plane, &settings).unwrap();
        let deviations_mm = deviations(&points, &fit.nominal, &fit.pose);
        let figures = Figures::new(&points, &deviations_mm, &fit.pose, &aperture).unwrap();
        (figures, places(&points, &deviations_mm, &fit, &aperture, None, true).unwrap())
    }

    #[test]
    fn the_rms_is_that_of_the_area_wherever_the_points_are_dense() {
        let truth_nm = 30.0 / 6.0_f64.sqrt();
        for noise_nm in [0.0, 3.0] {
            let (figures, places) = saddle(noise_nm);
            assert!(figures.rms_nm < 0.85 * truth_nm, "{figures:?}");
            let found_nm = places.rms_nm(noise_nm);
            assert!((found_nm / truth_nm - 1.0).abs() < 0.01, "{found_nm} {truth_nm}");
            let known = NoiseOnly::new(figures.rms_nm, noise_nm, figures.count).unwrap();
            let [low, high] = known.over(&places).rms_interval_nm(0.95);
            assert!(
                (low..=high).contains(&truth_nm) && high - low < 0.06 * truth_nm,
                "{low} {high}"
            );
        }
    }

    #[test]
    fn the_fit_counts_by_how_far_it_is_from_that_of_the_area() {
        let (_, places) = saddle(0.0);
        assert!(places.is_of_fit() && (places.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        // A saddle moves a plane nowhere, whatever the density over the radius.
        let [tz, ..] = places.moved[..] else { panic!("{:?}", places.moved) };
        assert!(tz.variance(0.0).sqrt() < 0.3e-6, "{tz:?}");
    }

    /// A tilted part moves the places of a raster by some of their noise: shares that go by it make the RMS too large.
    #[test]
    fn shares_of_a_raster_do_not_depend_on_its_noise() {
        let shares = |seed: u64| {
            let numbers = Numbers::new(seed, 0, 0);
            let step = (std::f64::consts::PI / 4000.0).sqrt();
            let node = |at: usize| [at % 80, at / 80].map(|at| step * (at as f64 - 39.7));
            let inside = (0..6400).map(node).filter(|[x, y]| x.hypot(*y) <= 1.0);
            let points: Vec<PointMm> = inside
                .zip(0..)
                .map(|([x, y], i)| [x, y, 1e-3 * x + 2e-6 * numbers.normal(i)])
                .collect();
            let aperture = Aperture::Circle { radius_mm: 1.0 };
            let free = vec![Parameter::Tz, Parameter::Rx, Parameter::Ry];
            let settings =
                FitSettings { free, aperture: aperture.clone(), ..FitSettings::default() };
            let fit = fit(&points, &Nominal::Plane, &settings).unwrap();
            let deviations_mm = deviations(&points, &fit.nominal, &fit.pose);
            places(&points, &deviations_mm, &fit, &aperture, None, true).unwrap().shares
        };
        let [one, other] = [1, 2].map(shares);
        let apart = one.iter().zip(&other).map(|(one, other)| (one - other).abs());
        assert!(apart.fold(0.0, f64::max) < 0.05 / one.len() as f64);
    }
}
