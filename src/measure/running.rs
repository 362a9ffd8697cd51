//! Running figures while points arrive.

use asphera_form::{
    Aperture, Base, Figures, Fit, FitSettings, Grid, Live, LiveEstimate, LiveReference,
    LiveSettings, Pose, Reference, ReferenceSettings, SplineFit, fit,
};
use asphera_geometry::PointMm;
use asphera_report::Convergence;

use super::errors::Errors;
use super::heights::Height;
use super::origin;
use crate::Part;

/// The running estimator over a map that grows with the points.
///
/// With an aperture the map has its size from the start. Without one nobody knows how large the part is:
/// whenever a point falls beyond the map, the map doubles and is made anew from all points, which is
/// seldom enough to cost each point a constant.
pub(super) struct Running {
    part: Part,
    live: Option<Estimator>,
    bounds: Bounds,
    /// Where the origin of the part was found when the map was made, without an aperture, mm.
    found_mm: [f64; 2],
    points: Vec<PointMm>,
    /// One for each of `points`, or none.
    uncertainties_mm: Vec<f64>,
}

/// Running fit of a nominal, or of a surface the points themselves make.
enum Estimator {
    Nominal(Box<Live>),
    Unknown(Box<LiveReference>),
}

/// A surface made from points.
#[derive(Clone, Copy)]
pub(super) struct MadeReference<'a> {
    pub(super) base: Base,
    pub(super) base_fit: &'a Fit,
    pub(super) spline: &'a SplineFit,
    pub(super) method: &'static str,
}

#[derive(Clone, Copy)]
struct Bounds {
    x_mm: [f64; 2],
    y_mm: [f64; 2],
    fixed: bool,
}

impl Running {
    pub(super) fn new(part: &Part) -> Running {
        Running {
            part: part.clone(),
            live: None,
            bounds: Bounds::of(&part.aperture).unwrap_or(Bounds::NONE),
            found_mm: [0.0; 2],
            points: Vec::new(),
            uncertainties_mm: Vec::new(),
        }
    }

    /// Takes a point with what is known of its height, where that is its weight.
    pub(super) fn push(&mut self, point: PointMm, height: Option<Height>) {
        let u_mm = height.map(|height| height.u_mm);
        let up = height.map(|height| height.up);
        if !self.bounds.fixed {
            self.points.push(point);
            self.uncertainties_mm.extend(u_mm);
            if !self.bounds.contains(point) && self.points.len() >= FIRST_POINTS {
                self.bounds = Bounds::around(&self.points);
                self.found_mm = found_mm(&self.part, &self.bounds, &self.points);
                let cells = self.cells();
                self.live = match &self.part.reference {
                    // Made of all points at once, not of few, then more, up to all.
                    Some(settings) => {
                        unknown((&self.part, cells), settings, &self.bounds, &self.points)
                    }
                    None => estimator((&self.part, cells), &self.bounds, up).map(|mut live| {
                        for (index, &point) in self.points.iter().enumerate() {
                            take(&mut live, point, self.uncertainties_mm.get(index).copied());
                        }
                        Estimator::Nominal(Box::new(live))
                    }),
                };
                return;
            }
        } else if self.live.is_none() {
            let of = (&self.part, self.cells());
            self.live = match &self.part.reference {
                Some(settings) => unknown(of, settings, &self.bounds, &[]),
                None => estimator(of, &self.bounds, up).map(Box::new).map(Estimator::Nominal),
            };
        }
        match &mut self.live {
            Some(Estimator::Nominal(live)) => take(live, point, u_mm),
            // A reference knows no weights.
            Some(Estimator::Unknown(live)) => live.push(point),
            None => {}
        }
    }

    /// The cells of the map, once it is known how large the part is.
    pub(super) fn grid(&self) -> Option<Grid> {
        let Bounds { x_mm: [x_min, x_max], y_mm: [y_min, y_max], .. } = self.bounds;
        (x_min < x_max && y_min < y_max).then(|| self.cells())
    }

