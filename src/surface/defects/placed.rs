//! The reference with its steps, and what it leaves.

use asphera_geometry::PointMm;

use super::cells::Cells;
use super::ground::Ground;
use super::line::Line;
use super::reference::Reference;
use super::residuals::{Residuals, noise_field, tail_of};
use super::steps::{self, Search, Step};
use super::tail::Tail;
use super::windows::{ByPlace, References};
use super::{DefectSettings, DefectsUnknown, Samples, WINDOW};
use crate::noise::{Along, Noise, NoiseSettings, estimate_noise};

/// A surface that is looked at closely.
pub(super) struct Looked<'a> {
    pub(super) samples: &'a Samples<'a>,
    pub(super) cells: &'a Cells,
    pub(super) largest_mm: f64,
    pub(super) spacing_mm: f64,
    pub(super) settings: &'a DefectSettings,
    /// Its noise, if it is known already: that of the surface it is a part of.
    pub(super) ground: Option<&'a Ground>,
}

/// What is found of it before single defects are.
pub(super) struct Placed {
    pub(super) steps: Vec<Step>,
    pub(super) reference: Reference,
    /// By cell what the reference misses of the form, in mm along the normal.
    pub(super) missed_mm: Vec<f64>,
    pub(super) residuals: Residuals,
    pub(super) tail: Tail,
}

impl Looked<'_> {
    pub(super) fn place(&self) -> Result<Placed, DefectsUnknown> {
        let noise = match self.settings.noise {
            Some(noise) => noise,
            // Where there is no reference either, that is the reason to tell.
            None => self.noise().or_else(|why| {
                Reference::new(self.samples, self.cells, self.window_mm(), &[], false).and(Err(why))
            })?,
        };
        let points = self.samples.points.len();
        let mut references = self.references(&[])?;
        let [widest, narrowest] = references.ends();
        let mut cell_mm = self.residuals(narrowest, 0, noise).cell_mm;
        // What is long and smooth is no step: steps are looked for before any of it is taken off.
        let mut steps = self.steps(widest, &cell_mm);
        if !steps.is_empty() {
            // A reference that may not jump bends towards a step, which then looks lower than it is.
            let jumping =
                Reference::new(self.samples, self.cells, self.window_mm(), &lines(&steps), true)?;
            steps = self.steps(&jumping, &cell_mm);
            references = self.references(&lines(&steps))?;
            cell_mm = self.residuals(references.ends()[1], 0, noise).cell_mm;
        }
        let ByPlace { reference, missed_mm } = references.by_place(self.cells, &cell_mm);
        let residuals = self.residuals(&reference, points, noise);
        let tail = match self.ground {
            Some(ground) => ground.tail,
            None => tail_of(self.cells, &reference, &residuals.cell_mm),
        };
        Ok(Placed { steps, reference, missed_mm, residuals, tail })
    }

    fn references(&self, steps: &[Line]) -> Result<References<'_>, DefectsUnknown> {
        References::new(self.samples, self.cells, self.window_mm(), steps)
    }

    /// Width of the widest windows.
    fn window_mm(&self) -> f64 {
        WINDOW * self.largest_mm
    }

    fn steps(&self, reference: &Reference, sigma_mm: &[f64]) -> Vec<Step> {
        let search = Search {
            largest_mm: self.largest_mm,
            spacing_mm: self.spacing_mm,
            sigma_mm,
            false_expected: self.settings.false_expected,
        };
        steps::find(self.samples.points, self.cells, reference, &search)
    }

    fn residuals(&self, reference: &Reference, points: usize, noise: Noise) -> Residuals {
        match self.ground {
            Some(ground) => Residuals::new(self.cells, reference, points, noise, &ground.field),
            None => {
                let field = noise_field(self.cells, reference);
                Residuals::new(self.cells, reference, points, noise, &field)
            }
        }
    }

    /// The noise of the heights, or of the deviations where these are looked at.
    fn noise(&self) -> Result<Noise, DefectsUnknown> {
        let Samples { points, adjacency, deviations_mm, .. } = *self.samples;
        let settings = NoiseSettings::new(NoiseSettings::NEIGHBOURHOODS, Along::Z)
            .expect("the default number is not too small");
        let estimate = match deviations_mm {
            None => estimate_noise(points, adjacency, &settings),
            Some(deviations_mm) => {
                let lifted: Vec<PointMm> = points
                    .iter()
                    .zip(deviations_mm)
                    .map(|(&[x, y, _], &deviation)| [x, y, deviation])
                    .collect();
                estimate_noise(&lifted, adjacency, &settings)
            }
        };
        Ok(estimate.map_err(DefectsUnknown::Noise)?.noise)
    }
}

fn lines(steps: &[Step]) -> Vec<Line> {
    steps.iter().map(|step| step.line.clone()).collect()
}
