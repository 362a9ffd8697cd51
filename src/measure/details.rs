//! The figures of standards and optical shops, of the final deviation.

use asphera_figures::{
    Approximation, Definition, Figure, FringeCount, FringeFit, Reference, Ring, Sample,
    SampleError, Share, Term, Unknown, decompose, fringe_fit, peak_to_valley, radial_profile,
    remove, rms, robust_peak_to_valley, slopes,
};
use asphera_form::basis::{Counting, aberration};
use asphera_form::{Nominal, Pose};
use asphera_geometry::{PointMm, VertexId};
use asphera_report::{
    FormFigure, HistogramFigures, RingFigures, Source, StandardFigures, ZernikeFigures, ZernikeTerm,
};

mod stations;

use super::judged::Sure;
use super::naming;
use super::standards::{self, Limited};
use crate::Part;

/// Figures of a final report about the form beside fit, PV and RMS.
#[derive(Default)]
pub(super) struct FormDetails {
    pub(super) figures: Vec<FormFigure>,
    pub(super) zernike: Option<ZernikeFigures>,
    /// Why there are none; among [`unknown`](Self::unknown), too.
    pub(super) zernike_unknown: Option<String>,
    pub(super) histogram: Option<HistogramFigures>,
    pub(super) rings: Vec<RingFigures>,
    /// Figures that standards define.
    pub(super) standards: StandardFigures,
    /// Those of them that a limit may be held against, beside figures of deviations.
    pub(super) limited: Vec<Limited>,
    /// Unknown figures, and why.
    pub(super) unknown: Vec<String>,
    /// Why slopes over the length of their limits are not those of the whole aperture.
    pub(super) slopes_missing: Option<String>,
}

/// What is known beside the deviations.
#[derive(Clone, Copy)]
pub(super) struct Beside<'a> {
    /// RMS over the points.
    pub(super) rms_nm: f64,
    /// Noise of a point, where it is known.
    pub(super) noise_nm: Option<f64>,
    /// Uncertainties of the figures.
    pub(super) sure: &'a Sure,
}

/// The deviation that A, B, C and their RMS are formed of, and the nominal it is from.
pub(super) struct Indicated<'a> {
    pub(super) sample: &'a Sample,
    pub(super) nominal: &'a Nominal,
    /// Whether the shape was free and is held at the design here.
    pub(super) from_design: bool,
}

/// Details of the deviations of `points`, in the frame the fit was made in. A point without a deviation has
/// NaN. Takes time in proportion to the points, the most of it for the Fringe terms.
pub(super) fn details(
    part: &Part,
    sample: &Result<Sample, SampleError>,
    indicated: Result<Indicated<'_>, String>,
    areas_mm2: &[f64],
    beside: Beside<'_>,
) -> FormDetails {
    let mut details = FormDetails::default();
    match sample {
        Ok(sample) => {
            // Where nothing is sampled densely enough, no point stands for an area, and all count alike.
            let weighted = sample.indices().iter().any(|&index| areas_mm2[index] > 0.0);
            details.fill(part, sample, indicated, weighted, beside);
        }
        Err(error) => details.unknown.push(format!("figures of the form: {error}")),
    }
    details
}

/// The deviations that count, at their places in the part frame.
pub(super) fn sample(
    part: &Part,
    pose: &Pose,
    points: &[PointMm],
    deviations_mm: &[f64],
    areas_mm2: &[f64],
) -> Result<Sample, SampleError> {
    Sample::by_area(&places_mm(pose, points), deviations_mm, Some(areas_mm2), &part.aperture)
}

/// Where points lie in the part frame, seen along its axis.
pub(super) fn places_mm(pose: &Pose, points: &[PointMm]) -> Vec<[f64; 2]> {
    let motion = pose.motion();
    let place = |point: &PointMm| {
        let [x, y, _] = motion.to_part(*point);
        [x, y]
    };
    points.iter().map(place).collect()
}

/// The area each point stands for, projected, in mm²: a third of that of every triangle it is a corner of.
pub(super) fn areas_mm2(
    points: &[PointMm],
    triangles: impl Iterator<Item = [VertexId; 3]>,
) -> Vec<f64> {
    let mut areas_mm2 = vec![0.0; points.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        for corner in corners {
            areas_mm2[corner as usize] += doubled.abs() / 6.0;
        }
    }
    areas_mm2
}

