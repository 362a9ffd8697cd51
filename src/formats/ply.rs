//! PLY, in and out (Greg Turk, "The PLY Polygon File Format", Stanford 1994).
//!
//! ```text
//! ply
//! format ascii 1.0                  or binary_little_endian, binary_big_endian
//! comment …
//! element vertex N
//! property double x                 also y, z, and others
//! element face M
//! property list uchar int vertex_indices
//! end_header
//! N vertices, M faces
//! ```
//!
//! Read are the vertices, in the order of the file: x, y and z of any type of number; where triangles are asked for, faces, too.
//! Other properties are passed over, and so is every other element. A vertex with a coordinate that is NaN is a gap.
//!
//! The format has no unit. A comment may state it, as `coordinates in mm` or `units: um`; otherwise it is taken from the options, or
//! is mm.
//!
//! Written are triangle meshes, binary little-endian.

mod body;
mod header;
mod pieces;
mod read;
mod vertices;
mod write;

pub use pieces::MeshPieces;
pub use read::{read, read_triangles};
pub use vertices::VertexRecords;
pub use write::write_mesh;

/// How every file begins; a line ending follows.
pub(crate) const MAGIC: &[u8] = b"ply";

/// Whether a file begins as one.
pub(crate) fn is_ply(bytes: &[u8]) -> bool {
    bytes.strip_prefix(MAGIC).is_some_and(|rest| rest.starts_with(b"\n") || rest.starts_with(b"\r"))
}

#[cfg(test)]
mod tests;
