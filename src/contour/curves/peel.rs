//! Peel: long edges of triangles go, then all but two at a sample.

use crate::triangulation::EdgeId;
use crate::{Graph, SampleId, Triangulation};

/// Peel: every edge that is a longest side of a triangle goes. Of the rest an edge stays if at both of its ends fewer than
/// two of the rest are shorter.
///
/// With δ > 0 samples with a single edge of length L then get their shortest missing Delaunay edge below δ·L, which
/// restores crossings. Nothing is proven of it here. A. D. Parakkat, S. Methirumangalath, R. Muthuganapathy, *Peeling the
/// longest*, Computers & Graphics 74 (2018) 33-43, as its public program works. Lengths are compared exactly, those with
/// δ in doubles. Linear time after the order of lengths.
///
/// # Panics
///
/// If δ is negative or not finite.
pub fn peel(triangulation: &Triangulation, delta: f64) -> Graph {
    assert!(delta.is_finite() && delta >= 0.0, "expected a finite δ of at least 0, found {delta}");
    let mut stays = vec![true; triangulation.edges().len()];
    for sides in
        (0..triangulation.triangles().len()).map(|triangle| triangulation.sides(triangle as u32))
    {
        let classes = sides.map(|side| triangulation.length_class(side));
        let longest = classes.into_iter().fold(0, u32::max);
        for (side, class) in sides.into_iter().zip(classes) {
            stays[side as usize] &= class != longest;
        }
    }
    let is_among_two = |sample: SampleId, edge: EdgeId| {
        let class = triangulation.length_class(edge);
        let shorter = triangulation.spokes(sample).iter().filter(|spoke| {
            stays[spoke.edge as usize] && triangulation.length_class(spoke.edge) < class
        });
        shorter.take(2).count() < 2
    };
    let kept: Vec<bool> = (0..triangulation.edges().len() as EdgeId)
        .map(|edge| {
            stays[edge as usize]
                && triangulation.ends(edge).into_iter().all(|end| is_among_two(end, edge))
        })
        .collect();
    let mut edges: Vec<[SampleId; 2]> = (0..)
        .zip(&kept)
        .filter(|&(_, &is_kept)| is_kept)
        .map(|(edge, _)| triangulation.ends(edge))
        .collect();
    if delta > 0.0 {
        edges.extend(restored(triangulation, &kept, delta));
    }
    Graph::new(edges)
}

/// The edges that samples with a single one get back.
fn restored<'a>(
    triangulation: &'a Triangulation,
    kept: &'a [bool],
    delta: f64,
) -> impl Iterator<Item = [SampleId; 2]> + 'a {
    (0..triangulation.len() as SampleId).filter_map(move |sample| {
        let (own, absent): (Vec<_>, Vec<_>) =
            triangulation.spokes(sample).iter().partition(|spoke| kept[spoke.edge as usize]);
        let [only]: [&crate::Spoke] = own[..] else { return None };
        let reach_mm = delta * triangulation.length_mm(only.edge);
        let shortest = absent
            .into_iter()
            .min_by_key(|spoke| (triangulation.length_class(spoke.edge), spoke.to))?;
        (triangulation.length_mm(shortest.edge) < reach_mm).then_some([sample, shortest.to])
    })
}
