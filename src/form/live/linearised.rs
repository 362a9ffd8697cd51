//! All points so far, linearised at one pose and shape: what the running figures are made of.

mod map_figures;
mod step;

use rayon::prelude::*;

use crate::fit::model::{Model, PartFrame};
use crate::fit::selection::Membership;
use crate::fit::slant::Slant;
use crate::fit::solve::System;
use crate::fit::triangle::Triangle;
use crate::live::classes::{Classes, side};
use crate::live::problem::{Problem, Sums};
use crate::live::reweighing::{Reweighed, Reweighing};
use crate::live::weighted::Weighted;
use crate::live::{Grid, LiveEstimate, LiveSettings};
use crate::{Estimate, Excluded, Fit, Nominal, Parameter, PointMm, Pose, Robust};

/// All points so far, linearised at one pose and shape.
#[derive(Clone, Debug)]
pub(crate) struct Linearised {
    fit: Fit,
    /// That of the pose of the fit.
    frame: PartFrame,
    /// The determinate parameters: those of the columns.
    free: Vec<Parameter>,
    made_at: usize,
    /// Whether the points are those the fit was made of: then it is the answer.
    is_fit: bool,
    excluded: Excluded,
    triangle: Triangle,
    cells: Vec<Option<Cell>>,
    /// Of points with uncertainties, beside the sums of points that count alike.
    weighted: Option<Weighted>,
    /// With a robust loss, beside both.
    robust: Option<Reweighing>,
    /// How the direction of the uncertainties stands on the surface; `None`: they are along the normal.
    slant: Option<Slant>,
    /// Scratch for one row: derivatives and distance.
    row: Vec<f64>,
}

/// Where the estimate lays the surface.
pub(crate) struct Place {
    /// The fit of the reference, moved there.
    pub(crate) fit: Fit,
    /// Pose and shape that find the scale of a robust loss.
    pub(crate) first: (Pose, Nominal),
}

/// Where the sums have their solution.
struct Solved {
    change: Vec<f64>,
    bends: Vec<f64>,
    /// The standard deviation that goes with the problem; `None` without degrees of freedom.
    sigma: Option<f64>,
    robust: Option<Robust>,
    /// (Σw)²/Σw² of a robust loss.
    effective_points: Option<f64>,
}

/// The points of one cell of the map.
#[derive(Clone, Debug)]
struct Cell {
    count: usize,
    /// Sums of the derivatives and of the distances.
    sums: Box<[f64]>,
    /// Sum of the squares of the distances.
    square_mm2: f64,
    /// Sum of the points, measured frame.
    point_sum_mm: PointMm,
    low_mm: f64,
    low: PointMm,
    high_mm: f64,
    high: PointMm,
}

impl Cell {
    fn merge(&mut self, other: &Cell) {
        self.count += other.count;
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, part)| *sum += part);
        self.square_mm2 += other.square_mm2;
        self.point_sum_mm.iter_mut().zip(other.point_sum_mm).for_each(|(sum, part)| *sum += part);
        if other.low_mm < self.low_mm {
            (self.low_mm, self.low) = (other.low_mm, other.low);
        }
        if other.high_mm > self.high_mm {
            (self.high_mm, self.high) = (other.high_mm, other.high);
        }
    }
}

impl Linearised {
    /// All points at one reference, without uncertainties or with one for each. Blocks of [`BLOCK`] points are
    /// joined in order, so the result does not depend on the number of threads. `unit_mm` as in [`Linearised::new`].
    pub(crate) fn of_points(
        fit: Fit,
        slant: Option<Slant>,
        points: &[PointMm],
        uncertainties_mm: &[f64],
        unit_mm: Option<f64>,
        settings: &LiveSettings,
    ) -> Linearised {
        let side = side(spanned(points, &fit.pose, &settings.grid));
        let empty = Linearised::new(fit, slant, points.len(), side, unit_mm, settings);
        empty.with_all(points, uncertainties_mm, settings)
    }

    /// With all points of a scan beside those that are here, block by block.
    fn with_all(
        &self,
        points: &[PointMm],
        uncertainties_mm: &[f64],
        settings: &LiveSettings,
    ) -> Linearised {
        let empty = self;
        let of_block = |(index, block): (usize, &[PointMm])| {
            let mut linearised = empty.clone();
            for (place, &point) in (BLOCK * index..).zip(block) {
                linearised.add(point, uncertainties_mm.get(place).copied(), settings);
            }
            linearised
        };
        let blocks: Vec<Linearised> = points.par_chunks(BLOCK).enumerate().map(of_block).collect();
        let joined = blocks.into_iter().reduce(|mut all, block| {
            all.merge(block);
            all
        });
        joined.unwrap_or_else(|| empty.clone())
    }

