//! Where in a body a nominal lies.

use asphera_form::{FitSettings, Nominal, Parameter, Pose, fit};
use asphera_geometry::PointMm;
use asphera_measure::Part;
use asphera_surface::Plane;

use crate::body::Skin;
use crate::selection::{Place, STEEPEST_DEG, Selection, facing, select, steepest_rad};
use asphera_geometry::vector::{Vector, dot, length, plus, unit};

/// A nominal laid into a surface.
#[derive(Clone, Debug)]
pub(crate) struct Laid {
    /// The plane along whose normal the face is looked at.
    pub(crate) plane: Plane,
    /// In the frame of the plane.
    pub(crate) pose: Pose,
    /// Root mean square of the distances of the points it was laid into, mm.
    pub(crate) rms_mm: f64,
    /// Share of the aperture that the face fills, roughly.
    pub(crate) filled: f64,
    pub(crate) selection: Selection,
}

/// The best place of the nominal, and the second best that looks another way.
pub(crate) struct Found {
    pub(crate) best: Laid,
    pub(crate) other: Option<Laid>,
}

/// Lays the nominal into each side of the surface that one of the candidate directions sees, or into that which `along` sees.
pub(crate) fn find(
    skin: &Skin,
    part: &Part,
    along: Option<Vector>,
    margin_mm: f64,
) -> Option<Found> {
    let directions = match along {
        Some(direction) => vec![unit(direction)?],
        None => candidates(&skin.places_mm),
    };
    let slope_rad = steepest_rad(&part.nominal, &part.aperture) + STEEPEST_DEG.to_radians();
    let angle_rad = slope_rad.clamp(LEAST_VIEW_DEG.to_radians(), MOST_VIEW_DEG.to_radians());
    let mut laid: Vec<Laid> = directions
        .into_iter()
        .filter_map(|axis| {
            let vertices = facing(skin, axis, angle_rad);
            lay(skin, part, axis, &vertices, margin_mm)
        })
        .collect();
    let fullest = laid.iter().map(|laid| laid.filled).fold(0.0, f64::max);
    laid.retain(|laid| laid.filled >= FULL * fullest.min(1.0));
    // A stable sort: of equal ones the first direction.
    laid.sort_by(|a, b| a.rms_mm.total_cmp(&b.rms_mm));
    let mut laid = laid.into_iter();
    let best = laid.next()?;
    let axis = axis_of(&best);
    let other = laid.find(|laid| dot(axis_of(laid), axis) < ANOTHER_WAY);
    Some(Found { best, other })
}

/// The nominal's axis, measured frame.
fn axis_of(laid: &Laid) -> Vector {
    let [x, y, z] = laid.pose.rotation().map(|row| row[2]);
    let [u, v, w] = laid.plane.axes();
    plus(plus(plus([0.0; 3], x, u), y, v), z, w)
}

/// Lays the nominal into some vertices, takes the face that it then describes, and repeats until both agree.
fn lay(skin: &Skin, part: &Part, axis: Vector, vertices: &[u32], margin_mm: f64) -> Option<Laid> {
    let mut plane = Plane::new([0.0; 3], axis).ok()?;
    let (mut pose, _) = laid_into(skin, part, &plane, vertices, None)?;
    let mut selection: Option<Selection> = None;
    for _ in 0..ROUNDS {
        let laid = Laid { plane, pose, rms_mm: 0.0, filled: 0.0, selection: Selection::default() };
        let tilted = axis_of(&laid);
        if dot(tilted, plane.normal()) < KEPT_DEG.to_radians().cos() {
            // Far from the direction that was tried: look along the part's own axis.
            plane = Plane::new([0.0; 3], tilted).ok()?;
            (pose, _) = laid_into(skin, part, &plane, vertices, None)?;
        }
        let place =
            Place { nominal: &part.nominal, aperture: &part.aperture, plane: &plane, pose: &pose };
        let next = select(skin, place, margin_mm, NEAR * margin_mm);
        let (again, rms_mm) = laid_into(skin, part, &plane, &next.vertices, Some(pose))?;
        pose = again;
        let is_same = selection.as_ref() == Some(&next);
        selection = Some(next);
        if is_same {
            let selection = selection?;
            let filled = filled(skin, part, &plane, &pose, &selection);
            return Some(Laid { plane, pose, rms_mm, filled, selection });
        }
    }
    let selection = selection?;
    let (pose, rms_mm) = laid_into(skin, part, &plane, &selection.vertices, Some(pose))?;
    let filled = filled(skin, part, &plane, &pose, &selection);
    Some(Laid { plane, pose, rms_mm, filled, selection })
}

/// The pose of the nominal in some vertices, of which up to [`SOME`] are looked at, and the root mean square of their distances.
fn laid_into(
    skin: &Skin,
    part: &Part,
    plane: &Plane,
    vertices: &[u32],
    start: Option<Pose>,
) -> Option<(Pose, f64)> {
    let some = vertices.len().min(SOME);
    let points: Vec<PointMm> = (0..some)
        .map(|index| vertices[index * vertices.len() / some])
        .map(|vertex| plane.to_plane(skin.places_mm[vertex as usize]))
        .collect();
    if points.is_empty() {
        return None;
    }
    let middle = |axis: usize| {
        let side = points.iter().map(|point| point[axis]);
        let (low, high) = side.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        f64::midpoint(low, high)
    };
    let middle = Pose { tx_mm: middle(0), ty_mm: middle(1), tz_mm: middle(2), ..Pose::default() };
    let free = match part.nominal {
        // Its turns change nothing: it is looked at along the direction that was tried.
        Nominal::Sphere { .. } => &SHIFTS[..],
        _ if part.nominal.is_rotational() => &Parameter::RIGID[..],
        _ => &Parameter::POSE,
    };
    let settings = FitSettings {
        free: free.to_vec(),
        aperture: part.aperture.clone(),
        search: start.is_none(),
        start: start.unwrap_or(middle),
        rank_tolerance: RANK_TOLERANCE,
        ..FitSettings::default()
    };
    let found = fit(&points, &part.nominal, &settings).ok()?;
    (found.used >= LEAST_USED).then_some((found.pose, found.residuals.rms_mm))
}

