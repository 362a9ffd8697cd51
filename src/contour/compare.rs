//! How far two outcomes differ: distances of curves, areas of regions, edges in common.

mod overlap;

use asphera_geometry::WeightedTree;

pub use self::overlap::{IouError, intersection_over_union};
use crate::polylines::Polylines;
use crate::{Graph, PlaceMm};

/// Distances between two sets of places, each to the nearest place of the other set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// The largest of them in mm (Hausdorff).
    pub hausdorff_mm: f64,
    /// Their root mean square in mm, those of both directions together.
    pub rms_mm: f64,
}

impl Deviation {
    /// The deviation of two sets of places; none if one is empty. n·log n time.
    pub fn between(a: &[PlaceMm], b: &[PlaceMm]) -> Option<Deviation> {
        let tree =
            |places: &[PlaceMm]| WeightedTree::new(places.iter().map(|&[x, y]| ([x, y, 0.0], 0.0)));
        let [to_a, to_b] = [tree(a), tree(b)];
        let forth = a.iter().map(|&[x, y]| to_b.least([x, y, 0.0]));
        let back = b.iter().map(|&[x, y]| to_a.least([x, y, 0.0]));
        if a.is_empty() || b.is_empty() {
            return None;
        }
        Deviation::of(&forth.chain(back).collect::<Option<Vec<f64>>>()?)
    }

    /// The deviation of two sets of lines, from every corner of each to the nearest place on the lines of the other; none if
    /// one has no corner. n·log n time.
    ///
    /// A line is its corners in mm and whether the last is joined to the first. A line may lie farther from the other
    /// within a side than at its corners only where the other bends: sides much longer than that hide it.
    pub fn between_lines(
        a: &[(Vec<PlaceMm>, bool)],
        b: &[(Vec<PlaceMm>, bool)],
    ) -> Option<Deviation> {
        let [to_a, to_b] = [Polylines::new(a), Polylines::new(b)];
        let forth = a.iter().flat_map(|(places, _)| places).map(|&place| to_b.distance_mm(place));
        let back = b.iter().flat_map(|(places, _)| places).map(|&place| to_a.distance_mm(place));
        Deviation::of(&forth.chain(back).collect::<Option<Vec<f64>>>()?)
    }

    fn of(distances_mm: &[f64]) -> Option<Deviation> {
        if distances_mm.is_empty() {
            return None;
        }
        let squares: f64 = distances_mm.iter().map(|distance| distance * distance).sum();
        Some(Deviation {
            hausdorff_mm: distances_mm.iter().copied().fold(0.0, f64::max),
            rms_mm: (squares / distances_mm.len() as f64).sqrt(),
        })
    }
}

/// Edges that two graphs over the same samples have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Share of the found edges that are true; 1 if none was found.
    pub precision: f64,
    /// Share of the true edges that were found; 1 if there are none.
    pub recall: f64,
}

/// The agreement of a found graph with the true one.
pub fn agreement(found: &Graph, truth: &Graph) -> Agreement {
    let common = found.edges().iter().filter(|&&[p, q]| truth.joins(p, q)).count() as f64;
    let share = |of: &Graph| match of.edges().len() {
        0 => 1.0,
        count => common / count as f64,
    };
    Agreement { precision: share(found), recall: share(truth) }
}
