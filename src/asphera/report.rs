//! The figures of a measurement, as every output writes them.
//!
//! One set of types serves the report file, the snapshots of the page and `--json`: what is shown
//! live and what is kept have the same names, units and meaning.

mod features;
mod fit;
mod fit_details;
mod form;
mod prospect;
mod standards;
mod unmeasured;
mod verdict;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use features::{DefectFigures, DefectSearchFigures, FeatureFigures, PartitionFigures};
pub use fit::{LossFigures, ReferenceFigures, WeightFigures};
pub use fit_details::{
    CautionFigures, CombinationFigures, CorrelationFigures, CovarianceFigures, FitDetails,
    ShareFigures, UndeterminedFigures,
};
pub use form::{
    ExpandedFigures, FormFigure, HistogramFigures, RingFigures, SimulatedFigures, Source,
    ZernikeFigures, ZernikeTerm,
};
pub use prospect::{Outlook, ProspectFigures, ProspectState};
pub use standards::{
    ContactFigures, IndicationFigures, MinimumZoneFigures, PsdFigures, QFigures, StandardFigures,
    TextureFigures,
};
pub use unmeasured::UnmeasuredFigures;
pub(crate) use verdict::words_of;
pub use verdict::{Check, Status, Verdict};

/// Version of the report's layout. A reader refuses what it does not know.
pub const FORMAT: &str = "asphera.report/1";

/// Everything asphera says about one measurement of one part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`FORMAT`].
    pub format: String,
    /// What became of the points.
    pub points: Points,
    /// The mesh of the points used.
    pub mesh: MeshFigures,
    /// Whether the points lie densely enough.
    pub sampling: SamplingFigures,
    /// Defects, and which way the surface bends.
    #[serde(flatten)]
    pub features: FeatureFigures,
    /// Nominal, fit and deviation; absent where no fit could be made, then [`Verdict::reasons`] says why.
    pub form: Option<FormFigures>,
    /// Pass, fail or undecided.
    pub verdict: Verdict,
    /// What each link and device delivered and lost. Empty for points read from a file.
    pub links: Vec<LinkFigures>,
    /// How long it took. The only part that differs between a live run and its replay.
    pub timing: Timing,
    /// The recording this belongs to; absent for points read from a file.
    pub session: Option<SessionFigures>,
}

/// What became of the points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Points {
    /// Records that were formed from what the devices sent, or rows of a file, gaps included.
    pub received: u64,
    /// Points in the mesh and inside the aperture: those of the fit and the figures.
    pub used: u64,
    /// Points not used, by reason. A point with several reasons counts once for each. A flag that does not
    /// forbid the use of a point stands in the figures of its device.
    pub flagged: BTreeMap<String, u64>,
    /// Points at the exact place and height of an earlier one.
    pub duplicates: u64,
    /// Triggers whose reading never arrived, as the gaps in the shared count tell.
    pub lost: u64,
}

/// The mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshFigures {
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Edges.
    pub edges: u64,
    /// Vertices on the convex hull of the projection.
    pub hull: u64,
    /// Area of the lifted triangles in mm²; in a snapshot as of `sampling.current.as_of_points`.
    pub area_mm2: f64,
    /// Whether no two points stand above each other at different heights, and no fold was found.
    pub projectable: bool,
    /// The plane of projection; absent where it is along z and nothing else was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub projection: Option<ProjectionFigures>,
    /// Where the surface is steep or folded; in a snapshot as of `sampling.as_of_points`.
    #[serde(default)]
    pub relief: ReliefFigures,
    /// Places measured more than once.
    #[serde(default)]
    pub repeats: RepeatFigures,
}

/// On which plane the points are projected, and how it came about.
///
/// The fit is made in the frame of the plane: its `parameters` are shifts along and turns about u, v and the
/// normal, and areas called projected are areas on the plane. Places and the pose are given in the measured
/// frame all the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "how", rename_all = "lowercase")]
pub enum ProjectionFigures {
    /// It was given.
    Given {
        /// The plane.
        plane: PlaneFigures,
    },
    /// It is to be fitted, and points wait for it: never in a report.
    Fitting {
        /// How many points wait.
        points: u64,
        /// At how many it is fitted.
        wanted: u64,
        /// Whether fewer were tried and lay on a line or a curve.
        tried: bool,
    },
    /// It was fitted from the first good points.
    Fitted {
        /// The plane.
        plane: PlaneFigures,
        /// From how many.
        points: u64,
    },
    /// It should have been fitted, but the first good points determine none; projected along z.
    Unfitted {
        /// The plane z = 0.
        plane: PlaneFigures,
        /// How many points were looked at.
        points: u64,
        /// Why they determine none.
        reason: String,
    },
}

