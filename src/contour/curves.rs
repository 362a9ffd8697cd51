//! Methods that reconstruct curves from samples of them.
//!
//! The documentation of each says what it is proven for and how certain the description is that it follows. ε and ρ are
//! sampling conditions: every place of the curve has a sample nearer than ε times the distance to the curve's medial axis
//! there (local feature size), or than ρ times the least such distance between the two samples beside it (reach).

mod ball_pivoting;
mod cocone;
mod connect2d;
mod conservative;
mod crawl;
mod crust;
mod exchange;
mod fit_connect;
mod gathan;
mod gathan_g;
mod hiyoshi;
mod hnn;
mod lee;
mod lenz;
mod nn;
mod one_step;
mod peel;
mod regular;
mod ruler;
mod stretch;
mod tour;
mod transport;
mod tree;
mod vision;
mod voronoi_labelling;

pub use ball_pivoting::{ball_pivoting, pivoting_radii_mm};
pub use cocone::cocone;
pub use connect2d::{connect2d, sig_connect2d};
pub use conservative::conservative_crust;
pub use crawl::crawl;
pub use crust::crust;
pub use exchange::{MOST_FOR_EXCHANGE, edge_exchange};
pub use fit_connect::fit_connect;
pub use gathan::gathan;
pub use gathan_g::gathan_g;
pub use hiyoshi::{MOST_FOR_MATCHING, hiyoshi};
pub use hnn::{HalfNeighbours, hnn_crust, one_sided_hnn_crust};
pub use lee::{MovedCurve, lee, lee_reach_mm};
pub use lenz::lenz;
pub use nn::nn_crust;
pub(crate) use one_step::one_step_curve;
pub use one_step::{OneStep, one_step_crust};
pub use peel::peel;
pub use regular::regular_shape;
pub use stretch::stretch_denoise;
pub use tour::{MOST_FOR_TOUR, tsp};
pub use transport::{Transport, optimal_transport, transport_tolerance_mm};
pub use tree::emst_curve;
pub use vision::{discur, vicur};
pub use voronoi_labelling::voronoi_labelling;
