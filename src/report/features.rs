//! What stands off the surface, and which way it bends.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Defects and partition. What was not looked for is absent, and its `…_unknown` says why.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FeatureFigures {
    /// Defects, the most significant first; empty where nothing was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub defects: Option<Vec<DefectFigures>>,
    /// How many more were found than are listed.
    #[serde(default)]
    pub defects_more: u64,
    /// By what they were found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub defects_search: Option<DefectSearchFigures>,
    /// Why they were not looked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub defects_unknown: Option<String>,
    /// Which way the surface bends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub partition: Option<PartitionFigures>,
    /// Why that is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub partition_unknown: Option<String>,
}

/// A place where the surface stands off over less than a largest width. Areas and lengths are those in the plane of
/// projection, of the part deeper than half of the depth; see `asphera_surface::defects`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DefectFigures {
    /// `pit`, `bump`, `scratch`, `ridge`, `step` or `spike`.
    pub kind: String,
    /// `round` or `long` of pits and bumps, `straight` or `bent` of what is at least four times as long as wide and of
    /// steps, `point` of spikes.
    pub shape: String,
    /// Its middle, measured frame, mm.
    pub at_mm: [f64; 3],
    /// Height over the surface about it along the normal, in nm; negative of what lies below. Of a step how much
    /// higher its higher side is. Of a wide bump on form that is not smooth over two windows it is a lower bound.
    pub height_nm: f64,
    /// Its standard uncertainty.
    pub height_u_nm: f64,
    /// Area in mm². Absent of steps and spikes.
    pub area_mm2: Option<f64>,
    /// Its standard uncertainty.
    pub area_u_mm2: Option<f64>,
    /// Length in mm. Absent of spikes, and where too few points lie in it.
    pub length_mm: Option<f64>,
    /// Width in mm, at most the length. Absent of steps too.
    pub width_mm: Option<f64>,
    /// Direction of the length in the plane of projection, counter-clockwise from its u, which along z is x; 0 to 180,
    /// of a step 0 to 360 with the higher side to the left. Absent of spikes and of what is bent.
    pub orientation_deg: Option<f64>,
    /// Volume between it and the surface about it, in µm³; negative below. Absent of steps and spikes.
    pub volume_um3: Option<f64>,
    /// Points that stand off; of a step those its height was measured from.
    pub points: u64,
    /// Whether it reaches the border of what was looked at: what is seen of it is then perhaps not all.
    pub on_border: bool,
    /// How sure it is: by how many standard deviations of what noise makes of such a sum it stands off.
    pub significance: f64,
}

/// By what defects were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DefectSearchFigures {
    /// From what they stand off: `nominal`, a smooth surface through the deviation from the nominal, or `points`, one
    /// through the points.
    pub reference: String,
    /// Width in mm of the windows in which that surface is fitted.
    pub window_mm: f64,
    /// Largest width of a defect in mm: what is wider is form.
    pub largest_mm: f64,
    /// Standard deviation of single points that counts as noise, nm; where noise differs by place, of half of the surface.
    pub sigma_nm: f64,
    /// Of how many of these at its place a single point must stand off; of that of a mean, a mean of as many or fewer.
    pub threshold_sigmas: f64,
    /// How many false ones are expected on the whole surface at that threshold, if noise is not correlated.
    pub false_expected: f64,
    /// Smallest height that is listed, nm.
    pub min_height_nm: f64,
    /// How many were lower than that.
    pub lower: u64,
    /// Points of the surface.
    pub points: u64,
    /// Points of which it is not known: too few lie about them.
    pub points_unknown: u64,
}

/// Shares of the surface by the way they bend, seen from the side its normal points to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartitionFigures {
    /// Share of the area, 0 to 1: `convex` bends away both ways, `concave` towards the viewer, `saddle` one way each,
    /// `ridge` away and `trough` towards one way only, `flat` not as far as can be told; `unknown` has too few points
    /// about it. Classes that do not occur are left out.
    pub shares: BTreeMap<String, f64>,
    /// How many connected regions each class has.
    pub regions: BTreeMap<String, u64>,
    /// A curvature below this, 1/mm, counts as none.
    pub flat_below_per_mm: f64,
    /// So does one below this many of its standard uncertainties.
    pub flat_below_sigmas: f64,
    /// Side in mm of the squares over which heights were averaged: what bends within a few of them is not seen.
    pub patch_mm: f64,
}
