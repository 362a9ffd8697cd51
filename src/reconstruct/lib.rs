//! Surfaces in space from points that no plane shows whole: balls, blades, whole lenses, knots, bands.
//!
//! [`local()`] meshes points by stars that depend on the points within a few spacings. [`prove`](prove::prove) tells what any triangle mesh is as a surface, by exact arithmetic.
//!
//! Lengths are mm. The crate holds no input or output, reads no clock and starts no thread of its own: where two help it works
//! in the caller's rayon pool. The same points give the same facets, whatever their order or the threads.

#![forbid(unsafe_code)]

mod geometry;
mod local;
mod neighbours;
pub mod prove;

pub use local::{LeftOut, MOST_POINTS, Reconstruction, TooManyPoints, local};
pub use prove::{Proof, ProofError, prove};
