//! What is told of the cells of the map after a change of the parameters.

use super::{Cell, Linearised};
use crate::deviation::NM_PER_MM;
use crate::fit::model::Model;
use crate::live::problem::dot;
use crate::live::{Grid, Map};
use crate::{Figures, Nominal, PointMm, Pose};

impl Linearised {
    /// The extremes are measured anew, without linearisation, at the estimated pose.
    pub(super) fn figures(
        &self,
        nominal: &Nominal,
        pose: &Pose,
        rms_mm: f64,
        count: usize,
    ) -> Option<Figures> {
        let model = Model::new(nominal, pose, &[]);
        let candidates = self.cells.iter().flatten().flat_map(|cell| [cell.low, cell.high]);
        let mut extremes: Option<[(f64, PointMm); 2]> = None;
        for point in candidates {
            let Some(distance_mm) = model.distance_mm(point) else { continue };
            let here = (distance_mm, point);
            let [low, high] = extremes.get_or_insert([here, here]);
            if here.0 < low.0 {
                *low = here;
            }
            if here.0 > high.0 {
                *high = here;
            }
        }
        let [low, high] = extremes?;
        Some(Figures {
            pv_nm: (high.0 - low.0) * NM_PER_MM,
            rms_nm: rms_mm * NM_PER_MM,
            max_nm: high.0 * NM_PER_MM,
            min_nm: low.0 * NM_PER_MM,
            at_max_mm: model.motion.to_part(high.1),
            at_min_mm: model.motion.to_part(low.1),
            count,
        })
    }

    /// The mean square of each cell of the map: that of its mean now, and how its points scattered about their
    /// mean at the reference, for which the pose has moved too little since to matter.
    pub(super) fn mean_squares_nm2(&self, grid: &Grid, change: &[f64], bends: &[f64]) -> Vec<f64> {
        let p = change.len();
        let cells = self.cells[..grid.cells()].iter().zip(bends.chunks_exact(p + 1));
        let mean_square = |(cell, bend): (&Option<Cell>, &[f64])| {
            let Some(cell) = cell else { return f64::NAN };
            let count = cell.count as f64;
            let (before_mm, moved_mm) = (cell.sums[p] / count, dot(&cell.sums, change) / count);
            let scatter_mm2 = (cell.square_mm2 / count - before_mm * before_mm).max(0.0);
            ((before_mm + moved_mm + bend[p]).powi(2) + scatter_mm2) * NM_PER_MM * NM_PER_MM
        };
        cells.map(mean_square).collect()
    }

    /// The highest and the lowest point of each block of `side` by `side` cells, by the distances at the
    /// reference; measured frame.
    pub(crate) fn extremes(&self, grid: &Grid, side: usize) -> Vec<PointMm> {
        let columns = grid.nx.div_ceil(side);
        let mut blocks: Vec<Option<&Cell>> = vec![None; columns * grid.ny.div_ceil(side)];
        let mut highest = blocks.clone();
        for (index, cell) in self.cells[..grid.cells()].iter().enumerate() {
            let Some(cell) = cell else { continue };
            let block = index / grid.nx / side * columns + index % grid.nx / side;
            if blocks[block].is_none_or(|lowest| cell.low_mm < lowest.low_mm) {
                blocks[block] = Some(cell);
            }
            if highest[block].is_none_or(|highest| cell.high_mm > highest.high_mm) {
                highest[block] = Some(cell);
            }
        }
        let lowest = blocks.into_iter().flatten().map(|cell| cell.low);
        lowest.chain(highest.into_iter().flatten().map(|cell| cell.high)).collect()
    }

    pub(super) fn map(&self, grid: &Grid, pose: &Pose, change: &[f64], bends: &[f64]) -> Map {
        let p = change.len();
        let motion = pose.motion();
        let cells = &self.cells[..grid.cells()];
        let mean_nm = |(cell, bend): (&Option<Cell>, &[f64])| {
            cell.as_ref().map_or(f64::NAN, |cell| {
                let sum_mm = cell.sums[p] + dot(&cell.sums, change);
                (sum_mm / cell.count as f64 + bend[p]) * NM_PER_MM
            })
        };
        let centroid_mm = |cell: &Option<Cell>| {
            cell.as_ref().map_or([f64::NAN; 2], |cell| {
                let [x, y, _] = motion.to_part(cell.point_sum_mm.map(|s| s / cell.count as f64));
                [x, y]
            })
        };
        Map {
            grid: *grid,
            mean_nm: cells.iter().zip(bends.chunks_exact(p + 1)).map(mean_nm).collect(),
            counts: cells.iter().map(|cell| cell.as_ref().map_or(0, |cell| cell.count)).collect(),
            centroids_mm: cells.iter().map(centroid_mm).collect(),
        }
    }
}
