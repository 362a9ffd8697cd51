//! The verdict of a part that was meshed in space, and what stands in its way.

use asphera_report::{SamplingFigures, Verdict};
use asphera_uncertainty::verdict::{Finding, Guard};

use super::form::Formed;
use super::meshed::Meshed;
use super::openings::Opening;
use crate::Part;
use crate::decision::{Held, hold};
use crate::judgement::{doubt, undecide, without_checks};
use crate::naming;
use crate::standards;

/// All that a verdict is made of.
pub(super) struct Evidence<'a> {
    pub(super) part: &'a Part,
    pub(super) meshed: &'a Meshed,
    pub(super) formed: Result<&'a Formed, &'a str>,
    pub(super) sampling: &'a SamplingFigures,
    pub(super) openings: &'a [Opening],
}

impl Evidence<'_> {
    pub(super) fn verdict(&self) -> Verdict {
        let mut verdict = without_checks(self.part);
        match self.formed {
            Err(why) => {
                doubt(&mut verdict, format!("no fit: {why}"));
                self.judge_mesh(&mut verdict);
                return verdict;
            }
            Ok(formed) => self.hold_limits(&mut verdict, formed),
        }
        if let Ok(formed) = self.formed {
            self.judge_fit(&mut verdict, formed);
        }
        self.judge_mesh(&mut verdict);
        self.judge_coverage(&mut verdict);
        verdict
    }

    fn hold_limits(&self, verdict: &mut Verdict, formed: &Formed) {
        let part = self.part;
        let guard = part.judging.guard;
        for limit in part.limits() {
            let figure = naming::of_limit(limit, part);
            let value = limit.is_of_whole().then(|| formed.value_nm(limit.definition)).flatten();
            let Some(value) = value else {
                undecide(verdict, format!("{}: {REFUSED}", figure.words()));
                continue;
            };
            let hidden = self.hidden();
            let u = formed.u_nm(limit.definition);
            let covers = formed.errors.as_ref().map(|errors| errors.covers(limit.definition));
            let finding = Finding { u, hidden, ..Finding::of_value(value) };
            let why = hidden.is_none().then(|| MISSING.to_owned());
            hold(
                verdict,
                guard,
                Held { figure, limit: limit.value, finding, hidden: None, covers, why },
            );
        }
        for (figure, _) in standards::limits(part) {
            undecide(verdict, format!("{}: {REFUSED}", figure.words()));
        }
    }

    /// What may hide where nothing was measured: the coverage that is wanted says how much may be missing, but where a
    /// probability is asked for nothing is known of the rest.
    fn hidden(&self) -> Option<f64> {
        let is_whole = self.sampling.coverage == Some(1.0);
        let by_probability = matches!(self.part.judging.guard, Some(Guard::Probability(_)));
        (is_whole || !by_probability).then_some(0.0)
    }

    fn judge_fit(&self, verdict: &mut Verdict, formed: &Formed) {
        let part = self.part;
        if !formed.fit.converged {
            doubt(verdict, "the fit did not converge".to_owned());
        }
        let (points, unknowns) = (self.meshed.points_mm.len(), formed.fit.unknowns);
        if points <= unknowns {
            doubt(
                verdict,
                format!("{points} points determine {unknowns} parameters and no deviation"),
            );
        }
        if !part.criterion.is_plain() {
            let why = "in space the fit is by least squares of points that count alike, and the nominal asks for another loss or weights; leave those out";
            doubt(verdict, why.to_owned());
        }
        if part.aperture != asphera_form::Aperture::None {
            let why = "the aperture of the nominal is a region of a plane: in space every point was taken; leave [aperture] out";
            undecide(verdict, why.to_owned());
        }
        let radius_nm = 1e6 * formed.fit.laid.shape.radius_mm();
        if formed.figures.rms_nm > MOST_OFF * radius_nm {
            doubt(
                verdict,
                format!(
                    "the points are none of this shape: their RMS is {:.1} % of its radius; check radius and unit",
                    100.0 * formed.figures.rms_nm / radius_nm
                ),
            );
        }
    }

    fn judge_mesh(&self, verdict: &mut Verdict) {
        let proof = &self.meshed.proof;
        let flaws = [
            (proof.nonmanifold_edges.count, "edges of three facets or more"),
            (proof.singular_vertices.count, "singular vertices"),
            (proof.self_intersections.count, "crossings of facets"),
        ];
        let flaws: Vec<String> = flaws
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        if !flaws.is_empty() {
            doubt(
                verdict,
                format!("the mesh in space is no surface: {}; {CAUSES}", flaws.join(", ")),
            );
        }
        if !proof.is_orientable {
            doubt(verdict, "the mesh in space has one side only".to_owned());
        }
        let points = self.meshed.points_mm.len();
        let unused = self.meshed.used().iter().filter(|used| !**used).count();
        if unused as f64 > MOST_UNUSED * points as f64 {
            undecide(verdict, format!("{unused} of {points} points are in no facet; {CAUSES}"));
        }
        if proof.components > 1 {
            let parts = proof.components;
            undecide(verdict, format!("the points make {parts} surfaces that do not touch"));
        }
        let noise = self.sampling.noise_sigma_nm.zip(self.sampling.spacing_median_mm);
        if let Some((noise_nm, spacing_mm)) = noise
            && 1e-6 * noise_nm > MOST_NOISE * spacing_mm
        {
            doubt(
                verdict,
                format!(
                    "the noise of {noise_nm:.0} nm is more than a quarter of the point spacing of {spacing_mm:.4} mm; thin the points, or measure with less noise"
                ),
            );
        }
    }

    fn judge_coverage(&self, verdict: &mut Verdict) {
        match self.sampling.coverage {
            None => {
                let why = self
                    .sampling
                    .unknown
                    .first()
                    .map_or("the coverage is not known", String::as_str);
                undecide(verdict, why.to_owned());
            }
            Some(coverage) if coverage < self.part.coverage_min => undecide(
                verdict,
                format!(
                    "only {:.1} % of the surface is sampled densely enough, {:.1} % are wanted",
                    100.0 * coverage,
                    100.0 * self.part.coverage_min
                ),
            ),
            Some(_) => {}
        }
        if let Some(longest) = self.openings.first() {
            let [x, y, z] = longest.at_mm;
            let count = self.openings.len();
            verdict.reasons.push(format!(
                "the surface is open: {count} loops of border, the longest {:.3} mm about ({x:.3}, {y:.3}, {z:.3}) mm; nothing is judged beyond",
                longest.length_mm
            ));
        }
    }
}

const REFUSED: &str = "not formed in space; give limits of pv_nm, rms_nm and rms_about_mean_nm";
const MISSING: &str = "what may hide there is not worked out in space";
const CAUSES: &str = "the points lie too far apart for the feature size, sheets cross, or the noise is above the spacing";
/// Of the radius: a larger RMS is no form deviation.
const MOST_OFF: f64 = 0.05;
/// Of the points.
const MOST_UNUSED: f64 = 0.01;
/// Of the spacing.
const MOST_NOISE: f64 = 0.25;
