//! Tests of reconstruction and proof from outside.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod alpha;
mod batches;
mod bodies;
mod cells;
mod cocone;
mod complexes;
mod delaunay;
mod graph;
mod invariance;
mod live;
mod peers;
mod proof;
mod put_back;
mod real;
mod shapes;
mod stars;
mod tangential;
mod tiles;
mod wrap;
