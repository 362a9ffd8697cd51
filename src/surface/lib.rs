//! Incremental Delaunay mesh of a projected surface, and the state of its sampling.
//!
//! A measured surface z(x, y) arrives point by point. [`Mesh`] triangulates its projection on the
//! x-y plane while it arrives, [`assess`] says how far the surface lies from the nearest sample
//! and whether that is near enough, and [`rasterize`] interpolates a value given at the vertices on a
//! regular grid without bridging gaps, [`chart`] shows both in coarse cells. [`topography`] finds where the surface may not be projectable,
//! [`projectable_along`] in which other [`Plane`] it is, and [`islands`] what parts and holes the
//! well-sampled part has. [`coverage`] says what of an aperture is known and what should be measured next,
//! [`lfs`] the local feature size, [`reduce`] which points are enough, [`curvature`] normals and
//! curvatures at the vertices, [`noise`] the noise of the heights and what spacing it allows;
//! [`sections`] cuts the surface. [`predicates`] decide questions about places exactly, and
//! [`WeightedTree`] finds what is near. [`check`] proves a finished mesh right by exact arithmetic.
//!
//! Lengths are mm, areas mm². The crate deliberately holds no input or output, reads no clock and
//! starts no thread of its own: where two help it works in the caller's rayon pool. The same calls give the
//! same bits, whatever the threads.

#![forbid(unsafe_code)]

mod area;
mod chart;
pub mod check;
pub mod coverage;
pub mod curvature;
pub mod defects;
mod delaunay;
mod distance;
mod exact;
#[cfg(test)]
#[path = "exact/tests/mod.rs"]
mod exact_tests;
mod fetch;
pub mod lfs;
mod location;
mod mesh;
mod nearest;
mod nearness;
pub mod noise;
mod order;
mod outcome;
mod outline;
mod paged;
mod point;
pub mod predicates;
mod projection;
mod quantile;
mod raster;
pub mod reduce;
#[cfg(test)]
mod regressions;
mod relief;
mod repeats;
mod rim;
mod room;
mod sampling;
pub mod sections;
mod sets;
mod triangle;

pub use area::{Area, area};
pub use chart::{Chart, chart};
pub use location::Location;
pub use mesh::{
    BATCH_POINTS, BoundsMm, ChangedPart, Changes, EditError, HEIGHTS_REMEMBERED, Mesh, Neighbours,
    Revision,
};
pub use nearest::{BoxMm, WeightedTree};
pub use outcome::{Counts, Outcome, VertexId};
pub use outline::{Contour, Island, IslandCounts, islands};
pub use paged::{PagedMesh, Paging, Part, Shelf, ShelfError, ShelfFailure};
pub use point::{PointMm, RANGE_MM, Rejection, TINY_MM};
pub use projection::{
    Obstacle, Plane, PlaneError, Projectability, THINNED_POINTS, projectable_along,
};
pub use raster::{Grid, RasterError, rasterize};
pub use relief::{Kind, Region, Relief, ReliefError, Topography, topography};
pub use repeats::Repeats;
pub use sampling::{
    Criteria, RunningSampling, RunningSpread, Sampling, State, StateCounts, Survey, assess,
};
pub use triangle::from_smallest;
