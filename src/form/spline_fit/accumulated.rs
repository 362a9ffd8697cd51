//! All points so far about one surface of base and splines: sums, cells of the map, and what is told of them.

use std::sync::Arc;

use asphera_geometry::BoundsMm;
use rayon::prelude::*;

use super::map_cells::{Change, Extreme, MapCell};
use super::moments::{Moments, Part, Place};
use super::reference::{
    Base, Finest, Knots, Made, ReferenceSettings, covering, dilated, shape_of, spacing_mm,
};
use super::{FEW_SPLINES, Smoothing, SplineFit, System, spline_fit};
use crate::deviation::NM_PER_MM;
use crate::fit::model::Model;
use crate::pose::Motion;
use crate::shape::{Cells, Jet, LARGEST_SIDE, Shape, SplineSurface, Sum};
use crate::{Excluded, Figures, Fit, Grid, LiveEstimate, Map, Nominal, PointMm};

/// All points so far about one surface.
#[derive(Clone, Debug)]
pub(super) struct Accumulated {
    pub(super) base: Base,
    pub(super) base_fit: Arc<Fit>,
    motion: Motion,
    /// The base as a shape.
    shape: Arc<dyn Shape>,
    /// Report of the splines.
    pub(super) spline: SplineFit,
    /// Over the whole net: residuals are from the base with these.
    coefficients_mm: Vec<f64>,
    chosen: Chosen,
    moments: Moments,
    cells: Vec<Option<MapCell>>,
    excluded: Excluded,
    /// Smallest and largest x and y of the points used, part frame.
    extent_mm: BoundsMm,
    settings: ReferenceSettings,
    /// Distance of the knots that was asked for when the net was made, and the longer side it was made for.
    pub(super) step_mm: f64,
    made_over_mm: f64,
    /// Mean square of the residuals in z then.
    made_mean_square_mm2: f64,
    /// Whether the net reaches over the points it was made for.
    pub(super) can_widen: bool,
    pub(super) made_at: usize,
}

/// A smoothness, and what there was when it was chosen.
#[derive(Clone, Copy, Debug)]
struct Chosen {
    weight: Weight,
    used: usize,
    /// Mean square of the residuals in z.
    mean_square_mm2: f64,
}

/// The weight of the penalty.
#[derive(Clone, Copy, Debug)]
enum Weight {
    /// The best goes with the noise and the surface, not with the number of points.
    Absolute(f64),
    /// Relative to the points in.
    Relative(f64),
}

impl Accumulated {
    /// All points about a full reference of them. Blocks are joined in order: the result does not depend on the number
    /// of threads.
    pub(super) fn of_points(
        made: Made,
        points: &[PointMm],
        settings: &ReferenceSettings,
        grid: &Grid,
    ) -> Accumulated {
        let empty = Accumulated::new(made, points.len(), settings, grid);
        let of_block = |block: &[PointMm]| {
            let mut kept = empty.clone();
            for &point in block {
                kept.add(point, grid);
            }
            kept
        };
        let blocks: Vec<Accumulated> = points.par_chunks(BLOCK).map(of_block).collect();
        let joined = blocks.into_iter().reduce(|mut all, block| {
            all.merge(&block);
            all
        });
        let mut kept = joined.unwrap_or(empty);
        kept.step_mm = kept.wanted_step_mm().unwrap_or(f64::NAN);
        kept.made_over_mm = kept.longer_mm();
        if let Some(part) = kept.part()
            && let Some(system) = kept.moments.system(&part, &kept.coefficients_mm)
        {
            kept.chosen = Chosen::of(&kept.spline, &system, settings.smoothing);
        }
        kept
    }

    fn new(made: Made, made_at: usize, settings: &ReferenceSettings, grid: &Grid) -> Accumulated {
        let Made { base, base_fit, spline } = made;
        let cells = spline.surface.cells();
        let margins = margins(&cells);
        let (net, coefficients_mm) = widened(&cells, spline.surface.coefficients_mm(), margins);
        Accumulated {
            motion: base_fit.pose.motion(),
            shape: shape_of(&base_fit.nominal),
            base,
            base_fit: Arc::new(base_fit),
            coefficients_mm,
            chosen: Chosen::FIRST,
            made_mean_square_mm2: spline.residual_rms_mm * spline.residual_rms_mm,
            spline,
            moments: Moments::new(net),
            cells: vec![None; grid.cells() + 1],
            excluded: Excluded::default(),
            extent_mm: BoundsMm::EMPTY,
            settings: settings.clone(),
            step_mm: f64::NAN,
            made_over_mm: f64::INFINITY,
            can_widen: margins.iter().flatten().all(|margin| *margin > 0),
            made_at,
        }
    }

