//! Expansion of a sample in Fringe terms.

use super::{Sample, Unknown};
use asphera_form::basis::{self, Counting, Normalisation, Scale, Zernike, expand};

/// How many Fringe terms a fit has, the piston included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FringeCount {
    /// Terms 1 to 36: all of (n + |m|)/2 up to 5.
    #[default]
    ThirtySix,
    /// Terms 1 to 37: those and the spherical term of order 12.
    ThirtySeven,
}

impl FringeCount {
    /// As many terms; `None` if no such fit exists.
    pub fn new(terms: u8) -> Option<FringeCount> {
        [FringeCount::ThirtySix, FringeCount::ThirtySeven]
            .into_iter()
            .find(|count| count.last() == terms)
    }

    /// The number of the last term.
    pub fn last(self) -> u8 {
        match self {
            FringeCount::ThirtySix => 36,
            FringeCount::ThirtySeven => 37,
        }
    }
}

/// Fringe terms fitted to a sample.
///
/// Terms are those of [`Zernike::fringe_37`], of height 1 at the rim, angles counted from +x towards +y. They
/// are fitted together, by area-weighted least squares at the measured places.
#[derive(Clone, Debug, PartialEq)]
pub struct FringeFit {
    /// Radius in mm of the disc the terms refer to.
    pub radius_mm: f64,
    /// Coefficients in nm, that of term j at j − 1. `None` for a term that the places do not tell from
    /// lower ones; the fit is without it.
    pub coefficients_nm: Vec<Option<f64>>,
    /// RMS of the residual in nm.
    pub residual_rms_nm: f64,
    /// Largest minus smallest value of the fit at the measured places in nm.
    pub range_nm: f64,
    /// Largest over smallest singular value of the terms at the places, each scaled to unit length: how
    /// much larger than the noise of the deviations that of a coefficient may be.
    pub condition: f64,
    /// Points used.
    pub used: usize,
}

impl FringeFit {
    /// Coefficient of the term `index` (from 1) in nm; `None` if not fitted or not determined.
    pub fn coefficient_nm(&self, index: u8) -> Option<f64> {
        let place = usize::from(index).checked_sub(1)?;
        self.coefficients_nm.get(place).copied().flatten()
    }

    /// Numbers of the terms the places do not determine, ascending.
    pub fn indeterminate(&self) -> Vec<u8> {
        let terms = (1_u8..).zip(&self.coefficients_nm);
        terms.filter(|(_, value)| value.is_none()).map(|(index, _)| index).collect()
    }
}

/// Fits the Fringe terms 1 to 36 or 37. `O(n·p²)` for n points and p terms.
///
/// Unknown with fewer points than terms. Terms may be indeterminate beyond that: see
/// [`FringeFit::indeterminate`].
pub fn fringe_fit(sample: &Sample, count: FringeCount) -> Result<FringeFit, Unknown> {
    let terms: Vec<u8> = (1..=count.last()).collect();
    let expansion = expand_fringe(sample, &terms, terms.len())?;
    let residual = &expansion.residual_nm;
    let fitted: Vec<f64> = sample.values_nm().iter().zip(residual).map(|(v, r)| v - r).collect();
    let [low, high] = Sample::range(&fitted).ok_or(Unknown::NoPoints)?;
    Ok(FringeFit {
        radius_mm: sample.radius_mm(),
        range_nm: high - low,
        residual_rms_nm: sample.mean(|i| residual[i] * residual[i]).sqrt(),
        coefficients_nm: expansion.coefficients_nm,
        condition: expansion.condition,
        used: sample.weighted(),
    })
}

/// An expansion with what it leaves of the sample.
pub(crate) struct Expansion {
    /// One a term; `None` for a term that is not determined and therefore left out.
    pub(crate) coefficients_nm: Vec<Option<f64>>,
    /// Deviation minus expansion in nm, one a place.
    pub(crate) residual_nm: Vec<f64>,
    pub(crate) condition: f64,
}

/// Area-weighted least squares of Fringe `terms` together. Unknown with fewer than `needed` points.
///
/// The only place of the figures that evaluates Fringe terms.
pub(crate) fn expand_fringe(
    sample: &Sample,
    terms: &[u8],
    needed: usize,
) -> Result<Expansion, Unknown> {
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    if sample.weighted() < needed {
        return Err(Unknown::TooFewPoints { used: sample.weighted(), needed });
    }
    let radius_mm = sample.radius_mm();
    if radius_mm == 0.0 && terms != [1] {
        return Err(Unknown::OnePlace);
    }
    // On the axis alone the piston needs no radius.
    let scale = Scale::round(if radius_mm > 0.0 { radius_mm } else { 1.0 });
    let scale = scale.map_err(|_| Unknown::OnePlace)?;
    let orders: Vec<(u32, i32)> = terms.iter().filter_map(|&term| fringe_orders(term)).collect();
    let basis = Zernike::of_orders(&orders, Normalisation::UnitHeight)
        .expect("Fringe terms 1 to 37, each once, exist");
    let areas = Some(sample.areas());
    let expansion = expand(&basis, &scale, sample.places_mm(), sample.values_nm(), areas)
        .map_err(|_| Unknown::TooFewPoints { used: sample.weighted(), needed })?;
    let coefficients = expansion.filled();
    let residual_nm =
        basis::residuals(&basis, &scale, &coefficients, sample.places_mm(), sample.values_nm());
    Ok(Expansion {
        coefficients_nm: expansion.coefficients,
        residual_nm,
        condition: expansion.condition,
    })
}

/// Radial and azimuthal order of a term of the Fringe set, the last of which is (12, 0).
pub fn fringe_orders(term: u8) -> Option<(u32, i32)> {
    if term == FringeCount::ThirtySeven.last() {
        Some((12, 0))
    } else {
        Counting::Fringe.orders(term.into())
    }
}
