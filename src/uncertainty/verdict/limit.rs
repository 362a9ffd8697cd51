//! Limits of named figures, over the aperture or a zone of it.

use std::borrow::Cow;
use std::str::FromStr;

use thiserror::Error;

use super::by_places::{OfArea, of_area};
use super::decision::Finding;
use crate::{Average, Draws, Simulated, Uncertainty, UncertaintyError};
use asphera_figures::{
    Approximation, Definition, Figure, Formation, FringeCount, Sample, SampleError, Share,
    SlopeSettings, Statistic, Subject, Terms, Unknown, decompose, irregular, peak_to_valley,
    remove, slopes,
};
use asphera_form::{Aperture, NM_PER_MM, Nominal};

/// The largest value allowed of one figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Which figure.
    pub definition: Definition,
    /// The largest value allowed, in the unit of the figure.
    pub value: f64,
    /// The part of the aperture it is for; [`Aperture::None`] is all of it.
    pub zone: Aperture,
    /// How slopes are formed; needed for them and for nothing else.
    pub slope: Option<SlopeSettings>,
    /// Terms that are removed from the deviation in the zone before the figure is formed (ISO 14999-4).
    pub less: Terms,
}

/// Points that the figures of limits are formed over.
#[derive(Clone, Copy, Debug)]
pub struct Over<'a> {
    /// The aperture of the part.
    pub aperture: &'a Aperture,
    /// The area each of the points stands for that the fit was made from, in mm² or any common unit; without it all
    /// points weigh the same.
    pub areas_mm2: Option<&'a [f64]>,
}

impl Over<'_> {
    /// The deviations that a limit is of, of some of the points used.
    fn sample(
        &self,
        limit: &Limit,
        uncertainty: &Uncertainty,
        (places, deviations_mm): (&[usize], &[f64]),
    ) -> Result<Sample, SampleError> {
        let areas = self.areas_for(limit).map(|areas| {
            let indices = uncertainty.indices();
            places.iter().map(|&place| areas[indices[place]]).collect::<Vec<f64>>()
        });
        self.weighted(limit, uncertainty, (places, deviations_mm), areas.as_deref())
    }

    /// Deviations with an area for each.
    fn weighted(
        &self,
        limit: &Limit,
        uncertainty: &Uncertainty,
        (places, deviations_mm): (&[usize], &[f64]),
        areas_mm2: Option<&[f64]>,
    ) -> Result<Sample, SampleError> {
        let all_mm = uncertainty.places_mm();
        let places_mm: Vec<[f64; 2]> = places.iter().map(|&place| all_mm[place]).collect();
        Sample::by_area(&places_mm, deviations_mm, areas_mm2, self.zone(limit))
    }

    /// The areas that a limit counts by. An RMS over the points knows none.
    fn areas_for(&self, limit: &Limit) -> Option<&[f64]> {
        self.areas_mm2.filter(|_| limit.definition != Definition::RmsOverPoints)
    }

    /// The part of the aperture that a limit is of.
    fn zone<'a>(&'a self, limit: &'a Limit) -> &'a Aperture {
        if limit.zone == Aperture::None { self.aperture } else { &limit.zone }
    }
}

