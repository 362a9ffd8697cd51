//! How densely the surface is sampled.

use serde::{Deserialize, Serialize};

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
    /// 99 % of the area are places whose gap is at most this, in mm.
    pub gap_p99_mm: Option<f64>,
    /// Largest gap allowed, in mm: the nominal's, or else four times the average distance of the points.
    pub gap_limit_mm: Option<f64>,
    /// Largest ε allowed: gap over local feature size. Absent where only ρ was asked for.
    pub epsilon_target: Option<f64>,
    /// Largest ε.
    pub epsilon_max: Option<f64>,
    /// 99 % of the area are places whose ε is at most this.
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
    /// Share of the aperture whose places are within all limits, 0 to 1; where every point counts, of the outline
    /// of the points. Beyond the outermost points no place is. Absent, like the two areas, where the local feature size is known nowhere.
    pub coverage: Option<f64>,
    /// Projected area of places beyond a limit that were scanned, but not densely enough, in mm².
    pub undersampled_area_mm2: Option<f64>,
    /// Projected area of places beyond a limit that were not scanned, in mm².
    pub uncovered_area_mm2: Option<f64>,
    /// Standard deviation of the heights from point to point, along the direction of projection, in nm.
    pub noise_sigma_nm: Option<f64>,
    /// Standard uncertainty of the noise in nm: of `noise_rms_nm` where there is one, else of `noise_sigma_nm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_u_nm: Option<f64>,
    /// Noise in nm of the quietest and of the loudest of some twenty regions, where it differs by twice and more;
    /// `noise_sigma_nm` is then a middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_range_nm: Option<[f64; 2]>,
    /// The root mean square of that noise over the part in nm: what it adds to the RMS.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_rms_nm: Option<f64>,
    /// Step in which the heights come, in nm, where noise does not blur it. Form below it is not known, and the noise is taken as that
    /// of rounding: step/√12.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_step_nm: Option<f64>,
    /// Half of the surface has facets of this spacing in mm or less.
    pub spacing_median_mm: Option<f64>,
    /// Share of the surface whose points are so near to each other that their noise turns facets by more than
    /// ε rad, or ρ rad if that is less.
    pub overdense_fraction: Option<f64>,
    /// The largest spacing in mm that satisfies ε and ρ everywhere. Absent of a plane, and where the noise is not known.
    #[serde(default)]
    pub spacing_coarsest_mm: Option<f64>,
    /// The smallest spacing in mm that is of use: with a smaller one, noise turns facets by more than ε rad.
    #[serde(default)]
    pub spacing_finest_mm: Option<f64>,
    /// The spacing in mm that satisfies ε, ρ and noise everywhere. Absent if there is none or any will do.
    pub spacing_recommended_mm: Option<f64>,
    /// Next measurements: regions that are not covered, those first that add most to the coverage.
    pub next: Vec<NextFigures>,
    /// How many more regions there are, those too small to be listed included.
    pub next_more: u64,
    /// The area in mm² of their places beyond a limit.
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
    /// The noise that the mean square of the deviations holds, and its standard uncertainty, in nm; `None` where it is not known.
    pub fn noise_in_rms_nm(&self) -> Option<[f64; 2]> {
        let noise_nm = self.noise_rms_nm.or(self.noise_sigma_nm)?;
        Some([noise_nm, self.noise_u_nm.unwrap_or(0.0)])
    }
}

impl SamplingFigures {
    /// The largest gap allowed wherever it is, in mm: by its own limit and by ρ, as far as the reach is known.
    pub fn gap_allowed_mm(&self) -> Option<f64> {
        let by_rho_mm = self.rho_target.zip(self.reach_mm).map(|(rho, reach_mm)| rho * reach_mm);
        match (self.gap_limit_mm, by_rho_mm) {
            (Some(limit_mm), Some(by_rho_mm)) => Some(limit_mm.min(by_rho_mm)),
            (limit_mm, by_rho_mm) => limit_mm.or(by_rho_mm),
        }
    }

    /// The smaller of the largest ε and ρ allowed.
    pub fn share_allowed(&self) -> Option<f64> {
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
/// to 1/8 too large, where triangles are about as halves of squares.
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
    /// Its projected area in mm², that of its polygons: what is to be measured. Some of its places may be within the
    /// limits.
    pub area_mm2: f64,
    /// Area of it beyond a limit that was scanned, but not densely enough.
    pub undersampled_mm2: f64,
    /// Area of it beyond a limit that was not scanned.
    pub uncovered_mm2: f64,
    /// Gain of coverage by measuring it, 0 to 1.
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
    /// Unit vector out of the material there: from where a probe comes. Only of meshes in space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub approach: Option<[f64; 3]>,
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