/// Share of the aperture that the vertices fill; without an aperture 1. Counted in cells of the aperture's box.
fn filled(skin: &Skin, part: &Part, plane: &Plane, pose: &Pose, selection: &Selection) -> f64 {
    let Some(half_mm) = part.aperture.half_extents_mm() else { return 1.0 };
    let mut cells = [[false; CELLS]; CELLS];
    let motion = pose.motion();
    for &vertex in &selection.vertices {
        let [x, y, _] = motion.to_part(plane.to_plane(skin.places_mm[vertex as usize]));
        let cell = |at: f64, half: f64| {
            let share = (at / half + 1.0) / 2.0;
            let inside = Some(share).filter(|share| (0.0..1.0).contains(share));
            inside.map(|share| (share * CELLS as f64) as usize)
        };
        if let (Some(i), Some(j)) = (cell(x, half_mm[0]), cell(y, half_mm[1])) {
            cells[j][i] = true;
        }
    }
    let middle = |cell: usize, half: f64| ((cell as f64 + 0.5) / CELLS as f64 * 2.0 - 1.0) * half;
    let (mut seen, mut wanted) = (0.0, 0.0);
    for (j, row) in cells.iter().enumerate() {
        for (i, &is_seen) in row.iter().enumerate() {
            if part.aperture.contains(middle(i, half_mm[0]), middle(j, half_mm[1])) {
                wanted += 1.0;
                seen += f64::from(u8::from(is_seen));
            }
        }
    }
    if wanted > 0.0 { seen / wanted } else { 0.0 }
}

/// The axes of the frame and the principal axes of the vertices, both ways.
fn candidates(places_mm: &[PointMm]) -> Vec<Vector> {
    let mut axes: Vec<Vector> = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    axes.extend(principal_axes(places_mm));
    let mut directions: Vec<Vector> = Vec::new();
    for axis in axes {
        for direction in [axis, axis.map(|side| 0.0 - side)] {
            if directions.iter().all(|&other| dot(direction, other) < ALIKE_DEG.to_radians().cos())
            {
                directions.push(direction);
            }
        }
    }
    directions
}

/// The axes of the ellipsoid of inertia: Jacobi's rotations.
fn principal_axes(places_mm: &[PointMm]) -> Vec<Vector> {
    let count = places_mm.len().max(1) as f64;
    let sum = places_mm.iter().fold([0.0; 3], |sum, &place| plus(sum, 1.0, place));
    let mean = sum.map(|side| side / count);
    let mut matrix = [[0.0; 3]; 3];
    for &place in places_mm {
        let from = plus(place, -1.0, mean);
        for (row, a) in matrix.iter_mut().zip(from) {
            row.iter_mut().zip(from).for_each(|(entry, b)| *entry += a * b / count);
        }
    }
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if matrix[p][q] == 0.0 {
                continue;
            }
            let angle = 0.5 * (2.0 * matrix[p][q]).atan2(matrix[q][q] - matrix[p][p]);
            let (sine, cosine) = angle.sin_cos();
            for row in &mut matrix {
                (row[p], row[q]) =
                    (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
            }
            let (a, b) = (matrix[p], matrix[q]);
            matrix[p] = [0, 1, 2].map(|i| cosine * a[i] - sine * b[i]);
            matrix[q] = [0, 1, 2].map(|i| sine * a[i] + cosine * b[i]);
            let (a, b) = (vectors[p], vectors[q]);
            vectors[p] = [0, 1, 2].map(|i| cosine * a[i] - sine * b[i]);
            vectors[q] = [0, 1, 2].map(|i| sine * a[i] + cosine * b[i]);
        }
    }
    vectors.into_iter().filter(|&vector| length(vector) > 0.5).filter_map(unit).collect()
}

/// A direction sees what is turned away from it by less than this, at most and at least.
const MOST_VIEW_DEG: f64 = 80.0;
const LEAST_VIEW_DEG: f64 = 35.0;
/// Motions that change a sphere.
const SHIFTS: [Parameter; 3] = [Parameter::Tx, Parameter::Ty, Parameter::Tz];
/// Points that a nominal is laid into to find its place.
const SOME: usize = 4000;
/// Fewer points than this are no face.
const LEAST_USED: usize = 20;
/// Faces that fill less of the aperture than this share of the best are not compared with it.
const FULL: f64 = 0.8;
/// A direction that is turned from another by more than 60° is another one.
const ANOTHER_WAY: f64 = 0.5;
/// Directions nearer than this are one.
const ALIKE_DEG: f64 = 2.0;
/// A part that is tilted less than this from the direction tried is looked at along that.
const KEPT_DEG: f64 = 8.0;
/// Rounds of laying and taking.
const ROUNDS: usize = 12;
/// Margins within which a vertex is near the nominal.
const NEAR: f64 = 2.0;
/// As of the running fit.
const RANK_TOLERANCE: f64 = 2e-4;
const SWEEPS: usize = 12;
/// Cells a side in which it is counted how much of the aperture is filled.
const CELLS: usize = 24;
