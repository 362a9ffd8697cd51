//! Tests of the sampling and of what a mesh tells through the public interface.

mod average;
mod coverage;
mod cuts;
mod cuts_in_space;
mod folds;
mod lenses;
mod lfs;
mod lidar;
mod outline;
#[expect(dead_code, reason = "the tests of the mesh use all of them")]
#[path = "../../../mesh/tests/it/patterns.rs"]
mod patterns;
mod places;
mod profiles;
mod projection;
#[path = "../../../mesh/tests/it/random.rs"]
mod random;
mod raster;
mod reduce;
mod rim_gap;
mod sampling;
mod sections;
mod shapes;
