//! The linear problem under a fit: what uncertainties and figures solve again, with other right-hand sides.
//!
//! Everything refers to the tall matrix [J | d] of a fit: a row a point, a column a free parameter, and last the
//! distances. [`Model`] gives its rows, [`Triangle`] its factor R, [`System`] what R determines. [`Selection`] and
//! [`Weights`] say which points count and how much.

pub use crate::fit::model::Model;
pub use crate::fit::selection::Selection;
pub use crate::fit::solve::{Step, System};
pub use crate::fit::triangle::{CHUNK, Spread, Triangle};
pub use crate::fit::weight::Weights;
