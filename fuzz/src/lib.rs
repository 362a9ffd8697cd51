//! What the fuzz targets share: inputs as a fuzzer can write them, and what must hold for what is made of them.

pub mod can;
pub mod contour;
pub mod drivers;
pub mod http;
pub mod laws;
pub mod readers;
pub mod scan;
pub mod space;
pub mod toml;
pub mod volumes;
