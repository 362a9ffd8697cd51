//! Questions about places in the plane and in space, decided exactly.
//!
//! A place is x and y in mm, in space x, y and z. Coordinates must be zero or at least [`crate::TINY_MM`] in size, and at most
//! [`crate::RANGE_MM`]: then no answer depends on rounding.

pub use crate::distance::{compare_distances_from, compare_with_right_angle};
pub use crate::exact::balls::{compare_facet_circle, compare_sphere, in_facet_ball};
pub use crate::exact::lengths::{
    certain_distances, compare_angle_sum, compare_distances, compare_with_sum, scalar_product,
    squared_distance,
};
pub use crate::exact::limbs::Limbs;
pub use crate::exact::radius::compare_circumradius;
pub use crate::exact::space::orientation_in_space;
pub use crate::exact::sphere::{
    by_x_y_z, certain_sphere, in_sphere, sphere_encloses, sphere_in_box_encloses,
};
pub use crate::exact::{
    Place, by_x_then_y, encloses, estimated_in_circle, estimated_orientation, in_circle, left_of,
    orientation, outside_edge,
};
