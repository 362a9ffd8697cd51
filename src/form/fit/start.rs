//! A pose to begin with, for data that lie far from where the start says.
//!
//! Candidates are made from a sample of the points and the best is taken by the root mean square of the
//! orthogonal distances. The given start stays unless another is ten times better, so that a good start
//! is never exchanged for a chance.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::fit::FitSettings;
use crate::fit::model::Model;
use crate::fit::plane::{BestPlane, centroid};
use crate::fit::search::search;
use crate::fit::selection::Membership;
use crate::fit::svd::Svd;
use crate::{Nominal, Parameter, PointMm, Pose};

/// The start pose for `points` in the measured frame. Only free parameters differ from the given start.
pub(crate) fn find(points: &[PointMm], nominal: &Nominal, settings: &FitSettings) -> Pose {
    let near = shifted(points, nominal, settings);
    if settings.search { search(points, nominal, settings, near) } else { near }
}

/// The start, or the same turns over another place if that is far better.
fn shifted(points: &[PointMm], nominal: &Nominal, settings: &FitSettings) -> Pose {
    let sample = sample(points, SAMPLE);
    let given = settings.start;
    let mut candidates = vec![given];
    let free = |parameter: &Parameter| settings.free.contains(parameter);
    if !sample.is_empty() && free(&Parameter::Tz) {
        candidates.extend(levelled(&sample, nominal, given, settings));
        if *nominal == Nominal::Plane && free(&Parameter::Rx) && free(&Parameter::Ry) {
            candidates.extend(total_least_squares_plane(&sample, given));
        }
        if *nominal != Nominal::Plane && free(&Parameter::Tx) && free(&Parameter::Ty) {
            let places = vertices(&sample, nominal, given);
            candidates.extend(
                places.into_iter().filter_map(|pose| levelled(&sample, nominal, pose, settings)),
            );
        }
    }
    let scores: Vec<Score> =
        candidates.iter().map(|pose| Score::of(&sample, nominal, pose, settings)).collect();
    let most = scores.iter().map(|score| score.used).max().unwrap_or(0);
    let eligible = |score: &Score| score.used > 0 && 2 * score.used >= most;
    let mut best: Option<usize> = None;
    for (index, score) in scores.iter().enumerate().filter(|(_, score)| eligible(score)) {
        if best.is_none_or(|best| score.rms_mm < scores[best].rms_mm) {
            best = Some(index);
        }
    }
    match best {
        Some(best) if !eligible(&scores[0]) || scores[best].rms_mm < FAR * scores[0].rms_mm => {
            candidates[best]
        }
        _ => given,
    }
}

struct Score {
    used: usize,
    rms_mm: f64,
}

impl Score {
    fn of(sample: &[PointMm], nominal: &Nominal, pose: &Pose, settings: &FitSettings) -> Score {
        let model = Model::new(nominal, pose, &[]);
        let members = sample.iter().filter(|&&point| {
            Membership::of(point, &model, &settings.aperture) == Membership::Used
        });
        let (mut used, mut square) = (0, 0.0);
        for distance_mm in members.filter_map(|&point| model.distance_mm(point)) {
            used += 1;
            square += distance_mm * distance_mm;
        }
        Score { used, rms_mm: (square / used as f64).sqrt() }
    }
}

/// Every n-th finite point, at most `most`.
pub(crate) fn sample(points: &[PointMm], most: usize) -> Vec<PointMm> {
    let step = points.len().div_ceil(most).max(1);
    let chosen = points.iter().step_by(step).copied();
    let finite: Vec<PointMm> = chosen.filter(is_finite).collect();
    // With many gaps the stride may have met only gaps.
    if finite.len() >= points.len().min(most) / 4 {
        return finite;
    }
    points.iter().copied().filter(is_finite).take(most).collect()
}

fn is_finite(point: &PointMm) -> bool {
    point.iter().all(|coordinate| coordinate.is_finite())
}

/// The pose shifted along z by the mean height of the points over the nominal; of those in the aperture,
/// if there are any.
pub(crate) fn levelled(
    sample: &[PointMm],
    nominal: &Nominal,
    pose: Pose,
    settings: &FitSettings,
) -> Option<Pose> {
    let motion = pose.motion();
    let (mut count, mut sum) = (0.0, 0.0);
    for &point in sample {
        let [x, y, z] = motion.to_part(point);
        let height = z - nominal.height_mm(x, y).unwrap_or(f64::NAN);
        if settings.aperture.contains(x, y) && height.is_finite() {
            count += 1.0;
            sum += height;
        }
    }
    let upright = motion.rotation[2][2];
    (count > 0.0 && upright.abs() > 0.1)
        .then(|| Pose { tz_mm: pose.tz_mm + sum / count / upright, ..pose })
}