    /// The cells of the maps, in the part frame.
    fn cells(&self) -> Grid {
        let Bounds { x_mm: [x_min_mm, x_max_mm], y_mm: [y_min_mm, y_max_mm], .. } = self.bounds;
        let [x_mm, y_mm] = self.found_mm;
        Grid {
            x_min_mm: x_min_mm - x_mm,
            x_max_mm: x_max_mm - x_mm,
            y_min_mm: y_min_mm - y_mm,
            y_max_mm: y_max_mm - y_mm,
            nx: CELLS,
            ny: CELLS,
        }
    }

    pub(super) fn estimate(&self) -> Option<LiveEstimate> {
        match self.live.as_ref()? {
            Estimator::Nominal(live) => live.estimate(),
            Estimator::Unknown(live) => live.estimate(),
        }
    }

    /// Reference that the points have made of an unknown surface so far.
    pub(super) fn reference(&self) -> Option<MadeReference<'_>> {
        let Estimator::Unknown(live) = self.live.as_ref()? else { return None };
        let (base, base_fit) = live.base()?;
        Some(MadeReference { base, base_fit, spline: live.spline()?, method: live.method()? })
    }

    /// Some hundred points that hold the deviation from a nominal at its worst: the highest and the lowest of each block
    /// of cells.
    pub(super) fn extremes(&self) -> Vec<PointMm> {
        match &self.live {
            Some(Estimator::Nominal(live)) => live.extremes(BLOCK),
            Some(Estimator::Unknown(_)) | None => Vec::new(),
        }
    }
}

impl<'a> From<&'a Reference> for MadeReference<'a> {
    fn from(made: &'a Reference) -> MadeReference<'a> {
        let Reference { base, base_fit, spline, fit } = made;
        MadeReference { base: *base, base_fit, spline, method: fit.method }
    }
}

/// Estimator of a surface the points themselves make, of the points there are.
fn unknown(
    (part, cells): (&Part, Grid),
    settings: &ReferenceSettings,
    bounds: &Bounds,
    points: &[PointMm],
) -> Option<Estimator> {
    let settings =
        ReferenceSettings { centre_mm: Some(centre_mm(part, bounds)), ..settings.clone() };
    let live = LiveReference::from_points(settings, cells, points.to_vec());
    live.ok().map(Box::new).map(Estimator::Unknown)
}

/// A point whose uncertainty gives no weight is taken as one that has none: beside others that leaves no fit, neither now
/// nor at the end.
fn take(live: &mut Live, point: PointMm, u_mm: Option<f64>) {
    if u_mm.is_none_or(|u_mm| live.push_weighted(point, u_mm).is_err()) {
        live.push(point);
    }
}

/// Running fits are by the loss of the part, weighted where it asks for that and the points have uncertainties, along `up`.
fn estimator((part, cells): (&Part, Grid), bounds: &Bounds, up: Option<[f64; 3]>) -> Option<Live> {
    let [tx_mm, ty_mm] = centre_mm(part, bounds);
    let fit = FitSettings { start: Pose { tx_mm, ty_mm, ..Pose::default() }, ..fit_settings(part) };
    let settings = LiveSettings { uncertain_along: up, ..LiveSettings::new(fit, cells) };
    Live::new(part.nominal.clone(), settings).ok()
}

/// Where the part is looked for. The reference of an unknown surface is made in the middle of the points, if nothing else
/// is said, and there a surface has its origin that has no place of its own.
fn centre_mm(part: &Part, bounds: &Bounds) -> [f64; 2] {
    match &part.reference {
        None => {
            let Pose { tx_mm, ty_mm, .. } = origin::start(part, || bounds.middle_mm());
            [tx_mm, ty_mm]
        }
        Some(reference) => reference
            .centre_mm
            .unwrap_or_else(|| if bounds.fixed { [0.0; 2] } else { bounds.middle_mm() }),
    }
}

