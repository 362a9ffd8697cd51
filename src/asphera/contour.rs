//! Contours of points: what `asphera contour` and a station share.

mod features;
mod figures;
mod gaps;
mod nominal;
mod plan;
mod report;
mod sampled;
mod slab;
mod strokes;
#[cfg(test)]
mod tests;

use asphera_contour::curves::HalfNeighbours;
use asphera_contour::features::Course;
use asphera_contour::strokes::Hint;
use asphera_contour::{
    Choice, FoundCurve, Graph, Kind, Method, MethodError, Parameters, PlaceMm, Samples,
    SamplesError, Triangulation,
};
use asphera_report::contour::ContourReport;
use thiserror::Error;

pub use self::nominal::{Nominal, NominalError};
pub use self::plan::{ContourLimits, ContourPlan};
pub(crate) use self::report::truth_report;
pub use self::slab::Slab;
pub(crate) use self::slab::plane_of;

use self::features::features_of;
use self::figures::{circle_of, deviation_from};
use self::gaps::close_gaps;
use self::report::{MOST_CHECKED, curve_report, region_report, unmeshed_report, with_choice};
use self::strokes::strokes_report;

/// How a contour is found and what is measured of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourSettings {
    /// The method or graph.
    pub method: Method,
    /// Its parameters.
    pub parameters: Parameters,
    /// Deviations from lines and arcs up to so many mm make no feature of their own.
    pub tolerance_mm: f64,
    /// Whether closed curves are sections of airfoils.
    pub is_airfoil: bool,
    /// Gaps up to so many mm are closed, and listed.
    pub gap_mm: Option<f64>,
    /// The outline that points are held against.
    pub nominal: Option<Nominal>,
    /// Places within regions, for the methods that take them.
    pub hints: Vec<Hint>,
}

/// Why there is no contour.
#[derive(Debug, Error)]
pub enum ContourError {
    /// Coordinates that cannot be used.
    #[error(transparent)]
    Samples(#[from] SamplesError),
    /// Fewer than three places.
    #[error(
        "expected three different places or more, found {places} in {points} points; measure more of the curve"
    )]
    TooFew {
        /// How many different places.
        places: usize,
        /// How many points.
        points: usize,
    },
    /// All places lie on one straight line.
    #[error(
        "expected points round a curve, found all {places} on one straight line; asphera section and asphera measure \
         work on profiles"
    )]
    OnLine {
        /// How many different places.
        places: usize,
    },
    /// The method cannot be used.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// There is a nominal outline, and no curve.
    #[error("{outline}: no point lies on a curve to be held against it")]
    NothingOnCurve {
        /// The file of the outline.
        outline: String,
    },
}

impl ContourError {
    /// Whether it is the points that cannot be used.
    pub(crate) fn is_of_points(&self) -> bool {
        match self {
            ContourError::Samples(_) | ContourError::TooFew { .. } => true,
            ContourError::OnLine { .. } => true,
            ContourError::Method(_) | ContourError::NothingOnCurve { .. } => false,
        }
    }
}

