//! Proximity graphs: which samples are near each other.
//!
//! Each holds the one before: nearest neighbours, [`emst`], [`rng`], [`gabriel`], the Delaunay triangulation.

mod bc0;
mod emst;
mod gabriel;
mod gamma;
mod lune;
mod sig;

pub use bc0::{bc0, raised};
pub use emst::emst;
pub use gabriel::gabriel;
pub use gamma::{MOST_FOR_PAIRS, beta_skeleton, gamma_neighbourhood};
pub use lune::{lune_beta_skeleton, rng};
pub use sig::{sig, sigdt};

use crate::{Graph, Triangulation};

/// The Delaunay graph: all edges of the triangulation.
pub fn delaunay(triangulation: &Triangulation) -> Graph {
    Graph::of_edges(triangulation, |_| true)
}

pub(crate) use emst::{Sets, longest_spanning, spanning, spanning_by_length};
pub(crate) use gabriel::is_gabriel;
