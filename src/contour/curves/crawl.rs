//! Crawl: chains grown through nearest neighbours.

use crate::{Graph, SampleId, Spoke, Triangulation};

/// Crawl: a chain begins with the shortest edge to a nearest neighbour and grows at the end with the nearer unvisited
/// Delaunay neighbour. It closes where one end is the second nearest Delaunay neighbour of the other, from six samples
/// on, or from three on if nothing is left to grow to.
///
/// No parameter; several curves, open and closed. Nothing is proven of it here. A. D. Parakkat, R. Muthuganapathy, *Crawl
/// through neighbors*, Computers & Graphics 58 (2016) 129-135, as its public program works; that leaves shorter chains open,
/// so closing those is our reading. n·log n time, as chains only go forward.
pub fn crawl(triangulation: &Triangulation) -> Graph {
    let mut visited = vec![false; triangulation.len()];
    let mut edges = Vec::new();
    for &seed in triangulation.by_length() {
        let ends = triangulation.ends(seed);
        if ends.iter().any(|&end| visited[end as usize]) || !joins_nearest(triangulation, ends) {
            continue;
        }
        edges.push(ends);
        for end in ends {
            visited[end as usize] = true;
        }
        grow(triangulation, ends, &mut visited, &mut edges);
    }
    Graph::new(edges)
}

/// Whether one of two samples is the nearest of the other.
fn joins_nearest(triangulation: &Triangulation, [p, q]: [SampleId; 2]) -> bool {
    let is_nearest = |of: SampleId, other: SampleId| {
        triangulation.nearest(of).is_some_and(|nearest| nearest.to == other)
    };
    is_nearest(p, q) || is_nearest(q, p)
}

/// Grows a chain from its first two samples until it closes or nothing is left at its ends.
fn grow(
    triangulation: &Triangulation,
    mut ends: [SampleId; 2],
    visited: &mut [bool],
    edges: &mut Vec<[SampleId; 2]>,
) {
    let mut length = 2;
    loop {
        let [p, q] = ends;
        let is_second =
            |of, other| second(triangulation, of).is_some_and(|spoke| spoke.to == other);
        let may_close = length >= 3 && (is_second(p, q) || is_second(q, p));
        if may_close && length >= LEAST_CLOSED {
            edges.push(ends);
            return;
        }
        let onward = ends.map(|end| {
            let unvisited =
                triangulation.spokes(end).iter().filter(|spoke| !visited[spoke.to as usize]);
            unvisited
                .min_by_key(|spoke| (triangulation.length_class(spoke.edge), spoke.to))
                .copied()
        });
        let key = |side: usize| {
            onward[side].map(|spoke| (triangulation.length_class(spoke.edge), spoke.to))
        };
        // An end without a neighbour left gives way to the other.
        let side = match (key(0), key(1)) {
            (None, None) => {
                edges.extend(may_close.then_some(ends));
                return;
            }
            (Some(_), None) => 0,
            (None, Some(_)) => 1,
            (Some(left), Some(right)) => usize::from(right < left),
        };
        if let Some(Spoke { to, .. }) = onward[side] {
            edges.push([ends[side], to]);
            visited[to as usize] = true;
            ends[side] = to;
            length += 1;
        }
    }
}

/// The way to the second nearest Delaunay neighbour.
fn second(triangulation: &Triangulation, sample: SampleId) -> Option<Spoke> {
    let nearest = triangulation.nearest(sample)?;
    let others = triangulation.spokes(sample).iter().filter(|spoke| spoke.to != nearest.to);
    others.min_by_key(|spoke| (triangulation.length_class(spoke.edge), spoke.to)).copied()
}

/// Least samples of a closed chain: the two of its first edge and four more, by the public program. Noise closes smaller ones.
const LEAST_CLOSED: usize = 6;