/// A plane of projection in the measured frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneFigures {
    /// Its unit normal, on the side from which the surface is seen.
    pub normal: [f64; 3],
    /// The place where u, v and the height are zero, mm: on the normal through the origin.
    pub origin_mm: [f64; 3],
    /// Unit vector of u.
    pub u: [f64; 3],
    /// Unit vector of v; u, v and the normal are right-handed.
    pub v: [f64; 3],
}

/// Where the surface is steep or folded, inside the aperture. See `asphera_surface::topography` for what
/// points can tell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReliefFigures {
    /// Where the projection is not one-to-one, the largest first. Their triangles join different sheets and
    /// count as not sampled.
    pub folds: Vec<RegionFigures>,
    /// Steps and steep flanks.
    pub walls: u64,
    /// Single readings off their surroundings.
    pub spikes: u64,
    /// If there are folds: in which plane the points would be projectable, or that none was found;
    /// directions in the measured frame.
    pub projection: Option<String>,
}

/// A region of steep triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionFigures {
    /// The middle of its steepest rise, measured frame, mm.
    pub at_mm: [f64; 3],
    /// Smallest coordinates of its steep sides, measured frame, mm; where the projection is not along z, of
    /// the box about them that stands on the plane.
    pub min_mm: [f64; 3],
    /// Largest coordinates, in the same way.
    pub max_mm: [f64; 3],
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Projected area in mm².
    pub projected_area_mm2: f64,
    /// Largest slope of a side against the plane of projection in degrees.
    pub slope_max_deg: f64,
}

/// Places measured more than once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RepeatFigures {
    /// How many places.
    pub places: u64,
    /// How many measurements in them.
    pub measurements: u64,
    /// Standard deviation of the heights about the mean of their place, pooled over all, in nm.
    pub spread_nm: Option<f64>,
}

/// The state of the sampling: see `asphera_surface::coverage` for the definitions. What is not known is
/// absent, and `unknown` says why.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SamplingFigures {
    /// Smallest local feature size inside the aperture, in mm. Absent if it is not known, or if there is
    /// none, as on a plane: ε is 0 there.
    pub lfs_min_mm: Option<f64>,
    /// Where the local feature size comes from: `nominal`, `measured` (medial balls of the points) or
    /// `curvature` (of the points, an upper bound: ε is then a lower one).
    pub lfs_source: Option<String>,
    /// Largest gap inside the aperture, in mm: the largest distance from the surface to its nearest point.
    pub gap_max_mm: Option<f64>,
    /// Area-weighted 99th percentile of the gap.
    pub gap_p99_mm: Option<f64>,
    /// Largest gap allowed, in mm: the nominal's, or else four times the average distance of the points.
    pub gap_limit_mm: Option<f64>,
    /// Largest ε allowed: gap over local feature size. Absent where only ρ was asked for.
    pub epsilon_target: Option<f64>,
    /// Largest ε.
    pub epsilon_max: Option<f64>,
    /// Area-weighted 99th percentile of ε.
    pub epsilon_p99: Option<f64>,
    /// Largest ρ allowed: gap over reach. Absent where it was not asked for.
    #[serde(default)]
    pub rho_target: Option<f64>,
    /// Largest ρ; a lower bound where the local feature size is not that of the nominal.
    #[serde(default)]
    pub rho_max: Option<f64>,
    /// The reach in mm: the smallest local feature size of the whole surface, from `lfs_source`. With `nominal` that
    /// over all of the aperture, measured or not; without one out to the farthest point, or of a freeform at the points.
    /// Else the smallest at the points where it is known. Absent if it is not known, or if there is none, as on a plane: ρ is 0 there.
    #[serde(default)]
    pub reach_mm: Option<f64>,
    /// Where ε is largest, or where it is nowhere above 0 the gap; measured frame, mm.
    pub at_max_mm: Option<[f64; 3]>,
    /// Share of the aperture that is sampled densely enough, 0 to 1; where every point counts, of the outline
    /// of the points. Absent, like the two areas, where the local feature size is known nowhere.
    pub coverage: Option<f64>,
    /// Projected area that was scanned, but not densely enough, in mm².
    pub undersampled_area_mm2: Option<f64>,
    /// Projected area that was not scanned, in mm².
    pub uncovered_area_mm2: Option<f64>,
    /// Standard deviation of the heights from point to point, along the direction of projection, in nm.
    pub noise_sigma_nm: Option<f64>,
    /// Half of the surface has facets of this spacing in mm or less.
    pub spacing_median_mm: Option<f64>,
    /// Share of the surface whose points are so near to each other that their noise turns facets by more than
    /// ε rad, or ρ rad if that is less.
    pub overdense_fraction: Option<f64>,
    /// The spacing in mm that satisfies ε, ρ and noise everywhere. Absent if there is none or any will do.
    pub spacing_recommended_mm: Option<f64>,
    /// What to measure next: regions that are not covered, those first that add most to the coverage.
    pub next: Vec<NextFigures>,
    /// How many more regions there are, those too small to be listed included.
    pub next_more: u64,
    /// Their area in mm².
    pub next_more_area_mm2: f64,
    /// How many pieces the part that is sampled densely enough is in.
    #[serde(default)]
    pub islands: Option<u64>,
    /// How many holes those pieces have.
    #[serde(default)]
    pub holes: Option<u64>,
    /// The largest of these holes, in mm².
    #[serde(default)]
    pub hole_max_mm2: Option<f64>,
    /// Why something is not known.
    pub unknown: Vec<String>,
    /// How many points had arrived when these figures were made.
    pub as_of_points: u64,
    /// In a snapshot: the figures that are kept current while points arrive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current: Option<CurrentFigures>,
}

