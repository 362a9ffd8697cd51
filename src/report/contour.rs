//! A contour: the curve or the area that points in the plane are samples of.

mod abridged;
mod features;
mod figures;
mod gaps;
mod sampled;
mod session;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use self::features::FeatureFigures;
pub use self::figures::{CircleFigures, DeviationFigures};
pub use self::gaps::GapFigures;
pub use self::sampled::{FailureFigures, SampledFigures};
pub use self::session::{ContourState, SessionContour};

/// Version of the layout of [`ContourReport`].
pub const CONTOUR_FORMAT: &str = "asphera-contour 1";

/// A curve or an area found from points, and its figures. Lengths are mm; rows are those of points, counted from 0.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct ContourReport {
    /// [`CONTOUR_FORMAT`].
    pub format: String,
    /// What was read.
    pub input: InputFigures,
    /// The method or graph.
    pub method: String,
    /// Why this method; where it was chosen by the points only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Its parameters with their values.
    pub parameters: BTreeMap<String, f64>,
    /// The condition under which its edges are proven to be those of the curve.
    pub guarantee: String,
    /// Pairs of rows, the smaller first, sorted. Of points in one place the first row stands for all.
    pub edges: Vec<[u32; 2]>,
    /// Runs of edges; none of a graph. Of a region the lines round its parts and holes come first; of strokes they are the lines between regions.
    pub chains: Vec<ChainFigures>,
    /// Cubic Bézier curves along each of `chains`, by four places each; of strokes only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beziers_mm: Vec<Vec<[[f64; 2]; 4]>>,
    /// Area of all parts in mm²; the next three are there for a region only, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_mm2: Option<f64>,
    /// How many parts there are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<usize>,
    /// How many holes all parts have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holes: Option<usize>,
    /// The parts, by the samples of their outlines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regions: Option<Vec<RegionFigures>>,
    /// Rows with one edge.
    pub ends: Vec<u32>,
    /// Rows with more than two.
    pub junctions: Vec<u32>,
    /// Gaps that were closed, the narrowest first; where it was asked for, or of strokes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<GapFigures>,
    /// Rows without any, of a region those that no part holds: what the method left out.
    pub left_out: Vec<u32>,
    /// Whether the points suffice for the curve; of a curve only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampling: Option<SampledFigures>,
    /// The circle of the points; of one curve that is near a circle only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circle: Option<CircleFigures>,
    /// Lines, arcs, corners and what they make; of a curve only.
    #[serde(default)]
    pub features: Vec<FeatureFigures>,
    /// Deviations from the nominal outline; where one is given only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<DeviationFigures>,
    /// What is not known, and why.
    pub unknown: Vec<String>,
    /// What was left out of long lists, in words; absent where they are whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub abridged: Option<String>,
}

/// The points that were read.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct InputFigures {
    /// How many.
    pub points: usize,
    /// How many different places.
    pub distinct: usize,
    /// Whether they are of an area or of a border; where the method was chosen by the points only, as the next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// How many of them are outliers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outliers: Option<usize>,
    /// The standard deviation of their distances to the curve, where noise was taken away, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_sigma_mm: Option<f64>,
    /// Median of the distances of places to their nearest one, mm; absent where no contour was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing_median_mm: Option<f64>,
}

/// A run of edges.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ChainFigures {
    /// Whether its last place is joined to its first.
    pub closed: bool,
    /// Its length in mm, the closing edge included.
    pub length_mm: f64,
    /// Its places in order; of a closed one the first is not repeated.
    pub points_mm: Vec<[f64; 2]>,
}

/// A part of a region.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct RegionFigures {
    /// Its label; of strokes only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Its area less its holes in mm².
    pub area_mm2: f64,
    /// Length of its outline and of the lines round its holes in mm.
    pub perimeter_mm: f64,
    /// Its outline, counter-clockwise; the first place is not repeated.
    pub outline_mm: Vec<[f64; 2]>,
    /// The lines round its holes, clockwise.
    pub holes_mm: Vec<Vec<[f64; 2]>>,
}
