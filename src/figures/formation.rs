//! A figure of a sample, by its definition.

use super::{
    Approximation, Definition, Figure, Sample, SlopeSettings, Subject, Unknown, amplitude,
    decompose, slopes,
};

/// Choices that a figure is formed with.
#[derive(Clone, Copy, Debug)]
pub struct Formation {
    /// Sphere or quadratic part that A is of.
    pub approximation: Approximation,
    /// Stations of slopes.
    pub slope: Option<SlopeSettings>,
}

impl Definition {
    /// The figure of a sample. The outer `None`: it is not formed of deviations, its variant does not exist, or a
    /// slope lacks its settings. `O(n)`; a Zernike figure `O(n·p²)` for its p terms.
    pub fn form(&self, sample: &Sample, by: Formation) -> Option<Result<Figure, Unknown>> {
        match self.subject() {
            Subject::Deviation => amplitude::form(self, sample),
            Subject::Indication => Some(
                decompose(sample, by.approximation, None).map(|found| self.among(&found.figures())),
            ),
            Subject::Slope => {
                let found = slopes(sample, by.slope?);
                Some(found.map(|found| self.among(&found.figures())))
            }
            _ => None,
        }
    }

    /// Heights in nm, one a place, whose mean square is that of the figure; for a coefficient what it is found
    /// beside. `None` where the figure does not average heights, or is unknown.
    pub fn averaged_nm(&self, sample: &Sample, approximation: Approximation) -> Option<Vec<f64>> {
        match self.subject() {
            Subject::Deviation => amplitude::averaged_nm(self, sample),
            Subject::Indication => decompose(sample, approximation, None).ok()?.averaged_nm(self),
            _ => None,
        }
    }

    fn among(&self, figures: &[Figure]) -> Figure {
        let found = figures.iter().find(|figure| figure.definition == *self);
        *found.expect("every figure of a subject is listed among those of its kind")
    }
}