/// Why a limit is refused, or cannot be judged.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LimitError {
    /// No figure has that name.
    #[error(
        "no figure is called {name:?}, expected one of {}", Definition::LIMITED.map(|one| one.id()).join(", ")
    )]
    Name {
        /// The name.
        name: String,
    },
    /// A limit that is not above 0.
    #[error("limit of {definition} is {found}, expected a finite number above 0")]
    Value {
        /// Which figure.
        definition: Definition,
        /// The limit.
        found: f64,
    },
    /// A slope without an integration length.
    #[error("a limit of {definition} needs an integration length and a sampling step")]
    Slope {
        /// Which figure.
        definition: Definition,
    },
    /// A figure that no limit can be given for.
    #[error("{definition} has no way to be judged")]
    Figure {
        /// Which figure.
        definition: Definition,
    },
    /// Places, deviations and zone make no sample.
    #[error("the zone gives no sample")]
    Sample(#[from] SampleError),
    /// There is no uncertainty.
    #[error("the uncertainty cannot be worked out")]
    Uncertainty(#[from] UncertaintyError),
}

impl FromStr for Limit {
    type Err = LimitError;

    /// `name limit` with the names of [`Limit::named`]: `pvr 120`.
    fn from_str(text: &str) -> Result<Limit, LimitError> {
        let (name, value) =
            text.trim().split_once(char::is_whitespace).unwrap_or((text.trim(), ""));
        let definition = Limit::named(name)?;
        let value = value.trim().parse().unwrap_or(f64::NAN);
        let limit = Limit::of_whole(definition, value);
        limit.check_value()?;
        Ok(limit)
    }
}

impl Limit {
    /// The figure of an identity, [`Definition::id`], in any case of letters.
    ///
    /// # Errors
    ///
    /// If no figure that can be limited has it.
    pub fn named(id: &str) -> Result<Definition, LimitError> {
        Definition::of_id(id).ok_or_else(|| LimitError::Name { name: id.to_owned() })
    }

    /// The limit of a figure of the whole aperture.
    pub fn of_whole(definition: Definition, value: f64) -> Limit {
        Limit { definition, value, zone: Aperture::None, slope: None, less: Terms::NONE }
    }

    /// Whether it is of the whole aperture and of the deviation as fitted.
    pub fn is_of_whole(&self) -> bool {
        self.zone == Aperture::None && self.less == Terms::NONE
    }

    /// Its name in a verdict: key and scope, `pv_nm`, `rms_nm 0-4.5 mm`, `rms_nm less piston`.
    pub fn name(&self) -> String {
        let key = self.definition.key();
        match self.zone {
            Aperture::Annulus { inner_mm, outer_mm } => format!("{key} {inner_mm}-{outer_mm} mm"),
            _ if self.less == Terms::NONE => key,
            _ => format!("{key} less {}", self.less),
        }
    }

    /// The length of slopes, the part of the aperture or the terms removed, in words: `over 1 mm`, `from 0-4.5 mm`, `with
    /// piston removed`; `None` of other figures of the whole deviation.
    pub fn scope(&self) -> Option<String> {
        let part = match self.zone {
            Aperture::Annulus { inner_mm, outer_mm } => {
                Some(format!("from {inner_mm}-{outer_mm} mm"))
            }
            _ if self.less == Terms::NONE => None,
            _ => Some(format!("with {} removed", self.less)),
        };
        let over = self.slope.map(|slope| slope.scope());
        over.into_iter().chain(part).reduce(|one, other| format!("{one}, {other}"))
    }

    fn check_value(&self) -> Result<(), LimitError> {
        if self.value.is_finite() && self.value > 0.0 {
            Ok(())
        } else {
            Err(LimitError::Value { definition: self.definition, found: self.value })
        }
    }

    fn validate(&self) -> Result<(), LimitError> {
        self.check_value()?;
        let definition = self.definition;
        match definition {
            _ if definition.subject() == Subject::Slope && self.slope.is_none() => {
                Err(LimitError::Slope { definition })
            }
            Definition::Pvr { terms } if FringeCount::new(terms).is_none() => {
                Err(LimitError::Figure { definition })
            }
            _ if matches!(definition.subject(), Subject::Points | Subject::Filtered) => {
                Err(LimitError::Figure { definition })
            }
            Definition::RobustPeakToValley { share } if Share::new(share).is_err() => {
                Err(LimitError::Figure { definition })
            }
            _ => Ok(()),
        }
    }

    /// The figure of deviations at places of the part frame, NaN where a point has none. [`Over::areas_mm2`] has one entry
    /// for each place. `O(n)`; a Zernike figure `O(n·p²)` for its p terms.
    ///
    /// # Errors
    ///
    /// If the limit makes no sense, or the zone gives no sample. The inner error says why the sample has no such figure.
    pub fn figure_of(
        &self,
        places_mm: &[[f64; 2]],
        deviations_mm: &[f64],
        over: Over<'_>,
        nominal: &Nominal,
    ) -> Result<Result<Figure, Unknown>, LimitError> {
        self.validate()?;
        let areas = over.areas_for(self);
        let sample = Sample::by_area(places_mm, deviations_mm, areas, over.zone(self))?;
        Ok(self.figure(&sample, approximation(nominal)))
    }

    /// Remainder of a sample without the terms.
    fn without_terms<'a>(&self, sample: &'a Sample) -> Result<Cow<'a, Sample>, Unknown> {
        Ok(match &self.less.list()[..] {
            [] => Cow::Borrowed(sample),
            terms => Cow::Owned(remove(sample, terms)?.sample),
        })
    }

    /// What the figure is the range of; `None` where it is not one of what least squares leave.
    fn ranged<'a>(
        &self,
        sample: &'a Sample,
        approximation: Approximation,
    ) -> Option<Result<Cow<'a, Sample>, Unknown>> {
        match self.definition {
            Definition::PeakToValley => Some(self.without_terms(sample)),
            Definition::Irregularity => Some(
                self.without_terms(sample)
                    .and_then(|left| irregular(&left, approximation).map(Cow::Owned)),
            ),
            _ => None,
        }
    }

    /// What noise may have raised a largest slope by, at most, on the average; `None` for other figures. Draws add noise to
    /// what has some already, and so tell too little of it.
    fn noise_on_largest_slope(&self, sample: &Sample, noise_nm: f64) -> Option<f64> {
        let is_max = self.definition.statistic() == Statistic::LargestSlope;
        let settings = self.slope.filter(|_| is_max)?;
        let found = slopes(&*self.without_terms(sample).ok()?, settings).ok()?;
        let figure = match self.definition {
            Definition::MeridionalSlopeMax => found.meridional,
            _ => found.gradient,
        };
        Some(figure.noise_on_max_urad(noise_nm, found.stations))
    }

    /// The figure over a sample.
    fn figure(&self, sample: &Sample, approximation: Approximation) -> Result<Figure, Unknown> {
        if let Some(left) = self.ranged(sample, approximation) {
            let range = peak_to_valley(&*left?)?;
            return Ok(Figure { definition: self.definition, ..range });
        }
        let sample = &*self.without_terms(sample)?;
        let by = Formation { approximation, slope: self.slope };
        self.definition.form(sample, by).expect("checked when the limit was")
    }
}

