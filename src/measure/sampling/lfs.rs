//! The local feature size of a part: that of its nominal, kept for the next look, or that of the points.
//!
//! [`Remembered::look`] alone decides which of them stands for a part. The sampling report and `asphera reduce` both
//! ask it, so that the one finds what the other made.

use asphera_form::Pose;
use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::freeform::{Footprint, Freeform};
use super::measured::{Cells, Measured, Readings, measured};
use super::meridian::Meridian;
use super::{CHUNK, Sampled};
use crate::Part;

/// The local feature size of a part that was looked at before, for the next look.
#[derive(Clone, Debug, Default)]
pub struct Remembered(pub(super) Known);

/// Sources of a local feature size.
#[derive(Clone, Debug, Default)]
pub(super) enum Known {
    #[default]
    Nothing,
    /// That of a nominal of revolution, over a disc of this radius in mm.
    Nominal { radius_mm: f64, meridian: Meridian },
    /// That of a freeform nominal.
    Freeform(Freeform),
    /// That of the points, at places of the plane.
    Points(Lfs),
}

impl Remembered {
    /// That of a part at `pose`, at places of the plane; `None` where it is not known.
    pub fn lfs_mm(&self, pose: &Pose) -> impl Fn(f64, f64) -> Option<f64> + use<'_> {
        let (tx, ty) = (pose.tx_mm, pose.ty_mm);
        let [[ax, bx, _], [ay, by, _], _] = pose.rotation();
        // Tilts of a part are small, so the place is only shifted, and turned about z; a local feature size
        // changes by no more than the way between.
        move |x, y| match &self.0 {
            Known::Nothing => None,
            Known::Nominal { meridian, .. } => {
                let (x, y) = (x - tx, y - ty);
                // Not hypot, which is slower: a place of a mesh neither overflows nor vanishes.
                meridian.at((x * x + y * y).sqrt())
            }
            Known::Freeform(freeform) => {
                let (x, y) = (x - tx, y - ty);
                freeform.at(ax * x + ay * y, bx * x + by * y)
            }
            Known::Points(lfs) => lfs.at(x, y),
        }
    }

    /// Looks for that of a part at its pose: of its nominal, unless that is known from before, else of the points.
    /// Without a part it is of the points. Says where it comes from: `nominal`, or as [`Lfs::of_points`] does. Fails
    /// with the reason in words; then nothing is known.
    pub(super) fn look(
        &mut self,
        laid: Option<(&Part, &Pose)>,
        sampled: Sampled<'_>,
        readings: Result<Readings, String>,
        reach_mm: Result<f64, String>,
    ) -> Result<&'static str, String> {
        let designed = laid.filter(|(part, _)| part.reference.is_none());
        let looked = designed.map(|(part, pose)| {
            let points = sampled.mesh.points();
            (part.nominal.is_rotational(), self.look_at_nominal(part, points, pose))
        });
        let found = match looked {
            Some((_, Ok(()))) => return Ok("nominal"),
            Some((true, Err(why))) => Err(why),
            // No design, or a freeform finer than a raster shows: the points tell more.
            Some((false, Err(_))) | None => Lfs::of_points(sampled, readings, reach_mm),
        };
        let (known, source) = match found {
            Ok((lfs, source)) => (Known::Points(lfs), Ok(source)),
            Err(why) => (Known::Nothing, Err(why)),
        };
        self.0 = known;
        source
    }

    /// Looks for that of the nominal, unless it is known. Fails with the reason in words.
    pub(super) fn look_at_nominal(
        &mut self,
        part: &Part,
        points: &[PointMm],
        pose: &Pose,
    ) -> Result<(), String> {
        if part.nominal.freeform().is_some() {
            return self.look_at_freeform(part, points, pose);
        }
        let radius_mm = part.aperture.reach_mm().unwrap_or_else(|| reach_mm_of(points, pose));
        if matches!(&self.0, Known::Nominal { radius_mm: known, .. } if *known == radius_mm) {
            return Ok(());
        }
        self.0 = Known::Nothing;
        let meridian = Meridian::of(&part.nominal, radius_mm)
            .map_err(|error| format!("the nominal has no local feature size: {error}"))?;
        self.0 = Known::Nominal { radius_mm, meridian };
        Ok(())
    }

    /// The same of a freeform.
    fn look_at_freeform(
        &mut self,
        part: &Part,
        points: &[PointMm],
        pose: &Pose,
    ) -> Result<(), String> {
        let footprint = Footprint::of(&part.aperture, points, pose);
        if matches!(&self.0, Known::Freeform(known) if *known.footprint() == footprint) {
            return Ok(());
        }
        self.0 = Known::Nothing;
        let freeform = Freeform::of(&part.nominal, footprint)
            .map_err(|error| format!("the nominal has no local feature size: {error}"))?;
        self.0 = Known::Freeform(freeform);
        Ok(())
    }
}

/// The local feature size of points.
#[derive(Clone, Debug)]
pub(super) enum Lfs {
    Cells(Cells),
    Everywhere(f64),
}

impl Lfs {
    /// What the points say, and where they say it from: `measured` of medial balls, `curvature` where noise
    /// or wrong readings leave no more than a bound. Fails with the reason in words.
    fn of_points(
        sampled: Sampled<'_>,
        readings: Result<Readings, String>,
        reach_mm: Result<f64, String>,
    ) -> Result<(Lfs, &'static str), String> {
        let found = match (readings, reach_mm) {
            (Ok(readings), Ok(reach_mm)) => {
                measured(sampled.mesh.points(), sampled.triangles, readings, reach_mm)
            }
            _ => Err("the noise is not known".to_owned()),
        };
        match found {
            Ok(Measured::Balls(cells)) => Ok((Lfs::Cells(cells), "measured")),
            Ok(Measured::Curvature(radius_mm)) => Ok((Lfs::Everywhere(radius_mm), "curvature")),
            Err(why) => Err(format!("the local feature size is not known: {why}")),
        }
    }

    /// At a place of the plane, in mm.
    fn at(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        match self {
            Lfs::Cells(cells) => cells.at(x_mm, y_mm),
            Lfs::Everywhere(mm) => Some(*mm),
        }
    }
}

/// The largest distance of a point from the axis in mm.
fn reach_mm_of(points: &[PointMm], pose: &Pose) -> f64 {
    let distance_mm = |point: &PointMm| (point[0] - pose.tx_mm).hypot(point[1] - pose.ty_mm);
    points.par_iter().with_min_len(CHUNK).map(distance_mm).reduce(|| 0.0, f64::max)
}
