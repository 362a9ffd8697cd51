//! The sampling of a profile: how much of its line in the aperture is covered.

use asphera_form::{Aperture, Fit};
use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_report::SamplingFigures;

use super::WHY;
use super::along::{self, Coverage, Station};
use super::line::{Line, chord};
use crate::Part;
use crate::details::places_mm;

/// The sampling along the line.
pub(super) fn sampled(
    mesh: &Mesh,
    part: &Part,
    line: &Line,
    fit: Option<&Fit>,
    stations: &[Station],
) -> (SamplingFigures, Option<Coverage>) {
    let s_mm: Vec<f64> = stations.iter().map(|station| station.s_mm).collect();
    let (Some(&first), Some(&last)) = (s_mm.first(), s_mm.last()) else {
        return (SamplingFigures::default(), None);
    };
    let pose = fit.map(|fit| fit.pose).unwrap_or_default();
    let nominal = fit.map_or(&part.nominal, |fit| &fit.nominal);
    // Place in the part frame against s, a straight line.
    let places = places_mm(&pose, mesh.points());
    let end = |s: f64| {
        let at = mesh.points().iter().zip(&places);
        at.min_by(|(a, _), (b, _)| {
            let off = |point: &PointMm| (line.along_mm([point[0], point[1]]) - s).abs();
            off(a).total_cmp(&off(b))
        })
    };
    let (Some((_, from)), Some((_, to))) = (end(first), end(last)) else {
        return (SamplingFigures::default(), None);
    };
    let step = [0, 1].map(|axis| (to[axis] - from[axis]) / (last - first));
    let start = [0, 1].map(|axis| from[axis] - first * step[axis]);
    let pieces = chord(&part.aperture, start, step, [first, last]);
    let spacing_mm = along::median_spacing_mm(&s_mm);
    let mean_mm = (last - first) / (s_mm.len() - 1) as f64;
    let gap_limit_mm = part.gap_limit_mm.unwrap_or(4.0 * mean_mm);
    let lfs_mm = |s: f64| {
        let [x, y] = [0, 1].map(|axis| start[axis] + s * step[axis]);
        nominal.lfs_bound_at_mm(x, y).unwrap_or(f64::INFINITY)
    };
    let share = part.epsilon_limit.or(part.rho_limit).unwrap_or(f64::INFINITY);
    let found = along::coverage(&pieces, &s_mm, spacing_mm, |s| {
        let lfs_mm = lfs_mm(s);
        (gap_limit_mm.min(share * lfs_mm), lfs_mm)
    });
    let mut unknown = vec![WHY.to_owned()];
    if fit.is_none() && part.aperture != Aperture::None {
        unknown.insert(0, "without a fit the place of the part is unknown".to_owned());
    }
    let is_known = found.length_mm > 0.0 && (fit.is_some() || part.aperture == Aperture::None);
    if found.length_mm <= 0.0 {
        unknown.insert(0, "the line does not cross the aperture".to_owned());
    }
    let figures = SamplingFigures {
        lfs_source: Some("curvature".to_owned()),
        gap_max_mm: Some(found.gap_max_mm),
        gap_limit_mm: Some(gap_limit_mm),
        epsilon_target: part.epsilon_limit,
        epsilon_max: Some(found.epsilon_max),
        rho_target: part.rho_limit,
        coverage: is_known.then(|| (found.covered_mm / found.length_mm).min(1.0)),
        spacing_median_mm: Some(spacing_mm),
        unknown,
        as_of_points: mesh.counts().pushed,
        ..SamplingFigures::default()
    };
    (figures, is_known.then_some(found))
}
