//! A reference surface made from the points themselves, where no nominal is known.
//!
//! First a base of few parameters (a plane, a sphere or a quadric) is laid into the points by their orthogonal
//! distances, then penalised B-splines take what stands off it along z of the base. What is left is what the
//! splines do not follow: noise, and form whose waves are shorter than [`SplineFit::cutoff_mm`]. Longer waves are
//! in the reference, and no deviation from it shows them.

use asphera_geometry::{BoundsMm, place};
use std::sync::Arc;

use thiserror::Error;

use crate::basis::{Product, Scale};
use crate::fit::start::sample;
use crate::fit::{FitSettings, solve};
use crate::middle::middle_mm;
use crate::shape::{Cells, Conic, LARGEST_SIDE, Series, Shape, SplineSurface, Sum};
use crate::spline_fit::{Smoothing, SplineFit, SplineFitError, fit_spline};
use crate::{Aperture, ApertureError, Fit, FitError, Nominal, Parameter, PointMm, Pose};

/// Surface under the splines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// A plane.
    Plane,
    /// A sphere.
    Sphere,
    /// `a·x² + b·xy + c·y²`.
    Quadric,
}

/// How far apart the knots of the splines are, alike along x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Knots {
    /// 27 to 32 cells over the longer side, fewer where that leaves less than nine points a cell: the distance is a power of
    /// the fourth root of two, in mm.
    #[default]
    Auto,
    /// This distance in mm.
    Spacing(f64),
    /// So many cells over the longer side, 1 to [`LARGEST_SIDE`].
    Across(usize),
}

/// How a reference is made.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceSettings {
    /// The base; `None`: the simplest whose residuals are at most 5 % above the smallest.
    pub base: Option<Base>,
    /// The knots.
    pub knots: Knots,
    /// How smooth the splines are.
    pub smoothing: Smoothing,
    /// Points outside it, in the part frame, do not count.
    pub aperture: Aperture,
    /// Where the origin of the part frame lies, x and y of the measured frame in mm. `None`: at its origin where
    /// there is an aperture, else in the middle of the points.
    pub centre_mm: Option<[f64; 2]>,
}

impl Default for ReferenceSettings {
    /// Everything by the points, without an aperture.
    fn default() -> ReferenceSettings {
        ReferenceSettings {
            base: None,
            knots: Knots::Auto,
            smoothing: Smoothing::CrossValidation,
            aperture: Aperture::None,
            centre_mm: None,
        }
    }
}

/// A reference surface, and how the points lie about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Surface under the splines.
    pub base: Base,
    /// The base alone, laid into a sample of at most 20,000 points.
    pub base_fit: Fit,
    /// The splines, in the part frame, over the base.
    pub spline: SplineFit,
    /// All points about base and splines. No parameter is free; its degrees of freedom are the points less the
    /// effective parameters of the splines.
    pub fit: Fit,
}

