//! Figures that a metrologist asks of a curve: circles with their roundness, lines, arcs, corners and what they make, and the deviation
//! from a nominal outline.

mod airfoil;
mod circle;
mod course;
mod cut_corner;
mod element;
mod enclosed;
mod joined;
mod joint;
mod moments;
mod outline;
mod pieces;
mod polynomial;
mod profile;
mod range;
mod section;
mod tip;
mod zone;

pub use self::airfoil::Airfoil;
pub use self::circle::Circle;
pub use self::course::{Course, Noise};
pub use self::outline::{NominalOutline, OutlineDeviation};
pub use self::profile::{Bridge, Estimate, Feature, Profile};
pub use self::range::noise_range;
pub use self::zone::{MinimumZone, minimum_zone};
