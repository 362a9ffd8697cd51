//! Point Cloud Graphs: which parts lie there, how they hang together, where they have holes and branches. No mesh is needed.
//!
//! [`Cloud`] holds the points, each place once, and finds neighbours. [`functions`] give a value a place: heights, distances, geodesic
//! distances, eigenfunctions. [`extract`] cuts the range of a function into [`Strips`] and makes the [`PointGraph`]: a node for every connected
//! piece of a strip, an arc between pieces of consecutive strips that are near. Its [`Loop`]s are holes: of a closed surface that is
//! sampled densely there are as many as its genus. [`parts`] parts a scene, and
//! [`library`] says which part is which.
//!
//! Points lie in the plane, in space or in four dimensions; lengths are mm. The same points give the same bits, whatever their order
//! or the threads.
//!
//! ```
//! use asphera_graph::{Choices, Cloud, extract, functions};
//!
//! // A ring in the plane: two branches, one loop.
//! let angles = (0..400).map(|step| f64::from(step) * std::f64::consts::TAU / 400.0);
//! let ring: Vec<[f64; 2]> = angles.map(|angle| [angle.cos(), angle.sin()]).collect();
//! let cloud = Cloud::new(&ring)?;
//! let height = functions::height(&cloud, [1.0, 0.0])?;
//! let found = extract(&cloud, &height, &Choices::default())?;
//! assert_eq!((found.loops.len(), found.graph.components().1), (1, 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Source: S. Biasotti and G. Patanè on the Point Cloud Graph of point-sampled surfaces and volumes; where the crate departs from
//! it, the items say so. The crate holds no input or output, reads no clock and starts no thread of its own. [`compare`] says how alike shapes are.
//! [`RunningGraph`] is kept up while points of a scan arrive.

#![forbid(unsafe_code)]

mod auto;
mod cloud;
pub mod compare;
mod extract;
mod fine_loops;
pub mod functions;
mod graph;
mod grown;
mod level_sets;
pub mod library;
mod links;
mod loop_places;
mod loops;
mod nearest;
mod parts;
mod resolutions;
mod running;
mod saddles;
mod segments;
mod slab;
mod stability;
mod strips;
mod thinned;
mod tree;
mod within;

pub use auto::{auto_strips, auto_tau_mm};
pub use cloud::{Cloud, CloudError, MOST_NEIGHBOURS, MOST_POINTS, PlaceId, RANGE_MM};
pub use extract::{Choices, ExtractError, Extraction, Pieces, StripChoice, extract};
pub use graph::{Arc, GraphError, Node, NodeId, PointGraph, tau_components};
pub use grown::{Growth, grown_graph};
pub use loops::Loop;
pub use nearest::Nearest;
pub use parts::{Part, Parts, auto_min_points, parts};
pub use resolutions::{Resolution, resolutions};
pub use running::{
    Change, ClosedStrip, PartId, RunningError, RunningEvent, RunningGraph, RunningNode,
    RunningPart, RunningSettings,
};
pub use segments::Segment;
pub use stability::{MostLoops, Stability};
pub use strips::{MOST_STRIPS, Strips, StripsError};
pub use within::Within;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
