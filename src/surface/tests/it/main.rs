//! Tests of the mesh, its sampling and its raster through the public interface.

mod lattice;
mod lidar;
mod oracle;
mod patterns;
mod raster;
mod sampling;
mod stream;