/// Why there is no reference.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReferenceError {
    /// The aperture is none.
    #[error("the aperture is not usable")]
    Aperture(#[from] ApertureError),
    /// A centre that is no place.
    #[error("the centre is ({}, {}) mm, expected finite numbers", .0[0], .0[1])]
    Centre([f64; 2]),
    /// The base cannot be laid into the points.
    #[error("the base of the reference, a {base}, cannot be laid into the points")]
    Base {
        /// `plane`, `sphere` or `quadric`.
        base: &'static str,
        /// Why.
        source: FitError,
    },
    /// Too few points.
    #[error(
        "{used} points in the aperture ({outside} lie outside), at least {LEAST_POINTS} are needed to make a reference from them"
    )]
    TooFew {
        /// Finite points in the aperture.
        used: usize,
        /// Finite points outside.
        outside: usize,
    },
    /// Points along a line.
    #[error(
        "all {used} points lie in a strip {length_mm:.6} mm long and {width_mm:.1e} mm wide: a line makes no surface"
    )]
    Line {
        /// Points in the aperture.
        used: usize,
        /// Length of the strip, four standard deviations of the places, in mm.
        length_mm: f64,
        /// Width of the strip in the same way.
        width_mm: f64,
    },
    /// A distance of knots that is none.
    #[error("knots every {0} mm, expected a positive distance")]
    Spacing(f64),
    /// Knots that follow single points.
    #[error(
        "knots every {spacing_mm:.4} mm are finer than the points, {distance_mm:.4} mm apart on average: expected {least_mm:.4} mm or more"
    )]
    FinerThanPoints {
        /// Distance of the knots in mm.
        spacing_mm: f64,
        /// Average distance of the points in mm.
        distance_mm: f64,
        /// The smallest distance of knots in mm that is taken.
        least_mm: f64,
    },
    /// More cells than can be handled.
    #[error(
        "{nx} by {ny} cells of knots, expected 1 to {LARGEST_SIDE} each way: knots every {least_mm:.4} mm or more"
    )]
    Cells {
        /// Cells along x.
        nx: usize,
        /// Cells along y.
        ny: usize,
        /// The smallest distance of knots in mm that is taken.
        least_mm: f64,
    },
    /// The splines cannot be fitted.
    #[error("the splines of the reference cannot be fitted")]
    Spline(#[from] SplineFitError),
    /// The deviations from the reference cannot be worked out.
    #[error("the deviations from the reference cannot be worked out")]
    Deviations(#[source] FitError),
}

impl Reference {
    /// The base as fitted, without the splines: as a freeform, whatever it is, and defined beyond the points.
    pub fn base_nominal(&self) -> Nominal {
        Nominal::Freeform(shape_of(&self.base_fit.nominal))
    }
}

impl Base {
    /// `plane`, `sphere` or `quadric`.
    pub fn name(self) -> &'static str {
        match self {
            Base::Plane => "plane",
            Base::Sphere => "sphere",
            Base::Quadric => "quadric",
        }
    }

    /// The criterion of a fit that uses it, as reports give it.
    pub(super) fn method(self) -> &'static str {
        match self {
            Base::Plane => "penalised B-splines over a plane, made from the points",
            Base::Sphere => "penalised B-splines over a sphere, made from the points",
            Base::Quadric => "penalised B-splines over a quadric, made from the points",
        }
    }
}

/// The surface that stands in for a reference until that is made, and what is to be fitted of it: the
/// quadric `z = a·x² + b·xy + c·y²` with shift along z, tilts, a, b and c (in mm at 1 mm from the axis).
pub fn provisional() -> (Nominal, Vec<Parameter>) {
    let powers = Product::powers(&[(2, 0), (1, 1), (0, 2)]).expect("orders of at most two");
    let scale = Scale::round(1.0).expect("a positive radius");
    let quadric = Series::new(powers, scale, &[0.0; 3]).expect("one coefficient for each order");
    let free = UPRIGHT.into_iter().chain((0..3).map(Parameter::Shape)).collect();
    (Nominal::Freeform(Arc::new(quadric)), free)
}

/// Makes a reference from points of the measured frame. The part frame is that of the base: z along its normal at
/// the centre.
///
/// `O(n)` for the points, and `O(splines·nx²)` for each of up to 40 degrees of smoothness, for splines on nx
/// cells along x: with 32 by 32 cells far below a second. The same points in the same order give the same bits.
///
/// # Errors
///
/// Points that make no surface, and knots finer than the points: see [`ReferenceError`].
pub fn reference(
    points: &[PointMm],
    settings: &ReferenceSettings,
) -> Result<Reference, ReferenceError> {
    let Made { base, base_fit, spline } = made(points, settings, Finest::Asked)?;
    let surface = Sum::new(vec![shape_of(&base_fit.nominal), Arc::new(spline.surface.clone())]);
    let nominal = Nominal::Freeform(Arc::new(surface.expect("two parts")));
    let settings = fixed(Vec::new(), base_fit.pose, settings.aperture.clone());
    let mut fit = solve(points, None, &nominal, &settings).map_err(ReferenceError::Deviations)?;
    fit.method = base.method();
    fit.dof = fit.used.saturating_sub(spline.effective_parameters.ceil() as usize);
    Ok(Reference { base, base_fit, spline, fit })
}

/// A reference before the points are held against it.
#[derive(Clone, Debug)]
pub(super) struct Made {
    pub(super) base: Base,
    pub(super) base_fit: Fit,
    pub(super) spline: SplineFit,
}

/// How fine knots may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Finest {
    /// As asked for, and an error if the points do not allow it.
    Asked,
    /// No finer than the points allow and so many cells over the longer side.
    Cells(usize),
}

