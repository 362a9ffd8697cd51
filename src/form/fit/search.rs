//! Looking for a part far from where the start says: shifted, tilted, upside down, turned about its axis.
//!
//! A few hundred of the points decide. If the fit from the given start explains their height over the best
//! plane, nothing else is tried, but of a freeform whose turn and shape are free whether it fits far better when its shifts and
//! tilts are found first. Otherwise a fixed list of poses is refined on the sample: both sides of the
//! part up; its axis along that of the start, along the normal of the best plane and through the centre of the
//! best sphere; its vertex over the centroid, over the vertex of the paraboloid of its radius and on the axis of
//! that sphere; for freeforms, its patch laid into the points centroid on centroid and plane on plane, at
//! [`AZIMUTHS`] turns where the turn is free. The first that explains the points is taken, else the
//! best if it is clearly better than the start.

use nalgebra::{Matrix3, Rotation3, UnitVector3, Vector3};

use crate::fit::model::Model;
use crate::fit::plane::BestPlane;
use crate::fit::refine::{LeastSquares, Limits, refine};
use crate::fit::robust::{ScaledLoss, refine_robustly};
use crate::fit::selection::Selection;
use crate::fit::start::{levelled, sample, vertices};
use crate::fit::symmetry::disc;
use crate::{FitSettings, Loss, Nominal, Parameter, PointMm, Pose};

/// A better pose than `start` for the points, or `start`.
pub(crate) fn search(
    points: &[PointMm],
    nominal: &Nominal,
    settings: &FitSettings,
    start: Pose,
) -> Pose {
    use Parameter::{Tx, Ty, Tz};
    let is_free = |parameter: &Parameter| settings.free.contains(parameter);
    if *nominal == Nominal::Plane || ![Tx, Ty, Tz].iter().all(is_free) {
        return start;
    }
    let sample = sample(points, SAMPLE);
    let Some(plane) = BestPlane::of(&sample) else { return start };
    let refiner = Refiner { sample: &sample, nominal, settings, relief_mm: plane.rms_mm };
    let first = refiner.settled(start, &settings.free);
    if let Some(laid) = refiner.laid_first(start).filter(|laid| refiner.explains(laid)) {
        let is_far = |first: &Settled| laid.spread_mm < CLEARLY * first.spread_mm;
        if first.as_ref().is_none_or(is_far) {
            return laid.pose;
        }
    }
    if let Some(first) = first.as_ref().filter(|first| refiner.explains(first)) {
        // Where the way is long, the full fit may not go the way the sample did.
        let near = refiner.measured(start, nominal);
        let is_near = near.is_some_and(|near| near.spread_mm <= NEAR * plane.rms_mm);
        return if is_near { start } else { first.pose };
    }
    let candidates = if nominal.is_rotational() {
        rotational(&sample, nominal, settings, &plane)
    } else {
        freeform(nominal, settings, &plane)
    };
    let pose_only: Vec<Parameter> =
        settings.free.iter().copied().filter(|free| Parameter::POSE.contains(free)).collect();
    let mut finished: Vec<Settled> = Vec::new();
    for candidate in candidates {
        let Some(found) = refiner.settled(candidate, &pose_only) else { continue };
        if refiner.explains(&found) {
            return found.pose;
        }
        finished.push(found);
    }
    let most = finished.iter().chain(&first).map(|settled| settled.used).max().unwrap_or(0);
    let eligible = |settled: &&Settled| 4 * settled.used >= 3 * most;
    let best = finished
        .iter()
        .filter(eligible)
        .reduce(|best, next| if next.spread_mm < SAME * best.spread_mm { next } else { best });
    match (best, first.as_ref().filter(eligible)) {
        (Some(best), Some(first)) if best.spread_mm < CLEARLY * first.spread_mm => best.pose,
        (Some(best), None) => best.pose,
        _ => start,
    }
}

/// A pose refined on the sample.
struct Settled {
    pose: Pose,
    used: usize,
    /// Root mean square distance in mm; with a robust loss the median of the absolute distances.
    spread_mm: f64,
}

struct Refiner<'a> {
    sample: &'a [PointMm],
    nominal: &'a Nominal,
    settings: &'a FitSettings,
    relief_mm: f64,
}

