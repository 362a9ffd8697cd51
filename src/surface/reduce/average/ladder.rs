//! Heights read from fits over windows of several widths.

use super::super::fitted::Fitted;

/// A height over the zero of the offsets, and what σ is multiplied by to give its standard uncertainty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    pub(super) height_mm: f64,
    pub(super) factor: f64,
}

impl Reading {
    /// The point as it was measured.
    pub(super) const MEASURED: Reading = Reading { height_mm: 0.0, factor: 1.0 };

    /// By how many standard deviations of the noise, squared, a reading over a narrower window differs.
    ///
    /// Where a fit over the wider window is right, it is the best estimate from all its points, so the difference has
    /// the variance of the narrower reading less that of the wider.
    pub(super) fn contrast(&self, narrower: &Reading, sigma_mm: f64) -> f64 {
        let variance = narrower.factor * narrower.factor - self.factor * self.factor;
        let difference = (self.height_mm - narrower.height_mm) / sigma_mm;
        if variance > 0.0 { difference * difference / variance } else { 0.0 }
    }
}

/// The readings over a window: those of its `count` nearest points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) count: usize,
    pub(super) plane: Option<Reading>,
    pub(super) quadric: Option<Reading>,
}

/// The readings at a kept point over its cell, over the nearer half of its points, and so on.
#[derive(Clone, Debug, Default)]
pub(super) struct Ladder {
    pub(super) steps: Vec<Step>,
}

impl Ladder {
    /// The ladder over offsets from the kept point, the nearest first.
    pub(super) fn over(offsets_mm: &[[f64; 3]]) -> Ladder {
        let counts = std::iter::successors(Some(offsets_mm.len()), |count| Some(count / 2));
        let step = |count: usize| {
            let window = &offsets_mm[..count];
            Step {
                count,
                plane: Fitted::<3>::to(window).map(|fitted| reading(&fitted)),
                quadric: Fitted::<6>::to(window).map(|fitted| reading(&fitted)),
            }
        };
        Ladder { steps: counts.take_while(|&count| count >= FEWEST).map(step).collect() }
    }

    /// The readings narrower than one: the quadric beside a plane, the quadrics over narrower windows and the point.
    pub(super) fn narrower(&self, which: Which) -> impl Iterator<Item = (Which, Reading)> {
        let from = which.step + usize::from(which.degree == Degree::Quadric);
        let quadric = move |step: usize| {
            let which = Which { step, degree: Degree::Quadric };
            Some((which, self.reading(which)?))
        };
        let measured = Which { step: usize::MAX, degree: Degree::Quadric };
        (from..self.steps.len()).filter_map(quadric).chain([(measured, Reading::MEASURED)])
    }

    /// A reading; beyond the last step the point as it was measured.
    pub(super) fn reading(&self, which: Which) -> Option<Reading> {
        if which.step == usize::MAX {
            return Some(Reading::MEASURED);
        }
        let step = self.steps.get(which.step)?;
        match which.degree {
            Degree::Plane => step.plane,
            Degree::Quadric => step.quadric,
        }
    }
}

/// A reading of a ladder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Which {
    pub(super) step: usize,
    pub(super) degree: Degree,
}

/// The polynomial that is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Degree {
    Plane,
    Quadric,
}

fn reading<const N: usize>(fitted: &Fitted<N>) -> Reading {
    Reading { height_mm: fitted.height_mm(), factor: fitted.height_factor() }
}

/// A quadric has six terms; with fewer points than this its value is hardly better than a single
/// height.
const FEWEST: usize = 10;
