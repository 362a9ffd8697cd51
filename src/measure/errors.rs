//! What is known of the errors of PV and RMS without a simulation of all points: while points arrive, and in the end
//! where the nominal file states no budget.

use std::collections::BTreeMap;

use asphera_figures::{Definition, Statistic};
use asphera_form::{Figures, FitSettings, fit};
use asphera_geometry::PointMm;
use asphera_report::UncertaintyFigures;
use asphera_surface::Plane;
use asphera_uncertainty::verdict::{Limit, Over, finding};
use asphera_uncertainty::{Budget, Draws, Noise, NoiseOnly, Places, UncertaintyError, uncertainty};

use super::origin;
use super::prospects::is_foreseen;
use super::running::fit_settings;
use super::uncertainties::{COVERAGE, in_plane};
use crate::{CorrelationFrom, Part};

/// Errors of the points, as of the last look at the mesh.
#[derive(Clone, Debug)]
pub(super) struct Errors {
    /// The noise of a point and its standard uncertainty in nm.
    noise_nm: Option<[f64; 2]>,
    correlated: Option<Correlated>,
    budget: bool,
}

/// Uncertainties of figures by long waves and the machine.
#[derive(Clone, Debug, Default)]
struct Correlated {
    u_rms_nm: f64,
    u_pv_nm: f64,
    /// The standard uncertainties of further limits' PV and RMS in nm, by name; those of other figures are not here.
    limits: BTreeMap<String, f64>,
}

/// The errors of the figure of a limit at one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorsOfLimit {
    /// Standard uncertainty in nm, of a PV at most that.
    pub(super) u_nm: f64,
    /// Rise of a PV by noise at most, nm.
    pub(super) pv_bias_at_most_nm: f64,
    /// The noise of a point, nm.
    pub(super) noise_nm: f64,
}

/// The errors of figures of one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorsOfFigures {
    /// By the noise alone.
    pub(super) noise: NoiseOnly,
    /// Standard uncertainty of the RMS.
    pub(super) u_rms_nm: f64,
    /// The standard uncertainty of the PV is at most this.
    pub(super) u_pv_nm: f64,
    budget: bool,
    /// Whether the RMS counts the places that were taken.
    places: bool,
}

/// Standard uncertainty that the nominal file states for the noise of every point, mm.
pub(super) fn stated_noise_mm(part: &Part) -> Option<f64> {
    let (budget, _) = part.judging.uncertainty.as_ref()?;
    match budget.noise {
        Noise::Uniform { sigma_mm, .. } => Some(sigma_mm),
        Noise::Measured | Noise::EachPoint(_) => None,
    }
}

impl Errors {
    /// Before anything is known but what the nominal file states.
    pub(super) fn new(part: &Part) -> Errors {
        let budget = part.judging.uncertainty.as_ref().map(|(budget, _)| budget);
        let correlated = budget.is_none_or(|budget| !is_correlated(budget));
        Errors {
            noise_nm: stated_noise_mm(part).map(|sigma_mm| [1e6 * sigma_mm, 0.0]),
            correlated: correlated.then(Correlated::default),
            budget: budget.is_some_and(is_correlated),
        }
    }

    /// Takes what a look at the mesh tells: the noise, where none is stated, and what correlated errors do to the
    /// points there are. `points` and `plane` are those of projection. Takes some ten milliseconds where the budget
    /// has a correlated part, however many points there are.
    pub(super) fn look(
        &mut self,
        part: &Part,
        points: &[PointMm],
        plane: &Plane,
        noise_nm: Option<[f64; 2]>,
    ) {
        let Some((budget, draws)) = &part.judging.uncertainty else {
            self.noise_nm = noise_nm;
            return;
        };
        if budget.noise == Noise::Measured {
            self.noise_nm = noise_nm;
        }
        if is_correlated(budget) {
            self.correlated = correlated(part, points, plane, budget, draws);
        }
    }

    /// The noise of a point in nm, where it is known.
    pub(super) fn noise_nm(&self) -> Option<f64> {
        self.noise_nm.map(|[noise_nm, _]| noise_nm)
    }

