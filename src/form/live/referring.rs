//! When the running estimator makes a new reference, and from what.
//!
//! A reference is made whenever the number of points has doubled. By squares it is the full fit, which takes some eight passes over
//! the points; a robust fit takes some ninety. So of many points only a sample is fitted then. It tells whether the estimate lies where the
//! fit would lie: of the many solutions of Tukey's loss, of two ways to lay a part, by the same determinate parameters.
//! If it does, the estimate itself is the new reference, where the points are linearised and their scale found anew:
//! what is left to the solution is then a small part of a small way. Otherwise all points are fitted. With a robust loss points
//! are linearised anew whenever a quarter of them is new, because weights change faster than rows do. By squares that is done
//! on the way, while further points arrive.

use rayon::prelude::*;

use crate::fit::model::Model;
use crate::fit::robust::scale;
use crate::fit::selection::Membership;
use crate::fit::slant::Slant;
use crate::fit::triangle::CHUNK;
use crate::fit::weight::Weights;
use crate::fit::{Fit, FitSettings, along_normal_mm, fit, fit_weighted};
use crate::live::Live;
use crate::live::linearised::{Linearised, Place};
use crate::{FitError, Loss, PointMm};

impl Live {
    /// Makes a reference that is due, or begins it. The present one has the points before `new`.
    pub(super) fn refer_on_the_way(&mut self, new: usize) {
        let rank_tolerance = self.settings.rank_tolerance.max(self.settings.fit.rank_tolerance);
        let settings = FitSettings { rank_tolerance, ..self.settings.fit.clone() };
        let is_due = self.points.len() >= self.next_fit;
        self.upcoming = None;
        let estimate = self.estimated();
        match estimate {
            Some(place) if !is_due || self.is_confirmed(&place, &settings) => match settings.loss {
                Loss::Squares => self.announce(place, new),
                _ => self.follow(&place),
            },
            _ => self.refer(&settings),
        }
        if is_due {
            self.next_fit = (2 * self.points.len()).max(self.next_fit);
        }
        self.plan();
    }

    /// Says when the next reference is due.
    pub(super) fn plan(&mut self) {
        let points = self.points.len();
        self.next_reference = match self.settings.fit.loss {
            Loss::Squares => self.next_fit,
            _ => (points + points / GROWTH).max(self.next_reference).min(self.next_fit),
        };
    }

    /// The estimate, where it may become the reference: by squares only of many points that determine all they can.
    fn estimated(&self) -> Option<Place> {
        let reference = self.reference.as_ref()?;
        match self.settings.fit.loss {
            Loss::Squares if self.points.len() <= AT_ONCE => None,
            Loss::Squares => reference.place_by_squares(),
            _ => reference.place(),
        }
    }

    /// Makes the full fit of all points so far the reference.
    pub(super) fn refer(&mut self, settings: &FitSettings) {
        self.next_fit = (2 * self.points.len()).max(self.next_fit);
        self.upcoming = None;
        match self.fitted(&self.points, &self.uncertainties_mm, settings) {
            Ok(Fitted { fit, slant, unit_mm }) => {
                let scale_mm = fit.robust.map(|robust| robust.scale_mm);
                self.linearise(fit, slant, unit_mm, scale_mm);
                if let Some(reference) = &mut self.reference {
                    reference.confirm();
                }
                self.failure = None;
            }
            Err(failure) => self.failure = Some(failure),
        }
    }

    /// Makes an estimate the reference.
    fn follow(&mut self, place: &Place) {
        let slant = self.settings.slant(&place.fit);
        let u_mm = slant.as_ref().map(|slant| {
            let pairs = self.points.iter().zip(&self.uncertainties_mm);
            pairs.map(|(&point, u_mm)| slant.share(point) * u_mm).collect::<Vec<f64>>()
        });
        let u_mm = u_mm.as_deref().unwrap_or(&self.uncertainties_mm);
        let weights = (!u_mm.is_empty()).then(|| Weights::new(u_mm, self.points.len()).ok());
        let weights = weights.flatten();
        let scale_mm = self.scale_mm(place, weights.as_ref());
        let mut fit = place.fit.clone();
        if let Some(robust) = &mut fit.robust {
            robust.scale_mm = scale_mm;
        }
        let unit_mm = weights.map(|weights| weights.reference_mm);
        self.linearise(fit, slant, unit_mm, Some(scale_mm));
    }

    fn linearise(
        &mut self,
        fit: Fit,
        slant: Option<Slant>,
        unit_mm: Option<f64>,
        scale_mm: Option<f64>,
    ) {
        let (points, u_mm) = (&self.points, &self.uncertainties_mm);
        let mut linearised =
            Linearised::of_points(fit, slant, points, u_mm, unit_mm, &self.settings);
        if let Some(scale_mm) = scale_mm.filter(|_| self.settings.fit.loss_scale_mm.is_none()) {
            linearised.calibrate(scale_mm);
        }
        self.reference = Some(linearised);
    }