impl SamplingFigures {
    /// The largest gap allowed wherever it is, in mm: by its own limit and by ρ, as far as the reach is known.
    pub(crate) fn gap_allowed_mm(&self) -> Option<f64> {
        let by_rho_mm = self.rho_target.zip(self.reach_mm).map(|(rho, reach_mm)| rho * reach_mm);
        match (self.gap_limit_mm, by_rho_mm) {
            (Some(limit_mm), Some(by_rho_mm)) => Some(limit_mm.min(by_rho_mm)),
            (limit_mm, by_rho_mm) => limit_mm.or(by_rho_mm),
        }
    }

    /// The smaller of the largest ε and ρ allowed.
    pub(crate) fn share_allowed(&self) -> Option<f64> {
        match (self.epsilon_target, self.rho_target) {
            (Some(epsilon), Some(rho)) => Some(epsilon.min(rho)),
            (epsilon, rho) => epsilon.or(rho),
        }
    }
}

/// The figures of the sampling that are kept current while points arrive: never in a report.
///
/// They are simpler than the others, to the safe side. A triangle counts as a whole if its centre lies in the
/// aperture, where the part lay at the last look (`sampling.as_of_points`); also one that bridges what was not
/// scanned. Thin triangles along the outline have the gap that their corners alone tell. The local feature size
/// is that at one corner, less what it may lose on the way across the triangle. Percentiles are upper bounds, by up
/// to 1/8 too large.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurrentFigures {
    /// How many points had arrived in the mesh. Fewer than in the mesh by now where points come in no order: then
    /// these figures wait for the next look, too.
    pub as_of_points: u64,
    /// Triangles that count.
    pub triangles: u64,
    /// Their area in space in mm².
    pub area_mm2: f64,
    /// Share of their projected area that is sampled densely enough, 0 to 1. Not the coverage: what no triangle
    /// reaches does not count. Absent where the local feature size is known nowhere.
    pub dense_fraction: Option<f64>,
    /// Largest gap in mm.
    pub gap_max_mm: Option<f64>,
    /// Gap that half of the area has at most.
    pub gap_median_mm: Option<f64>,
    /// Area-weighted 99th percentile of the gap.
    pub gap_p99_mm: Option<f64>,
    /// Largest ε; absent where the local feature size is not known.
    pub epsilon_max: Option<f64>,
    /// Area-weighted 99th percentile of ε.
    pub epsilon_p99: Option<f64>,
    /// Largest ρ; absent where the reach was not known at the last look.
    #[serde(default)]
    pub rho_max: Option<f64>,
    /// Half of the area has facets of this spacing in mm or less; off by less than 1/16.
    pub spacing_median_mm: Option<f64>,
}

