//! Incremental Delaunay mesh of a projected surface, and the state of its sampling.