impl Refiner<'_> {
    fn explains(&self, settled: &Settled) -> bool {
        settled.spread_mm <= EXPLAINED * self.relief_mm && 4 * settled.used >= 3 * self.sample.len()
    }

    /// The pose after a fit of the `free` parameters, in two rounds for points that come into the aperture.
    fn settled(&self, mut pose: Pose, free: &[Parameter]) -> Option<Settled> {
        let limits = Limits {
            tolerance_mm: SETTLED * self.relief_mm,
            iterations: STEPS,
            rank_tolerance: self.settings.rank_tolerance.max(RANK_TOLERANCE),
            polish: false,
            damping: DAMPING,
            start: self.settings.start,
        };
        let mut nominal = self.nominal.clone();
        let mut selection = self.select(&pose, &nominal);
        for _ in 0..ROUNDS {
            if selection.points.len() < free.len() {
                return None;
            }
            let refined = match self.settings.loss {
                Loss::Squares => {
                    let squares = LeastSquares { points: &selection.points, roots: None, free };
                    refine(squares, pose, nominal, limits, None)?
                }
                _ => {
                    let huber = ScaledLoss { loss: Loss::HUBER, given_mm: None };
                    refine_robustly(&selection, pose, nominal, free, limits, huber)?.refined
                }
            };
            (pose, nominal) = (refined.pose, refined.nominal);
            let next = self.select(&pose, &nominal);
            let is_same = next.memberships == selection.memberships;
            selection = next;
            if is_same {
                break;
            }
        }
        self.measured(pose, &nominal)
    }

    /// The pose after a fit of shifts and tilts alone and then of all that is free, for a freeform whose turn and shape are free.
    ///
    /// What a decentred and tilted part leaves looks like a little astigmatism and coma. Turn and coefficients would take it at once,
    /// and may end in a minimum a quarter turn away with the sign of a coefficient exchanged.
    fn laid_first(&self, start: Pose) -> Option<Settled> {
        let free = &self.settings.free;
        let has_shape = free.iter().any(|free| !Parameter::POSE.contains(free));
        if self.nominal.is_rotational() || !has_shape || !free.contains(&Parameter::Rz) {
            return None;
        }
        let laying: Vec<Parameter> =
            free.iter().copied().filter(|free| Parameter::RIGID.contains(free)).collect();
        let laid = self.settled(start, &laying)?;
        self.settled(laid.pose, free)
    }

    fn select(&self, pose: &Pose, nominal: &Nominal) -> Selection {
        Selection::new(self.sample, None, nominal, pose, &self.settings.aperture)
    }

    /// How far the sample stands off the nominal at a pose; `None` if it does not stand over it.
    fn measured(&self, pose: Pose, nominal: &Nominal) -> Option<Settled> {
        let selection = self.select(&pose, nominal);
        let used = selection.points.len();
        let model = Model::new(nominal, &pose, &[]);
        let mut distances: Vec<f64> =
            selection.points.iter().filter_map(|&point| model.distance_mm(point)).collect();
        let spread_mm = if self.settings.loss == Loss::Squares {
            (distances.iter().map(|d| d * d).sum::<f64>() / used as f64).sqrt()
        } else {
            distances.iter_mut().for_each(|distance| *distance = distance.abs());
            distances.sort_by(f64::total_cmp);
            *distances.get(used / 2)?
        };
        spread_mm.is_finite().then_some(Settled { pose, used, spread_mm })
    }
}

/// Poses of a part of revolution.
fn rotational(
    sample: &[PointMm],
    nominal: &Nominal,
    settings: &FitSettings,
    plane: &BestPlane,
) -> Vec<Pose> {
    let given = settings.start;
    let up = Vector3::from(given.rotation().map(|row| row[2]));
    let mut axes = vec![up];
    if tilts_are_free(settings) {
        let normal = if plane.normal.dot(&up) < 0.0 { -plane.normal } else { plane.normal };
        axes.push(normal);
    }
    let mut poses = Vec::new();
    for upside_down in sides(settings) {
        for &axis in &axes {
            let pose = laid_along(axis, upside_down, &given);
            let places = vertices(sample, nominal, pose);
            let placed = places
                .into_iter()
                .map(|place| levelled(sample, nominal, place, settings).unwrap_or(place));
            poses.extend(placed);
        }
    }
    poses
}

/// Poses of a freeform.
fn freeform(nominal: &Nominal, settings: &FitSettings, plane: &BestPlane) -> Vec<Pose> {
    let given = settings.start;
    let up = Vector3::from(given.rotation().map(|row| row[2]));
    let normal = if plane.normal.dot(&up) < 0.0 { -plane.normal } else { plane.normal };
    // A disc of uniform points has a root mean square radius of its radius over √2.
    let radius_mm = (plane.extent_mm * 2.0_f64.sqrt()).min(WITHIN * nominal.domain_mm());
    let patch: Vec<PointMm> = disc(radius_mm, PATCH)
        .filter_map(|[x, y]| nominal.height_mm(x, y).map(|z| [x, y, z]))
        .collect();
    let Some(own) = BestPlane::of(&patch) else { return Vec::new() };
    let turn_is_free = settings.free.contains(&Parameter::Rz);
    let azimuths = if turn_is_free { AZIMUTHS } else { 1 };
    let targets = if tilts_are_free(settings) { vec![normal, up] } else { vec![up] };
    let mut poses = Vec::new();
    for upside_down in sides(settings) {
        for &target in &targets {
            for azimuth in 0..azimuths {
                let turn = std::f64::consts::TAU * azimuth as f64 / azimuths as f64;
                let pose = if turn_is_free {
                    turned(&own, target, upside_down, turn)
                } else {
                    laid_along(target, upside_down, &given)
                };
                poses.push(over(pose, own.centroid, plane.centroid));
                if upside_down && !turn_is_free {
                    // Turned over about the other axis.
                    let pose = Pose {
                        rx_rad: std::f64::consts::PI - pose.rx_rad,
                        ry_rad: pose.ry_rad + std::f64::consts::PI,
                        ..pose
                    };
                    poses.push(over(pose, own.centroid, plane.centroid));
                }
            }
        }
    }
    poses
}

