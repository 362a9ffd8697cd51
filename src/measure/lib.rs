//! One part: points in, figures out.
//!
//! Points become a mesh, its sampling, a fit, deviations and a verdict. Running figures can be had at any moment, at a cost
//! that does not depend on the number of points. The final figures are made once, from all points. They depend on the points and
//! their order, and on nothing else: no file, no clock, no runtime.
//!
//! - [`Part`]: the design of a part, and how it is judged.
//! - [`Pipeline`]: takes points, and has running figures; [`Pipeline::finish`] makes a [`Measurement`].
//! - [`Measurement`]: report, mesh, deviations and maps.
//! - [`section`]: cuts through a mesh.

mod assessment;
mod cells;
mod correlated;
mod cutting;
mod decision;
mod defects;
mod design;
mod details;
mod deviation_map;
mod document;
mod errors;
mod figures;
mod fit_details;
mod fitting;
mod folded;
mod heights;
mod inspection;
#[cfg(test)]
mod interval_study;
mod judged;
mod judgement;
mod maps;
mod measurement;
mod meshing;
mod naming;
mod origin;
mod part;
mod partition;
mod pipeline;
mod profile;
mod projection;
mod prospects;
#[cfg(test)]
mod random;
mod removal;
mod running;
mod sampling;
pub mod section;
mod space;
mod standards;
mod step;
mod systematic;
mod tip;
mod uncertainties;
mod unmeasured;

pub use asphera_form::HIGHEST_MM;
pub use asphera_uncertainty::verdict::{Finding, Guard};
pub use cutting::FinishedMesh;
pub use decision::hold_whole;
pub use defects::features_of_mesh;
pub use deviation_map::{DeviationMap, MapSource};
pub use judgement::{ask, doubt, undecide};
pub use measurement::Measurement;
pub use meshing::{PointsSurface, folded, surface_of_points};
pub use part::{
    COVERAGE_MIN, CorrelationFrom, Criterion, DefectLimits, FLAT_BELOW_PER_MM, FigureSettings,
    Judging, LISTED, Part, Q_TERMS, TextureSettings, Weights,
};
pub use pipeline::{Pipeline, RunningFigures};
pub use projection::{Along, AlongError, DEFAULT_POINTS, MAX_POINTS, MIN_POINTS};
pub use sampling::{
    DesignSpacing, MOST_PLACES, Next, PointsSampling, Remembered, Wanted, design_spacing,
    sampling_of_mesh, sampling_of_points,
};
pub use sampling::{Readings, Sampled, feature_size, no_area};
pub use space::{
    ReducedInSpace, ReductionLimits, ReductionState, SparseInSpace, SurfaceInSpace,
    reduce_in_space, refuse_path,
};
pub use step::Step;
pub use systematic::Systematic;
pub use tip::{LARGEST_MM, Tip, TipError, TipReads, contacts};

#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;

// Unit tests read nominal files with the reader itself, which names this crate from outside.
#[cfg(test)]
extern crate self as asphera_measure;
#[cfg(test)]
#[path = "../nominal/lib.rs"]
#[expect(unreachable_pub, unused_imports, reason = "a crate of its own elsewhere")]
mod nominal;