    /// Errors of figures; `None` where the noise, or what a budget has besides, is not known.
    pub(super) fn of(&self, figures: &Figures) -> Option<ErrorsOfFigures> {
        let correlated = self.correlated.as_ref()?;
        let [noise_nm, u_noise_nm] = self.noise_nm?;
        let noise = NoiseOnly::new(figures.rms_nm, noise_nm, figures.count)?.known_to(u_noise_nm);
        Some(ErrorsOfFigures {
            noise,
            u_rms_nm: noise.u_rms_nm.hypot(correlated.u_rms_nm),
            u_pv_nm: noise.u_pv_at_most_nm.hypot(correlated.u_pv_nm),
            budget: self.budget,
            places: false,
        })
    }

    /// Errors of the PV, or else of the RMS, of a limit of that name over a zone or with terms removed, of `count` points;
    /// `None` as with [`Errors::of`].
    pub(super) fn of_limit(
        &self,
        name: &str,
        definition: Definition,
        value_nm: f64,
        count: usize,
    ) -> Option<ErrorsOfLimit> {
        let [noise_nm, u_noise_nm] = self.noise_nm?;
        let noise = NoiseOnly::new(value_nm, noise_nm, count)?.known_to(u_noise_nm);
        let correlated_nm = match self.correlated.as_ref()? {
            _ if !self.budget => 0.0,
            correlated => *correlated.limits.get(name)?,
        };
        let of_noise_nm = match definition {
            Definition::PeakToValley => noise.u_pv_at_most_nm,
            _ => noise.u_rms_nm,
        };
        Some(ErrorsOfLimit {
            u_nm: of_noise_nm.hypot(correlated_nm),
            pv_bias_at_most_nm: noise.pv_bias_at_most_nm,
            noise_nm: noise.noise_nm,
        })
    }

    /// Whether the noise is that of the points, and not stated.
    pub(super) fn is_measured(&self, part: &Part) -> bool {
        let budget = part.judging.uncertainty.as_ref();
        budget.is_none_or(|(budget, _)| budget.noise == Noise::Measured)
    }

    /// Sources of the bands of a convergence: PV and RMS.
    pub(super) fn bases(&self) -> [String; 2] {
        let why = match (self.noise_nm, &self.correlated) {
            (None, _) => "not known: the noise of the points has not been measured yet",
            (_, None) => "not known: what the correlated errors do has not been worked out yet",
            _ if self.budget => return ["an upper bound by the", "by the"].map(by_the_budget),
            _ => return ["an upper bound", "by noise"].map(by_noise_only),
        };
        [why.to_owned(), why.to_owned()]
    }
}

fn by_the_budget(how: &str) -> String {
    format!(
        "{how} {}; without the choice of places, and without what is not measured yet",
        UncertaintyFigures::BUDGET
    )
}

fn by_noise_only(how: &str) -> String {
    let how = if how == "by noise" { String::new() } else { format!("{how}, ") };
    format!(
        "{how}{}: without correlated errors, the choice of places, and what is not measured yet",
        UncertaintyFigures::NOISE_ONLY
    )
}

impl ErrorsOfFigures {
    /// The same with the RMS over the area, and what the places of the points do to it.
    pub(super) fn over(self, places: &Places) -> ErrorsOfFigures {
        let correlated_nm = (self.u_rms_nm.powi(2) - self.noise.u_rms_nm.powi(2)).max(0.0).sqrt();
        let noise = self.noise.over(places);
        ErrorsOfFigures {
            noise,
            u_rms_nm: noise.u_rms_nm.hypot(correlated_nm),
            places: true,
            ..self
        }
    }

