//! What a figure makes of the deviations.

use super::Definition;

/// Kinds of figures that noise, the places taken and unmeasured area act on alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// Range or extreme: a single place decides it.
    Extreme,
    /// Root mean square of heights.
    MeanSquare,
    /// Coefficient that is linear in the heights.
    Coefficient,
    /// Largest slope of the stations.
    LargestSlope,
    /// Root mean square of the slopes of the stations.
    MeanSquareSlope,
    /// Several of these together, or a range of means: PVr, B, C.
    Compound,
}

impl Definition {
    /// What the figure makes of the deviations.
    pub fn statistic(&self) -> Statistic {
        self.row().statistic
    }
}
