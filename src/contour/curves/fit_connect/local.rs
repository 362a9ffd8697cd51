//! A sample with those about it, in order along a fit.

use super::fit::Fit;
use crate::triangulation::distance_mm;
use crate::{PlaceMm, SampleId, Triangulation};

/// The side of a sample along its fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left = 0,
    Right = 1,
}

/// The neighbourhood of a sample.
pub(super) struct Local {
    sample: SampleId,
    /// The nearest samples, more than are in use.
    nearest: Vec<SampleId>,
    /// The fit in coordinates from the sample; none as long as none conforms.
    fit: Option<Fit>,
    /// The neighbours to the left and right, the nearest along the fit first.
    sides: [Vec<SampleId>; 2],
}

impl Local {
    pub(super) fn new(sample: SampleId) -> Local {
        Local { sample, nearest: Vec::new(), fit: None, sides: [Vec::new(), Vec::new()] }
    }

    /// Fits the sample and so many neighbours; whether the fit conforms and is taken.
    pub(super) fn refit(&mut self, triangulation: &Triangulation, count: usize) -> bool {
        if self.nearest.len() < count {
            self.nearest = triangulation.nearby(self.sample).take(2 * count + 4).collect();
        }
        let near = &self.nearest[..count.min(self.nearest.len())];
        let from = triangulation.place(self.sample);
        let relative = |sample: SampleId| {
            let at = triangulation.place(sample);
            [at[0] - from[0], at[1] - from[1]]
        };
        if near.len() < 2 {
            return false;
        }
        let mut places = vec![[0.0; 2]];
        places.extend(near.iter().map(|&other| relative(other)));
        let fit = Fit::new(&places);
        let mut ways: Vec<(f64, SampleId)> =
            near.iter().map(|&other| (fit.way([0.0; 2], relative(other)), other)).collect();
        ways.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()).then(a.1.cmp(&b.1)));
        let side = |wants_left: bool| -> Vec<SampleId> {
            ways.iter().filter(|way| (way.0 < 0.0) == wants_left).map(|way| way.1).collect()
        };
        let sides = [side(true), side(false)];
        let [Some(&a), Some(&b)] = sides.each_ref().map(|side| side.last()) else { return false };
        let [a, b, p] = [relative(a), relative(b), [0.0; 2]].map(|place| fit.foot(place));
        let across = distance_mm(a, b);
        let conforms = across > distance_mm(p, a) && across > distance_mm(p, b);
        if conforms {
            self.fit = Some(fit);
            self.sides = sides;
        }
        conforms
    }

    pub(super) fn conforms(&self) -> bool {
        self.fit.is_some()
    }

    pub(super) fn side(&self, side: Side) -> &[SampleId] {
        &self.sides[side as usize]
    }

    /// The side on which another sample lies, if it is a neighbour.
    pub(super) fn side_of(&self, other: SampleId) -> Option<Side> {
        [Side::Left, Side::Right].into_iter().find(|&side| self.side(side).contains(&other))
    }

    /// The neighbours of a side that lie before another of them.
    pub(super) fn before(&self, side: Side, other: SampleId) -> Vec<SampleId> {
        self.side(side).iter().copied().take_while(|&sample| sample != other).collect()
    }

    /// The sample and its neighbours.
    pub(super) fn all(&self) -> impl Iterator<Item = SampleId> + '_ {
        std::iter::once(self.sample).chain(self.sides.iter().flatten().copied())
    }

    /// Unit normal of the fit at the sample.
    pub(super) fn normal(&self) -> Option<PlaceMm> {
        self.fit.map(|fit| fit.normal([0.0; 2]))
    }

    /// Way from a place along a normal to the fit.
    pub(super) fn meeting(
        &self,
        triangulation: &Triangulation,
        place: PlaceMm,
        normal: PlaceMm,
    ) -> Option<f64> {
        let from = triangulation.place(self.sample);
        self.fit?.meeting([place[0] - from[0], place[1] - from[1]], normal)
    }
}
