//! Uncertainties of a fit and of its figures, as the GUM has them (JCGM 100, 101 and 102).
//!
//! A [`Budget`] says what errors the points have: independent noise, [`LongWave`] errors that are correlated over
//! the surface, and [`Effect`]s of the machine. [`uncertainty`] carries them through a least-squares fit by
//! U_b = G·U_d·Gᵀ, which holds for whatever covariance U_d of the points, where [`Fit::covariance`] takes the
//! residuals for noise; without a budget, [`type_a`] takes U_d from the deviations, correlated as they are, and
//! [`glance`] the same roughly at little cost. The measurand of a parameter or of the RMS is what the fit would give at
//! the same places without these errors, and so it is of figures of points and of the texture. [`places()`] says what these places
//! do: [`Uncertainty::over`] makes the RMS and the parameters those of the area, where points count by what they stand for; what
//! lies between the points is another matter: see [`unmeasured`]. Where nothing but the noise is known, [`NoiseOnly`] has closed
//! forms for PV and RMS. PV, Sp, Sv, Sz and the like are made of extremes, which noise drives apart: their intervals reach from what the
//! form has for sure up to what a defect of a single point may hide in noise, so that they hold the truth whatever the form is;
//! u of them is that of single points. Where nothing but noise is there, they begin at 0.
//!
//! Outliers that a robust loss holds back still pull: each counts as an error of its own, as likely in either sense.
//! Where all lie on one side, as dust does, Huber's loss is moved by some of a scale besides, which no uncertainty tells;
//! Tukey's is not.
//!
//! Deliberately absent: the calibration that a budget comes from; random numbers that are not counted.

mod budget;
mod distribution;
mod extremes;
mod field;
mod halve;
mod heights;
mod linear;
mod means;
mod modes;
mod noise_only;
mod places;
mod remainder;
mod rms;
mod scatter;
mod simulate;
mod square;
mod strata;
mod taken;
mod type_a;
mod unmeasured;
pub mod verdict;
mod windows;
mod zone;

use nalgebra::DMatrix;

use asphera_form::{Aperture, Covariance, Fit, Parameter, PointMm};
use linear::Linear;
use modes::Modes;
use taken::Taken;

pub use budget::{Budget, Effect, Kernel, LongWave, Noise, UncertaintyError};
use distribution::student_quantile;
pub use means::Average;
pub use noise_only::NoiseOnly;
pub use places::{Places, places};
pub use rms::RmsUncertainty;
pub use simulate::{Draws, Simulated};
pub use square::MeanSquare;
use taken::Worth;
pub use type_a::{Correlation, Independence, TypeA, TypeAParameter, glance, type_a};
pub use unmeasured::{Hidden, largest_bend, largest_bend_of_windows, unmeasured};

/// The uncertainties of a fit.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// The independent noise that was taken.
    pub noise: NoiseFound,
    /// One entry an estimate of the fit, in its order.
    pub parameters: Vec<ParameterUncertainty>,
    /// Covariances of the estimates, in their order.
    pub covariance: Covariance,
    /// The part of it that long-wave errors and effects of the machine make.
    pub correlated: Covariance,
    /// The root mean square about the nominal.
    pub rms: RmsUncertainty,
    /// Share of the variance of each long-wave error, on the average over the points, whose correlation over
    /// short distances was neglected.
    pub neglected: Vec<f64>,
    /// Where the points were taken, if that counts: see [`Uncertainty::over`].
    taken: Option<Taken>,
    budget: Budget,
    linear: Linear,
    modes: Modes,
    noise_mm2: Vec<f64>,
}

/// The independent noise of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseFound {
    /// Root of the mean variance in mm.
    pub sigma_mm: f64,
    /// Degrees of freedom; infinite if it was stated as certain.
    pub dof: f64,
    /// Whether it was measured from the points themselves.
    pub measured: bool,
    /// How much of its variance may be form that is fine against the points, in mm²; 0 where it is stated.
    pub by_form_mm2: f64,
}

/// The standard uncertainty of a parameter and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterUncertainty {
    /// Which.
    pub parameter: Parameter,
    /// Its value in [`Parameter::unit`].
    pub value: f64,
    /// Its standard uncertainty in the same unit.
    pub u: f64,
    /// Effective degrees of freedom (Welch and Satterthwaite: JCGM 100:2008, G.4).
    pub dof: f64,
    /// Standard uncertainty by each source, in the same unit: the noise first, then the long-wave errors, then
    /// the effects, in the order of the budget, where a robust loss holds points for outliers, these, and the places where
    /// they count. Their squares add up to u².
    pub sources: Vec<(String, f64)>,
}