/// Base and splines of a reference.
pub(super) fn made(
    points: &[PointMm],
    settings: &ReferenceSettings,
    finest: Finest,
) -> Result<Made, ReferenceError> {
    settings.aperture.validate()?;
    let [tx_mm, ty_mm] = match settings.centre_mm {
        Some(centre) if !centre.iter().all(|place| place.is_finite()) => {
            return Err(ReferenceError::Centre(centre));
        }
        Some(centre) => centre,
        None if settings.aperture == Aperture::None => {
            let places: Vec<[f64; 2]> = points.iter().map(|&[x, y, _]| [x, y]).collect();
            middle_mm(&places).unwrap_or_default()
        }
        None => [0.0; 2],
    };
    let start = Pose { tx_mm, ty_mm, ..Pose::default() };
    let (inside, outside) = places_mm(points, &start, settings);
    require(&inside, outside)?;
    let (base, base_fit) = laid(&sample(points, SAMPLE), start, settings)?;
    let shape = shape_of(&base_fit.nominal);
    let motion = base_fit.pose.motion();
    let heights: Vec<PointMm> = points
        .iter()
        .filter(|point| point.iter().all(|coordinate| coordinate.is_finite()))
        .map(|point| motion.to_part(*point))
        .filter(|[x, y, _]| settings.aperture.contains(*x, *y))
        .filter_map(|[x, y, z]| Some([x, y, z - shape.sag_mm(x, y)?]))
        .collect();
    let cells = cells(&heights, settings.knots, finest)?;
    let spline = fit_spline(&heights, &cells, settings.smoothing)?;
    let spline = SplineFit { surface: dilated(&spline.surface), ..spline };
    Ok(Made { base, base_fit, spline })
}

/// These splines, defined beside cells that hold a point, too: the foot of a point may lie over the border.
pub(super) fn dilated(surface: &SplineSurface) -> SplineSurface {
    let cells = surface.cells();
    let beside = |index: usize, count: usize| index.saturating_sub(1)..(index + 2).min(count);
    let holds = |i: usize, j: usize| surface.defined()[j * cells.nx + i];
    let touches = |cell: usize| {
        let (i, j) = (cell % cells.nx, cell / cells.nx);
        beside(j, cells.ny).any(|j| beside(i, cells.nx).any(|i| holds(i, j)))
    };
    let defined: Vec<bool> = (0..cells.nx * cells.ny).map(touches).collect();
    SplineSurface::new(cells, surface.coefficients_mm(), &defined).expect("the splines of a fit")
}

/// Smallest and largest x and y of the finite points.
fn extent_mm(points: &[PointMm]) -> ([f64; 2], [f64; 2]) {
    let finite = points.iter().filter(|point| point.iter().all(|place| place.is_finite()));
    let BoundsMm { low, high } = BoundsMm::about(finite.map(|&point| place(point)));
    (low, high)
}

/// The finite points in the aperture, as places about the centre, and how many more are finite.
fn places_mm(
    points: &[PointMm],
    start: &Pose,
    settings: &ReferenceSettings,
) -> (Vec<[f64; 2]>, usize) {
    let mut outside = 0;
    let mut inside = Vec::new();
    for [x, y, z] in points {
        let place = [x - start.tx_mm, y - start.ty_mm];
        if !(place[0].is_finite() && place[1].is_finite() && z.is_finite()) {
            continue;
        }
        if settings.aperture.contains(place[0], place[1]) {
            inside.push(place);
        } else {
            outside += 1;
        }
    }
    (inside, outside)
}

/// Fails where places make no surface.
fn require(places: &[[f64; 2]], outside: usize) -> Result<(), ReferenceError> {
    let used = places.len();
    if used < LEAST_POINTS {
        return Err(ReferenceError::TooFew { used, outside });
    }
    let count = used as f64;
    let mean = [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count);
    let moment = |a: usize, b: usize| {
        places.iter().map(|place| (place[a] - mean[a]) * (place[b] - mean[b])).sum::<f64>() / count
    };
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    let large = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
    // The product of the two is the determinant, of which less is lost than of their difference.
    let small = if large > 0.0 { ((xx * yy - xy * xy) / large).max(0.0) } else { 0.0 };
    if small <= NARROW * NARROW * large {
        let [length_mm, width_mm] = [large, small].map(|variance| 4.0 * variance.sqrt());
        return Err(ReferenceError::Line { used, length_mm, width_mm });
    }
    Ok(())
}

