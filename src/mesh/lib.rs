//! Incremental Delaunay mesh of a projected surface.
//!
//! A measured surface z(x, y) arrives point by point. [`Mesh`] triangulates its projection on the x-y plane
//! while it arrives; [`PagedMesh`] is the same mesh for scans larger than memory. [`check`] proves a finished
//! mesh right by exact arithmetic.
//!
//! Lengths are mm, areas mm². The crate deliberately holds no input or output, reads no clock and starts no
//! thread of its own: where two help it works in the caller's rayon pool. The same calls give the same bits,
//! whatever the threads.

#![forbid(unsafe_code)]

mod area;
pub mod check;
mod delaunay;
mod fetch;
mod location;
mod mesh;
mod order;
mod outcome;
mod paged;
#[cfg(test)]
#[path = "../geometry/regressions.rs"]
mod regressions;
mod repeats;
mod room;

pub use area::{Area, area};
pub use delaunay::About;
pub use location::Location;
pub use mesh::{
    BATCH_POINTS, ChangedPart, Changes, EditError, HEIGHTS_REMEMBERED, Mesh, Neighbours, Revision,
};
pub use outcome::{Counts, Outcome};
pub use paged::{PagedMesh, Paging, Part, Shelf, ShelfError, ShelfFailure};
pub use repeats::Repeats;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