fn approximation(nominal: &Nominal) -> Approximation {
    match nominal {
        Nominal::Sphere { radius_mm } => {
            Approximation::sphere(*radius_mm).unwrap_or(Approximation::Quadratic)
        }
        _ => Approximation::Quadratic,
    }
}

/// The figure of a limit with its uncertainty, by the deviations of a fit. [`Finding::hidden`] is left open.
///
/// Zones lie in the part frame, and the fit is that of the whole aperture. PV and RMS of all of it have
/// uncertainties of their own; any other figure is simulated, and one that cannot be has none. Draws of what averages over the
/// area (A and any RMS) are of 16,384 points at most. Draws of ranges of what least squares leave (B, and the PV over a zone or
/// without terms) cost the same for any number of points. Of others each draw works the figure of all points out anew. Where
/// `uncertainty` is that over the area ([`Uncertainty::over`]), the change of a figure by weights of the area it knows counts
/// in u; of A and any RMS it is a bias, and how places scatter counts in u.
///
/// # Errors
///
/// If the limit makes no sense, its zone gives no sample, or the uncertainty cannot be worked out. The inner error says why the
/// deviations have no such figure.
pub fn finding(
    limit: &Limit,
    uncertainty: &Uncertainty,
    nominal: &Nominal,
    over: Over<'_>,
    draws: &Draws,
) -> Result<Result<Finding, Unknown>, LimitError> {
    limit.validate()?;
    let approximation = approximation(nominal);
    let dof = uncertainty.noise.dof;
    if limit.zone == Aperture::None && limit.less == Terms::NONE {
        if limit.definition == Definition::RmsOverPoints {
            let rms = &uncertainty.rms;
            let bias = rms.measured_nm - rms.form_nm;
            let (value, u) = (rms.measured_nm, Some(rms.u_nm));
            return Ok(Ok(Finding { u, dof, bias, ..Finding::of_value(value) }));
        }
        if limit.definition == Definition::PeakToValley {
            let found = uncertainty.peak_to_valley_nm(draws)?;
            let (value, u, bias) = (found.measured, Some(found.u), found.bias);
            return Ok(Ok(Finding { u, dof, bias, ..Finding::of_value(value) }));
        }
    }
    let all: Vec<usize> = (0..uncertainty.indices().len()).collect();
    let sample = over.sample(limit, uncertainty, (&all, uncertainty.deviations_mm()))?;
    let found = match limit.ranged(&sample, approximation) {
        Some(Ok(whole)) => of_range(limit, uncertainty, approximation, draws, &whole)?,
        Some(Err(unknown)) => Err(unknown),
        None => of_any(limit, uncertainty, approximation, over, draws, &sample)?,
    };
    let area = uncertainty.shares().and_then(|shares| {
        let deviations_mm = uncertainty.deviations_mm();
        let sample = over.weighted(limit, uncertainty, (&all, deviations_mm), Some(shares)).ok()?;
        let value = limit.figure(&sample, approximation).ok()?.value;
        let left = limit.without_terms(&sample).ok()?;
        let areas = over.areas_for(limit);
        Some(of_area(limit.definition, uncertainty, approximation, &left, (value, areas)))
    });
    let noise_nm = uncertainty.noise.sigma_mm * 1e6;
    let on_max = limit.noise_on_largest_slope(&sample, noise_nm);
    Ok(found.map(|(value, simulated)| {
        let averaged = simulated.as_ref().zip(average(limit.definition));
        if let Some((simulated, kind)) = averaged {
            return averaged_finding(value, (simulated, kind), area, uncertainty);
        }
        let (u, bias) = simulated.map_or((None, 0.0), |found| (Some(found.u), found.bias));
        let bias = on_max.map_or(bias, |on_max| on_max.min(value));
        // How far the figure is from that of the area is known, but not taken off.
        let moved = area.map_or(0.0, |area| area.value - value);
        Finding { u: u.map(|u| u.hypot(moved)), dof, bias, ..Finding::of_value(value) }
    }))
}