/// The pose with its shift such that a place of the part frame comes to one of the measured frame.
fn over(pose: Pose, part: Vector3<f64>, measured: Vector3<f64>) -> Pose {
    let turned = Vector3::from(pose.motion().turn_to_measured(part.into()));
    let [tx_mm, ty_mm, tz_mm] = (measured - turned).into();
    Pose { tx_mm, ty_mm, tz_mm, ..pose }
}

/// The part turned such that the plane of its patch lies along `target`, or upside down, and then by
/// `turn` about it.
fn turned(own: &BestPlane, target: Vector3<f64>, upside_down: bool, turn: f64) -> Pose {
    let (over, target) = if upside_down {
        (Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI), -target)
    } else {
        (Rotation3::identity(), target)
    };
    let onto = Rotation3::rotation_between(&(over * own.normal), &target);
    let about = Rotation3::from_axis_angle(&UnitVector3::new_normalize(target), turn);
    let rotation = about * onto.unwrap_or_else(Rotation3::identity) * over;
    from_rotation(rotation.matrix())
}

/// Pose with the part's axis along a unit vector, or against it, and the given turn about z. Of the two
/// there are, the one next to the given pose, or next to that turned over about its x axis.
fn laid_along(axis: Vector3<f64>, upside_down: bool, given: &Pose) -> Pose {
    let axis = if upside_down { -axis } else { axis };
    // Rzᵀ·n = (sin ry·cos rx, −sin rx, cos ry·cos rx).
    let (sin, cos) = given.rz_rad.sin_cos();
    let x = cos * axis.x + sin * axis.y;
    let y = cos * axis.y - sin * axis.x;
    let rx_rad = (-y).atan2(x.hypot(axis.z));
    if upside_down {
        let rx_rad = std::f64::consts::PI - rx_rad;
        return Pose { rx_rad, ry_rad: (-x).atan2(-axis.z), ..*given };
    }
    Pose { rx_rad, ry_rad: x.atan2(axis.z), ..*given }
}

/// The angles of the matrix Rz·Ry·Rx, that about y between −π/2 and π/2; no shift.
fn from_rotation(m: &Matrix3<f64>) -> Pose {
    let rx_rad = m[(2, 1)].atan2(m[(2, 2)]);
    let (sin, cos) = rx_rad.sin_cos();
    let ry_rad = (-m[(2, 0)]).atan2(sin * m[(2, 1)] + cos * m[(2, 2)]);
    let rz_rad = (sin * m[(0, 2)] - cos * m[(0, 1)]).atan2(cos * m[(1, 1)] - sin * m[(1, 2)]);
    Pose { rx_rad, ry_rad, rz_rad, ..Pose::default() }
}

fn tilts_are_free(settings: &FitSettings) -> bool {
    settings.free.contains(&Parameter::Rx) && settings.free.contains(&Parameter::Ry)
}

/// A part can be turned over where its tilts are free.
fn sides(settings: &FitSettings) -> impl Iterator<Item = bool> {
    [false, true].into_iter().take(if tilts_are_free(settings) { 2 } else { 1 })
}

/// Points that decide.
const SAMPLE: usize = 192;
/// Places of a freeform that stand for its patch.
const PATCH: usize = 256;
/// Turns that are tried about the axis of a freeform.
const AZIMUTHS: usize = 12;
/// A fit explains points when it leaves this share of their height over the best plane.
const EXPLAINED: f64 = 1e-3;
/// A start from which the full fit goes straight leaves no more than this share.
const NEAR: f64 = 0.05;
/// A pose is clearly better than the start's if it leaves less than this share of what that leaves.
const CLEARLY: f64 = 0.5;
/// Of poses that are as good as each other the first counts.
const SAME: f64 = 0.99;
/// Rounds of a refinement: the second takes the points the first brought into the aperture.
const ROUNDS: usize = 2;
const STEPS: usize = 40;
/// Damping of the first step from a guess.
const DAMPING: f64 = 1.0;
/// Share of the height over the best plane by which a pose on the sample may still move.
const SETTLED: f64 = 1e-6;
/// Weakly determined motions only lead a coarse fit astray.
const RANK_TOLERANCE: f64 = 1e-6;
/// The border of the domain is left out.
const WITHIN: f64 = 0.999;