impl FormDetails {
    fn fill(
        &mut self,
        part: &Part,
        sample: &Sample,
        indicated: Result<Indicated<'_>, String>,
        weighted: bool,
        beside: Beside<'_>,
    ) {
        let Beside { rms_nm, noise_nm, sure } = beside;
        let alike = if weighted { "" } else { ", every point counted alike" };
        let as_fitted = &*format!("as fitted{alike}");
        let fringe = fringe_fit(sample, part.figures.zernike);
        for (name, figure) in [
            ("PV", peak_to_valley(sample)),
            ("RMS", Ok(Figure { definition: Definition::RmsOverPoints, value: rms_nm })),
            ("RMS", rms(sample, Reference::Zero)),
            ("RMS", rms(sample, Reference::Mean)),
            ("PV99%", robust_peak_to_valley(sample, Share::NINETY_NINE)),
            ("PVr", fringe.as_ref().map_err(Unknown::clone).and_then(FringeFit::pvr)),
        ] {
            self.take(name, figure, as_fitted, sure);
        }
        self.indication(part, indicated, alike, sure);
        self.slopes(sample, part, noise_nm);
        self.remainders(sample, sure);
        if let Some(terms) = part.figures.q_terms {
            match standards::q_spectrum(sample, terms, noise_nm) {
                Ok((found, lacking)) => {
                    self.standards.q_spectrum = Some(found);
                    self.unknown.extend(lacking.map(|why| format!("Q spectrum: {why}")));
                }
                Err(why) => self.lacks("Q spectrum", &why),
            }
        }
        match &fringe {
            Ok(found) if found.condition > MOST_CONDITION => self.zernike_lacks(format!(
                "the places measured cannot separate them (condition {:.1e}, at most {MOST_CONDITION:.0e} is allowed). Measure about the origin, or set [aperture] centre_mm to the middle of the points",
                found.condition
            )),
            Ok(found) => self.zernike = Some(zernike(found, Source::Points)),
            Err(why) => self.zernike_lacks(why.to_string()),
        }
        match radial_profile(sample, None) {
            Ok(found) => self.rings = found.iter().map(ring).collect(),
            Err(why) => self.lacks("radial profile", &why),
        }
        let pv_limit_nm = part.judging.pv_limit_nm();
        self.histogram = histogram(sample.values_nm())
            .map(|histogram| HistogramFigures { pv_limit_nm, ..histogram });
    }

    fn indication(
        &mut self,
        part: &Part,
        indicated: Result<Indicated<'_>, String>,
        alike: &str,
        sure: &Sure,
    ) {
        let found = indicated.and_then(|Indicated { sample, nominal, from_design }| {
            let parts = decompose(sample, approximation(nominal), None);
            parts.map(|parts| (parts, from_design)).map_err(|why| why.to_string())
        });
        match found {
            Ok((parts, from_design)) => {
                let asked = part.judging.indication.as_ref();
                self.standards.indication = Some(standards::found(&parts, asked));
                let of = if from_design { "against the design, shape held" } else { "as fitted" };
                let variant = format!("{of}{alike}");
                for found in parts.figures() {
                    self.figures.push(naming::figure_of_all(found, &variant, sure));
                }
            }
            Err(why) => self.unknown.push(format!("A, B, C and their RMS: {why}")),
        }
    }

    /// Slopes over the length that the nominal file states for figures, else for limits, else over a twentieth of the
    /// aperture's width: ISO 10110-12 leaves it to the drawing.
    fn slopes(&mut self, sample: &Sample, part: &Part, noise_nm: Option<f64>) {
        let of_limit = part.limits().iter().find_map(|limit| limit.slope);
        let twentieth = || part.figures.slope_over(&part.aperture, sample.radius_mm());
        let Some(settings) = part.figures.slope.or(of_limit).or_else(twentieth) else {
            return self.lacks("slopes", &Unknown::OnePlace);
        };
        match slopes(sample, settings) {
            Ok(found) => {
                let over = settings.scope();
                self.unknown.extend(stations::missing(&found, sample));
                self.slopes_missing = of_limit.and_then(|of_limit| match of_limit == settings {
                    true => stations::missing(&found, sample),
                    false => stations::missing(&slopes(sample, of_limit).ok()?, sample),
                });
                let shares =
                    noise_nm.map_or([(None, None); 4], |nm| stations::noise_of(&found, nm));
                for (figure, (noise_adds, without_noise)) in found.figures().into_iter().zip(shares)
                {
                    let figure = naming::figure(figure, over.clone());
                    self.figures.push(FormFigure { noise_adds, without_noise, ..figure });
                }
            }
            Err(why) => self.lacks("slopes", &why),
        }
    }

    /// PV and RMS of what is left when one more of the usual terms is taken out.
    fn remainders(&mut self, sample: &Sample, sure: &Sure) {
        for last in 1..REMOVED.len() {
            let terms = &REMOVED[..=last];
            match remove(sample, terms) {
                Ok(removed) => {
                    let sample = &removed.sample;
                    for (name, figure) in
                        [("PV", peak_to_valley(sample)), ("RMS", rms(sample, Reference::Zero))]
                    {
                        self.add(
                            name,
                            figure.map(|figure| naming::figure_without(figure, terms, sure)),
                        );
                    }
                }
                Err(why) => self.lacks(&naming::without(terms), &why),
            }
        }
    }