/// Where the origin of the part lies by the points so far, as far as the cells of the map must know it: without an aperture they
/// lie about the points.
fn found_mm(part: &Part, bounds: &Bounds, points: &[PointMm]) -> [f64; 2] {
    let [tx_mm, ty_mm] = centre_mm(part, bounds);
    if part.reference.is_some() || part.nominal.slides() == [true; 2] {
        return [tx_mm, ty_mm];
    }
    let start = Pose { tx_mm, ty_mm, ..Pose::default() };
    let settings = FitSettings { start, rank_tolerance: RANK_TOLERANCE, ..fit_settings(part) };
    let found = fit(points, &part.nominal, &settings).map_or(start, |fit| fit.pose);
    [found.tx_mm, found.ty_mm]
}

/// Settings of the fit.
pub(super) fn fit_settings(part: &Part) -> FitSettings {
    let Part { free, aperture, criterion, reference, side, .. } = part;
    FitSettings {
        free: free.clone(),
        aperture: aperture.clone(),
        loss: criterion.loss,
        loss_scale_mm: criterion.loss_scale_mm,
        // An unknown surface has no place of its own to be looked for.
        search: reference.is_none(),
        side: *side,
        ..FitSettings::default()
    }
}

impl Bounds {
    const NONE: Bounds = Bounds { x_mm: [0.0, 0.0], y_mm: [0.0, 0.0], fixed: false };

    fn of(aperture: &Aperture) -> Option<Bounds> {
        let [x, y] = aperture.half_extents_mm()?;
        Some(Bounds { x_mm: [-x, x], y_mm: [-y, y], fixed: true })
    }

    /// Twice the extent of the points, square, so that it does not have to grow again soon.
    fn around(points: &[PointMm]) -> Bounds {
        let extent = |axis: usize| {
            points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
                [low.min(point[axis]), high.max(point[axis])]
            })
        };
        let (x, y) = (extent(0), extent(1));
        let half = (x[1] - x[0]).max(y[1] - y[0]).max(f64::MIN_POSITIVE);
        let around = |[low, high]: [f64; 2]| {
            let middle = (low + high) / 2.0;
            [middle - half, middle + half]
        };
        Bounds { x_mm: around(x), y_mm: around(y), fixed: false }
    }

    fn middle_mm(&self) -> [f64; 2] {
        [self.x_mm, self.y_mm].map(|[low, high]| low.midpoint(high))
    }

    fn contains(&self, [x, y, _]: PointMm) -> bool {
        (self.x_mm[0]..=self.x_mm[1]).contains(&x) && (self.y_mm[0]..=self.y_mm[1]).contains(&y)
    }
}

/// PV and RMS against points, thinned to a bounded number of rows.
#[derive(Default)]
pub(super) struct History {
    rows: Convergence,
}

impl History {
    /// Notes an estimate with what is known of its errors.
    pub(super) fn note(&mut self, estimate: &LiveEstimate, errors: &Errors) {
        let count = estimate.count as u64;
        if self.rows.points.last().is_some_and(|last| *last >= count) {
            return;
        }
        let Figures { pv_nm, rms_nm, .. } = estimate.figures;
        let known = errors.of(&estimate.figures);
        let u_nm = [known.map(|known| known.u_pv_nm), known.map(|known| known.u_rms_nm)];
        self.rows.push(count, [pv_nm, rms_nm], u_nm, errors.bases());
        if self.rows.points.len() > MAX_ROWS {
            self.rows.thin();
        }
    }

    pub(super) fn convergence(&self) -> Convergence {
        self.rows.clone()
    }
}

const CELLS: usize = 96;
/// Cells of a block along either side: 144 blocks.
const BLOCK: usize = 8;
const FIRST_POINTS: usize = 64;
/// As of the running fit: a small patch tells tilt from shift too badly to go by it.
const RANK_TOLERANCE: f64 = 2e-4;
const MAX_ROWS: usize = 600;
