//! Which vertices lie alike beside the border of a surface.
//!
//! An edge that is turned down over a few spacings is form no window follows. It is alike along the border, so what
//! stands off there is held against the vertices as near to the border, over some way along it.

use asphera_geometry::{PointMm, VertexId};

use super::tail;
use crate::curvature::Adjacency;

/// Vertices by how near to the border they are and by squares of the plane.
pub(super) struct RimZones {
    /// By vertex; 0 is far from the border.
    zone: Vec<u32>,
    count: usize,
}

impl RimZones {
    /// Zones of the vertices that are `used`, for points of a spacing.
    pub(super) fn new(
        points: &[PointMm],
        adjacency: &Adjacency,
        used: &[bool],
        spacing_mm: f64,
    ) -> RimZones {
        let mut ring = vec![usize::MAX; points.len()];
        let mut last: Vec<VertexId> = (0..points.len() as VertexId)
            .filter(|&vertex| used[vertex as usize] && adjacency.on_border(vertex))
            .collect();
        last.iter().for_each(|&vertex| ring[vertex as usize] = 0);
        for step in 1..BAND_OF.len() {
            let mut next = Vec::new();
            for &vertex in &last {
                for &other in adjacency.neighbours(vertex) {
                    if ring[other as usize] == usize::MAX {
                        ring[other as usize] = step;
                        next.push(other);
                    }
                }
            }
            last = next;
        }
        let low = low_mm(points, used);
        let near = || (0..points.len()).filter(|&vertex| ring[vertex] < BAND_OF.len());
        let mut squares: Vec<(i64, i64, usize, usize)> = near()
            .map(|vertex| {
                let [x, y, _] = points[vertex];
                let [column, row] =
                    [x - low[0], y - low[1]].map(|at| (at / (WAY * spacing_mm)) as i64);
                (column, row, BAND_OF[ring[vertex]], vertex)
            })
            .collect();
        squares.sort_unstable();
        let mut zone = vec![0; points.len()];
        let mut count = 1;
        for alike in squares.chunk_by(|p, q| (p.0, p.1, p.2) == (q.0, q.1, q.2)) {
            if alike.len() >= LEAST {
                alike.iter().for_each(|&(.., vertex)| zone[vertex] = count);
                count += 1;
            }
        }
        RimZones { zone, count: count as usize }
    }

    pub(super) fn of(&self, vertex: usize) -> usize {
        self.zone[vertex] as usize
    }

    /// By zone, how much larger a statistic is there than normal of deviation 1; 1 where it hardly is.
    pub(super) fn factors(&self, statistic: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sizes = vec![Vec::new(); self.count];
        for (vertex, &zone) in self.zone.iter().enumerate().filter(|&(_, &zone)| zone > 0) {
            let size = statistic(vertex).abs();
            if size.is_finite() {
                sizes[zone as usize].push(size);
            }
        }
        sizes
            .iter_mut()
            .map(|sizes| tail::scale(sizes).filter(|&scale| scale > PLAIN).unwrap_or(1.0))
            .collect()
    }
}

/// The least coordinates of the vertices that are used.
fn low_mm(points: &[PointMm], used: &[bool]) -> [f64; 2] {
    let used = points.iter().zip(used).filter(|&(_, &used)| used);
    used.fold([f64::INFINITY; 2], |low, (point, _)| [low[0].min(point[0]), low[1].min(point[1])])
}

/// By rings from the border on, which band it is.
const BAND_OF: [usize; 7] = [0, 0, 1, 1, 2, 2, 2];
/// Side of a square in spacings: a pit as wide as twenty covers less than a fifth of a band in it.
const WAY: f64 = 120.0;
/// Fewest vertices of a zone.
const LEAST: usize = 60;
/// A scale up to which a zone is like any other.
const PLAIN: f64 = 1.3;