/// The plane nearest to the points, for a plane. `None` if the points determine none, or one that stands
/// upright.
fn total_least_squares_plane(sample: &[PointMm], pose: Pose) -> Option<Pose> {
    let BestPlane { centroid, normal, .. } = BestPlane::of(sample)?;
    if normal.z < 0.1 {
        return None;
    }
    // Rzᵀ·n = (sin ry·cos rx, −sin rx, cos ry·cos rx).
    let (sin, cos) = pose.rz_rad.sin_cos();
    let x = cos * normal.x + sin * normal.y;
    let y = cos * normal.y - sin * normal.x;
    let over = centroid - Vector3::new(pose.tx_mm, pose.ty_mm, 0.0);
    Some(Pose {
        tz_mm: over.z + (normal.x * over.x + normal.y * over.y) / normal.z,
        rx_rad: (-y).atan2(x.hypot(normal.z)),
        ry_rad: x.atan2(normal.z),
        ..pose
    })
}

/// Poses with the vertex over three places: the centroid, the vertex of the paraboloid of the nominal's
/// radius, and the axis of the best algebraic sphere.
pub(crate) fn vertices(sample: &[PointMm], nominal: &Nominal, pose: Pose) -> Vec<Pose> {
    let Some(radius) = nominal.radius_mm() else { return Vec::new() };
    let motion = pose.motion();
    let turned: Vec<PointMm> = sample.iter().map(|&point| motion.turn_to_part(point)).collect();
    let centroid = centroid(&turned);
    let centred: Vec<Vector3<f64>> =
        turned.iter().map(|&point| Vector3::from(point) - centroid).collect();
    let mut places = vec![[0.0, 0.0]];
    // z − r²/(2R) = −(x·x₀ + y·y₀)/R + constant.
    let paraboloid = least_squares(&centred, |p| {
        ([p.x, p.y, 1.0], p.z - (p.x * p.x + p.y * p.y) / (2.0 * radius))
    });
    places.extend(paraboloid.map(|[b, c, _]| [-b * radius, -c * radius]));
    // |p|² = 2·(x·x₀ + y·y₀ + z·z₀) + constant.
    let sphere =
        least_squares(&centred, |p| ([2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0], p.norm_squared()));
    places.extend(sphere.map(|[x, y, _, _]| [x, y]));
    let shift = |[x, y]: [f64; 2]| {
        let place = [x + centroid.x, y + centroid.y, centroid.z];
        let [tx_mm, ty_mm, tz_mm] = motion.turn_to_measured(place);
        Pose { tx_mm, ty_mm, tz_mm, ..pose }
    };
    places.into_iter().map(shift).collect()
}

/// Linear least squares with N unknowns; the minimum-norm solution where the points do not determine
/// them. `None` if it fails.
fn least_squares<const N: usize>(
    points: &[Vector3<f64>],
    row: impl Fn(&Vector3<f64>) -> ([f64; N], f64),
) -> Option<[f64; N]> {
    let mut matrix = DMatrix::zeros(points.len(), N);
    let mut rhs = DVector::zeros(points.len());
    for (i, point) in points.iter().enumerate() {
        let (coefficients, value) = row(point);
        coefficients.iter().enumerate().for_each(|(j, &entry)| matrix[(i, j)] = entry);
        rhs[i] = value;
    }
    if !matrix.iter().chain(rhs.iter()).all(|entry| entry.is_finite()) {
        return None;
    }
    let svd = Svd::new(matrix);
    let least = FLAT * svd.extremes().0;
    let along = svd.scaled_u.tr_mul(&rhs);
    let turned = DVector::from_fn(N, |k, _| {
        if svd.sigma[k] > least { along[k] / (svd.sigma[k] * svd.sigma[k]) } else { 0.0 }
    });
    let solution = svd.v * turned;
    let solution: [f64; N] = std::array::from_fn(|j| solution[j]);
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}

/// Points the candidates are made from.
const SAMPLE: usize = 2048;
/// A candidate replaces the given start if its root mean square is below this share.
const FAR: f64 = 0.1;
/// Directions with a smaller share of the extent are not determined.
const FLAT: f64 = 1e-12;
