//! Digitized volumes: what a binary grid tells of the part that was scanned.
//!
//! [`Samples`] holds a volume as bits. [`Histogram`] counts the 256 codes of its cells in one pass; [`Topology`] has Euler
//! numbers, components, tunnels and cavities, and [`GridCheck`] says whether the grid was fine enough for the part.
//! [`reconstruct`] makes a surface of it, [`VolumeBounds`] and the tables of fractions tell its volume, [`blurred_area`] its area.
//!
//! Lengths are in samples: neighbours along x, y and z are 1 apart, and sample (x, y, z) lies at that place. The crate
//! deliberately holds no input or output, reads no clock and starts no thread of its own: where two help it works in the
//! caller's rayon pool. The same samples give the same bits, whatever the threads.
//!
//! Source: Stelldinger, Latecki, Siqueira, Topological equivalence between a 3D object and the reconstruction of its digital
//! image, IEEE PAMI 29 (2007).

#![forbid(unsafe_code)]

mod bands;
mod blur;
mod cell;
mod cells;
mod codes;
mod cuts;
mod decider;
mod euler;
mod fractions;
mod gaps;
mod grid;
mod histogram;
mod implicit;
mod interpolated;
mod levels;
mod majority;
mod marching;
mod numbering;
mod parts;
mod quadrature;
mod reconstruct;
mod refine;
mod samples;
mod scan;
mod smooth;
mod smoothing;
mod surface;
mod table;
mod tally;
mod threshold;
mod topology;
mod trilinear;
mod tube;
mod volumes;
mod voxels;

pub use bands::{Bands, GreySlices, SurfaceBand};
pub use blur::{BlurredArea, blurred_area, total_variation};
pub use codes::{Case, CodeFacts, facts};
pub use euler::{euler_6, euler_26};
pub use fractions::{
    Fractions, ball_fractions, majority_fractions, marching_fractions, trilinear_fractions,
    voxel_fractions,
};
pub use gaps::{open_area, with_missing};
pub use grid::{Critical, CriticalKind, GridCheck, PLACES, Verdict, Violation, needed_spacing_mm};
pub use histogram::Histogram;
pub use levels::{BINS, LevelCounts, LevelRange, Levels};
pub use majority::{Majority, majority};
pub use marching::{Crossings, GREY_MARGIN, Grey, Middles, marching_cubes};
pub use parts::{Parts, cavities, components};
pub use reconstruct::{BALL_RADIUS, LEAST_BALL_RADIUS, Method, MethodError, reconstruct};
pub use refine::MAX_REFINE;
pub use samples::{MAX_SAMPLES, Samples, SizeError, SlabBuilder};
pub use scan::Gaps;
pub use smooth::Blend;
pub use smoothing::smoothed;
pub use surface::{Piece, Surface, SurfaceCheck};
pub use table::Ambiguity;
pub use tally::{SurfaceFigures, SurfaceTally};
pub use topology::Topology;
pub use trilinear::trilinear_surface;
pub use tube::{area_bounds, difference_area, semi_local_area, tube_counts};
pub use volumes::{VolumeBounds, counting_uncertainty};
pub use voxels::voxel_surface;