    /// Takes a point; whether it does not lie beyond the net.
    pub(super) fn add(&mut self, point: PointMm, grid: &Grid) -> bool {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            self.excluded.not_finite += 1;
            return true;
        }
        let [x, y, z] = self.motion.to_part(point);
        if !self.settings.aperture.contains(x, y) {
            self.excluded.outside_aperture += 1;
            return true;
        }
        let Some(base) = self.shape.jet(x, y) else {
            self.excluded.outside_domain += 1;
            return true;
        };
        let Some(place) = Place::of(self.moments.net(), x, y) else {
            self.excluded.outside_domain += 1;
            return false;
        };
        let (height_mm, cosine) = self.surface_at(&base, &place);
        let residual_mm = z - height_mm;
        self.moments.add(&place, residual_mm, cosine);
        self.extent_mm.add([x, y]);
        let distance_mm = residual_mm * cosine;
        let one = MapCell::new(Extreme { distance_mm, place_mm: [x, y], point });
        match &mut self.cells[grid.cell(x, y)] {
            Some(cell) => cell.merge(&one),
            empty => *empty = Some(one),
        }
        true
    }

    /// Everything of another about the same surface.
    fn merge(&mut self, other: &Accumulated) {
        self.excluded = self.excluded.with(other.excluded);
        self.moments.merge(&other.moments);
        self.extent_mm.join(&other.extent_mm);
        for (cell, other) in self.cells.iter_mut().zip(&other.cells) {
            match (cell.as_mut(), other) {
                (Some(cell), Some(other)) => cell.merge(other),
                (None, other) => *cell = *other,
                (Some(_), None) => {}
            }
        }
    }

    /// The cells a reference made anew would have; `None` without points.
    fn part(&self) -> Option<Part> {
        let occupied = self.moments.occupied()?;
        if let Knots::Across(_) = self.settings.knots {
            return Some(occupied);
        }
        let net = self.moments.net();
        let BoundsMm { low, high } = self.extent_mm;
        Some(Part::common(net, &covering(low, high, net.step_x_mm, self.settings.knots)))
    }

    /// Whether a reference made anew would have other knots.
    pub(super) fn has_other_knots(&self) -> bool {
        let ratio = self.wanted_step_mm().map(|step_mm| (step_mm / self.step_mm).ln());
        ratio.is_some_and(|ratio| ratio.abs() > OUTDATED)
    }

    /// Whether a reference made anew would have another base: that of a part tells little of the rest. Where what is left has
    /// become far more, other points may be farthest out.
    pub(super) fn is_outdated(&self) -> bool {
        let grown = if self.made_at < FEW { GROWN_FEW } else { GROWN };
        self.longer_mm() > self.made_over_mm * grown
            || self.is_rougher_than(self.made_mean_square_mm2)
    }

    fn is_rougher_than(&self, mean_square_mm2: f64) -> bool {
        let most_mm2 = ROUGHER * mean_square_mm2 * self.moments.used() as f64;
        self.moments.square_in_z_mm2() > most_mm2
    }

    fn longer_mm(&self) -> f64 {
        let [width_mm, height_mm] = self.extent_mm.size_mm();
        width_mm.max(height_mm)
    }

    /// The distance of the knots of a reference made anew; `None` where it would not be made.
    fn wanted_step_mm(&self) -> Option<f64> {
        spacing_mm(self.extent_mm.size_mm(), self.moments.used(), self.settings.knots, FINEST).ok()
    }

    /// Chooses the smoothness anew if it is time, and moves everything to the surface that gives. `O(splines·nx²)`.
    pub(super) fn keep_up(&mut self) {
        let (used, before) = (self.moments.used(), self.chosen.used);
        let rougher = self.is_rougher_than(self.chosen.mean_square_mm2);
        if used <= before + before / if rougher { CHOICES_ROUGHER } else { CHOICES } {
            return;
        }
        self.chosen.used = used;
        let Some(part) = self.part() else { return };
        let Some(system) = self.moments.system(&part, &self.coefficients_mm) else { return };
        let near = self.chosen.weight.relative(&system);
        let smoothing = self.settings.smoothing;
        let (Some(trial), at_limit) = system.smoothed_near(smoothing, near) else { return };
        let change_mm: Vec<f64> =
            trial.coefficients_mm.iter().zip(&system.begin_mm).map(|(a, b)| a - b).collect();
        let change_mm = part.spread(self.moments.net(), &change_mm);
        let Some(surface) = self.surface(&part, &change_mm) else { return };
        self.spline = spline_fit(surface, &trial, at_limit, &system);
        self.chosen = Chosen::of(&self.spline, &system, smoothing);
        self.move_by(&part, &change_mm);
    }

    /// Moves everything to other coefficients of the splines of a part. Beyond it they go straight on.
    fn move_by(&mut self, part: &Part, change_mm: &[f64]) {
        let change = |place_mm: [f64; 2]| self.changed(place_mm, change_mm);
        self.cells = self.cells.iter().map(|cell| cell.map(|cell| cell.moved(change))).collect();
        self.moments.move_by(change_mm);
        let net = *self.moments.net();
        let all_mm: Vec<f64> =
            self.coefficients_mm.iter().zip(change_mm).map(|(a, b)| a + b).collect();
        let own_mm = part.coefficients(&net, &all_mm);
        (_, self.coefficients_mm) = widened(&part.cells(&net), &own_mm, part.margins(&net));
    }

    /// The splines of a part after a change of the coefficients.
    fn surface(&self, part: &Part, change_mm: &[f64]) -> Option<SplineSurface> {
        let net = self.moments.net();
        let all_mm: Vec<f64> =
            self.coefficients_mm.iter().zip(change_mm).map(|(a, b)| a + b).collect();
        let own_mm = part.coefficients(net, &all_mm);
        let holding = self.moments.holding(part);
        Some(dilated(&SplineSurface::new(part.cells(net), &own_mm, &holding).ok()?))
    }

    pub(super) fn estimate(&self, grid: &Grid) -> Option<LiveEstimate> {
        let part = self.part()?;
        let system = self.moments.system(&part, &self.coefficients_mm)?;
        let change_mm = part.spread(self.moments.net(), &self.solved(&system)?);
        let spline = self.surface(&part, &change_mm)?;
        let sum = Sum::new(vec![Arc::clone(&self.shape), Arc::new(spline)]).ok()?;
        let nominal = Nominal::Freeform(Arc::new(sum));
        let changed = |place_mm: [f64; 2]| self.changed(place_mm, &change_mm);
        let all: Vec<Option<MapCell>> =
            self.cells.iter().map(|cell| cell.map(|cell| cell.moved(changed))).collect();
        let cells = &all[..grid.cells()];
        let of_cells = |figure: &dyn Fn(&MapCell) -> f64| -> Vec<f64> {
            cells.iter().map(|cell| cell.as_ref().map_or(f64::NAN, figure)).collect()
        };
        let count = self.moments.used();
        let rms_mm = (self.moments.square_mm2(&change_mm) / count as f64).sqrt();
        let base_fit = &self.base_fit;
        Some(LiveEstimate {
            figures: self.figures(&nominal, rms_mm, &all)?,
            mean_squares_nm2: of_cells(&|cell| cell.mean_square_mm2() * NM_PER_MM * NM_PER_MM),
            map: Map {
                grid: *grid,
                mean_nm: of_cells(&|cell| cell.mean_mm() * NM_PER_MM),
                counts: cells.iter().map(|cell| cell.map_or(0, |cell| cell.count())).collect(),
                centroids_mm: cells
                    .iter()
                    .map(|cell| cell.map_or([f64::NAN; 2], |cell| cell.centroid_mm()))
                    .collect(),
            },
            estimates: base_fit.estimates.clone(),
            indeterminate: base_fit.indeterminate.clone(),
            undetermined: base_fit.undetermined.clone(),
            weights: None,
            robust: None,
            effective_points: count as f64,
            // Nothing for certain: the surface that is made next may follow all of it.
            least_rms_mm: 0.0,
            count,
            excluded: self.excluded,
            reference_count: self.made_at,
            pose: base_fit.pose,
            nominal,
        })
    }

    /// How far the coefficients are from those there are: with the smoothness of now, but for many splines, whose points
    /// lie about the surface as they did when it was chosen, with that of then.
    fn solved(&self, system: &System) -> Option<Vec<f64>> {
        let near = self.chosen.weight.relative(system);
        if system.begin_mm.len() > FEW_SPLINES {
            let (change_mm, _) = system.change(near * system.unit)?;
            let mean_square_mm2 = system.square_mm2(&change_mm) / system.used as f64;
            if (mean_square_mm2 / self.chosen.mean_square_mm2 - 1.0).abs() <= OTHER {
                return Some(change_mm);
            }
        }
        let (trial, _) = system.smoothed_near(self.settings.smoothing, near);
        let found_mm = trial?.coefficients_mm;
        Some(found_mm.iter().zip(&system.begin_mm).map(|(found, begin)| found - begin).collect())
    }

    /// Of the extremes of the cells those that are farthest out now, measured anew; `None` where they are not finite.
    fn figures(
        &self,
        nominal: &Nominal,
        rms_mm: f64,
        cells: &[Option<MapCell>],
    ) -> Option<Figures> {
        let extremes = cells.iter().flatten().map(|cell| (cell.low(), cell.high()));
        let (low, high) = extremes.reduce(|(low, high), (next_low, next_high)| {
            let lower = next_low.distance_mm < low.distance_mm;
            let higher = next_high.distance_mm > high.distance_mm;
            (if lower { next_low } else { low }, if higher { next_high } else { high })
        })?;
        let model = Model::new(nominal, &self.base_fit.pose, &[]);
        let [low_mm, high_mm] = [low, high]
            .map(|extreme| model.distance_mm(extreme.point).unwrap_or(extreme.distance_mm));
        let found = Figures {
            pv_nm: (high_mm - low_mm) * NM_PER_MM,
            rms_nm: rms_mm * NM_PER_MM,
            max_nm: high_mm * NM_PER_MM,
            min_nm: low_mm * NM_PER_MM,
            at_max_mm: self.motion.to_part(high.point),
            at_min_mm: self.motion.to_part(low.point),
            count: self.moments.used(),
        };
        (found.pv_nm.is_finite() && found.rms_nm.is_finite()).then_some(found)
    }

    /// Height of base and splines, and the cosine of their slope.
    fn surface_at(&self, base: &Jet, place: &Place) -> (f64, f64) {
        let (height_mm, own) = place.height(&self.coefficients_mm);
        let [p, q] = [0, 1].map(|axis| base.gradient[axis] + own[axis]);
        (base.z_mm + height_mm, (1.0 + p * p + q * q).sqrt().recip())
    }

    /// By how much distances change at a place with the splines.
    fn changed(&self, [x, y]: [f64; 2], change_mm: &[f64]) -> Change {
        let here = self.shape.jet(x, y).zip(Place::of(self.moments.net(), x, y));
        let Some((base, place)) = here else { return Change::default() };
        let (_, cosine) = self.surface_at(&base, &place);
        let (height_mm, slopes) = place.height(change_mm);
        Change { by_mm: -cosine * height_mm, slopes: slopes.map(|slope| -cosine * slope) }
    }
}

