//! What a mesh tells of a measured surface.
//!
//! [`assess`] says how far a surface lies from the nearest sample and whether that is near enough, and
//! [`rasterize`] interpolates a value given at the vertices on a regular grid without bridging gaps, [`chart`]
//! shows both in coarse cells. [`topography`] finds where the surface may not be projectable,
//! [`projectable_along`] in which other [`Plane`] it is, and [`islands`] what parts and holes the
//! well-sampled part has. [`coverage`] says what of an aperture is known and what should be measured next,
//! [`lfs`] the local feature size, [`reduce`] which points are enough, [`curvature`] normals and
//! curvatures at the vertices, [`noise`] the noise of the heights and what spacing it allows;
//! [`sections`] cuts the surface.
//!
//! Lengths are mm, areas mm². The crate deliberately holds no input or output, reads no clock and
//! starts no thread of its own: where two help it works in the caller's rayon pool. The same calls give the
//! same bits, whatever the threads.

#![forbid(unsafe_code)]

mod chart;
pub mod coverage;
pub mod curvature;
pub mod defects;
pub mod lfs;
pub mod noise;
mod outline;
mod projection;
mod raster;
pub mod reduce;
#[cfg(test)]
#[path = "../geometry/regressions.rs"]
mod regressions;
mod relief;
mod rim;
mod sampling;
pub mod sections;

pub use chart::{Chart, Facets, chart};
pub use outline::{Contour, Island, IslandCounts, islands};
pub use projection::{
    Obstacle, Plane, PlaneError, Projectability, THINNED_POINTS, projectable_along,
};
pub use raster::{Grid, RasterError, rasterize};
pub use relief::{Kind, Region, Relief, ReliefError, Topography, topography};
pub use sampling::{
    Criteria, RunningSampling, RunningSpread, Sampling, State, StateCounts, Survey, assess,
};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