/// An expanded uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expanded {
    /// k·u, in the unit of u.
    pub expanded: f64,
    /// Coverage factor, from Student's distribution.
    pub k: f64,
    /// The probability of coverage it is for.
    pub p: f64,
    /// Effective degrees of freedom.
    pub dof: f64,
}

impl ParameterUncertainty {
    /// Adds a source whose variance is certain.
    fn add(&mut self, source: &str, variance: f64) {
        let before = self.u * self.u;
        self.u = (before + variance).sqrt();
        if before > 0.0 {
            self.dof *= (1.0 + variance / before).powi(2);
        }
        self.sources.push((source.to_owned(), variance.sqrt()));
    }

    /// The half width of the interval about the value that holds the truth with probability `p`, above 0 and
    /// below 1.
    pub fn expanded(&self, p: f64) -> Expanded {
        let k = coverage_factor(p, self.dof);
        Expanded { expanded: k * self.u, k, p, dof: self.dof }
    }
}

/// The k of an interval ±k·u with probability `p`, two-sided, by Student's distribution with `dof` degrees of
/// freedom (JCGM 100:2008, G.3). An infinite number gives 1.96 for 95 %.
pub fn coverage_factor(p: f64, dof: f64) -> f64 {
    student_quantile(0.5 + 0.5 * p, dof)
}

/// The uncertainties of `fit` over the `points` it was made from.
///
/// `aperture` is that of its settings and `uncertainties_mm` those of [`asphera_form::fit_weighted`], if it had any:
/// they are its weights, while `budget` says what the errors are. `O(n·p² + N·(p + m)²)` for n points, p
/// parameters, up to 2304 nodes N, and up to 160 functions m a long-wave error.
pub fn uncertainty(
    points: &[PointMm],
    fit: &Fit,
    aperture: &Aperture,
    uncertainties_mm: Option<&[f64]>,
    budget: &Budget,
) -> Result<Uncertainty, UncertaintyError> {
    budget.validate(points.len())?;
    if fit.dof == 0 {
        let parameters = fit.estimates.len();
        return Err(UncertaintyError::NoFreedom { used: fit.used, parameters });
    }
    let linear = Linear::new(points, fit, aperture, uncertainties_mm)?;
    let modes = Modes::new(&linear, budget);
    let (own_mm2, noise) = noise(&linear, budget)?;
    let left: Vec<f64> = (0..linear.len()).map(|place| modes.remainder_mm2(place)).collect();
    let noise_mm2: Vec<f64> = own_mm2.iter().zip(&left).map(|(own, left)| own + left).collect();
    let p = linear.parameters.len();
    let mut by_noise = DMatrix::zeros(p, p);
    for (place, variance) in noise_mm2.iter().enumerate() {
        let gain = linear.gain(place);
        for i in 0..p {
            for j in 0..p {
                by_noise[(i, j)] += linear.noise_factor * variance * gain[i] * gain[j];
            }
        }
    }
    let by_outliers = linear.by_outliers();
    let mut by_modes = DMatrix::zeros(p, p);
    for moved in &modes.moved {
        for i in 0..p {
            for j in 0..p {
                by_modes[(i, j)] += moved[i] * moved[j];
            }
        }
    }
    let total = &by_noise + &by_modes + DMatrix::from_row_slice(p, p, &by_outliers);
    let rms = RmsUncertainty::new(
        &linear,
        &modes,
        (&noise_mm2, budget.noise_shared_by.max(1.0)),
        &by_noise,
        &noise,
    );
    Ok(Uncertainty {
        parameters: parameters(fit, &linear, &modes, budget, (&by_noise, noise.dof)),
        covariance: Covariance::new(p, total.as_slice(), 1.0),
        correlated: Covariance::new(p, by_modes.as_slice(), 1.0),
        neglected: modes.neglected(),
        taken: None,
        noise,
        rms,
        budget: budget.clone(),
        linear,
        modes,
        noise_mm2,
    })
}

impl Uncertainty {
    /// The same of the area the points were taken of: the RMS is that over the area about its own best fit, and parameters
    /// count how far they are from that, and how places scatter. `places` must be of the same points and fit.
    pub fn over(mut self, places: &Places) -> Uncertainty {
        let taken = Taken::new(places, &self.linear.indices);
        let noise_mm2 = self.noise.sigma_mm * self.noise.sigma_mm;
        self.rms = self.rms.over(places, &taken.shares, &self.noise_mm2);
        if places.moved.len() == self.parameters.len() {
            let p = self.parameters.len();
            let moved = &places.moved;
            let entries = (0..p * p).map(|at| {
                let (i, j) = (at % p, at / p);
                let by_noise = self.covariance.entry(i, j).unwrap_or(0.0);
                by_noise
                    + if i == j {
                        moved[i].variance(noise_mm2)
                    } else {
                        moved[i].shift * moved[j].shift
                    }
            });
            let entries: Vec<f64> = entries.collect();
            self.covariance = Covariance::new(p, &entries, 1.0);
            for (of, moved) in self.parameters.iter_mut().zip(moved) {
                of.add("places", moved.variance(noise_mm2));
            }
        }
        self.taken = Some(taken);
        self
    }

