//! How alike two shapes are: descriptors, their distances, and how well these find shapes of the same class.

mod evaluation;
mod seed;
mod shape;

pub use evaluation::{Evaluation, RECALLS, evaluation};
pub use seed::{GraphFeatures, graph_features};
pub use shape::{MOST_PLACES, ShapeDescriptor, Size, shape_descriptor};
