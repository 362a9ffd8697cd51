//! Curves and outlines from points in the plane.
//!
//! [`Samples`] are the points, each place once; [`Triangulation`] is their exact Delaunay triangulation as a graph.
//! [`graphs`] are the proximity graphs in it, [`curves`] the methods that reconstruct a curve from samples of it. Both
//! give a [`Graph`], whose [`Chain`]s, ends and junctions say what was joined and what was not. [`regions`] are the methods
//! that give a [`Region`]: an area in [`Part`]s with holes. [`sampler`] makes samples of known curves. [`features`] are circles
//! and deviations from nominal outlines, [`gaps`] curves across what is missing. [`Method`] names them all,
//! with their parameters, what is proven of them and where they come from; [`CurveSampling`] says whether samples meet that for the curve that
//! was found; [`agreement`] and [`Deviation`] compare
//! outcomes. [`strokes`] are regions and lines of drawings with gaps and repeated lines.
//!
//! Lengths are mm. What is decided by comparing lengths or angles is decided exactly, and ties fall by coordinates: the
//! same places give the same edges, whatever the order of the points, a power-of-two scale, or the threads. A quarter turn
//! gives the same edges where no decision is a tie. Where a method needs places that are not samples (Voronoi vertices) or
//! figures that are roots (sums of lengths), it computes them in doubles, and says so.
//!
//! ```
//! use asphera_contour::{Method, Parameters, Samples, Triangulation};
//!
//! let points = [[0.0, 0.0], [1.0, 0.0], [1.2, 1.0], [0.1, 1.1]];
//! let mesh = Triangulation::new(Samples::new(&points)?);
//! let curve = Method::HnnCrust.run(&mesh, &Parameters::new())?;
//! assert_eq!(curve.edges_by_row(mesh.samples()), [[0, 1], [0, 3], [1, 2], [2, 3]]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate holds no input or output, reads no clock and starts no thread of its own.

#![forbid(unsafe_code)]

pub mod benchmark;
mod bezier;
mod bridges;
mod cells;
mod choice;
mod compare;
mod counting;
pub mod curves;
pub mod features;
pub mod gaps;
mod graph;
pub mod graphs;
mod inside;
mod methods;
mod polylines;
mod region;
pub mod regions;
pub mod sampler;
mod samples;
mod sampling;
pub mod strokes;
mod triangulation;

pub use choice::{Choice, FoundCurve};
pub use compare::{Agreement, Deviation, IouError, agreement, intersection_over_union};
pub use graph::{Chain, Graph};
pub use methods::{Kind, Method, MethodError, Parameter, Parameters};
pub use region::{Part, Region};
pub use samples::{MOST_POINTS, PlaceMm, SampleId, Samples, SamplesError};
pub use sampling::{
    Condition, CurveSampling, EdgeSampling, Failure, Quantity, Step, Verdict, medial_axis_mm,
};
pub use triangulation::{Edge, EdgeId, Spoke, TriangleId, Triangulation};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
