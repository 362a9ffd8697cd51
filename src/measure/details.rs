//! The figures of standards and optical shops, of the final deviation.

use asphera_figures::{
    Approximation, Definition, Figure, FringeCount, FringeFit, Reference, Ring, Sample,
    SampleError, Share, SlopeFigure, Slopes, Term, Unknown, decompose, fringe_fit, peak_to_valley,
    radial_profile, remove, rms, robust_peak_to_valley, slopes,
};
use asphera_form::basis::{Counting, aberration};
use asphera_form::{Nominal, Pose};
use asphera_geometry::{PointMm, VertexId};
use asphera_report::{
    FormFigure, HistogramFigures, RingFigures, Source, StandardFigures, ZernikeFigures, ZernikeTerm,
};

use super::naming;
use super::standards;
use crate::Part;

/// Figures of a final report about the form beside fit, PV and RMS.
#[derive(Default)]
pub(super) struct FormDetails {
    pub(super) figures: Vec<FormFigure>,
    pub(super) zernike: Option<ZernikeFigures>,
    pub(super) histogram: Option<HistogramFigures>,
    pub(super) rings: Vec<RingFigures>,
    /// Those of [`standards`] that come of the deviations alone.
    pub(super) standards: StandardFigures,
    /// Unknown figures, and why.
    pub(super) unknown: Vec<String>,
    noise_nm: Option<f64>,
}

/// The deviation that A, B, C and their RMS are formed of, and the nominal it is from.
pub(super) struct Indicated<'a> {
    pub(super) sample: &'a Sample,
    pub(super) nominal: &'a Nominal,
    /// Whether the shape was free and is held at the design here.
    pub(super) from_design: bool,
}

