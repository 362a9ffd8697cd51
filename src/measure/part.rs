//! The design of a part, its aperture, its fit and its limits.

mod criterion;
mod defects;
mod figures;
mod judging;

pub use criterion::{Criterion, Weights};
pub use defects::{DefectLimits, FLAT_BELOW_PER_MM, LISTED};
pub use figures::{FigureSettings, Q_TERMS, TextureSettings};
pub use judging::{CorrelationFrom, Judging};

use asphera_figures::Definition;
use asphera_form::{Aperture, MeasuredFrom, Nominal, Parameter, ReferenceSettings};
use asphera_surface::coverage::Target;
use asphera_uncertainty::verdict::Limit;

/// The design of a part, and how it is judged.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The design surface; of an unknown one what stands in for it until [`Part::reference`] is made.
    pub nominal: Nominal,
    /// How the points make the surface, where no design is known.
    pub reference: Option<ReferenceSettings>,
    /// The region that counts, in the part frame, about its origin.
    pub aperture: Aperture,
    /// Where the middle of the aperture lies, as the nominal file says: of a surface that slides (see
    /// [`Nominal::slides`]) a place in the frame of the points, else beside the vertex. The part frame of a surface that
    /// has a vertex has its origin there.
    pub centre_mm: [f64; 2],
    /// Parameters the fit may change.
    pub free: Vec<Parameter>,
    /// How much each deviation counts in the fit.
    pub criterion: Criterion,
    /// Sides from which the part may have been measured.
    pub side: MeasuredFrom,
    /// Limits, guard band, and uncertainty.
    pub judging: Judging,
    /// Which figures the final report has, and how they are formed.
    pub figures: FigureSettings,
    /// Largest gap of the sampling allowed, mm; none: only ε counts.
    pub gap_limit_mm: Option<f64>,
    /// Largest gap over local feature size allowed; none: only that over the reach counts.
    pub epsilon_limit: Option<f64>,
    /// Largest gap over reach allowed, the smallest local feature size of the whole surface.
    pub rho_limit: Option<f64>,
    /// Share of the aperture that must be sampled densely enough for a pass, 0 to 1.
    pub coverage_min: f64,
    /// Which defects are looked for; `None`: none.
    pub defects: Option<DefectLimits>,
    /// A curvature below this counts as none when the surface is parted by it, 1/mm.
    pub flat_below_per_mm: f64,
}

impl Part {
    /// A part of a design, judged by nothing. The rigid motions are fitted, of a surface that is not of revolution with the
    /// turn about its axis; least squares, no aperture, ε below 0.05 over nine tenths of it.
    pub fn new(nominal: Nominal) -> Part {
        let free = if nominal.is_rotational() { &Parameter::RIGID[..] } else { &Parameter::POSE };
        Part {
            free: free.to_vec(),
            nominal,
            reference: None,
            aperture: Aperture::None,
            centre_mm: [0.0; 2],
            criterion: Criterion::default(),
            side: MeasuredFrom::default(),
            judging: Judging::default(),
            figures: FigureSettings::default(),
            gap_limit_mm: None,
            epsilon_limit: Some(Target::COCONE_EPSILON),
            rho_limit: None,
            coverage_min: COVERAGE_MIN,
            defects: Some(DefectLimits::default()),
            flat_below_per_mm: FLAT_BELOW_PER_MM,
        }
    }

    /// Whether a verdict is asked for: there is a limit of anything.
    pub fn has_limits(&self) -> bool {
        self.judging.has_limits()
    }

    /// Whether a figure of points and nominal is formed: one that is asked for, or has a limit.
    pub fn asks_for(&self, figure: Definition) -> bool {
        let limited = self.judging.standards.iter().map(|(limited, _)| limited);
        self.figures.of_points.iter().chain(limited).any(|asked| *asked == figure)
    }

    /// Limits of figures of the deviation, in the order in which they are held.
    pub fn limits(&self) -> &[Limit] {
        &self.judging.limits
    }
}

/// The share of an aperture that must be sampled densely enough, by default.
pub const COVERAGE_MIN: f64 = 0.9;