/// A region that is not covered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextFigures {
    /// Its projected area in mm².
    pub area_mm2: f64,
    /// Of this, what was scanned, but not densely enough.
    pub undersampled_mm2: f64,
    /// Of this, what was not scanned.
    pub uncovered_mm2: f64,
    /// What measuring it adds to the coverage, 0 to 1.
    pub adds_coverage: Option<f64>,
    /// Largest ε in it; absent outside the outline of the points.
    pub epsilon_max: Option<f64>,
    /// Largest gap in it, in mm; absent outside the outline of the points.
    pub gap_max_mm: Option<f64>,
    /// The spacing of points it needs, along the surface, in mm.
    pub spacing_needed_mm: Option<f64>,
    /// How many points that are.
    pub points_needed: Option<u64>,
    /// A place inside, measured frame, mm.
    pub at_mm: [f64; 3],
    /// Where it lies, the largest piece first.
    pub polygons: Vec<PolygonFigures>,
    /// How far the lines of the polygons were moved to have fewer corners, in mm; 0 where they are as found.
    pub simplified_mm: f64,
}

/// A polygon with holes, seen along the direction of projection. Places are in the measured frame, at the
/// height of the nominal as it lies, or without one at that of the points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolygonFigures {
    /// Its corners, counter-clockwise, mm.
    pub outline_mm: Vec<[f64; 3]>,
    /// Its holes, clockwise.
    pub holes_mm: Vec<Vec<[f64; 3]>>,
}

/// Nominal, fit and deviation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormFigures {
    /// The design surface in words: `asphere R 11.65 mm, conic -1.1, …`.
    pub nominal: String,
    /// The surface that was made from the points where no design is known; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceFigures>,
    /// How the nominal was laid into the points.
    pub fit: FitFigures,
    /// What remains.
    pub deviation: DeviationFigures,
    /// Whether these are running figures, to be replaced by a full fit at the end.
    pub provisional: bool,
    /// The figures of standards and optical shops, final only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<FormFigure>,
    /// The deviation in Zernike terms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zernike: Option<ZernikeFigures>,
    /// How many points have which deviation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub histogram: Option<HistogramFigures>,
    /// Mean deviation by distance from the axis, the innermost ring first; final only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rings: Vec<RingFigures>,
    /// Minimum zone, spectra, texture and the indication of the drawing; final only.
    #[serde(flatten)]
    pub standards: StandardFigures,
    /// Why a figure is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<String>,
}

/// How the nominal was laid into the points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitFigures {
    /// The criterion: `orthogonal least squares`.
    pub method: String,
    /// Why the iteration ended.
    pub termination: String,
    /// How many steps it took.
    pub iterations: u32,
    /// Names of the parameters that were free.
    pub free: Vec<String>,
    /// Every free parameter: value, unit and standard uncertainty (k = 1). Shifts and turns are those against
    /// the plane of projection, which along z is the measured frame.
    pub parameters: BTreeMap<String, ParameterFigures>,
    /// Free parameters the points do not determine; they stayed at their start.
    pub indeterminate: Vec<String>,
    /// Pose of the part in the measured frame.
    pub pose: PoseFigures,
    /// How many points of equal weight count as much, (Σw)²/Σw²; absent where all count alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effective_points: Option<f64>,
    /// How much a deviation counts, where that is not by its square; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<LossFigures>,
    /// What points are weighted by, where they do not count alike; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<WeightFigures>,
    /// How it ended, what it lacks, how its figures must be read.
    #[serde(flatten)]
    pub details: FitDetails,
}

/// One fitted parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterFigures {
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Its standard uncertainty (k = 1) in the same unit, by what `u_model` of the fit names; absent where there is none.
    pub u: Option<f64>,
    /// Half width of the interval that holds the truth with 95 %, from the budget or the deviations; absent without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expanded_95: Option<f64>,
    /// Its standard uncertainty in the same unit if form error like that of this part counts, as of another part of the same
    /// make; roughly, for it is from a glance. Absent of the pose, where `u` counts it, and where deviations are not plainly
    /// correlated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_by_form: Option<f64>,
}

/// A rigid motion from the part frame into the measured frame: `p' = Rz·Ry·Rx·p + t`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseFigures {
    /// Shift along x in mm.
    pub tx_mm: f64,
    /// Shift along y in mm.
    pub ty_mm: f64,
    /// Shift along z in mm.
    pub tz_mm: f64,
    /// Rotation about x in rad.
    pub rx_rad: f64,
    /// Rotation about y in rad.
    pub ry_rad: f64,
    /// Rotation about z in rad.
    pub rz_rad: f64,
}

/// Form deviation: measured minus nominal along the nominal's normal, after alignment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeviationFigures {
    /// Range.
    pub pv_nm: f64,
    /// Root mean square over the points.
    pub rms_nm: f64,
    /// Largest, positive where material stands above the nominal (+z side).
    pub max_nm: f64,
    /// Smallest.
    pub min_nm: f64,
    /// Where the largest is, part frame, mm.
    pub at_max_mm: [f64; 3],
    /// Where the smallest is, part frame, mm.
    pub at_min_mm: [f64; 3],
    /// What is known of the errors of these figures; absent where the noise is not known, `unknown` says why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyFigures>,
    /// What the part of the aperture that was not measured may hide; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmeasured: Option<UnmeasuredFigures>,
}