impl Chosen {
    /// Before any.
    const FIRST: Chosen =
        Chosen { weight: Weight::Relative(1.0), used: usize::MAX / 2, mean_square_mm2: 0.0 };

    fn of(spline: &SplineFit, system: &System, smoothing: Smoothing) -> Chosen {
        let weight = match smoothing {
            Smoothing::Relative { lambda } => Weight::Relative(lambda),
            Smoothing::CrossValidation | Smoothing::Noise { .. } => {
                Weight::Absolute(spline.lambda * system.unit)
            }
        };
        let mean_square_mm2 = spline.residual_rms_mm * spline.residual_rms_mm;
        Chosen { weight, used: system.used, mean_square_mm2 }
    }
}

impl Weight {
    /// λ relative to the points of a problem.
    fn relative(self, system: &System) -> f64 {
        match self {
            Weight::Absolute(weight) => weight / system.unit,
            Weight::Relative(lambda) => lambda,
        }
    }
}

/// How many cells a net reaches over the points it is made for, at either end of either axis.
fn margins(cells: &Cells) -> [[usize; 2]; 2] {
    let wanted = cells.nx.max(cells.ny).div_ceil(MARGIN);
    [cells.nx, cells.ny].map(|side| [wanted.min((LARGEST_SIDE - side) / 2); 2])
}