    /// Sources of the errors.
    fn model(&self) -> &'static str {
        if self.budget { UncertaintyFigures::BUDGET } else { UncertaintyFigures::NOISE_ONLY }
    }

    /// Scope of the uncertainty of a limited figure, in words.
    pub(super) fn covers(&self, definition: Definition) -> String {
        covers(self.model(), definition, self.places)
    }

    /// As reports write them, for a PV and an RMS in nm. `measured`: whether the noise is that of the points.
    pub(super) fn figures(&self, pv_nm: f64, measured: bool) -> UncertaintyFigures {
        let ErrorsOfFigures { noise, u_rms_nm, u_pv_nm, places, .. } = *self;
        let wider = |[low, high]: [f64; 2], own: f64, all: f64, about: f64| {
            let by = if own > 0.0 { all / own } else { 1.0 };
            let beyond = if own > 0.0 { 0.0 } else { TWO_SIDED * all };
            [(about - (about - low) * by - beyond).max(0.0), about + (high - about) * by + beyond]
        };
        let pv_95_nm =
            wider(noise.pv_interval_nm(pv_nm, COVERAGE), noise.u_pv_at_most_nm, u_pv_nm, pv_nm);
        let rms_95_nm =
            wider(noise.rms_interval_nm(COVERAGE), noise.u_rms_nm, u_rms_nm, noise.form_nm);
        let model = self.model();
        UncertaintyFigures {
            model: model.to_owned(),
            u_pv_nm,
            pv_at_most: true,
            pv_bias_nm: noise.pv_bias_at_most_nm,
            pv_95_nm,
            pv_covers: UncertaintyFigures::covers_places(model),
            u_rms_nm,
            rms_without_noise_nm: noise.form_nm,
            rms_95_nm,
            rms_covers: UncertaintyFigures::covers_area(model, places),
            noise_nm: noise.noise_nm,
            noise_measured: measured,
            draws: None,
            seed: None,
        }
    }
}

/// Sources of the uncertainties of the figures of a part. Further limits and guard bands alone ask for them too, and name no
/// more than noise.
pub(super) fn model(part: &Part) -> &'static str {
    match &part.judging.uncertainty {
        Some((budget, _)) if is_correlated(budget) => UncertaintyFigures::BUDGET,
        _ if part.judging.correlated == CorrelationFrom::Budget => UncertaintyFigures::NOISE_ONLY,
        _ => UncertaintyFigures::NOISE_BESIDE_FORM,
    }
}

/// Scope of the uncertainty of a figure by a model, in words. `places`: whether averages count the places taken.
pub(super) fn covers(model: &str, definition: Definition, places: bool) -> String {
    match definition.statistic() {
        Statistic::Extreme | Statistic::LargestSlope => UncertaintyFigures::covers_places(model),
        Statistic::MeanSquare | Statistic::Coefficient => {
            UncertaintyFigures::covers_area(model, places)
        }
        Statistic::MeanSquareSlope | Statistic::Compound => {
            UncertaintyFigures::covers_difference(model, places)
        }
    }
}

/// Whether the nominal file states errors that are correlated.
pub(super) fn has_correlated(part: &Part) -> bool {
    part.judging.uncertainty.as_ref().is_some_and(|(budget, _)| is_correlated(budget))
}

fn is_correlated(budget: &Budget) -> bool {
    !(budget.long_waves.is_empty() && budget.effects.is_empty())
}

/// Uncertainties by long waves and the machine of the figures of some of the points, spread evenly over the order in which they
/// arrived: errors that are smooth over the part need no more.
fn correlated(
    part: &Part,
    points: &[PointMm],
    plane: &Plane,
    budget: &Budget,
    draws: &Draws,
) -> Option<Correlated> {
    let some = points.len().min(SOME_POINTS);
    let some: Vec<PointMm> = (0..some).map(|index| points[index * points.len() / some]).collect();
    let start = origin::start_of(part, points);
    let settings = FitSettings { start, rank_tolerance: RANK_TOLERANCE, ..fit_settings(part) };
    let fit = fit(&some, &part.nominal, &settings).ok()?;
    let effects = budget.effects.iter().map(|effect| in_plane(effect, plane)).collect();
    // The noise is that of all points, and not of these.
    let noise = Noise::Uniform { sigma_mm: 0.0, dof: f64::INFINITY };
    let budget = Budget { noise, effects, ..budget.clone() };
    let worked_out = || -> Result<Correlated, UncertaintyError> {
        let found = uncertainty(&some, &fit, &part.aperture, None, &budget)?;
        let draws = Draws { count: draws.count.min(MOST_DRAWS), ..*draws };
        let pv = found.peak_to_valley_nm(&draws)?;
        let further = |limit: &Limit| is_foreseen(limit) && !limit.is_of_whole();
        let limits: Vec<Limit> =
            part.limits().iter().filter(|limit| further(limit)).cloned().collect();
        let over = Over { aperture: &part.aperture, areas_mm2: None };
        // A limit that cannot be held was refused with the nominal file.
        let u_nm =
            |limit: &Limit| finding(limit, &found, &part.nominal, over, &draws).ok()?.ok()?.u;
        let limits = limits.iter().filter_map(|limit| Some((limit.name(), u_nm(limit)?)));
        Ok(Correlated { u_rms_nm: found.rms.u_nm, u_pv_nm: pv.u, limits: limits.collect() })
    };
    worked_out().ok()
}