/// Of what averages over the area: by how much noise and places have moved it is its bias.
fn averaged_finding(
    value: f64,
    (simulated, kind): (&Simulated, Average),
    area: Option<OfArea>,
    uncertainty: &Uncertainty,
) -> Finding {
    let area = area.unwrap_or(OfArea { value, variance: 0.0, crowding: 1.0 });
    let noise = &uncertainty.noise;
    let found = |left: f64, u: f64| Finding {
        u: Some(u),
        dof: noise.dof,
        bias: value - left,
        is_average: true,
        ..Finding::of_value(value)
    };
    match (kind, simulated.mean_square()) {
        (Average::OfSquares, Some(mut square)) => {
            square.left += area.value * area.value - value * value;
            square.rate *= area.crowding;
            let fourth_nm4 = (noise.sigma_mm * NM_PER_MM).powi(4);
            // The noise may be another than was taken: see `rms.rs`.
            let best = if noise.measured { 2.0 / uncertainty.indices().len() as f64 } else { 0.0 };
            let by_measuring = 2.0 * fourth_nm4 * (noise.dof.recip() - best);
            square.apart += area.variance + by_measuring.max(-2.0 * square.rate * square.noise);
            // Half of what may be form is taken for it.
            let by_form = 0.5 * noise.by_form_mm2 * NM_PER_MM * NM_PER_MM;
            square.left += by_form;
            square.apart += by_form * by_form;
            Finding { square: Some(square), ..found(square.root(), square.u()) }
        }
        _ => found(area.value, (area.crowding * simulated.u * simulated.u + area.variance).sqrt()),
    }
}