/// These splines over a net that reaches farther by so many cells at either end of either axis, straight on beyond the
/// border.
fn widened(
    cells: &Cells,
    coefficients_mm: &[f64],
    [along, across]: [[usize; 2]; 2],
) -> (Cells, Vec<f64>) {
    let net = Cells {
        x_min_mm: cells.x_min_mm - along[0] as f64 * cells.step_x_mm,
        y_min_mm: cells.y_min_mm - across[0] as f64 * cells.step_y_mm,
        nx: cells.nx + along[0] + along[1],
        ny: cells.ny + across[0] + across[1],
        ..*cells
    };
    let rows = coefficients_mm.chunks_exact(cells.nx + 3);
    let rows: Vec<Vec<f64>> = rows.map(|row| straight_on(row, along)).collect();
    let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<f64>>();
    let upright: Vec<Vec<f64>> = (0..net.nx + 3).map(|i| straight_on(&column(i), across)).collect();
    let all = (0..net.ny + 3).flat_map(|j| upright.iter().map(move |column| column[j]));
    (net, all.collect())
}

/// A sequence of at least two values with so many more before and after, on a straight line.
fn straight_on(values: &[f64], [before, after]: [usize; 2]) -> Vec<f64> {
    let last = values.len() - 1;
    let before = (1..=before).rev().map(|k| values[0] - k as f64 * (values[1] - values[0]));
    let after = (1..=after).map(|k| values[last] + k as f64 * (values[last] - values[last - 1]));
    before.chain(values.iter().copied()).chain(after).collect()
}