    /// Without points. A robust loss looks at blocks of cells of the given side. `unit_mm` is the uncertainty of a point of mean weight at the reference, if points have any and
    /// the loss is robust.
    pub(crate) fn new(
        fit: Fit,
        slant: Option<Slant>,
        made_at: usize,
        side: usize,
        unit_mm: Option<f64>,
        settings: &LiveSettings,
    ) -> Linearised {
        let free: Vec<Parameter> =
            fit.estimates.iter().map(|estimate| estimate.parameter).collect();
        let LiveSettings { fit: fitting, grid, .. } = settings;
        Linearised {
            is_fit: false,
            robust: Reweighing::new(
                &fit,
                fitting,
                grid,
                side,
                unit_mm.unwrap_or(1.0),
                free.len() + 1,
            ),
            made_at,
            excluded: Excluded::default(),
            triangle: Triangle::new(free.len() + 1),
            cells: vec![None; grid.cells() + 1],
            weighted: None,
            slant,
            row: vec![0.0; free.len() + 1],
            frame: PartFrame::of(&fit.pose),
            fit,
            free,
        }
    }

    /// Takes a point, with its standard uncertainty if points have any.
    pub(crate) fn add(&mut self, point: PointMm, u_mm: Option<f64>, settings: &LiveSettings) {
        self.is_fit = false;
        let u_mm = u_mm.map(|u_mm| self.along_normal_mm(point, u_mm));
        if let Some(robust) = &mut self.robust {
            robust.note(u_mm);
        }
        let model = Model::in_frame(&self.fit.nominal, self.frame, &self.free);
        let membership = Membership::of(point, &model, &settings.fit.aperture);
        self.excluded.count(membership);
        if membership != Membership::Used || model.row(point, &mut self.row).is_none() {
            return;
        }
        let part_mm = model.motion.to_part(point);
        let distance_mm = self.row[self.free.len()];
        self.triangle.push(&self.row);
        let place = settings.grid.cell(part_mm[0], part_mm[1]);
        if let Some(u_mm) = u_mm {
            self.weigh(u_mm, place);
        }
        if let Some(robust) = &mut self.robust {
            robust.add(&self.row, u_mm, place);
        }
        let cell = self.cells[place].get_or_insert_with(|| Cell {
            count: 0,
            sums: vec![0.0; self.row.len()].into(),
            square_mm2: 0.0,
            point_sum_mm: [0.0; 3],
            low_mm: distance_mm,
            low: point,
            high_mm: distance_mm,
            high: point,
        });
        cell.count += 1;
        cell.square_mm2 += distance_mm * distance_mm;
        cell.point_sum_mm.iter_mut().zip(point).for_each(|(sum, coordinate)| *sum += coordinate);
        cell.sums.iter_mut().zip(&self.row).for_each(|(sum, entry)| *sum += entry);
        if distance_mm < cell.low_mm {
            (cell.low_mm, cell.low) = (distance_mm, point);
        }
        if distance_mm > cell.high_mm {
            (cell.high_mm, cell.high) = (distance_mm, point);
        }
    }

    fn along_normal_mm(&self, point: PointMm, u_mm: f64) -> f64 {
        self.slant.as_ref().map_or(u_mm, |slant| slant.share(point) * u_mm)
    }

    /// Counts the row of a point by its uncertainty, too.
    fn weigh(&mut self, u_mm: f64, place: usize) {
        let (columns, cells) = (self.row.len(), self.cells.len());
        let weighted = self.weighted.get_or_insert_with(|| Weighted::new(columns, cells, u_mm));
        weighted.add(&self.row, u_mm, place);
    }

    /// Points used that have no uncertainty.
    pub(crate) fn without_uncertainty(&self) -> usize {
        self.triangle.rows() - self.weighted.as_ref().map_or(0, Weighted::count)
    }

    /// Whether points used have uncertainties.
    pub(crate) fn has_uncertainties(&self) -> bool {
        self.weighted.is_some()
    }

    /// Everything of another accumulator with the same reference, free parameters and grid: as if its points
    /// had been added here, to the rounding of the sums (a share of about 1e-15 times the root of the number
    /// of blocks). Of points equally far out the one that is here counts.
    pub(crate) fn merge(&mut self, mut other: Linearised) {
        self.is_fit = false;
        self.excluded = self.excluded.with(other.excluded);
        self.triangle.flush();
        other.triangle.flush();
        self.triangle.join(&other.triangle);
        match (&mut self.weighted, other.weighted) {
            (Some(weighted), Some(other)) => weighted.merge(other),
            (weighted @ None, other) => *weighted = other,
            (Some(_), None) => {}
        }
        if let (Some(robust), Some(other)) = (&mut self.robust, other.robust) {
            robust.merge(other);
        }
        for (cell, other) in self.cells.iter_mut().zip(other.cells) {
            match (cell.as_mut(), other) {
                (Some(cell), Some(other)) => cell.merge(&other),
                (None, other) => *cell = other,
                (Some(_), None) => {}
            }
        }
    }