    /// Share of the area of each point used, if it is known.
    pub(crate) fn shares(&self) -> Option<&[f64]> {
        self.taken.as_ref().map(|taken| &taken.shares[..])
    }

    /// Variance that the places leave a mean over the area, beside that by noise: 0 where the area is not known.
    ///
    /// `worth` has an entry a point, in the order of [`Uncertainty::indices`]. In the square of its unit.
    pub(crate) fn scatter_of_mean(&self, worth: &[Worth]) -> f64 {
        self.taken.as_ref().map_or(0.0, |taken| taken.variance(worth, &self.noise_mm2))
    }

    /// Indices of the points used, among those given.
    pub fn indices(&self) -> &[usize] {
        &self.linear.indices
    }

    /// Places of the points used, part frame, mm.
    pub fn places_mm(&self) -> &[[f64; 2]] {
        &self.linear.places_mm
    }

    /// Their deviations in mm.
    pub fn deviations_mm(&self) -> &[f64] {
        &self.linear.distances_mm
    }
}

/// The independent variance of each point used, and what is told of it.
fn noise(linear: &Linear, budget: &Budget) -> Result<(Vec<f64>, NoiseFound), UncertaintyError> {
    let count = linear.len();
    let mut by_form_mm2 = 0.0;
    let (variances, dof, measured) = match &budget.noise {
        Noise::Measured => {
            let found = scatter::scatter(&linear.places_mm, &linear.distances_mm)?;
            by_form_mm2 = scatter::by_form_mm2(&linear.places_mm, &linear.distances_mm, &found);
            (vec![found.sigma_mm * found.sigma_mm; count], found.dof, true)
        }
        Noise::Uniform { sigma_mm, dof } => (vec![sigma_mm * sigma_mm; count], *dof, false),
        Noise::EachPoint(sigma_mm) => {
            let used = linear.indices.iter().map(|&index| sigma_mm[index] * sigma_mm[index]);
            (used.collect(), f64::INFINITY, false)
        }
    };
    let sigma_mm = (variances.iter().sum::<f64>() / count as f64).sqrt();
    Ok((variances, NoiseFound { sigma_mm, dof, measured, by_form_mm2 }))
}

fn parameters(
    fit: &Fit,
    linear: &Linear,
    modes: &Modes,
    budget: &Budget,
    (by_noise, noise_dof): (&DMatrix<f64>, f64),
) -> Vec<ParameterUncertainty> {
    let waves = (1..).zip(&budget.long_waves);
    let waves = waves.map(|(number, wave)| (format!("long-wave error {number}"), wave.dof));
    let effects = budget.effects.iter().map(|effect| (effect.name.clone(), effect.dof));
    let named: Vec<(String, f64)> = waves.chain(effects).collect();
    let (by_outliers, outliers) = (linear.by_outliers(), linear.outliers.len());
    let of_estimate = |(index, estimate): (usize, &asphera_form::Estimate)| {
        let mut sources = vec![("noise".to_owned(), by_noise[(index, index)])];
        let mut freedom = by_noise[(index, index)].powi(2) / noise_dof;
        for ((name, dof), range) in named.iter().zip(&modes.sources) {
            let variance: f64 = modes.moved[range.clone()].iter().map(|m| m[index].powi(2)).sum();
            freedom += variance * variance / dof;
            sources.push((name.clone(), variance));
        }
        if outliers > 0 {
            let variance = by_outliers[index * (linear.parameters.len() + 1)];
            // As many pulls of much the same size.
            freedom += variance * variance / outliers as f64;
            sources.push(("outliers".to_owned(), variance));
        }
        let variance: f64 = sources.iter().map(|(_, variance)| variance).sum();
        sources.iter_mut().for_each(|(_, value)| *value = value.sqrt());
        ParameterUncertainty {
            parameter: estimate.parameter,
            value: estimate.value,
            u: variance.sqrt(),
            dof: if freedom > 0.0 { variance * variance / freedom } else { f64::INFINITY },
            sources,
        }
    };
    fit.estimates.iter().enumerate().map(of_estimate).collect()
}

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