/// Difference of the logarithms of the distances of knots from which on a net is another.
const OUTDATED: f64 = 0.06;
/// Growth of the longer side after which the base is another, of few points and of more.
const GROWN_FEW: f64 = 1.06;
const GROWN: f64 = 1.12;
pub(super) const FEW: usize = 4096;
/// The smoothness is chosen anew when points have grown by more than one of so many parts.
const CHOICES: usize = 8;
/// The same where the mean square has grown by more than [`ROUGHER`].
const CHOICES_ROUGHER: usize = 64;
/// Growth of a mean square that is no chance.
const ROUGHER: f64 = 1.25;
/// Share by which a mean square is another.
const OTHER: f64 = 0.003;
/// The net reaches over the points by one of so many parts of the longer side.
const MARGIN: usize = 8;
/// Cells over the longer side whose equations an estimate solves.
pub(super) const FINEST: Finest = Finest::Cells(40);
/// Points of one block: so many that joining their sums costs little.
const BLOCK: usize = 1 << 17;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wider_net_has_the_same_splines_and_goes_straight_on() {
        let cells =
            Cells { x_min_mm: 1.0, y_min_mm: -2.0, step_x_mm: 0.5, step_y_mm: 0.5, nx: 24, ny: 5 };
        let bent: Vec<f64> = (0..cells.splines()).map(|i| (0.7 * i as f64).sin()).collect();
        assert_eq!(margins(&cells), [[3, 3], [3, 3]]);
        let (net, wide) = widened(&cells, &bent, [[3, 2], [1, 4]]);
        assert_eq!((net.nx, net.ny, net.x_min_mm, net.y_min_mm), (29, 10, -0.5, -2.5));
        let surface = |cells: Cells, coefficients: &[f64]| {
            SplineSurface::new(cells, coefficients, &vec![true; cells.nx * cells.ny]).unwrap()
        };
        let (narrow, wide) = (surface(cells, &bent), surface(net, &wide));
        for (x, y) in [(1.0, -2.0), (3.3, 0.1), (4.9, 0.4)] {
            let [a, b] = [&narrow, &wide].map(|surface| surface.sag_mm(x, y).unwrap());
            assert!((a - b).abs() < 1e-13);
        }
        let beyond = wide.jet(-0.4, -1.0).unwrap();
        assert!(beyond.hessian_per_mm[0].abs() < 1e-12, "{beyond:?}");
        // No room is left at the largest net.
        let most = Cells { nx: LARGEST_SIDE, ..cells };
        assert_eq!(margins(&most), [[0, 0], [16, 16]]);
    }
}
