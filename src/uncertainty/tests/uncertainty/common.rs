//! Parts, places and numbers that the tests share with those of fits.

#[path = "../../../form/tests/form/common/lens.rs"]
mod lens;
#[path = "../../../form/tests/form/common/places.rs"]
mod places;

pub(crate) use lens::{al1815, misaligned, normals};
pub(crate) use places::{Noise, spiral};
