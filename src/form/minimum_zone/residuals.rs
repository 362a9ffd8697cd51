//! What the search for a minimum zone asks of a problem, and how a nominal laid into points answers.

use std::ops::Range;

use crate::fit::model::Model;
use crate::nominal::parameter::moved;
use crate::{Nominal, Parameter, PointMm, Pose};

/// Signed distances that depend on parameters. Indices run from 0 to `len`.
pub(super) trait Residuals: Sync {
    /// Values of all parameters, and whatever belongs to them.
    type Place: Clone + Sync;

    /// Number of distances.
    fn len(&self) -> usize;

    /// Number of parameters that may change.
    fn parameters(&self) -> usize;

    /// The place a step of the parameters leads to; `None` where the numbers make no surface.
    fn moved(&self, from: &Self::Place, step: &[f64]) -> Option<Self::Place>;

    /// Appends the distances of a range in mm; NaN where there is none.
    fn distances(&self, at: &Self::Place, range: Range<usize>, out: &mut Vec<f64>);

    /// Appends for every index the derivatives by the parameters and then the distance in mm. `None` if one
    /// of them has no distance.
    fn rows(
        &self,
        at: &Self::Place,
        indices: impl Iterator<Item = usize>,
        out: &mut Vec<f64>,
    ) -> Option<()>;
}

/// Points of the measured frame and the parameters a nominal has towards them.
pub(super) struct Part<'a> {
    pub(super) points: &'a [PointMm],
    pub(super) free: &'a [Parameter],
}

/// A nominal and where it lies.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    pub(super) pose: Pose,
    pub(super) nominal: Nominal,
}

impl Residuals for Part<'_> {
    type Place = Laid;

    fn len(&self) -> usize {
        self.points.len()
    }

    fn parameters(&self) -> usize {
        self.free.len()
    }

    fn moved(&self, from: &Laid, step: &[f64]) -> Option<Laid> {
        let changes = self.free.iter().copied().zip(step.iter().copied());
        moved(changes, &from.pose, &from.nominal).map(|(pose, nominal)| Laid { pose, nominal })
    }

    fn distances(&self, at: &Laid, range: Range<usize>, out: &mut Vec<f64>) {
        let model = Model::new(&at.nominal, &at.pose, &[]);
        let distance =
            |&point: &PointMm| model.foot(point).map_or(f64::NAN, |foot| foot.distance_mm());
        out.extend(self.points[range].iter().map(distance));
    }

    fn rows(
        &self,
        at: &Laid,
        indices: impl Iterator<Item = usize>,
        out: &mut Vec<f64>,
    ) -> Option<()> {
        let model = Model::new(&at.nominal, &at.pose, self.free);
        for index in indices {
            let start = out.len();
            out.resize(start + model.columns(), 0.0);
            model.row(self.points[index], &mut out[start..])?;
        }
        Some(())
    }
}
