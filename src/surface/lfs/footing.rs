//! Where a ball begins: a measured point and its normal, smoothed over the neighbours.
//!
//! The tilt of a normal had from a few facets is about the noise of a point over the distance to its
//! neighbours, and a large ball magnifies it (see [`super::ball`]). A paraboloid fitted to all points
//! within a few gaps has a normal several times better, and a foot that lies on the surface better
//! than one point. It is used where it is better: where the surface bends too much for it, its
//! residuals tell.

use asphera_geometry::PointMm;
use nalgebra::{SMatrix, SVector};

use super::measured::Accuracy;
use super::octree::{Cube, Octree};
use super::vector::{along, cross, dot, minus, unit};

/// Measured points in their tree.
#[derive(Clone, Copy)]
pub(super) struct Oriented<'a> {
    pub(super) points: &'a [PointMm],
    pub(super) normals: &'a [Option<[f64; 3]>],
    pub(super) tree: &'a Octree,
}

/// Where a ball begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footing {
    pub(super) at_mm: PointMm,
    pub(super) normal: [f64; 3],
    /// Standard deviation of the tilt of the normal, in rad.
    pub(super) tilt_rad: f64,
}

/// The footing of a point with this normal.
pub(super) fn footing(
    of: Oriented<'_>,
    point: u32,
    normal: [f64; 3],
    accuracy: &Accuracy,
    queue: &mut Vec<Cube>,
) -> Footing {
    let raw = Footing { at_mm: of.points[point as usize], normal, tilt_rad: accuracy.normal_rad };
    if accuracy.normal_rad == 0.0 {
        return raw;
    }
    let near = neighbours(of, raw.at_mm, reach_mm(accuracy), queue);
    let rows = rows(of, raw, &near, reach_mm(accuracy));
    let fitted = rows.and_then(|rows| fit(raw, &rows, accuracy));
    fitted.filter(|fitted| fitted.tilt_rad < raw.tilt_rad).unwrap_or(raw)
}

/// How far the neighbours that count are, in mm.
pub(super) fn reach_mm(accuracy: &Accuracy) -> f64 {
    REACH_GAPS * accuracy.gap_mm
}

/// The points within a distance, in the order of cubes.
fn neighbours(of: Oriented<'_>, at_mm: PointMm, reach_mm: f64, queue: &mut Vec<Cube>) -> Vec<u32> {
    let mut found = Vec::new();
    queue.clear();
    queue.extend(of.tree.root());
    while let Some(cube) = queue.pop() {
        if cube.distance_mm(at_mm) > reach_mm {
            continue;
        }
        let before = queue.len();
        queue.extend(of.tree.children(cube));
        if queue.len() == before {
            let way = minus(of.points[cube.point as usize], at_mm);
            if dot(way, way) <= reach_mm * reach_mm {
                found.push(cube.point);
            }
        }
    }
    found
}

/// A neighbour in the frame of the normal, over the reach: 1, x, y, x², xy, y², and its height.
type Row = (SVector<f64, 6>, f64);

/// The neighbours that face the same way.
fn rows(of: Oriented<'_>, raw: Footing, near: &[u32], reach_mm: f64) -> Option<Vec<Row>> {
    let [across, along] = tangents(raw.normal)?;
    let faces = |other: &&u32| {
        of.normals[**other as usize].is_some_and(|facing| dot(facing, raw.normal) > SAME_WAY)
    };
    let row = |&other: &u32| {
        let way = minus(of.points[other as usize], raw.at_mm);
        let [x, y, z] = [across, along, raw.normal].map(|axis| dot(way, axis) / reach_mm);
        (SVector::from([1.0, x, y, x * x, x * y, y * y]), z)
    };
    Some(near.iter().filter(faces).map(row).collect())
}

/// The footing on the paraboloid that fits best; `None` if none does.
fn fit(raw: Footing, rows: &[Row], accuracy: &Accuracy) -> Option<Footing> {
    if rows.len() < FEWEST {
        return None;
    }
    let Footing { at_mm, normal, .. } = raw;
    let reach_mm = reach_mm(accuracy);
    let [across, along_it] = tangents(normal)?;
    let mut matrix = SMatrix::<f64, 6, 6>::zeros();
    let mut side = SVector::<f64, 6>::zeros();
    for (row, z) in rows {
        matrix += row * row.transpose();
        side += row * *z;
    }
    let inverse = matrix.cholesky()?.inverse();
    let solved = inverse * side;
    let squares: f64 = rows.iter().map(|(row, z)| (z - row.dot(&solved)).powi(2)).sum();
    let variance = squares / (rows.len() - 6) as f64;
    let noise = (accuracy.position_mm / reach_mm).powi(2);
    // What the fit cannot follow tilts it as a whole; noise averages out.
    let misfit = (variance - 2.0 * noise).max(0.0);
    let tilt_rad = (noise * inverse[(1, 1)].max(inverse[(2, 2)]) + 4.0 * misfit).sqrt();
    let tilted =
        [0, 1, 2].map(|axis| normal[axis] - solved[1] * across[axis] - solved[2] * along_it[axis]);
    let at_mm = along(at_mm, normal, solved[0] * reach_mm);
    tilt_rad.is_finite().then_some(Footing { at_mm, normal: unit(tilted)?, tilt_rad })
}

/// Two unit vectors across a unit vector and each other.
fn tangents(normal: [f64; 3]) -> Option<[[f64; 3]; 2]> {
    let mut axis = [0.0; 3];
    let least = (1..3).fold(
        0,
        |least, axis| {
            if normal[axis].abs() < normal[least].abs() { axis } else { least }
        },
    );
    axis[least] = 1.0;
    let first = unit(cross(normal, axis))?;
    Some([first, cross(normal, first)])
}

/// How many gaps away a neighbour may be.
const REACH_GAPS: f64 = 3.5;

/// How few neighbours will do: twice as many as there are coefficients.
const FEWEST: usize = 12;

/// Cosine of the angle up to which normals face the same way.
const SAME_WAY: f64 = 0.7;
