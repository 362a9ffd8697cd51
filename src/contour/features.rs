//! Figures that a metrologist asks of a curve: circles with their roundness, and the deviation from a nominal outline.

mod circle;
mod outline;
mod range;
mod zone;

pub use self::circle::Circle;
pub use self::outline::{NominalOutline, OutlineDeviation};
pub use self::range::noise_range;
pub use self::zone::{MinimumZone, minimum_zone};