impl ContourSettings {
    /// The contour of points and its figures; `stage` hears of what is done. Rows are those of `points`.
    ///
    /// # Errors
    ///
    /// When the points or the method cannot be used.
    pub(crate) fn contour(
        &self,
        points: &[PlaceMm],
        stage: &mut dyn FnMut(&'static str),
    ) -> Result<ContourReport, ContourError> {
        let samples = Samples::new(points)?;
        if samples.len() < 3 {
            let (places, points) = (samples.len(), samples.points());
            return Err(ContourError::TooFew { places, points });
        }
        if samples.are_on_line() {
            return Err(ContourError::OnLine { places: samples.len() });
        }
        let (mut report, used, courses) = if self.is_without_mesh(&samples) {
            stage(self.method.name());
            self.found_without_mesh(&samples)?
        } else {
            stage("meshing");
            let triangulation = Triangulation::new(samples);
            stage(self.method.name());
            self.found(&triangulation)?
        };
        stage("features");
        let found = features_of(&courses, self.tolerance_mm, self.is_airfoil);
        if let ([chain], true) = (&report.chains[..], report.sampling.is_some()) {
            match circle_of(&used, chain.closed && !found.has_bridge) {
                Some(Ok(circle)) => report.circle = Some(circle),
                Some(Err(why)) => report.unknown.push(why),
                None => {}
            }
        }
        report.features = found.features;
        report.unknown.extend(found.unknown);
        if self.is_airfoil && courses.is_empty() {
            let why = "airfoil: expected a closed curve, found none; give a method of curves";
            report.unknown.push(why.to_owned());
        }
        if let Some(nominal) = &self.nominal {
            let u_mm = report.input.noise_sigma_mm.or_else(|| noise_mm(&courses));
            let (deviation, unknown) = deviation_from(nominal, &used, u_mm)?;
            report.deviation = deviation;
            report.unknown.extend(unknown);
        }
        Ok(report)
    }

    /// Whether neither the method nor the report asks for a mesh: the sampling of so many points is not checked.
    fn is_without_mesh(&self, samples: &Samples) -> bool {
        self.method == Method::HnnCrust && samples.len() > MOST_CHECKED
    }

    /// As [`ContourSettings::found`], of HNN-Crust.
    fn found_without_mesh(&self, samples: &Samples) -> Result<ReportedCurve, MethodError> {
        let (method, parameters) = (self.method, &self.parameters);
        parameters.check(&method)?;
        let neighbours = HalfNeighbours::new(samples);
        let is_one_sided = parameters.value(&method, "one_sided") > 0.0;
        let graph = if is_one_sided { neighbours.one_sided() } else { neighbours.curve() };
        let curve = FoundCurve { graph, ..FoundCurve::default() };
        let spacing_mm = neighbours.spacing_median_mm();
        let mut report = unmeshed_report(samples, (method, parameters), &curve, spacing_mm);
        close_gaps(&mut report, samples, method, &curve, self.gap_mm);
        let courses = Course::of_curve(samples, &curve, &[]);
        let used = used_of(samples, &curve, &courses);
        Ok((report, used, courses))
    }

    /// The curve or area that the method finds, the points it was made of, and the courses of its curves.
    fn found(&self, triangulation: &Triangulation) -> Result<ReportedCurve, MethodError> {
        let method = self.method;
        let parameters = method.chosen(triangulation, &self.parameters)?;
        if let Some(strokes) = method.strokes(triangulation, &parameters, &self.hints)? {
            let mut report =
                strokes_report(triangulation, method, &parameters, &strokes, self.tolerance_mm);
            close_gaps(
                &mut report,
                triangulation.samples(),
                method,
                &FoundCurve::default(),
                self.gap_mm,
            );
            return Ok((
                report,
                joined(triangulation.samples(), strokes.region.border()),
                Vec::new(),
            ));
        }
        let region = method.region(triangulation, &parameters)?;
        let samples = triangulation.samples();
        Ok(match region {
            _ if method == Method::Auto => by_points(triangulation, &parameters, self.gap_mm)?,
            Some(region) => {
                let mut report = region_report(triangulation, method, &parameters, &region);
                close_gaps(&mut report, samples, method, &FoundCurve::default(), self.gap_mm);
                (report, joined(samples, region.border()), Vec::new())
            }
            None => {
                let curve = method.curve(triangulation, &parameters)?;
                let mut report = curve_report(triangulation, method, &parameters, &curve);
                close_gaps(&mut report, samples, method, &curve, self.gap_mm);
                let courses = match method.kind() {
                    Kind::Curve => Course::of_curve(samples, &curve, &[]),
                    Kind::Region | Kind::Graph => Vec::new(),
                };
                let used = used_of(samples, &curve, &courses);
                (report, used, courses)
            }
        })
    }
}

/// A report without features, the points its contour was made of, and the courses of its curves.
type ReportedCurve = (ContourReport, Vec<PlaceMm>, Vec<Course>);

/// The contour by the method that the points ask for.
fn by_points(
    triangulation: &Triangulation,
    parameters: &Parameters,
    gap_mm: Option<f64>,
) -> Result<ReportedCurve, MethodError> {
    let choice = Choice::new(triangulation);
    let method = choice.method;
    let samples = triangulation.samples();
    let (report, used, courses) = match method.region(triangulation, parameters)? {
        Some(region) => {
            let mut report = region_report(triangulation, method, parameters, &region);
            close_gaps(&mut report, samples, method, &FoundCurve::default(), gap_mm);
            (report, joined(samples, region.border()), Vec::new())
        }
        None => {
            let curve = choice.curve(triangulation).unwrap_or_default();
            let mut report = curve_report(triangulation, method, parameters, &curve);
            close_gaps(&mut report, samples, method, &curve, gap_mm);
            let courses = Course::of_curve(samples, &curve, &choice.outliers);
            let used = used_of(samples, &curve, &courses);
            let apart = samples.len().saturating_sub(used.len() + choice.outliers.len());
            if apart > 0 {
                report.unknown.push(format!(
                    "curve: {apart} points beside the {} outliers lie on no curve that was found; it may lack a part there",
                    choice.outliers.len()
                ));
            }
            (report, used, courses)
        }
    };
    Ok((with_choice(report, &choice), used, courses))
}

/// The noise of the points of curves: that of the noisiest; none where no curve has points enough.
fn noise_mm(courses: &[Course]) -> Option<f64> {
    let long = courses.iter().filter(|course| course.places_mm().len() >= NOISE_POINTS);
    long.filter_map(|course| Some(course.noise()?.sigma_mm)).reduce(f64::max)
}

/// Least points by which noise is known to about a sixth: an uncertainty that a guard band may rest on.
const NOISE_POINTS: usize = 50;

/// The places of samples that an edge joins.
fn joined(samples: &Samples, graph: &Graph) -> Vec<PlaceMm> {
    let degrees = graph.degrees(samples.len());
    let places = samples.places().iter().zip(degrees);
    places.filter(|(_, degree)| *degree > 0).map(|(&place, _)| place).collect()
}

/// The places that a curve was made of: those of its courses where noise was taken away, else those that it joins.
fn used_of(samples: &Samples, curve: &FoundCurve, courses: &[Course]) -> Vec<PlaceMm> {
    match curve.places_mm {
        Some(_) => courses.iter().flat_map(Course::places_mm).copied().collect(),
        None => joined(samples, &curve.graph),
    }
}