/// The base that is asked for or chosen, in a sample of the points.
fn laid(
    sample: &[PointMm],
    start: Pose,
    settings: &ReferenceSettings,
) -> Result<(Base, Fit), ReferenceError> {
    let fitted = |base: Base, nominal: &Nominal, free: Vec<Parameter>, start: Pose| {
        solve(sample, None, nominal, &fixed(free, start, settings.aperture.clone()))
            .map_err(|source| ReferenceError::Base { base: base.name(), source })
    };
    let plane = fitted(Base::Plane, &Nominal::Plane, UPRIGHT.to_vec(), start)?;
    if settings.base == Some(Base::Plane) {
        return Ok((Base::Plane, plane));
    }
    let (nominal, free) = provisional();
    let quadric = fitted(Base::Quadric, &nominal, free, plane.pose)?;
    if settings.base == Some(Base::Quadric) {
        return Ok((Base::Quadric, quadric));
    }
    let nominal = Nominal::Sphere { radius_mm: radius_mm(&quadric, sample) };
    let free = UPRIGHT.into_iter().chain([Parameter::Radius]).collect();
    let sphere = fitted(Base::Sphere, &nominal, free, quadric.pose);
    if settings.base == Some(Base::Sphere) {
        return Ok((Base::Sphere, sphere?));
    }
    let mut found = vec![(Base::Plane, plane), (Base::Quadric, quadric)];
    // A sphere that does not reach all points is none for them.
    if let Ok(sphere) = sphere
        && sphere.used == found[1].1.used
        && sphere.indeterminate.is_empty()
    {
        found.insert(1, (Base::Sphere, sphere));
    }
    let least = found.iter().map(|(_, fit)| fit.residuals.rms_mm).fold(f64::INFINITY, f64::min);
    let chosen = found.iter().position(|(_, fit)| fit.residuals.rms_mm <= AS_GOOD * least);
    Ok(found.swap_remove(chosen.unwrap_or(0)))
}

/// The radius of the sphere that bends as the quadric does at its vertex, large enough to reach the points.
fn radius_mm(quadric: &Fit, sample: &[PointMm]) -> f64 {
    let terms: Vec<f64> = quadric
        .nominal
        .freeform()
        .map(|shape| shape.parameters().iter().map(|parameter| parameter.value).collect())
        .unwrap_or_default();
    // Half the sum of the second derivatives 2a and 2c.
    let bend_per_mm = terms.first().zip(terms.last()).map_or(0.0, |(a, c)| a + c);
    let (low, high) = extent_mm(sample);
    let reach_mm = 0.55 * (high[0] - low[0]).hypot(high[1] - low[1]);
    let largest_mm = FLAT * reach_mm;
    let radius_mm = bend_per_mm.recip().abs().clamp(reach_mm, largest_mm.max(reach_mm));
    if bend_per_mm < 0.0 { -radius_mm } else { radius_mm }
}

/// A base as a shape.
pub(super) fn shape_of(nominal: &Nominal) -> Arc<dyn Shape> {
    match nominal {
        Nominal::Freeform(shape) => Arc::clone(shape),
        Nominal::Sphere { radius_mm } => {
            Arc::new(Conic::sphere(*radius_mm).expect("the radius of a fitted sphere"))
        }
        Nominal::Plane | Nominal::Asphere(_) => Arc::new(Conic::plane()),
    }
}

/// The distance of the knots in mm for so many points over sides of these lengths.
pub(super) fn spacing_mm(
    sides_mm: [f64; 2],
    points: usize,
    knots: Knots,
    finest: Finest,
) -> Result<f64, ReferenceError> {
    let longer_mm = sides_mm[0].max(sides_mm[1]);
    let distance_mm = (sides_mm[0] * sides_mm[1] / points as f64).sqrt();
    let least_mm = POINTS_ACROSS * distance_mm;
    let spacing_mm = match knots {
        Knots::Auto => stepped((longer_mm / AUTO_CELLS).max(AUTO_POINTS_ACROSS * distance_mm)),
        Knots::Across(cells) => longer_mm / cells as f64,
        Knots::Spacing(spacing_mm) => spacing_mm,
    };
    if !(spacing_mm.is_normal() && spacing_mm > 0.0) {
        return Err(ReferenceError::Spacing(spacing_mm));
    }
    let spacing_mm = match finest {
        Finest::Asked => spacing_mm,
        Finest::Cells(most) => {
            spacing_mm.max(AUTO_POINTS_ACROSS * distance_mm).max(longer_mm / most as f64)
        }
    };
    let spacing_mm = spacing_mm.min(longer_mm);
    if spacing_mm < least_mm.min(longer_mm) {
        return Err(ReferenceError::FinerThanPoints { spacing_mm, distance_mm, least_mm });
    }
    Ok(spacing_mm)
}

