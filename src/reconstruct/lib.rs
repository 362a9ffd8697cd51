//! Surfaces in space from points that no plane shows whole: balls, blades, whole lenses, knots, bands.
//!
//! [`local()`] meshes points by stars that depend on the points within a few spacings. [`prove`](prove::prove) tells what any triangle mesh is as a surface, by exact arithmetic.
//!
//! Lengths are mm. The crate holds no input or output, reads no clock and starts no thread of its own: where two help it works
//! in the caller's rayon pool. The same points give the same facets, whatever their order or the threads.

#![forbid(unsafe_code)]

mod alpha;
mod centres;
mod cocone;
mod convection;
mod delaunay;
mod deviation;
mod draw;
mod facing;
mod geometry;
mod graph;
mod local;
mod natural;
mod neighbours;
mod poles;
pub mod prove;
mod reach;
mod rings;
mod robust_cocone;
mod sampling;
mod sculpture;
mod sides;
mod surface;
mod tangential;
mod turning;
mod wrap;

pub use alpha::{AlphaError, AlphaShape, AlphaStanding, alpha_shape};
pub use cocone::{
    COCONE_BOUND, CellCocone, Cocone, POINTS_IN_CELL, cocone, loc_cocone, super_cocone,
};
pub use convection::convection;
pub use delaunay::{Delaunay, MOST_DELAUNAY_POINTS, NoDelaunay, Unsound, check_delaunay};
pub use deviation::distances_mm;
pub use graph::{
    Cell, Contact, FaceRule, GraphChoices, GraphError, GraphMap, GraphSurface, LandmarkOrder,
    LiveGraph, MOST_HOPS, MOST_NEIGHBOURS, MOST_TILED_POINTS, NoSurface, PointGraph, Stage,
    TileError, TileShelf, TileShelfFailure, TiledGraph, TiledSurface,
};
pub use local::{FacetChanges, LocalSurface, MOST_POINTS, SurfaceByPlace, TooManyPoints, local};
pub use natural::{NATURAL_BOUND, Natural, natural};
pub use prove::{Proof, ProofError, prove};
pub use robust_cocone::{RobustCocone, robust_cocone};
pub use sampling::{LISTED_ABOVE, SamplingCondition};
pub use sculpture::sculpture;
pub use surface::{LeftOut, Reconstruction};
pub use tangential::{TANGENTIAL_BOUND, Tangential, tangential};
pub use wrap::{WRAP_BOUND, Wrap, wrap};