/// A value and what draws tell of it.
type Drawn = Result<(f64, Option<Simulated>), Unknown>;

/// Of the range of `whole`, which is what least squares leave of the deviations in the zone.
fn of_range(
    limit: &Limit,
    uncertainty: &Uncertainty,
    approximation: Approximation,
    draws: &Draws,
    whole: &Sample,
) -> Result<Drawn, LimitError> {
    let range = match peak_to_valley(whole) {
        Ok(range) => range,
        Err(unknown) => return Ok(Err(unknown)),
    };
    let left = |places_mm: &[[f64; 2]], deviations_mm: &[f64], areas: &[f64]| {
        let sample = Sample::new(places_mm, deviations_mm, Some(areas), &limit.zone).ok()?;
        Some(limit.ranged(&sample, approximation)?.ok()?.into_owned())
    };
    Ok(Ok((range.value, uncertainty.simulate_range(draws, whole, left)?)))
}

/// Of any other figure of `sample`, the deviations in the zone.
fn of_any(
    limit: &Limit,
    uncertainty: &Uncertainty,
    approximation: Approximation,
    over: Over<'_>,
    draws: &Draws,
    sample: &Sample,
) -> Result<Drawn, LimitError> {
    let figure = match limit.figure(sample, approximation) {
        Ok(figure) => figure,
        Err(unknown) => return Ok(Err(unknown)),
    };
    let of = |places: &[usize], deviations_mm: &[f64]| {
        let sample = over.sample(limit, uncertainty, (places, deviations_mm)).ok()?;
        // With its sense: errors go into A evenly, but not into its amount where that is about nothing.
        if limit.definition == Definition::Sagitta {
            let left = limit.without_terms(&sample).ok()?;
            return decompose(&left, approximation, None).ok().map(|found| found.sagitta_nm);
        }
        limit.figure(&sample, approximation).ok().map(|figure| figure.value)
    };
    let all = || (0..uncertainty.indices().len()).collect::<Vec<usize>>();
    let simulated = match (average(limit.definition), limit.definition.statistic()) {
        (Some(kind), _) => uncertainty.simulate_average(draws, kind, of),
        (None, Statistic::MeanSquareSlope) => {
            let all = all();
            uncertainty.simulate_of_squares(draws, |deviations_mm: &[f64]| of(&all, deviations_mm))
        }
        (None, _) => {
            let all = all();
            uncertainty.simulate(draws, |deviations_mm: &[f64]| of(&all, deviations_mm))
        }
    };
    Ok(Ok((figure.value, simulated?)))
}

/// How noise adds to a figure that averages over the area; `None` for one made of extremes, or of as many rings as the
/// points fill.
fn average(definition: Definition) -> Option<Average> {
    match definition.statistic() {
        Statistic::MeanSquare => Some(Average::OfSquares),
        Statistic::Coefficient => Some(Average::OfHeights),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_by_name() {
        let limit: Limit = "pvr 120".parse().unwrap();
        assert_eq!((limit.definition, limit.value), (Definition::Pvr { terms: 36 }, 120.0));
        let missing: Result<Limit, _> = "rms".parse();
        assert!(matches!(missing, Err(LimitError::Value { .. })));
        let error = "sag 5".parse::<Limit>().unwrap_err().to_string();
        assert!(
            error.starts_with("no figure is called \"sag\", expected one of pv, rms"),
            "{error}"
        );
        for bad in ["pv 0", "pv -1", "pv nan", "pv 1 2"] {
            assert!(bad.parse::<Limit>().is_err(), "{bad}");
        }
        let slope: Limit = "slope_max 30".parse().unwrap();
        assert!(matches!(slope.validate(), Err(LimitError::Slope { .. })));
    }
}
