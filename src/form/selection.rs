//! Which points take part in a fit.

use rayon::prelude::*;

use crate::model::Model;
use crate::triangle::CHUNK;
use crate::{Aperture, Nominal, PointMm, Pose};

/// Points left out of a fit, by reason. A point has exactly one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Excluded {
    /// A coordinate is NaN or infinite.
    pub not_finite: usize,
    /// The place in the part frame lies outside the aperture.
    pub outside_aperture: usize,
    /// The point stands over no place of the nominal.
    pub outside_domain: usize,
}

impl Excluded {
    /// How many in all.
    pub fn total(&self) -> usize {
        self.not_finite + self.outside_aperture + self.outside_domain
    }

    pub(crate) fn count(&mut self, membership: Membership) {
        match membership {
            Membership::Used => {}
            Membership::NotFinite => self.not_finite += 1,
            Membership::OutsideAperture => self.outside_aperture += 1,
            Membership::OutsideDomain => self.outside_domain += 1,
        }
    }
}

/// Whether one point takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Membership {
    Used,
    NotFinite,
    OutsideAperture,
    OutsideDomain,
}

impl Membership {
    pub(crate) fn of(point: PointMm, model: &Model, aperture: &Aperture) -> Membership {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            return Membership::NotFinite;
        }
        let part_mm = model.motion.to_part(point);
        if !aperture.contains(part_mm[0], part_mm[1]) {
            Membership::OutsideAperture
        } else if model.nominal.meridian_foot(part_mm).is_none() {
            Membership::OutsideDomain
        } else {
            Membership::Used
        }
    }
}

/// The points that take part under one pose and nominal.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    pub(crate) points: Vec<PointMm>,
    pub(crate) memberships: Vec<Membership>,
    pub(crate) excluded: Excluded,
}

impl Selection {
    pub(crate) fn new(
        points: &[PointMm],
        nominal: &Nominal,
        pose: &Pose,
        aperture: &Aperture,
    ) -> Selection {
        let model = Model::new(nominal, pose, &[]);
        let memberships: Vec<Membership> = points
            .par_iter()
            .with_min_len(CHUNK)
            .map(|&point| Membership::of(point, &model, aperture))
            .collect();
        let mut excluded = Excluded::default();
        memberships.iter().for_each(|&membership| excluded.count(membership));
        let used = points.iter().zip(&memberships);
        let used = used.filter(|&(_, &membership)| membership == Membership::Used);
        Selection { points: used.map(|(&point, _)| point).collect(), memberships, excluded }
    }
}
