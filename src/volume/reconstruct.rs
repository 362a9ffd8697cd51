//! The surfaces that a volume may be given, by method.

use crate::implicit::{Balls, Trilinear};
use crate::majority::{Majority, majority};
use crate::marching::{Crossings, marching_cubes};
use crate::refine::{MAX_REFINE, implicit_surface};
use crate::smooth::{Blend, Smooth};
use crate::table::Ambiguity;
use crate::voxels::voxel_surface;
use crate::{Samples, SizeError, Surface};

/// Radius of the balls unless another is asked for: the middle of what the source allows, (½ + 1/√3)·r′ with r′ = √3/2.
pub const BALL_RADIUS: f64 = 0.933_012_701_892_219_3;

/// Least radius of the balls, r′ = √3/2: half the diagonal of a voxel. The largest is just below 1.
pub const LEAST_BALL_RADIUS: f64 = 0.866_025_403_784_438_6;

/// How a volume becomes a surface. All but [`Method::Voxels`] keep the topology of an r-regular solid sampled at h < r / √3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Faces of voxels: the baseline, which does not keep it.
    Voxels,
    /// Faces of the finer voxels of majority interpolation.
    Majority(Majority),
    /// Marching cubes; with [`Ambiguity::Paired`] the modified marching cubes of the source.
    Marching(Ambiguity),
    /// Balls of a radius about the foreground samples, seen on a grid `refine` times finer.
    Balls {
        /// In spacings, from [`LEAST_BALL_RADIUS`] to below 1.
        radius: f64,
        /// Pieces of a cell's side, 1 to [`MAX_REFINE`].
        refine: usize,
    },
    /// Trilinear interpolation of ±1, seen on a grid `refine` times finer. Of grey values
    /// [`trilinear_surface`](crate::trilinear_surface) makes the surface.
    Trilinear {
        /// Pieces of a cell's side, 1 to [`MAX_REFINE`].
        refine: usize,
    },
    /// The same, its pieces blended.
    Smooth {
        /// How.
        blend: Blend,
        /// Pieces of a cell's side, 1 to [`MAX_REFINE`].
        refine: usize,
    },
}

/// Why a method makes no surface.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum MethodError {
    /// The balls leave gaps, or reach beyond the cells about their sample.
    #[error(
        "ball radius: expected {LEAST_BALL_RADIUS:.4} or more and below 1 spacing, found {found}"
    )]
    Radius {
        /// What was asked for.
        found: f64,
    },
    /// Too fine, or no grid at all.
    #[error("refinement: expected 1 to {MAX_REFINE} pieces of a cell's side, found {found}")]
    Refine {
        /// What was asked for.
        found: usize,
    },
    /// The finer grid has too many samples.
    #[error(transparent)]
    Size(#[from] SizeError),
}

/// The surface of a volume: a closed oriented 2-manifold for every volume and method, in samples.
///
/// `crossings` places the vertices of [`Method::Marching`]; the other methods know the samples only.
///
/// # Errors
///
/// [`MethodError`] where a figure of the method is out of range or the finer grid is too large.
pub fn reconstruct(
    samples: &Samples,
    method: &Method,
    crossings: &impl Crossings,
) -> Result<Surface, MethodError> {
    let checked = |refine: usize| {
        if (1..=MAX_REFINE).contains(&refine) {
            Ok(refine)
        } else {
            Err(MethodError::Refine { found: refine })
        }
    };
    let surface = match *method {
        Method::Voxels => voxel_surface(samples),
        Method::Majority(which) => voxel_surface(&majority(samples, which)?)
            .moved(|vertex| vertex.map(|place| place / 2.0 - 1.0), false),
        Method::Marching(rule) => marching_cubes(samples, rule, crossings),
        Method::Balls { radius, refine } => {
            if !(LEAST_BALL_RADIUS..1.0).contains(&radius) {
                return Err(MethodError::Radius { found: radius });
            }
            implicit_surface(samples, &Balls { radius }, checked(refine)?)?
        }
        Method::Trilinear { refine } => implicit_surface(samples, &Trilinear, checked(refine)?)?,
        Method::Smooth { blend, refine } => {
            implicit_surface(samples, &Smooth { blend }, checked(refine)?)?
        }
    };
    Ok(surface)
}
