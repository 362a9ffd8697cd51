//! Cocone by cells of an octree, so that no triangulation of all points is needed.
//!
//! Localized Cocone (T. K. Dey, R. Dyer, L. Wang 2011, "Localized Cocone surface reconstruction") proves
//! that cells with enough surroundings give the surface of Cocone. Here each cell has a certificate: the Voronoi cells of
//! its points are those of all points. Super Cocone (T. K. Dey, J. Giesen, J. Hudson 2001, "Delaunay based shape reconstruction from large data")
//! trusts a margin instead. Facets that meet cocones of all three corners are then pruned, and one layer is taken, as in [`super::cocone`].

use asphera_geometry::{PointMm, WeightedTree};
use rayon::prelude::*;

use super::candidates::flat_points;
use super::cell::{CellFindings, Meeting, Surroundings};
use super::sheets::Sheets;
use super::{COCONE_BOUND, Cocone, layer, octree};
use crate::delaunay::{INFINITE, NoDelaunay, check_span};
use crate::neighbours::Neighbours;
use crate::poles::Poles;
use crate::reach::REACH;
use crate::sampling::SamplingCondition;
use crate::surface::{LeftOut, admitted, of_numbered};

/// A surface by cocones in cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CellCocone {
    /// The surface and its figures, as of Cocone.
    pub cocone: Cocone,
    /// Cells of the octree.
    pub cells: usize,
    /// How often points were missing in the surroundings of a cell.
    pub rounds: usize,
}

/// How many points a cell of an octree holds at most, if nothing else is asked.
pub const POINTS_IN_CELL: usize = 20_000;

/// Reconstructs a surface by cocones, in cells of at most so many points whose surroundings are proven to be enough.
///
/// # Errors
///
/// Points that do not span space.
pub fn loc_cocone(points_mm: &[PointMm], most_in_cell: usize) -> Result<CellCocone, NoDelaunay> {
    by_cells(points_mm, most_in_cell, true)
}

/// Reconstructs a surface by cocones, in cells of at most so many points with a margin about them.
///
/// # Errors
///
/// Points that do not span space.
pub fn super_cocone(points_mm: &[PointMm], most_in_cell: usize) -> Result<CellCocone, NoDelaunay> {
    by_cells(points_mm, most_in_cell, false)
}

fn by_cells(
    points_mm: &[PointMm],
    most_in_cell: usize,
    is_certified: bool,
) -> Result<CellCocone, NoDelaunay> {
    let (numbered, left_out) = admitted(points_mm);
    check_span(&numbered)?;
    let ids: Vec<u32> = numbered.iter().map(|&(_, id)| id).collect();
    let places_mm: Vec<PointMm> = numbered.into_iter().map(|(place, _)| place).collect();
    let cells = octree::leaves(&places_mm, most_in_cell);
    let surroundings = Surroundings {
        places_mm: &places_mm,
        tree: &WeightedTree::of_points(&places_mm),
        sample: &sample(&places_mm),
        reach_mm: &reaches(&places_mm),
        is_certified,
    };
    let found: Vec<CellFindings> =
        cells.par_iter().map(|own| surroundings.examine(own)).collect::<Result<_, _>>()?;
    let rounds = found.iter().map(|cell| cell.rounds).sum();
    let (poles, meetings) = merged(places_mm.len(), found);
    let (facets, reaches) = by_facet(meetings);
    let flat = flat_points(&places_mm, &poles, &facets, &reaches);
    let candidates: Vec<[u32; 3]> = (facets.into_iter().zip(reaches))
        .filter(|(_, reaches)| reaches.iter().all(|&reach| reach >= 0.0))
        .map(|(facet, _)| facet)
        .collect();
    let count = candidates.len();
    let mut sheets = Sheets::of(&places_mm, candidates);
    sheets.prune(&flat);
    let pruned = sheets.is_present.iter().filter(|&&is_present| is_present).count();
    let facets = layer::outer(&sheets);
    let cocone = Cocone {
        candidates: count,
        pruned,
        not_flat: flat.iter().filter(|&&flat| !flat).count(),
        sampling: SamplingCondition::of(&places_mm, &poles, &facets, COCONE_BOUND),
        surface: of_numbered(points_mm, &ids, left_out, facets, LeftOut::NoFacet),
    };
    Ok(CellCocone { cocone, cells: cells.len(), rounds })
}

/// Normals and poles by point, and the meetings of all cells.
fn merged(points: usize, cells: Vec<CellFindings>) -> (Poles, Vec<Meeting>) {
    let mut poles = Poles {
        normals: vec![None; points],
        first: vec![None; points],
        second: vec![None; points],
        cells: vec![[INFINITE; 2]; points],
    };
    let mut meetings = Vec::new();
    for cell in cells {
        for (number, normal, [first, second]) in cell.points {
            let at = number as usize;
            poles.normals[at] = normal;
            poles.first[at] = first;
            poles.second[at] = second;
        }
        meetings.extend(cell.meetings);
    }
    (poles, meetings)
}

/// Facets, and how far each reaches in the cocones of its corners; below 0 where it does not meet one.
fn by_facet(mut meetings: Vec<Meeting>) -> (Vec<[u32; 3]>, Vec<[f64; 3]>) {
    meetings.par_sort_unstable_by_key(|meeting| (meeting.facet, meeting.corner));
    let groups = meetings.chunk_by(|one, other| one.facet == other.facet);
    groups
        .map(|group| {
            let mut reaches = [-1.0; 3];
            for meeting in group {
                reaches[meeting.corner as usize] = meeting.reach_mm;
            }
            (group[0].facet, reaches)
        })
        .unzip()
}

/// How far each point sees: 2.3 times the distance of its 16th neighbour.
fn reaches(places_mm: &[PointMm]) -> Vec<f64> {
    let tree = Neighbours::of(places_mm.iter().copied().zip(0..).collect());
    let far = tree.map_nearest(16, |_, near, _: &mut ()| near.last().map_or(0.0, |near| near.0));
    let mut reaches = vec![0.0; far.len()];
    for (&at, far) in tree.ids.iter().zip(far) {
        reaches[at as usize] = REACH * far.sqrt();
    }
    reaches
}

/// A few of all points, drawn by their coordinates, with the outermost along the axes.
fn sample(places_mm: &[PointMm]) -> Vec<u32> {
    let every = (places_mm.len() / SAMPLE).max(1) as u64;
    let mut sample: Vec<u32> = (0..)
        .zip(places_mm)
        .filter(|(_, place)| crate::draw::bits(**place, 0, true).is_multiple_of(every))
        .map(|(at, _)| at)
        .collect();
    for axis in 0..3 {
        let by = |one: &u32, other: &u32| {
            places_mm[*one as usize][axis].total_cmp(&places_mm[*other as usize][axis])
        };
        sample.extend((0..places_mm.len() as u32).min_by(by));
        sample.extend((0..places_mm.len() as u32).max_by(by));
    }
    sample.sort_unstable();
    sample.dedup();
    sample
}

/// About so many points stand for all others.
const SAMPLE: usize = 1_000;
