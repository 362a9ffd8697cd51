//! Defects of a surface that deviates from a nominal, looked for closely only where a quick look finds something.

use asphera_geometry::{PointMm, VertexId};
use rayon::prelude::*;

use super::cells::NONE;
use super::ring_profile::RingProfile;
use super::screen::{Parts, Screen};

use super::{
    Defect, DefectSettings, DefectsUnknown, Ground, Samples, WINDOW, by_significance, find,
    needs_noise,
};
use crate::curvature::{Adjacency, AdjacencyError};

/// A measured surface and what it deviates from its nominal.
#[derive(Clone, Copy, Debug)]
pub struct DeviatingSurface<'a> {
    /// The vertices.
    pub points: &'a [PointMm],
    /// The triangles.
    pub triangles: &'a [[VertexId; 3]],
    /// One for each vertex, in mm along the normal; not finite where it is not known: such vertices are no part of
    /// the surface.
    pub deviations_mm: &'a [f64],
    /// Place of each vertex about the axis of the part in mm, if it has one: form that is alike all round is no defect.
    pub places_mm: Option<&'a [[f64; 2]]>,
    /// The distance that vertices have on average, in mm.
    pub spacing_mm: f64,
    /// The length in mm from which on an edge bridges a gap; see [`Adjacency::new`].
    pub reach_mm: f64,
}

/// The defects of a surface that was screened first.
#[derive(Clone, Debug)]
pub struct DefectSearch {
    /// The most significant first.
    pub defects: Vec<Defect>,
    /// Standard deviation in mm of the residuals that counts as noise, of half of the surface.
    pub sigma_mm: f64,
    /// Standard deviations from which on a single residual is a defect; of the mean of some it is as many, or fewer
    /// where the tails of the noise are long.
    pub threshold: f64,
    /// Largest width of a defect in mm.
    pub largest_mm: f64,
    /// Width in mm of the windows of the reference.
    pub window_mm: f64,
    /// Vertices of the surface.
    pub vertices: u64,
    /// Vertices that were looked at closely.
    pub looked_at: u64,
    /// Vertices of which it is not known whether they are defects.
    pub unreferenced: u64,
}

/// Finds the defects of a surface with many vertices: as [`find_defects`](super::find_defects) does, but only about those places at
/// which the means and extremes of cells (`screen.rs`) hint at something.
///
/// Form that is alike all round the axis, if places about one are given, is taken off the deviations first.
///
/// The number of false defects expected is that of the whole surface. On a surface with few defects this takes
/// some 40 ns a vertex, and where half of it is suspect as long as [`find_defects`](super::find_defects). A defect that can be told by
/// means only, and hardly, may be missed: from 1.3 times the threshold on it is not. What reaches beyond the part
/// looked at is told by [`Defect::on_border`]; what lies in the rim of a part, where nothing was suspected, is none.
///
/// # Errors
///
/// As [`find_defects`](super::find_defects); a part without a reference or a known noise counts as [`DefectSearch::unreferenced`].
pub fn search_defects(
    surface: &DeviatingSurface<'_>,
    settings: &DefectSettings,
) -> Result<DefectSearch, DefectsUnknown> {
    let DeviatingSurface { points, deviations_mm, spacing_mm, .. } = *surface;
    if deviations_mm.len() != points.len() {
        return Err(DefectsUnknown::Numbers {
            points: points.len(),
            adjacency: points.len(),
            deviations: deviations_mm.len(),
        });
    }
    needs_noise(settings, points, surface.triangles)?;
    let without_rings_mm = without_rings_mm(surface);
    let surface = &DeviatingSurface {
        deviations_mm: without_rings_mm.as_deref().unwrap_or(deviations_mm),
        ..*surface
    };
    let deviations_mm = surface.deviations_mm;
    let largest_mm = settings.largest_mm.unwrap_or(DefectSettings::LARGEST_SPACINGS * spacing_mm);
    let window_mm = WINDOW * largest_mm;
    let screen = Screen {
        points,
        deviations_mm,
        spacing_mm,
        window_mm,
        sigma_mm: settings.noise.map_or(0.0, |noise| noise.sigma_mm()),
        false_expected: settings.false_expected,
    };
    let Parts { vertices: parts, used, sigma_mm, threshold, suspects, ground } = screen.parts()?;
    let triangles = triangles_of(surface, &parts)?;
    let searched: Vec<Result<(Vec<Defect>, u64), DefectsUnknown>> = parts
        .par_iter()
        .zip(&triangles)
        .with_max_len(1)
        .map(|(vertices, triangles)| {
            let share = vertices.len() as f64 / used as f64;
            let settings = DefectSettings {
                largest_mm: Some(largest_mm),
                false_expected: share * settings.false_expected,
                ..*settings
            };
            part(surface, (vertices, triangles), &settings, &ground)
        })
        .collect();
    let (mut defects, mut unreferenced) = (Vec::new(), 0);
    for found in searched {
        let (found, unknown) = found?;
        defects.extend(found.into_iter().filter(|defect| suspects.meet(&defect.bounds_mm)));
        unreferenced += unknown;
    }
    defects.sort_by(by_significance);
    Ok(DefectSearch {
        defects,
        sigma_mm,
        threshold,
        largest_mm,
        window_mm,
        vertices: used,
        looked_at: parts.iter().map(|part| part.len() as u64).sum(),
        unreferenced,
    })
}