    /// Takes a figure of the whole aperture with its uncertainty, or why it is not known.
    pub(super) fn take(
        &mut self,
        name: &str,
        figure: Result<Figure, Unknown>,
        variant: &str,
        sure: &Sure,
    ) {
        self.add(name, figure.map(|figure| naming::figure_of_all(figure, variant, sure)));
    }

    fn add(&mut self, name: &str, figure: Result<FormFigure, Unknown>) {
        match figure {
            Ok(figure) => self.figures.push(figure),
            Err(why) => self.lacks(name, &why),
        }
    }

    fn zernike_lacks(&mut self, why: String) {
        self.unknown.push(format!("Zernike terms: {why}"));
        self.zernike_unknown = Some(why);
    }

    fn lacks(&mut self, name: &str, why: &Unknown) {
        self.unknown.push(format!("{name}: {why}"));
    }
}

/// Shape of a change of the radius, by the kind of the nominal.
fn approximation(nominal: &Nominal) -> Approximation {
    match nominal {
        Nominal::Sphere { radius_mm } => {
            Approximation::sphere(*radius_mm).unwrap_or(Approximation::Quadratic)
        }
        _ => Approximation::Quadratic,
    }
}

pub(super) fn zernike(fit: &FringeFit, source: Source) -> ZernikeFigures {
    let terms = (1_u8..).zip(&fit.coefficients_nm).filter_map(|(index, value_nm)| {
        // The rule of counting holds for the first 36; the 37th is another.
        let (n, m) = if index == FringeCount::ThirtySeven.last() {
            (12, 0)
        } else {
            Counting::Fringe.orders(index.into())?
        };
        Some(ZernikeTerm {
            index: index.into(),
            name: aberration(n, m)?,
            n,
            m,
            value_nm: (*value_nm)?,
        })
    });
    ZernikeFigures {
        scheme: "Fringe".to_owned(),
        normalisation: "height 1 at the rim".to_owned(),
        radius_mm: fit.radius_mm,
        terms: terms.collect(),
        indeterminate: fit.indeterminate().into_iter().map(u32::from).collect(),
        residual_rms_nm: fit.residual_rms_nm,
        source,
    }
}

/// The bins are as wide as 1, 2 or 5 times a power of ten, so that an axis reads well.
fn histogram(values_nm: &[f64]) -> Option<HistogramFigures> {
    histogram_of(values_nm, values_nm.iter().map(|_| 1), Source::Points)
}

/// As [`histogram`], of values that stand for as many points as `each` says.
pub(super) fn histogram_of(
    values_nm: &[f64],
    each: impl Iterator<Item = u64>,
    source: Source,
) -> Option<HistogramFigures> {
    let (low, high) = values_nm
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), nm| (low.min(*nm), high.max(*nm)));
    if low > high {
        return None;
    }
    let wanted = (values_nm.len() as f64).sqrt().clamp(8.0, MOST_BINS);
    let width_nm = round_up((high - low) / wanted, low.abs().max(high.abs()));
    let first = (low / width_nm).floor();
    let bin = |nm: f64| ((nm / width_nm).floor() - first) as usize;
    let mut counts = vec![0; bin(high) + 1];
    for (nm, points) in values_nm.iter().zip(each) {
        counts[bin(*nm)] += points;
    }
    let pv_limit_nm = None;
    Some(HistogramFigures { low_nm: first * width_nm, width_nm, counts, pv_limit_nm, source })
}

/// The least of 1, 2 or 5 times a power of ten that is not below `width`, and wide enough that numbers of
/// size `largest` can be told apart by it.
fn round_up(width: f64, largest: f64) -> f64 {
    let width = width.max(1e-9 * largest).max(1e-6);
    let decade = 10.0_f64.powi(width.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade);
    steps.into_iter().find(|step| *step >= width).unwrap_or(10.0 * decade)
}

fn ring(ring: &Ring) -> RingFigures {
    RingFigures {
        from_mm: ring.from_mm,
        to_mm: ring.to_mm,
        points: ring.count as u64,
        covered: ring.covered,
        mean_nm: ring.heights.map(|heights| heights.mean_nm),
        low_nm: ring.heights.map(|heights| heights.low_nm),
        high_nm: ring.heights.map(|heights| heights.high_nm),
    }
}

/// In the order in which they are usually taken out.
const REMOVED: [Term; 6] =
    [Term::Piston, Term::Tilt, Term::Power, Term::Astigmatism, Term::Coma, Term::Spherical];
/// Terms that are told apart worse are far larger than their sum: over a rectangle of 1 to 4 about its middle it is 4400, about a
/// place a quarter of its length aside 160,000, about its corner 2e7.
const MOST_CONDITION: f64 = 1e4;
/// More say no more to the eye.
const MOST_BINS: f64 = 64.0;

#[cfg(test)]
mod tests;
