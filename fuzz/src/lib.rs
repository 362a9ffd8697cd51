//! What the fuzz targets share: scans as a fuzzer can write them, and what must hold for a mesh.

pub mod laws;
pub mod scan;