/// Deviations without the rings about the axis; `None` where there are none, or no axis.
fn without_rings_mm(surface: &DeviatingSurface<'_>) -> Option<Vec<f64>> {
    let places_mm = surface.places_mm?;
    let profile = RingProfile::of(surface, places_mm)?;
    let without =
        |(deviation_mm, place_mm): (&f64, &[f64; 2])| deviation_mm - profile.height_mm(*place_mm);
    Some(surface.deviations_mm.iter().zip(places_mm).map(without).collect())
}

/// The triangles of each part, by the places of their corners in it.
fn triangles_of(
    surface: &DeviatingSurface<'_>,
    parts: &[Vec<VertexId>],
) -> Result<Vec<Vec<[VertexId; 3]>>, DefectsUnknown> {
    let mut triangles = vec![Vec::new(); parts.len()];
    if parts.is_empty() {
        return Ok(triangles);
    }
    let points = surface.points.len();
    let mut owner = vec![NONE; points];
    let mut number = vec![NONE; points];
    for (part, vertices) in (0..).zip(parts) {
        for (local, &vertex) in (0..).zip(vertices) {
            owner[vertex as usize] = part;
            number[vertex as usize] = local;
        }
    }
    for (triangle, &corners) in surface.triangles.iter().enumerate() {
        if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= points) {
            return Err(DefectsUnknown::Corner { triangle, corner, points });
        }
        let [a, b, c] = corners.map(|corner| owner[corner as usize]);
        if a != NONE && a == b && b == c {
            triangles[a as usize].push(corners.map(|corner| number[corner as usize]));
        }
    }
    Ok(triangles)
}

/// The defects of a part, and how many of its vertices are not known.
fn part(
    surface: &DeviatingSurface<'_>,
    (vertices, triangles): (&[VertexId], &[[VertexId; 3]]),
    settings: &DefectSettings,
    ground: &Ground,
) -> Result<(Vec<Defect>, u64), DefectsUnknown> {
    let points: Vec<PointMm> =
        vertices.iter().map(|&vertex| surface.points[vertex as usize]).collect();
    let deviations_mm: Vec<f64> =
        vertices.iter().map(|&vertex| surface.deviations_mm[vertex as usize]).collect();
    let adjacency = match Adjacency::new(&points, triangles, Some(surface.reach_mm)) {
        Ok(adjacency) => adjacency,
        Err(AdjacencyError::Reach { reach_mm }) => return Err(DefectsUnknown::Reach { reach_mm }),
        Err(AdjacencyError::Corner { triangle, corner, points }) => {
            return Err(DefectsUnknown::Corner { triangle, corner, points });
        }
    };
    let samples = Samples {
        points: &points,
        triangles,
        adjacency: &adjacency,
        deviations_mm: Some(&deviations_mm),
    };
    match find(&samples, settings, Some(ground)) {
        Ok(found) => Ok((found.defects, found.unreferenced)),
        Err(
            DefectsUnknown::NoArea
            | DefectsUnknown::Scattered { .. }
            | DefectsUnknown::NoReference { .. }
            | DefectsUnknown::Noise(_),
        ) => Ok((Vec::new(), vertices.len() as u64)),
        Err(other) => Err(other),
    }
}

#[cfg(test)]
mod tests;