    /// Whether the other was linearised at the same pose and shape by the same parameters.
    pub(crate) fn is_compatible(&self, other: &Linearised) -> bool {
        let (own, others) = (&self.fit, &other.fit);
        own.pose == others.pose
            && own.nominal == others.nominal
            && self.free == other.free
            && own.indeterminate == others.indeterminate
            && match (&self.robust, &other.robust) {
                (Some(own), Some(others)) => own.is_compatible(others),
                (own, others) => own.is_none() && others.is_none(),
            }
    }

    /// All points of another scan at this reference, as if they had been added one by one.
    pub(crate) fn add_all(
        &mut self,
        points: &[PointMm],
        uncertainties_mm: &[f64],
        settings: &LiveSettings,
    ) {
        let of_points = self.emptied(&settings.grid).with_all(points, uncertainties_mm, settings);
        self.merge(of_points);
    }

    /// Reference without its points.
    fn emptied(&self, grid: &Grid) -> Linearised {
        Linearised {
            fit: self.fit.clone(),
            frame: self.frame,
            free: self.free.clone(),
            made_at: self.made_at,
            is_fit: false,
            excluded: Excluded::default(),
            triangle: Triangle::new(self.free.len() + 1),
            cells: vec![None; grid.cells() + 1],
            weighted: None,
            robust: self.robust.as_ref().map(|robust| robust.emptied(grid, self.row.len())),
            slant: self.slant.clone(),
            row: self.row.clone(),
        }
    }

    pub(crate) fn estimate(&self, grid: &Grid) -> Option<LiveEstimate> {
        let alike = self.alike()?;
        if self.has_uncertainties() && self.without_uncertainty() > 0 {
            return None;
        }
        let by_weight = match &self.weighted {
            Some(weighted) => Some(weighted.problem()?),
            None => None,
        };
        let count = alike.system.rows();
        let problem = by_weight.as_ref().unwrap_or(&alike);
        let step = problem.system.solve_along(&self.fit.freedoms, 0.0);
        let dof = count - self.fit.freedoms.count();
        let solved = self.solved(problem, dof);
        let Solved { change, bends, sigma, robust, effective_points } = solved;
        let (pose, nominal) = self.moved(&change)?;
        let estimates = self.free.iter().zip(&step.variance_factors);
        let estimates = estimates.filter_map(|(&parameter, factor)| {
            let value = parameter.value(&pose, &nominal)?;
            Some(Estimate { parameter, value, u: sigma.map(|sigma| sigma * factor.sqrt()) })
        });
        let rms_mm = |square: f64| (square / count as f64).sqrt();
        let whole = alike.square(&change, &bends);
        let mut least = whole;
        if self.weighted.is_some() || robust.is_some() {
            let (change, bends) = self.change(&alike);
            least = alike.square(&change, &bends).min(whole);
            // From where outliers do not count to where they do is far for a linear problem: it may end before.
            if robust.is_some() {
                least *= SURE_LEAST;
            }
        }
        let alike_points =
            || self.weighted.as_ref().map_or(count as f64, Weighted::effective_points);
        let effective_points = effective_points.unwrap_or_else(alike_points);
        Some(LiveEstimate {
            estimates: estimates.collect(),
            indeterminate: self.fit.indeterminate.clone(),
            undetermined: self.fit.undetermined.clone(),
            figures: self.figures(&nominal, &pose, rms_mm(whole), count)?,
            mean_squares_nm2: self.mean_squares_nm2(grid, &change, &bends),
            map: self.map(grid, &pose, &change, &bends),
            weights: self.weighted.as_ref().map(|weighted| weighted.told(sigma)),
            robust,
            effective_points,
            least_rms_mm: rms_mm(least),
            count,
            excluded: self.excluded,
            reference_count: self.made_at,
            pose,
            nominal,
        })
    }

