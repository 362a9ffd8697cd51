//! What is looked for, and what is given.

use asphera_geometry::{PointMm, RANGE_MM, VertexId};
use thiserror::Error;

use crate::curvature::Adjacency;
use crate::noise::{Noise, NoiseUnknown};

/// A measured surface: its vertices, its triangles and who is whose neighbour.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// The vertices. Those without neighbours or with a coordinate that is not finite are left out.
    pub points: &'a [PointMm],
    /// The triangles of the surface. Those with a side that joins no neighbours are left out.
    pub triangles: &'a [[VertexId; 3]],
    /// The neighbours, with a reach that bridges no gap.
    pub adjacency: &'a Adjacency,
    /// One deviation from a nominal surface for each vertex, in mm along its normal, to be looked at
    /// in place of the heights; not finite where it is not known.
    ///
    /// The reference then follows what the nominal leaves, its form error, not the form itself.
    pub deviations_mm: Option<&'a [f64]>,
}

/// How large defects may be, and how many false ones are put up with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefectSettings {
    pub(super) largest_mm: Option<f64>,
    pub(super) false_expected: f64,
    pub(super) noise: Option<Noise>,
}

/// A setting that is not usable.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum DefectSettingsError {
    /// The largest width of a defect is not a length.
    #[error("the largest width {0} mm is not above 0 and up to 1e12 mm")]
    Largest(f64),
    /// The number of false defects is none.
    #[error("{0} false defects are not from 1e-9 to 10")]
    FalseExpected(f64),
}

impl DefectSettings {
    /// Default of the expected number of false defects on a whole surface of uncorrelated noise.
    pub const FALSE_EXPECTED: f64 = 0.01;
    /// Default of the largest width, in spacings.
    pub const LARGEST_SPACINGS: f64 = 20.0;

    /// Settings for defects up to that width in mm, above 0 and up to 1e12. Wider ones count as form.
    ///
    /// The reference is a quartic over windows three times as wide: what form departs from a quartic
    /// over them is taken for defects, or hides them. Where that is not small against the noise, pass
    /// deviations from a nominal, or a smaller width.
    pub fn with_largest_mm(self, largest_mm: f64) -> Result<DefectSettings, DefectSettingsError> {
        if largest_mm > 0.0 && largest_mm <= RANGE_MM {
            Ok(DefectSettings { largest_mm: Some(largest_mm), ..self })
        } else {
            Err(DefectSettingsError::Largest(largest_mm))
        }
    }

    /// Settings with that many false defects expected on a whole surface of uncorrelated noise, 1e-9 to 10.
    pub fn with_false_expected(self, count: f64) -> Result<DefectSettings, DefectSettingsError> {
        if (1e-9..=10.0).contains(&count) {
            Ok(DefectSettings { false_expected: count, ..self })
        } else {
            Err(DefectSettingsError::FalseExpected(count))
        }
    }

    /// Settings with this noise, which is otherwise estimated from the points.
    pub fn with_noise(self, noise: Noise) -> DefectSettings {
        DefectSettings { noise: Some(noise), ..self }
    }
}

impl Default for DefectSettings {
    /// Widths up to [`DefectSettings::LARGEST_SPACINGS`] spacings, [`DefectSettings::FALSE_EXPECTED`]
    /// false defects, noise as estimated.
    fn default() -> DefectSettings {
        DefectSettings {
            largest_mm: None,
            false_expected: DefectSettings::FALSE_EXPECTED,
            noise: None,
        }
    }
}

/// Why defects cannot be looked for.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum DefectsUnknown {
    /// Points, adjacency and deviations are not of the same number.
    #[error("{points} points, {adjacency} of them with neighbours and {deviations} deviations")]
    Numbers {
        /// How many points were given.
        points: usize,
        /// How many vertices the adjacency has.
        adjacency: usize,
        /// How many deviations were given; as many as points if none were.
        deviations: usize,
    },
    /// A triangle has a corner that is no point.
    #[error("triangle {triangle} has the corner {corner}, but there are {points} points")]
    Corner {
        /// Index of the triangle.
        triangle: usize,
        /// Its corner.
        corner: VertexId,
        /// How many points there are.
        points: usize,
    },
    /// The length from which on an edge bridges a gap is none.
    #[error("reach {reach_mm} mm is not above 0")]
    Reach {
        /// The length in mm.
        reach_mm: f64,
    },
    /// No triangle of the surface has an area.
    #[error("the triangles of the surface have no area")]
    NoArea,
    /// The surface is too thin or too scattered for the windows of the reference.
    #[error(
        "cells of {side_mm} mm over a surface of {extent_mm:?} mm are too many for {points} points"
    )]
    Scattered {
        /// Side of a cell in mm.
        side_mm: f64,
        /// Extent of the surface along x and y in mm.
        extent_mm: [f64; 2],
        /// How many points there are.
        points: usize,
    },
    /// No window holds enough samples for a reference.
    #[error("no window of {window_mm:.4} mm has samples in enough places for a quartic")]
    NoReference {
        /// Width of a window in mm.
        window_mm: f64,
    },
    /// The noise is not known.
    #[error("the noise is not known")]
    Noise(#[source] NoiseUnknown),
    /// Heights come in steps of unknown size, and nothing says how large one is.
    #[error(
        "most neighbours have the very same height, as of readings in steps of unknown size: state noise_nm in the table uncertainty"
    )]
    HiddenSteps,
}
