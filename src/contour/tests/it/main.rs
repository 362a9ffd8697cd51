//! Tests of graphs and curves from outside.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod airfoils;
mod authors;
mod benchmark;
mod bridges;
mod choice;
mod cocone;
mod compare;
mod corners;
mod curves;
mod degenerate;
mod enclosed;
mod features;
mod free_forms;
mod gaps;
mod graphs;
mod guarantees;
mod half_neighbours;
mod hiyoshi;
mod invariance;
mod noisy;
mod outlines;
mod peers;
mod places;
mod profiles;
mod regions;
mod rolled;
mod sampler;
mod sampling;
mod shortened;
mod smooth;
mod strokes;
mod transport;
