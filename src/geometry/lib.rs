//! Geometry that every kernel crate of asphera stands on.
//!
//! Measured points and their range, [`predicates`] that decide questions about places exactly, boxes, the
//! nearest of a set of points ([`WeightedTree`]), Morton's curve ([`along_morton`]), [`outline`]s, [`side`]s, disjoint
//! [`Sets`], sums that do not lose what is small ([`Sum`]), counted random [`Numbers`], places on a mesh, weighted [`quantile`]s, [`vector`]s and single triangles in space.
//!
//! Lengths are mm, areas mm². The crate holds no input or output, reads no clock and starts no thread.

#![forbid(unsafe_code)]

mod bounds;
mod distance;
mod exact;
#[cfg(test)]
#[path = "exact/tests/mod.rs"]
mod exact_tests;
mod morton;
mod nearest;
pub mod nearness;
mod numbers;
pub mod outline;
mod point;
pub mod predicates;
pub mod quantile;
#[cfg(test)]
mod regressions;
mod sampled;
mod sets;
pub mod side;
mod sum;
mod triangle;
pub mod vector;

pub use bounds::{BoundsMm, BoxMm};
pub use morton::along_morton;
pub use nearest::WeightedTree;
pub use numbers::Numbers;
pub use point::{Point, PointMm, RANGE_MM, Rejection, TINY_MM, VertexId, admit, place};
pub use sampled::{SurfacePlace, sampled_surface};
pub use sets::Sets;
pub use sum::Sum;
pub use triangle::{Gap, Sizes, Triangle, from_smallest, greater, lesser, sizes};
