//! Topography files, in and out: bytes in, types out.
//!
//! | format | source | read | written |
//! |---|---|---|---|
//! | [`xyz`] | columns of text, profiles, matrices of heights | yes | no |
//! | [`x3p`] | ISO 25178-72:2017 and Amd 1:2020 (ISO 5436-2) | surface, point cloud | surface, point cloud |
//! | [`metropro`] | Zygo MetroPro `.dat` | yes | no |
//! | [`sdf`] | ISO 25178-71, text and binary | yes | no |
//! | [`grid_sag`] | grid sag of Zemax OpticStudio, `.DAT` and `.GRD` | yes | no |
//! | [`ply`] | Stanford PLY, ASCII and binary | points, triangles | mesh |
//! | [`stl`] | STL, ASCII and binary | points, triangles | mesh |
//! | [`obj`] | Wavefront OBJ | points, triangles | no |
//! | [`off`] | OFF of Geomview | points, triangles | no |
//! | [`las`] | ASPRS LAS 1.0 to 1.4, and LAZ | points | no |
//! | [`npy`] | NumPy arrays | points, profiles, matrices of heights | no |
//! | [`zemax`] | lens files `.zmx` | surfaces | no |
//! | [`drawing`] | lines of SVG and DXF | lines in the plane | no |
//! | [`mask`] | PNG images | black and white | no |
//! | [`volume`] | `.vol`, NRRD, MetaImage, NIfTI, TIFF stacks, `.vti`, `.vgi`, raw | volumes | no |
//!
//! Every length is in mm, whatever the unit in the file. The frame is right-handed: x to the right,
//! y up, z out of the surface towards the instrument. Missing data are gaps: NaN in a
//! [`HeightMap`], a count in a [`Cloud`], never a zero and never a made-up height.
//!
//! A damaged or hostile file is a [`ReadError`] that names the format, the place, what was expected
//! and what was found. No reader allocates memory in proportion to a size that a file only claims.
//!
//! This crate deliberately opens no file, reads no clock and keeps no state: the same bytes in give
//! the same values out, and the same values in give the same bytes out.

#![forbid(unsafe_code)]

pub mod drawing;
pub mod grid_sag;
pub mod las;
pub mod mask;
pub mod metropro;
pub mod npy;
pub mod obj;
pub mod off;
pub mod ply;
pub mod sdf;
pub mod stl;
pub mod volume;
pub mod x3p;
pub mod xyz;
pub mod zemax;

mod detect;
mod error;
mod lengths;
mod scan;
#[cfg(test)]
mod test_data;
mod topography;
mod triangles;

pub use detect::{read, read_with, read_with_column};
pub use error::{Format, KINDS, MAX_POINTS, Place, ReadError, VOLUME_KINDS, WriteError};
pub use topography::{Cloud, HeightMap, Source, Topography};
pub use triangles::{Triangles, read_triangles};
