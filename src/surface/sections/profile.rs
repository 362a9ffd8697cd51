//! Profiles: a value along a section, and its figures.
//!
//! Between two points of a section a value given at the vertices runs straight, so means over the
//! arc position are known exactly: it does not matter how many edges a section happens to cross.

use std::ops::Range;

use asphera_geometry::VertexId;
use thiserror::Error;

use super::pieces::{Section, Source};

/// A value in mm, such as a height or a deviation, against the arc position of a section.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    samples: Vec<Sample>,
    /// What each sample is interpolated from.
    sources: Vec<Source>,
    /// The samples of each piece, two or more.
    pieces: Vec<Range<usize>>,
}

/// A point of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Arc position in mm.
    pub s_mm: f64,
    /// The value in mm.
    pub value_mm: f64,
    /// The length of arc in mm it stands for: half the way to each neighbour in its piece.
    pub length_mm: f64,
}

/// Figures of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileFigures {
    /// The length of arc in mm on which the value is known.
    pub length_mm: f64,
    /// Peak to valley in mm: the largest value less the smallest one.
    pub pv_mm: f64,
    /// Mean over the arc position in mm.
    pub mean_mm: f64,
    /// Root of the mean square over the arc position in mm.
    pub rms_mm: f64,
    /// The same of what differs from the mean.
    pub rms_about_mean_mm: f64,
    /// Where the largest value is; the first of several.
    pub max: Sample,
    /// Where the smallest value is; the first of several.
    pub min: Sample,
}

/// Why there is no figure or no fit of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ProfileError {
    /// The section has no part on which the value is known, or that part has no length.
    #[error("the profile has no length: the section meets no measured surface")]
    NoLength,
    /// Fewer vertices take part than there are parameters, or as many.
    #[error("the profile comes from {vertices} vertices, and a fit of {parameters} parameters needs {}", parameters + 1)]
    TooShort {
        /// How many different vertices the profile is interpolated from.
        vertices: usize,
        /// How many parameters the fit has.
        parameters: usize,
    },
    /// The polynomial asked for has too many terms.
    #[error("degree {degree}: expected at most {}", super::MAX_DEGREE)]
    Degree {
        /// The degree.
        degree: usize,
    },
    /// The samples lie so that parameters cannot be told from each other.
    #[error("the profile does not determine the {parameters} parameters of the fit")]
    Indeterminate {
        /// How many parameters the fit has.
        parameters: usize,
    },
    /// The iteration did not end.
    #[error("the fit had not converged after {steps} steps: the profile is not near a circle")]
    NotConverged {
        /// How many steps were made.
        steps: usize,
    },
}

impl Profile {
    /// The heights along a section made by [`super::section`].
    pub fn heights(section: &Section) -> Profile {
        let heights = section
            .pieces
            .iter()
            .map(|piece| piece.points.iter().map(|point| point.at_mm[2]).collect::<Vec<_>>());
        Profile::new(section, heights)
    }

    /// A value in mm given at the vertices, such as a deviation, along a section made by
    /// [`super::section`]. Where it is not finite, the profile is broken.
    pub fn along(section: &Section, mut value_mm: impl FnMut(VertexId) -> f64) -> Profile {
        let values = section.pieces.iter().map(|piece| {
            let points = piece.points.iter();
            points.map(|point| point.interpolate(&mut value_mm)).collect::<Vec<_>>()
        });
        Profile::new(section, values)
    }

    fn new(section: &Section, values: impl Iterator<Item = Vec<f64>>) -> Profile {
        let (mut samples, mut sources, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
        for (piece, values) in section.pieces.iter().zip(values) {
            let mut start = samples.len();
            let mut end_piece = |samples: &mut Vec<Sample>, sources: &mut Vec<Source>| {
                if samples.len() - start < 2 {
                    samples.truncate(start);
                    sources.truncate(start);
                } else {
                    pieces.push(start..samples.len());
                }
                start = samples.len();
            };
            for (point, value_mm) in piece.points.iter().zip(values) {
                if value_mm.is_finite() {
                    samples.push(Sample { s_mm: point.s_mm, value_mm, length_mm: 0.0 });
                    sources.push(point.source);
                } else {
                    end_piece(&mut samples, &mut sources);
                }
            }
            end_piece(&mut samples, &mut sources);
        }
        for piece in &pieces {
            for right in piece.start + 1..piece.end {
                let half_mm = (samples[right].s_mm - samples[right - 1].s_mm) / 2.0;
                samples[right - 1].length_mm += half_mm;
                samples[right].length_mm += half_mm;
            }
        }
        Profile { samples, sources, pieces }
    }

    /// The samples, in order of the arc position within each piece.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// The samples of each piece; the value is known all along from its first to its last.
    pub fn pieces(&self) -> impl Iterator<Item = &[Sample]> {
        self.pieces.iter().map(|piece| &self.samples[piece.clone()])
    }

    /// What the samples are interpolated from.
    pub(super) fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// These samples with other values, such as what a fit leaves.
    pub fn map(&self, mut value_mm: impl FnMut(&Sample) -> f64) -> Profile {
        let mut mapped = self.clone();
        for (sample, new) in self.samples.iter().zip(&mut mapped.samples) {
            new.value_mm = value_mm(sample);
        }
        mapped
    }

    /// Its figures, of the line that runs straight from sample to sample.
    ///
    /// # Errors
    ///
    /// If it has no length.
    pub fn figures(&self) -> Result<ProfileFigures, ProfileError> {
        let (&first, length_mm) =
            self.samples.first().zip(self.length_mm()).ok_or(ProfileError::NoLength)?;
        let extreme = |better: fn(f64, f64) -> bool| {
            let samples = self.samples.iter().copied();
            samples.fold(
                first,
                |best, next| if better(next.value_mm, best.value_mm) { next } else { best },
            )
        };
        let (max, min) = (extreme(|next, best| next > best), extreme(|next, best| next < best));
        // Averaged from a value of the profile on, not to lose digits to what all have in common.
        let mean_mm = first.value_mm
            + self.mean(length_mm, |p, q| {
                let (p, q) = (p - first.value_mm, q - first.value_mm);
                (p + q) / 2.0
            });
        let square = |p: f64, q: f64| (p * p + p * q + q * q) / 3.0;
        let about_mean = self.mean(length_mm, |p, q| square(p - mean_mm, q - mean_mm));
        Ok(ProfileFigures {
            length_mm,
            pv_mm: max.value_mm - min.value_mm,
            mean_mm,
            rms_mm: self.mean(length_mm, square).max(0.0).sqrt(),
            rms_about_mean_mm: about_mean.max(0.0).sqrt(),
            max,
            min,
        })
    }

    /// How much of the arc position it covers; none if nothing.
    pub(super) fn length_mm(&self) -> Option<f64> {
        let ends = self.pieces().filter_map(|piece| piece.first().zip(piece.last()));
        let length_mm: f64 = ends.map(|(first, last)| last.s_mm - first.s_mm).sum();
        (length_mm > 0.0).then_some(length_mm)
    }

    /// The mean over the arc position of what has the mean `of` between two samples.
    fn mean(&self, length_mm: f64, of: impl Fn(f64, f64) -> f64) -> f64 {
        let mut sum = asphera_geometry::Sum::default();
        for pair in self.pieces().flat_map(|piece| piece.windows(2)) {
            sum.add((pair[1].s_mm - pair[0].s_mm) * of(pair[0].value_mm, pair[1].value_mm));
        }
        sum.total() / length_mm
    }
}