/// The next power of the fourth root of two: as points become more and reach farther, distances stay for a while.
fn stepped(spacing_mm: f64) -> f64 {
    ((spacing_mm.log2() * STEPS).ceil() / STEPS).exp2()
}

/// Cells over the places of the points.
fn cells(heights: &[PointMm], knots: Knots, finest: Finest) -> Result<Cells, ReferenceError> {
    let (low, high) = extent_mm(heights);
    let sides = [0, 1].map(|axis| high[axis] - low[axis]);
    let spacing_mm = spacing_mm(sides, heights.len(), knots, finest)?;
    let longer_mm = sides[0].max(sides[1]);
    let least_mm = POINTS_ACROSS * (sides[0] * sides[1] / heights.len() as f64).sqrt();
    let cells = covering(low, high, spacing_mm, knots);
    let Cells { nx, ny, .. } = cells;
    if nx.max(ny) > LARGEST_SIDE {
        let least_mm = least_mm.max(longer_mm / LARGEST_SIDE as f64);
        return Err(ReferenceError::Cells { nx, ny, least_mm });
    }
    Ok(cells)
}

/// The cells over places from `low` to `high`. They reach over them, for the foot of a point on the border may lie beyond.
///
/// Knots lie at multiples of their distance, so that places which join others leave them where they are; where cells are
/// counted, they begin and end with the places.
pub(super) fn covering(low: [f64; 2], high: [f64; 2], spacing_mm: f64, knots: Knots) -> Cells {
    if let Knots::Across(_) = knots {
        let sides = [0, 1].map(|axis| high[axis] - low[axis] + 2.0 * RIM * spacing_mm);
        let counts = sides.map(|side| ((side / spacing_mm - 3.0 * RIM).ceil() as usize).max(1));
        let step = [0, 1].map(|axis| spacing_mm.max(sides[axis] / counts[axis] as f64));
        let middle = [0, 1].map(|axis| low[axis].midpoint(high[axis]));
        let [x_min_mm, y_min_mm] =
            [0, 1].map(|axis| middle[axis] - 0.5 * counts[axis] as f64 * step[axis]);
        let ([step_x_mm, step_y_mm], [nx, ny]) = (step, counts);
        return Cells { x_min_mm, y_min_mm, step_x_mm, step_y_mm, nx, ny };
    }
    let first = low.map(|place| (place / spacing_mm - RIM).floor());
    let end = high.map(|place| (place / spacing_mm + RIM).ceil());
    let [nx, ny] = [0, 1].map(|axis| ((end[axis] - first[axis]) as usize).max(1));
    let [x_min_mm, y_min_mm] = first.map(|knot| knot * spacing_mm);
    Cells { x_min_mm, y_min_mm, step_x_mm: spacing_mm, step_y_mm: spacing_mm, nx, ny }
}

/// A fit from `start` that looks nowhere else.
fn fixed(free: Vec<Parameter>, start: Pose, aperture: Aperture) -> FitSettings {
    FitSettings { free, start, aperture, search: false, ..FitSettings::default() }
}

/// A base is laid at the centre: only height and tilts change.
const UPRIGHT: [Parameter; 3] = [Parameter::Tz, Parameter::Rx, Parameter::Ry];
/// A cell of cubic splines has as many coefficients.
const LEAST_POINTS: usize = 16;
/// Width over length of places that are a line.
const NARROW: f64 = 1e-3;
/// Points from which the base is made: the splines take what these miss.
const SAMPLE: usize = 20_000;
/// Residuals of the same size, for the choice of the base.
const AS_GOOD: f64 = 1.05;
/// A sphere begins with at most so many times the reach of the points as its radius.
const FLAT: f64 = 1e6;
/// Distances of knots where nothing is said: so many from each to its double.
const STEPS: f64 = 4.0;
/// Cells over the longer side where nothing is said, at most: fitted within a second.
const AUTO_CELLS: f64 = 32.0;
/// Cells reach over the points by this share of a cell.
const RIM: f64 = 0.01;
/// Points along the side of a cell, where nothing is said and at least.
const AUTO_POINTS_ACROSS: f64 = 3.0;
const POINTS_ACROSS: f64 = 2.0;
