//! How a fit counted the points, and what a surface made from them is.

use serde::{Deserialize, Serialize};

/// A robust loss: how much a deviation counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LossFigures {
    /// `huber` or `tukey`.
    pub name: String,
    /// Beyond this deviation a point counts less than by its square (Huber), or not at all (Tukey), nm; with
    /// weights that of a point of mean weight.
    pub threshold_nm: f64,
    /// Whether the threshold was given; otherwise it was found from the deviations.
    pub threshold_given: bool,
    /// The standard deviation of most deviations that goes with the threshold, nm.
    pub scale_nm: f64,
    /// Points that count by less than half their weight, the next included.
    pub below_half: u64,
    /// Points that do not count.
    pub left_out: u64,
    /// Times the weights were worked out.
    pub rounds: u64,
}

/// Weights of the points: 1/u² of their standard uncertainties u along the normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WeightFigures {
    /// Smallest u of the points used, nm.
    pub u_min_nm: f64,
    /// Largest u of the points used, nm.
    pub u_max_nm: f64,
    /// Sum of the squares of deviation over u, over the degrees of freedom: about 1 if the uncertainties tell all
    /// there is. Absent without degrees of freedom.
    pub reduced_chi_square: Option<f64>,
}

/// A reference surface that was made from the points, because no design is known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceFigures {
    /// Surface under the splines: `plane`, `sphere` or `quadric`.
    pub base: String,
    /// Root mean square deviation of the points from that alone, nm.
    pub base_rms_nm: f64,
    /// Cells of the splines along x and y.
    pub cells: [u32; 2],
    /// Distance of the knots along x and y, mm.
    pub knots_mm: [f64; 2],
    /// How smooth: `cross validation`, `noise` (as given) or `given`.
    pub smoothing: String,
    /// The weight of the smoothness against the points.
    pub lambda: f64,
    /// Parameters the splines use, as the trace of what takes heights to fitted ones.
    pub effective_parameters: f64,
    /// Half the height of waves of this length is in the reference, mm; of longer ones more.
    pub follows_mm: f64,
    /// Standard deviation of what the splines do not follow, by the degrees of freedom left, nm; absent without.
    pub noise_nm: Option<f64>,
    /// While points arrive: how many there were when base and knots were made of all of them. Absent in the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub as_of_points: Option<u64>,
}