/// Points whose errors are looked at while others arrive.
const SOME_POINTS: usize = 1024;
/// Measurements simulated then: a standard uncertainty to 7 %.
const MOST_DRAWS: u32 = 100;
/// As of the running fit: a small patch tells tilt from shift too badly to go by it.
const RANK_TOLERANCE: f64 = 2e-4;
/// Half the width of a two-sided interval of 95 % over the standard uncertainty.
const TWO_SIDED: f64 = 1.959_963_984_540_054;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nominal::parse;

    const PLANE: &str = "[surface]\nkind = \"plane\"\n";

    fn figures(count: usize) -> Figures {
        Figures {
            pv_nm: 100.0,
            rms_nm: 20.0,
            max_nm: 60.0,
            min_nm: -40.0,
            at_max_mm: [0.0; 3],
            at_min_mm: [0.0; 3],
            count,
        }
    }

    #[test]
    fn without_a_budget_it_is_the_noise_and_nothing_before_the_first_look() {
        let part = parse("p.toml", PLANE).unwrap();
        let mut errors = Errors::new(&part);
        assert!(errors.of(&figures(100)).is_none() && errors.bases()[0].starts_with("not known"));
        errors.look(&part, &[], &Plane::XY, Some([3.0, 0.0]));
        let found = errors.of(&figures(100)).unwrap();
        assert_eq!(found.u_rms_nm, found.noise.u_rms_nm);
        // Noise that is measured is known to so much.
        errors.look(&part, &[], &Plane::XY, Some([3.0, 0.3]));
        let less = errors.of(&figures(1_000_000)).unwrap().u_rms_nm;
        assert!((less - 0.3 * 3.0 / (400.0_f64 - 9.0).sqrt()).abs() < 1e-3, "{less}");
        let told = found.figures(100.0, true);
        assert_eq!((&told.model[..], told.pv_at_most, told.draws), ("noise only", true, None));
        assert!(told.pv_95_nm[0] < 100.0 && told.pv_95_nm[1] > 100.0 + 2.0 * 3.0);
        assert!(errors.bases()[1].starts_with("noise only"), "{:?}", errors.bases());
    }

    /// A wave longer than the part is all but taken up by the fit; one as long as a tenth of it is not, and then makes
    /// far more than the noise of many points.
    #[test]
    fn a_budget_widens_the_band_by_what_is_correlated() {
        let of = |length_mm: f64| {
            let text = format!(
                "{PLANE}[uncertainty]\nnoise_nm = 1\nlong_wave_nm = 5\nlong_wave_mm = {length_mm}\n"
            );
            let part = parse("p.toml", &text).unwrap();
            let points: Vec<PointMm> = (0..4000_u32)
                .map(|i| {
                    let (x, y) = (f64::from(i % 63), f64::from(i / 63));
                    [x, y, 2e-5 * (0.4 * x).sin()]
                })
                .collect();
            let mut errors = Errors::new(&part);
            assert!(errors.of(&figures(4000)).is_none(), "what is correlated is not known yet");
            errors.look(&part, &points, &Plane::XY, None);
            errors.of(&figures(4000)).unwrap()
        };
        let (long, short) = (of(600.0), of(6.0));
        assert!(long.u_rms_nm < 0.2 && short.u_rms_nm > 3.0 * long.u_rms_nm, "{long:?} {short:?}");
        assert!(short.u_pv_nm > short.noise.u_pv_at_most_nm + 2.0, "{short:?}");
        let told = short.figures(100.0, false);
        assert_eq!(told.model, UncertaintyFigures::BUDGET);
        assert!(
            told.rms_95_nm[1] > told.rms_without_noise_nm + 1.9 * short.u_rms_nm
                && !told.noise_measured,
            "{told:?}"
        );
    }
}
