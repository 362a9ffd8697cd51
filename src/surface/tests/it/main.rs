//! Tests of the mesh, its sampling and its raster through the public interface.

mod folds;
mod lattice;
mod lidar;
mod oracle;
mod outline;
mod paged;
mod patterns;
mod projection;
mod raster;
mod sampling;
mod shapes;
mod stream;
