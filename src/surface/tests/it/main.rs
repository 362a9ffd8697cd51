//! Tests of the mesh, its sampling and its raster through the public interface.

mod batches;
mod changes;
mod coverage;
mod cuts;
mod folds;
mod lattice;
mod lenses;
mod lfs;
mod lidar;
mod natural;
mod oracle;
mod outline;
mod paged;
mod patterns;
mod profiles;
mod projection;
mod queries;
mod raster;
mod reduce;
mod sampling;
mod scans;
mod sections;
mod shapes;
mod stream;
mod threads;
mod withdrawn;
