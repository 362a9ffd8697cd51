//! The deviation from the design, where parameters of the shape were free: what figures that refer to the design are formed of.

use asphera_figures::{Sample, SampleError, Subject, Treatment, is_motion};
use asphera_form::{Figures, Fit, Parameter};
use asphera_mesh::Mesh;
use asphera_report::CautionFigures;

use super::details::{Indicated, places_mm, sample};
use super::fitting::Fitted;
use super::judgement::Deviating;
use super::measurement::deviation;
use crate::Part;

/// The deviation from the design.
pub(super) struct Design<'a> {
    pub(super) fit: &'a Fit,
    /// Of every vertex, NaN outside the aperture.
    pub(super) deviations_mm: Vec<f64>,
    pub(super) found: Option<Figures>,
    places_mm: Vec<[f64; 2]>,
    sample: Result<Sample, SampleError>,
}

impl<'a> Design<'a> {
    /// `None` where what the fit leaves is that from the design.
    pub(super) fn new(
        part: &Part,
        mesh: &Mesh,
        fitted: &'a Fitted,
        areas_mm2: &[f64],
    ) -> Option<Result<Design<'a>, String>> {
        fitted.design.as_ref()?;
        Some(fitted.fit_for(Subject::Indication, part).map(|fit| {
            let (deviations_mm, found) = deviation(mesh, part, fit);
            let sample = sample(part, &fit.pose, mesh.points(), &deviations_mm, areas_mm2);
            let places_mm = places_mm(&fit.pose, mesh.points());
            Design { fit, deviations_mm, found, places_mm, sample }
        }))
    }

    /// The deviation as limits take it.
    pub(super) fn deviating<'b>(&'b self, areas_mm2: &'b [f64]) -> Deviating<'b> {
        let Design { fit, deviations_mm, places_mm, .. } = self;
        Deviating { places_mm, deviations_mm, areas_mm2, nominal: &fit.nominal }
    }

    /// Sample of A, B, C and their RMS.
    pub(super) fn indicated(&self) -> Result<Indicated<'_>, String> {
        let sample = self.sample.as_ref().map_err(ToString::to_string)?;
        Ok(Indicated { sample, nominal: &self.fit.nominal, from_design: true })
    }
}

/// What the deviation of figures of a subject is from, in words: absent where the fit leaves the shape as it is, where there is
/// no design, and of surfaces that filters leave.
pub(super) fn scope(subject: Subject, part: &Part) -> Option<&'static str> {
    if part.reference.is_some() {
        return None;
    }
    match subject.treatment(&part.free) {
        Treatment::AsFitted => None,
        Treatment::FromDesign => Some("against the design"),
        Treatment::Cautioned => Some("about the fitted shape"),
    }
}

/// Which figures do not judge the shape, as parameters of it were free.
pub(super) fn caution(part: &Part) -> Option<CautionFigures> {
    let with = |wanted: Treatment| {
        let all = Subject::ALL.into_iter();
        let some = all.filter(move |subject| subject.treatment(&part.free) == wanted);
        some.map(Subject::figures).collect::<Vec<_>>().join(", ")
    };
    let of_shape: Vec<Parameter> =
        part.free.iter().copied().filter(|&parameter| !is_motion(parameter)).collect();
    if of_shape.is_empty() || part.reference.is_some() {
        return None;
    }
    let names: Vec<String> =
        of_shape.iter().map(|parameter| parameter.name(&part.nominal)).collect();
    let text = format!(
        "the fit changes the shape (free: {}). {} are figures of what the fit leaves, and say nothing of the design. {} \
         compare with the design, with the shape held",
        names.join(", "),
        with(Treatment::Cautioned),
        with(Treatment::FromDesign)
    );
    Some(CautionFigures { kind: "free_shape".to_owned(), text, forbids_verdict: false })
}

#[cfg(test)]
mod tests;