/// Details of the deviations of `points`, in the frame the fit was made in. A point without a deviation has
/// NaN; `rms_nm` is their RMS over the points. `noise_nm` is the noise of a point, where it is known. Takes time in
/// proportion to the points, the most of it for the Fringe terms.
pub(super) fn details(
    part: &Part,
    sample: &Result<Sample, SampleError>,
    indicated: Result<Indicated<'_>, String>,
    areas_mm2: &[f64],
    rms_nm: f64,
    noise_nm: Option<f64>,
) -> FormDetails {
    let mut details = FormDetails { noise_nm, ..FormDetails::default() };
    match sample {
        Ok(sample) => {
            // Where nothing is sampled densely enough, no point stands for an area, and all count alike.
            let weighted = sample.indices().iter().any(|&index| areas_mm2[index] > 0.0);
            details.fill(part, sample, indicated, weighted, rms_nm);
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
    let (turn, shift_mm) = (pose.rotation(), pose.to_measured([0.0; 3]));
    // As `Pose::to_part`, which would make the rotation anew for every point.
    let place = |point: &PointMm| {
        [0, 1].map(|column| {
            (0..3).map(|row| turn[row][column] * (point[row] - shift_mm[row])).sum::<f64>()
        })
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
        rms_nm: f64,
    ) {
        let as_fitted = if weighted { "as fitted" } else { "as fitted, every point counted alike" };
        let fringe = fringe_fit(sample, part.figures.zernike);
        for (name, figure) in [
            ("PV", peak_to_valley(sample)),
            ("RMS", Ok(Figure { definition: Definition::RmsOverPoints, value: rms_nm })),
            ("RMS", rms(sample, Reference::Zero)),
            ("RMS", rms(sample, Reference::Mean)),
            ("PV99%", robust_peak_to_valley(sample, Share::NINETY_NINE)),
            ("PVr", fringe.as_ref().map_err(Unknown::clone).and_then(FringeFit::pvr)),
        ] {
            self.take(name, figure, as_fitted);
        }
        self.indication(part, indicated, as_fitted);
        self.slopes(sample, part);
        self.remainders(sample);
        if let Some(terms) = part.figures.q_terms {
            match standards::q_spectrum(sample, terms, self.noise_nm) {
                Ok((found, lacking)) => {
                    self.standards.q_spectrum = Some(found);
                    self.unknown.extend(lacking.map(|why| format!("Q spectrum: {why}")));
                }
                Err(why) => self.lacks("Q spectrum", &why),
            }
        }
        match &fringe {
            Ok(found) if found.condition > MOST_CONDITION => self.unknown.push(format!(
                "Zernike terms: over the places measured they cancel one another (condition {:.1e}, at most {MOST_CONDITION:.0e} is \
                 allowed): expected points about the origin, or an aperture laid about them (centre_mm)",
                found.condition
            )),
            Ok(found) => self.zernike = Some(zernike(found, Source::Points)),
            Err(why) => self.lacks("Zernike terms", why),
        }
        match radial_profile(sample, None) {
            Ok(found) => self.rings = found.iter().map(ring).collect(),
            Err(why) => self.lacks("radial profile", &why),
        }
        self.histogram = histogram(sample.values_nm());
    }

    fn indication(
        &mut self,
        part: &Part,
        indicated: Result<Indicated<'_>, String>,
        as_fitted: &str,
    ) {
        let found = indicated.and_then(|Indicated { sample, nominal, from_design }| {
            let parts = decompose(sample, approximation(nominal), None);
            parts.map(|parts| (parts, from_design)).map_err(|why| why.to_string())
        });
        match found {
            Ok((parts, from_design)) => {
                let asked = part.judging.indication.as_ref();
                self.standards.indication = Some(standards::found(&parts, asked));
                let variant = match from_design {
                    true => as_fitted.replace("as fitted", "against the design, shape held"),
                    false => as_fitted.to_owned(),
                };
                parts.figures().into_iter().for_each(|found| self.put(found, variant.clone()));
            }
            Err(why) => self.unknown.push(format!("A, B, C and their RMS: {why}")),
        }
    }

    /// Slopes over the length that the nominal file states, else over a twentieth of the aperture's width: ISO
    /// 10110-12 leaves it to the drawing.
    fn slopes(&mut self, sample: &Sample, part: &Part) {
        let Some(settings) = part.figures.slope_over(&part.aperture, sample.radius_mm()) else {
            return self.lacks("slopes", &Unknown::OnePlace);
        };
        match slopes(sample, settings) {
            Ok(found) => {
                let over = format!("over {} mm", (settings.integration_mm() * 1e4).round() / 1e4);
                let shares = self.noise_nm.map_or([(None, None); 4], |nm| noise_of(&found, nm));
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
    fn remainders(&mut self, sample: &Sample) {
        for last in 1..REMOVED.len() {
            let terms = &REMOVED[..=last];
            match remove(sample, terms) {
                Ok(removed) => {
                    let sample = &removed.sample;
                    for (name, figure) in
                        [("PV", peak_to_valley(sample)), ("RMS", rms(sample, Reference::Zero))]
                    {
                        self.add(name, figure.map(|figure| naming::figure_without(figure, terms)));
                    }
                }
                Err(why) => self.lacks(&naming::without(terms), &why),
            }
        }
    }

    pub(super) fn take(&mut self, name: &str, figure: Result<Figure, Unknown>, variant: &str) {
        self.add(name, figure.map(|figure| naming::figure(figure, variant.to_owned())));
    }

    fn add(&mut self, name: &str, figure: Result<FormFigure, Unknown>) {
        match figure {
            Ok(figure) => self.figures.push(figure),
            Err(why) => self.lacks(name, &why),
        }
    }

    fn put(&mut self, figure: Figure, variant: String) {
        self.figures.push(naming::figure(figure, variant));
    }

    fn lacks(&mut self, name: &str, why: &Unknown) {
        self.unknown.push(format!("{name}: {why}"));
    }
}

/// Rise of slopes by noise of a point in nm, in the order of their figures, and what is left without it.
fn noise_of(found: &Slopes, noise_nm: f64) -> [(Option<f64>, Option<f64>); 4] {
    let of_kind = |figure: &SlopeFigure| {
        let on_max = figure.noise_on_max_urad(noise_nm, found.stations).min(figure.max_urad);
        let without = figure.rms_without_noise_urad(noise_nm);
        [(Some(on_max), None), (Some(figure.rms_urad - without), Some(without))]
    };
    let [[a, b], [c, d]] = [&found.meridional, &found.gradient].map(of_kind);
    [a, b, c, d]
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
    Some(HistogramFigures { low_nm: first * width_nm, width_nm, counts, source })
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
mod tests {
    use crate::nominal::parse;
    use asphera_form::basis::{Normalisation, zernike_value};
    use asphera_form::{Fit, FitSettings, fit};
    use proptest::prelude::*;

    use super::*;

    const RADIUS_MM: f64 = 4.0;

    fn fringe(index: u32, u: f64, v: f64) -> f64 {
        let (n, m) = Counting::Fringe.orders(index).unwrap();
        zernike_value(n, m, Normalisation::UnitHeight, u, v).unwrap()
    }

    fn flat() -> Part {
        let nominal = format!(
            "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = {RADIUS_MM:?}\n\
             [fit]\nfree = [\"tz\"]\n"
        );
        parse("flat.toml", &nominal).unwrap()
    }

    /// Places on a square lattice over the disc, with a deviation each.
    fn measured(nm: impl Fn(f64, f64) -> f64) -> (Vec<PointMm>, Vec<f64>) {
        let mut points = Vec::new();
        for i in -50..=50 {
            for j in -50..=50 {
                let (u, v) = (f64::from(i) * 0.0199, f64::from(j) * 0.0199);
                if u.hypot(v) <= 1.0 {
                    points.push([RADIUS_MM * u, RADIUS_MM * v, nm(u, v) * 1e-6]);
                }
            }
        }
        let deviations_mm = points.iter().map(|point| point[2]).collect();
        (points, deviations_mm)
    }

    fn of(
        part: &Part,
        points: &[PointMm],
        deviations_mm: &[f64],
        areas_mm2: &[f64],
    ) -> FormDetails {
        let settings = FitSettings { free: part.free.clone(), ..FitSettings::default() };
        let fit = fit(points, &part.nominal, &settings).unwrap();
        // The fit must not move the part, whose deviations are given.
        let fit = Fit { pose: Pose::default(), ..fit };
        let sample = sample(part, &fit.pose, points, deviations_mm, areas_mm2);
        let indicated = sample.as_ref().map_err(ToString::to_string).map(|sample| Indicated {
            sample,
            nominal: &fit.nominal,
            from_design: false,
        });
        details(part, &sample, indicated, areas_mm2, 0.0, None)
    }

    fn value(details: &FormDetails, name: &str, variant: &str) -> f64 {
        let found = |figure: &&FormFigure| figure.name == name && figure.variant == variant;
        let figure = details.figures.iter().find(found);
        figure.unwrap_or_else(|| panic!("no {name} {variant}: {:#?}", details.figures)).value
    }

    #[test]
    fn terms_put_in_are_found_named_and_taken_out() {
        let put_in = [(1, 5.0), (2, -8.0), (4, 30.0), (5, 12.0), (8, -7.0), (9, 6.0), (11, 4.0)];
        let (points, deviations_mm) =
            measured(|u, v| put_in.iter().map(|&(index, nm)| nm * fringe(index, u, v)).sum());
        let found = of(&flat(), &points, &deviations_mm, &vec![1.0; points.len()]);
        // What is not rotational counts as noise of the Q spectrum, whose first terms it drowns.
        assert!(
            found.unknown.iter().all(|why| why.starts_with("Q spectrum")),
            "{:?}",
            found.unknown
        );
        let zernike = found.zernike.as_ref().unwrap();
        assert_eq!((zernike.terms.len(), zernike.radius_mm), (36, RADIUS_MM));
        for term in &zernike.terms {
            let had = put_in.iter().find(|(index, _)| *index == term.index);
            let had = had.map_or(0.0, |(_, nm)| *nm);
            assert!((term.value_nm - had).abs() < 1e-8, "{term:?}, not {had} nm");
        }
        let term = |index: usize| &zernike.terms[index - 1];
        assert_eq!((term(4).name.as_str(), term(4).n, term(4).m), ("defocus", 2, 0));
        assert_eq!((term(30).name.as_str(), term(30).n, term(30).m), ("tertiary trefoil x", 7, 3));
        // What is left in the end is the trefoil: ±4 nm at the rim.
        let all = "piston, tilt, power, astigmatism, coma, spherical removed";
        let left_nm = value(&found, "PV", all);
        assert!((7.6..8.0 + 1e-6).contains(&left_nm), "{left_nm}");
        assert!(value(&found, "PV", "piston, tilt removed") > value(&found, "PV", all));
        // The sphere of 30 nm of Fringe 4 and what 6 nm of Fringe 9 hold of it.
        assert!((value(&found, "A", "as fitted") - 60.0).abs() < 1.0);
    }

    #[test]
    fn what_the_points_do_not_tell_is_said() {
        let points: Vec<PointMm> = (0..5).map(|i| [f64::from(i) * 0.5, 0.1, 1e-6]).collect();
        let found = of(&flat(), &points, &[1e-6; 5], &[0.0; 5]);
        assert_eq!(value(&found, "PV", "as fitted, every point counted alike"), 0.0);
        assert_eq!(found.zernike, None);
        for name in ["PVr", "Zernike terms", "slopes"] {
            assert!(found.unknown.iter().any(|why| why.starts_with(name)), "{:?}", found.unknown);
        }
        assert_eq!(found.histogram.unwrap().counts, [5]);
    }

    #[test]
    fn a_triangle_stands_for_a_third_at_each_corner() {
        let points = [[0.0, 0.0, 9.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [3.0, 2.0, 0.0]];
        let areas = areas_mm2(&points, [[0, 1, 2], [1, 3, 2]].into_iter());
        assert_eq!(areas, [1.0, 2.0, 2.0, 1.0]);
    }

    proptest! {
        #[test]
        fn a_histogram_counts_every_point_where_it_lies(
            values_nm in prop::collection::vec(-1e3..1e3f64, 1..200),
            scale in prop::sample::select(vec![1e-9, 1e-3, 1.0, 1e9]),
            offset_nm in prop::sample::select(vec![0.0, -1e3, 1e6]),
        ) {
            let values_nm: Vec<f64> =
                values_nm.iter().map(|nm| nm * scale + offset_nm).collect();
            let HistogramFigures { low_nm, width_nm, counts, .. } = histogram(&values_nm).unwrap();
            prop_assert_eq!(counts.iter().sum::<u64>(), values_nm.len() as u64);
            prop_assert!(counts[0] > 0 && counts[counts.len() - 1] > 0);
            prop_assert!(counts.len() <= 66, "{} bins", counts.len());
            let high_nm = low_nm + width_nm * counts.len() as f64;
            let rounding = 1e-12 * (low_nm.abs() + high_nm.abs());
            for nm in values_nm {
                prop_assert!(low_nm - rounding <= nm && nm <= high_nm + rounding);
            }
            let digit = width_nm / 10.0_f64.powi((width_nm * 1.000_001).log10().floor() as i32);
            prop_assert!([1.0, 2.0, 5.0].iter().any(|d| (digit - d).abs() < 1e-6), "{}", width_nm);
        }
    }
}
