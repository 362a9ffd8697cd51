//! Local feature size: how far a surface is from its medial axis.
//!
//! The medial axis of a surface is the set of all points with two nearest points on it, with its
//! limits; lfs(x) is the distance from x to it (N. Amenta, M. Bern, Discrete & Computational Geometry 22
//! (1999) 481-504, doi:10.1007/PL00009475). It is small where the surface bends, and where two parts of
//! it come near each other. Three ways lead to it, each on its own:
//!
//! - [`NominalLfs`], from the design: analytic curvature and medial balls against the surface itself.
//! - [`MeasuredLfs`], from measured points with normals: medial balls that are not shrunk onto noise.
//! - [`Curvature`], from the curvature of a mesh: a bound from above, and with a bottleneck one from below.
//!
//! [`LfsField`] holds what any of them said at a few places, and so bounds it at every place.
//!
//! A *medial ball* touches the surface in a point, along its normal, and holds no other point of it; its
//! centre is on the medial axis. So only that part of the axis is found which is reached along
//! normals: not what the border alone makes, such as the middle of a hole in a plane.

mod axis;
mod ball;
mod curvature;
mod error;
mod field;
mod footing;
mod measured;
mod meshed;
mod nominal;
mod octree;
mod value;
mod vector;

pub use axis::{MedialAxis, MedialBall, Side};
pub use curvature::{Curvature, reach_floor_mm};
pub use error::LfsError;
pub use field::{LfsBounds, LfsField, LfsNode};
pub use measured::{Accuracy, MeasuredLfs};
pub use meshed::{MeshReach, NoReach, mesh_reach};
pub use nominal::{Jet, Nominal, NominalLfs};
pub use value::{Lfs, Why};
