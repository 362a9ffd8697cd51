//! Surfaces in space from points that no plane shows whole: balls, blades, whole lenses, knots, bands.
//!
//! [`local()`] meshes points by stars that depend on the points within a few spacings. [`prove`](prove::prove) tells what any triangle mesh is as a surface, by exact arithmetic.
//!
//! Lengths are mm. The crate holds no input or output, reads no clock and starts no thread of its own: where two help it works
//! in the caller's rayon pool. The same points give the same facets, whatever their order or the threads.

#![forbid(unsafe_code)]

mod delaunay;
mod geometry;
mod graph;
mod local;
mod neighbours;
pub mod prove;
mod surface;

pub use delaunay::{Delaunay, MOST_DELAUNAY_POINTS, NoDelaunay, Unsound, check_delaunay};
pub use graph::{
    Cell, Contact, FaceRule, GraphChoices, GraphError, GraphMap, GraphSurface, LandmarkOrder,
    MOST_HOPS, MOST_NEIGHBOURS, NoSurface, PointGraph, Stage,
};
pub use local::{MOST_POINTS, TooManyPoints, local};
pub use prove::{Proof, ProofError, prove};
pub use surface::{LeftOut, Reconstruction};