    /// The scale of all points about the pose that finds it, of a point of mean weight.
    fn scale_mm(&self, place: &Place, weights: Option<&Weights>) -> f64 {
        if let Some(given_mm) = self.settings.fit.loss_scale_mm {
            return given_mm;
        }
        let model = Model::new(&place.fit.nominal, &place.fit.pose, &[]);
        let first = Model::new(&place.first.1, &place.first.0, &[]);
        let aperture = &self.settings.fit.aperture;
        let distance = |(index, &point): (usize, &PointMm)| {
            let used = Membership::of(point, &model, aperture) == Membership::Used;
            let distance_mm = used.then(|| first.distance_mm(point)).flatten()?;
            Some(weights.map_or(1.0, |weights| weights.roots[index]) * distance_mm)
        };
        let points = self.points.par_iter().enumerate().with_min_len(CHUNK);
        let distances: Vec<f64> = points.filter_map(distance).collect();
        scale(&distances)
    }

    /// Whether the fit of a sample of the points lies where an estimate lies. Never if they are few.
    fn is_confirmed(&self, place: &Place, settings: &FitSettings) -> bool {
        if self.points.len() <= SAMPLE {
            return false;
        }
        let chosen = sample(self.points.len());
        let points: Vec<PointMm> = chosen.iter().map(|&index| self.points[index]).collect();
        let u_mm: Vec<f64> =
            chosen.iter().filter_map(|&index| self.uncertainties_mm.get(index).copied()).collect();
        let Ok(Fitted { fit, unit_mm, .. }) = self.fitted(&points, &u_mm, settings) else {
            return false;
        };
        let parameters = |fit: &Fit| -> Vec<_> {
            fit.estimates.iter().map(|estimate| estimate.parameter).collect()
        };
        let scale_mm = fit.robust.map_or(fit.sigma_mm, |robust| robust.scale_mm);
        let apart = apart_mm(&points, &u_mm, unit_mm, &fit, place);
        parameters(&fit) == parameters(&place.fit) && apart <= APART * scale_mm
    }

    /// The full fit of points, how the direction of their uncertainties stands on it, and the uncertainty of one of mean
    /// weight.
    fn fitted(
        &self,
        points: &[PointMm],
        given_mm: &[f64],
        settings: &FitSettings,
    ) -> Result<Fitted, FitError> {
        let nominal = &self.nominal;
        if given_mm.is_empty() {
            let fit = fit(points, nominal, settings)?;
            return Ok(Fitted { fit, slant: None, unit_mm: None });
        }
        let unit_mm = |u_mm: &[f64]| Weights::new(u_mm, points.len()).map(|one| one.reference_mm);
        let Some(direction) = self.settings.uncertain_along else {
            let fit = fit_weighted(points, Some(given_mm), nominal, settings)?;
            return Ok(Fitted { fit, slant: None, unit_mm: Some(unit_mm(given_mm)?) });
        };
        let first = fit(points, nominal, settings)?;
        let u_mm = along_normal_mm(points, given_mm, direction, &first);
        let fit = fit_weighted(points, Some(&u_mm), nominal, settings)?;
        let slant = self.settings.slant(&first);
        Ok(Fitted { fit, slant, unit_mm: Some(unit_mm(&u_mm)?) })
    }
}

/// A full fit with what goes with its weights.
struct Fitted {
    fit: Fit,
    slant: Option<Slant>,
    unit_mm: Option<f64>,
}

/// One place in each of [`SAMPLE`] stretches of equal length, by a sequence that no scan line shares: multiples of the
/// golden ratio.
fn sample(count: usize) -> Vec<usize> {
    let stretch = count as f64 / SAMPLE as f64;
    let place = |index: usize| {
        let within = (index as f64 * GOLDEN).fract();
        (((index as f64 + within) * stretch) as usize).min(count - 1)
    };
    (0..SAMPLE).map(place).collect()
}

/// Root mean square of the distance between two surfaces at points, each by its weight.
fn apart_mm(
    points: &[PointMm],
    u_mm: &[f64],
    unit_mm: Option<f64>,
    fit: &Fit,
    place: &Place,
) -> f64 {
    let one = Model::new(&fit.nominal, &fit.pose, &[]);
    let other = Model::new(&place.fit.nominal, &place.fit.pose, &[]);
    let (mut count, mut square) = (0.0, 0.0);
    for (index, &point) in points.iter().enumerate() {
        let (Some(a), Some(b)) = (one.distance_mm(point), other.distance_mm(point)) else {
            continue;
        };
        let root = unit_mm.zip(u_mm.get(index)).map_or(1.0, |(unit_mm, u_mm)| unit_mm / u_mm);
        count += 1.0;
        square += (root * (a - b)).powi(2);
    }
    (square / count).sqrt()
}

/// A new reference is due when one in so many points is new.
const GROWTH: usize = 4;
/// So many points are fitted and linearised at once by squares: some 50 ms.
const AT_ONCE: usize = 1 << 17;
/// Points of a sample.
const SAMPLE: usize = 2048;
/// The golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Two fits are the same if their surfaces lie so many scales apart: what a sample leaves open is a tenth of that.
const APART: f64 = 0.5;