    /// The change of the parameters by squares or, from there on, by the robust loss. Where that is beyond the reach of
    /// linearisation, it stays at the reference.
    fn solved(&self, problem: &Problem<'_>, dof: usize) -> Solved {
        let Some(robust) = &self.robust else {
            let (change, bends) = self.change(problem);
            let square = problem.square(&change, &bends);
            let sigma = (dof > 0).then(|| (square / dof as f64).sqrt());
            return Solved { change, bends, sigma, robust: None, effective_points: None };
        };
        // Both count points by their uncertainties, but in units of their own.
        let unit = self.weighted.as_ref().map_or(1.0, Weighted::unit_mm) / robust.unit_mm();
        let found = if self.is_fit { None } else { self.reweighed(None) };
        let Some(found) = found else {
            let change = vec![0.0; self.free.len()];
            let bends = vec![0.0; self.cells.len() * (self.free.len() + 1)];
            let known = self.is_fit && self.fit.covariance.is_some();
            let sigma = known.then_some(self.fit.sigma_mm * unit);
            let effective_points = Some(robust.effective_points());
            return Solved { change, bends, sigma, robust: self.fit.robust, effective_points };
        };
        let sigma = found.sigma.filter(|_| dof > 0).map(|sigma| sigma * unit);
        Solved {
            change: found.change,
            bends: found.bends,
            sigma,
            robust: Some(found.robust),
            effective_points: Some(found.effective_points),
        }
    }

    /// The solution by the robust loss, at the scale `fixed_mm` if there is one; `None` without such a loss, and where
    /// it is beyond the reach of linearisation.
    pub(crate) fn reweighed(&self, fixed_mm: Option<f64>) -> Option<Reweighed> {
        let robust = self.robust.as_ref()?;
        let bends = |change: &[f64]| self.bends(change);
        let means = |classes: &Classes, bends: &[f64]| self.mean_bends(classes, bends);
        robust.solve(&self.fit.freedoms, fixed_mm, &bends, &means)
    }

    /// Where the robust loss lays the surface now; `None` for squares and beyond the reach of linearisation.
    pub(crate) fn place(&self) -> Option<Place> {
        let found = self.reweighed(None)?;
        let (pose, nominal) = self.moved(&found.change)?;
        let fit = Fit { pose, nominal, robust: Some(found.robust), ..self.fit.clone() };
        Some(Place { fit, first: self.moved(&found.first_change)? })
    }

    /// Where the sums of squares lay the surface now; `None` where that is beyond the reach of linearisation, and where points
    /// beyond those of the reference may determine more.
    pub(crate) fn place_by_squares(&self) -> Option<Place> {
        let Fit { pose, nominal, undetermined, .. } = &self.fit;
        if !undetermined.iter().all(|undetermined| undetermined.by_shape) {
            return None;
        }
        let alike = self.alike()?;
        let by_weight = match &self.weighted {
            Some(weighted) => Some(weighted.problem()?),
            None => None,
        };
        let (change, _) = self.undamped(by_weight.as_ref().unwrap_or(&alike))?;
        let first = (*pose, nominal.clone());
        let (pose, nominal) = self.moved(&change)?;
        Some(Place { fit: Fit { pose, nominal, ..self.fit.clone() }, first })
    }

    /// Says that the reference is the fit of the points here.
    pub(crate) fn confirm(&mut self) {
        self.is_fit = true;
    }

    /// Holds the scale of the points here, which is known, against what their classes tell of it.
    pub(crate) fn calibrate(&mut self, scale_mm: f64) {
        if let Some(found) = self.reweighed(Some(scale_mm))
            && let Some(robust) = &mut self.robust
        {
            robust.calibrate(&found, scale_mm);
        }
    }

    /// The problem of points that count alike; `None` with fewer points than parameters.
    fn alike(&self) -> Option<Problem<'_>> {
        let mut triangle = self.triangle.clone();
        triangle.flush();
        if triangle.rows() < self.free.len().max(1) || !triangle.is_finite() {
            return None;
        }
        let cells = self.cells.iter().map(|cell| {
            let cell = cell.as_ref()?;
            Some(Sums { rows: &cell.sums, weight: cell.count as f64 })
        });
        Some(Problem { system: System::new(&triangle), cells: cells.collect(), root_weight: 1.0 })
    }
}

/// Cells of the map that points span along x or y, whichever are more.
fn spanned(points: &[PointMm], pose: &Pose, grid: &Grid) -> usize {
    let motion = pose.motion();
    let mut span = [[usize::MAX, 0]; 2];
    for &point in points {
        let [x_mm, y_mm, _] = motion.to_part(point);
        let cell = grid.cell(x_mm, y_mm);
        if cell < grid.cells() {
            for ([least, most], at) in span.iter_mut().zip([cell % grid.nx, cell / grid.nx]) {
                (*least, *most) = ((*least).min(at), (*most).max(at));
            }
        }
    }
    span.map(|[least, most]| (most + 1).saturating_sub(least)).into_iter().fold(1, usize::max)
}

/// Points of one block: so many that joining their cells costs little.
const BLOCK: usize = 1 << 17;
/// Remainder of a sum of squares that a step to it may have missed the least of: eight times what was ever missed.
const SURE_LEAST: f64 = 0.987;