/// Uncertainties of PV and RMS, by the budget of the nominal file or, without one, by the noise of the points alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UncertaintyFigures {
    /// What they are made of: [`UncertaintyFigures::BUDGET`], [`UncertaintyFigures::NOISE_ONLY`] or
    /// [`UncertaintyFigures::NOISE_BESIDE_FORM`].
    #[serde(default = "UncertaintyFigures::budget")]
    pub model: String,
    /// Standard uncertainty (k = 1) of the PV, by simulated measurements.
    pub u_pv_nm: f64,
    /// Whether that and `pv_bias_nm` are upper bounds: where nothing was simulated.
    #[serde(default)]
    pub pv_at_most: bool,
    /// What noise adds to the PV on the average, as far as the draws tell.
    pub pv_bias_nm: f64,
    /// Interval of the PV, 95 %.
    pub pv_95_nm: [f64; 2],
    /// Standard uncertainty (k = 1) of the RMS without noise.
    pub u_rms_nm: f64,
    /// RMS with the mean square of the noise taken off.
    pub rms_without_noise_nm: f64,
    /// Interval of that, 95 %.
    pub rms_95_nm: [f64; 2],
    /// Standard deviation of the independent noise of a point.
    pub noise_nm: f64,
    /// Whether the noise was measured from the points.
    pub noise_measured: bool,
    /// Measurements simulated; absent where none were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub draws: Option<u32>,
    /// Seed of the simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

impl UncertaintyFigures {
    /// By the table `[uncertainty]` of the nominal file, correlated errors included.
    pub const BUDGET: &str = "error budget of the nominal file";
    /// By the noise of the points, and nothing that is correlated from point to point.
    pub const NOISE_ONLY: &str = "noise only";
    /// The same where the nominal file says so: what is correlated in the deviations is form of the part, which PV and RMS
    /// tell of, and no error of theirs.
    pub const NOISE_BESIDE_FORM: &str = "noise only, what is correlated being form";

    fn budget() -> String {
        UncertaintyFigures::BUDGET.to_owned()
    }
}

/// What one link and its devices delivered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkFigures {
    /// The link.
    pub name: String,
    /// Bytes received (CAN frames of the kernel: 16 bytes each).
    pub received_bytes: u64,
    /// Bytes that belong to no valid frame.
    pub discarded_bytes: u64,
    /// Times it was opened.
    pub opened: u64,
    /// Times it was lost.
    pub closed: u64,
    /// Its devices.
    pub devices: Vec<DeviceFigures>,
}

/// What one device delivered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceFigures {
    /// The device.
    pub name: String,
    /// Readings.
    pub readings: u64,
    /// Readings with a flag, by flag. A reading with several flags counts once for each.
    pub flagged: BTreeMap<String, u64>,
    /// Triggers skipped, as gaps in the shared count tell: readings lost before they reached the host.
    pub lost: u64,
    /// Readings that found no companion of the same count.
    pub unjoined: u64,
    /// Readings whose trigger could not be told.
    pub ambiguous: u64,
    /// Times a whole cycle of the shared count was found missing.
    pub slips: u64,
    /// Faults by kind.
    pub faults: BTreeMap<String, u64>,
    /// Every channel that makes no coordinate: smallest, mean and largest value.
    pub channels: BTreeMap<String, ChannelFigures>,
}

/// What a recorded channel did during the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFigures {
    /// Unit of the values.
    pub unit: String,
    /// Smallest value.
    pub min: f64,
    /// Mean value.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
    /// How many values.
    pub count: u64,
}

/// How long it took. Never compared between runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// From the start to the report, in s.
    pub total_s: f64,
    /// From the last point to the report, in s.
    pub after_last_point_s: f64,
    /// Points received over the whole time.
    pub points_per_s: f64,
}

/// The recording a report belongs to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SessionFigures {
    /// Name of the recording's folder.
    pub id: String,
    /// When it began, RFC 3339, UTC, by the host's clock.
    pub started: String,
    /// Name of the station.
    pub station: String,
    /// Version of asphera that recorded it.
    pub version: String,
    /// Why it ended: `complete`, `stopped`, `idle`, `interrupted`.
    pub ended: String,
}
