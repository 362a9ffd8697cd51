//! The face of a volume that a nominal describes, as points for a measurement.
//!
//! A [`Body`] is a volume of grey values with its surface. [`Body::face`] finds where the nominal lies in it, and takes the part of the
//! surface that it describes: a [`Face`]. Its points lie where the grey values reach the threshold, between the samples. Each face
//! knows how blur, noise and threshold move its points, and [`Face::part`] hands that to the error budget of a measurement.
//! [`between`] tells how two measured faces lie to each other: thickness, wedge, decentre. A [`VolumeViewer`] has what a picture needs.
//!
//! The crate deliberately reads no file and no clock. The same values give the same points, whatever the threads.

#![forbid(unsafe_code)]

mod body;
mod edge;
mod errors;
mod face;
mod flattening;
mod laying;
mod noise;
mod pair;
mod resolution;
mod selection;
mod slice;
mod unblur;
mod view;

pub use body::{Body, Lattice, Scan};
pub use face::{Face, FaceError, Settings, Threshold};
pub use pair::{Lying, between};
pub use view::{MeasuredFace, VolumeViewer};

#[cfg(test)]
mod interval_study;
#[cfg(test)]
mod tests;
