//! Which points take part in a fit.

use rayon::prelude::*;

use crate::fit::model::Model;
use crate::fit::triangle::CHUNK;
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

    pub(crate) fn with(self, other: Excluded) -> Excluded {
        Excluded {
            not_finite: self.not_finite + other.not_finite,
            outside_aperture: self.outside_aperture + other.outside_aperture,
            outside_domain: self.outside_domain + other.outside_domain,
        }
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
        } else if model.nominal.surface_foot(part_mm).is_none() {
            Membership::OutsideDomain
        } else {
            Membership::Used
        }
    }
}

/// The points that take part under one pose and nominal.
#[derive(Clone, Debug)]
pub struct Selection {
    /// Places of the points in the measured frame, mm.
    pub points: Vec<PointMm>,
    /// Roots of their weights, if there are weights.
    pub roots: Option<Vec<f64>>,
    pub(crate) memberships: Vec<Membership>,
    pub(crate) excluded: Excluded,
}

impl Selection {
    /// `roots` holds one root of a weight for each point.
    pub fn new(
        points: &[PointMm],
        roots: Option<&[f64]>,
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
        Selection::of(points, roots, memberships)
    }

    /// The memberships of the same points under another pose and nominal, under which every point used so
    /// far is known to stand over the nominal: only the others are asked that again.
    pub(crate) fn memberships_under(
        &self,
        points: &[PointMm],
        nominal: &Nominal,
        pose: &Pose,
        aperture: &Aperture,
    ) -> Vec<Membership> {
        let model = Model::new(nominal, pose, &[]);
        let again = |(&point, &before): (&PointMm, &Membership)| {
            if before != Membership::Used {
                return Membership::of(point, &model, aperture);
            }
            let part_mm = model.motion.to_part(point);
            if aperture.contains(part_mm[0], part_mm[1]) {
                Membership::Used
            } else {
                Membership::OutsideAperture
            }
        };
        points.par_iter().zip(&self.memberships).with_min_len(CHUNK).map(again).collect()
    }

    /// From memberships that are known.
    pub(crate) fn of(
        points: &[PointMm],
        roots: Option<&[f64]>,
        memberships: Vec<Membership>,
    ) -> Selection {
        let mut excluded = Excluded::default();
        memberships.iter().for_each(|&membership| excluded.count(membership));
        let used = points.iter().zip(&memberships);
        let used = used.filter(|&(_, &membership)| membership == Membership::Used);
        let points = used.map(|(&point, _)| point).collect();
        let roots = roots.map(|roots| {
            let used = roots.iter().zip(&memberships);
            let used = used.filter(|&(_, &membership)| membership == Membership::Used);
            used.map(|(&root, _)| root).collect()
        });
        Selection { points, roots, memberships, excluded }
    }

    /// Indices of the used points among those it was made from.
    pub fn indices(&self) -> Vec<usize> {
        let used = self.memberships.iter().enumerate();
        used.filter(|&(_, &member)| member == Membership::Used).map(|(index, _)| index).collect()
    }

    /// Distances from the axis, in mm, of the points that stand over no place of the nominal; `points` are
    /// those it was made from.
    pub(crate) fn beyond_mm(&self, points: &[PointMm], pose: &Pose) -> impl Iterator<Item = f64> {
        let motion = pose.motion();
        let pairs = points.iter().zip(&self.memberships);
        let beyond = pairs.filter(|&(_, &member)| member == Membership::OutsideDomain);
        beyond.map(move |(&point, _)| {
            let [x, y, _] = motion.to_part(point);
            x.hypot(y)
        })
    }

    /// Largest distance of a used point from the axis in mm.
    pub(crate) fn reach_mm(&self, pose: &Pose) -> f64 {
        let motion = pose.motion();
        let distance_mm = |&point: &PointMm| {
            let [x, y, _] = motion.to_part(point);
            x.hypot(y)
        };
        self.points.iter().map(distance_mm).fold(0.0, f64::max)
    }
}
