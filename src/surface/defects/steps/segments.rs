//! The segments of a line of crests, and the samples about each.

use asphera_geometry::PointMm;

use super::super::cells::Cells;
use super::super::line::local_mm;
use super::super::reference::Reference;
use super::super::shape::principal;
use super::{Jump, WIDE, place};

/// A line of cells, cut into segments of one length.
pub(super) struct Segments {
    pub(super) origin_mm: [f64; 2],
    /// The higher side lies to the left.
    pub(super) along: [f64; 2],
    /// Where the first begins, in mm along the line.
    first_mm: f64,
    /// The length of the line.
    pub(super) length_mm: f64,
    /// The length of each.
    pub(super) segment_mm: f64,
    /// The median of the offsets of its cells; `None` without one.
    pub(super) middle_mm: Vec<Option<f64>>,
}

impl Segments {
    /// `None` where the cells lie on no line or one below `least_mm` in length.
    pub(super) fn new(
        cells: &Cells,
        jumps: &[Option<Jump>],
        crests: &[usize],
        least_mm: f64,
    ) -> Option<Segments> {
        let places: Vec<[f64; 2]> = crests.iter().map(|&cell| cells.centre_mm(cell)).collect();
        let count = places.len() as f64;
        let origin_mm =
            [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count);
        let mut along = principal(
            places.iter().map(|place| ([place[0] - origin_mm[0], place[1] - origin_mm[1]], 1.0)),
        )?
        .direction;
        let uphill = crests
            .iter()
            .filter_map(|&cell| jumps[cell])
            .fold([0.0; 2], |sum, jump| [sum[0] + jump.uphill[0], sum[1] + jump.uphill[1]]);
        if uphill[1] * along[0] - uphill[0] * along[1] < 0.0 {
            along = along.map(|part| -part);
        }
        let local: Vec<[f64; 2]> =
            places.iter().map(|&place| local_mm(origin_mm, along, place)).collect();
        let ways = || local.iter().map(|place| place[0]);
        let first_mm = ways().fold(f64::INFINITY, f64::min) - 0.5 * cells.side_mm;
        let last_mm = ways().fold(f64::NEG_INFINITY, f64::max) + 0.5 * cells.side_mm;
        let length_mm = last_mm - first_mm;
        if length_mm < least_mm {
            return None;
        }
        let count = (length_mm / (SEGMENT * cells.side_mm)).round().max(1.0) as usize;
        let segment_mm = length_mm / count as f64;
        let middle_mm = Vec::new();
        let mut segments =
            Segments { origin_mm, along, first_mm, length_mm, segment_mm, middle_mm };
        let mut offsets: Vec<Vec<f64>> = vec![Vec::new(); count];
        for &[way, offset] in &local {
            offsets[(segments.index(way).max(0.0) as usize).min(count - 1)].push(offset);
        }
        let middle_mm = offsets.into_iter().map(|mut offsets| {
            let middle = offsets.len() / 2;
            (!offsets.is_empty()).then(|| *offsets.select_nth_unstable_by(middle, f64::total_cmp).1)
        });
        segments.middle_mm = middle_mm.collect();
        Some(segments)
    }

    pub(super) fn count(&self) -> usize {
        self.middle_mm.len()
    }

    /// The segment at a place along the line; beyond its ends there is none of that number.
    fn index(&self, way_mm: f64) -> f64 {
        ((way_mm - self.first_mm) / self.segment_mm).floor()
    }

    /// The middle of a segment along the line.
    pub(super) fn centre_mm(&self, segment: usize) -> f64 {
        self.first_mm + (segment as f64 + 0.5) * self.segment_mm
    }

    /// The samples of each segment in a wide band: way from its middle, offset, height.
    pub(super) fn samples(
        &self,
        points: &[PointMm],
        cells: &Cells,
        reference: &Reference,
    ) -> Vec<Vec<[f64; 3]>> {
        let mut samples: Vec<Vec<[f64; 3]>> = vec![Vec::new(); self.count()];
        for cell in 0..cells.len() {
            for (&vertex, residual) in
                cells.members(cell).iter().zip(&reference.residuals_mm[cells.range(cell)])
            {
                let [way, offset] = local_mm(self.origin_mm, self.along, place(points, vertex));
                let segment = self.index(way);
                if !(segment >= 0.0 && segment < self.count() as f64 && residual.is_finite()) {
                    continue;
                }
                let segment = segment as usize;
                let Some(middle) = self.middle_mm[segment] else { continue };
                if (offset - middle).abs() <= WIDE * cells.side_mm {
                    samples[segment].push([
                        way - self.centre_mm(segment),
                        offset - middle,
                        residual / reference.secants[cell],
                    ]);
                }
            }
        }
        samples
    }
}

/// Length of a segment in cells.
const SEGMENT: f64 = 12.0;
