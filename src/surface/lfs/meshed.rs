//! Reach of a body that a closed mesh shows: the least local feature size on both sides.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_geometry::vector::{cross, dot, length, minus, plus};
use thiserror::Error;

use super::error::LfsError;
use super::measured::{Accuracy, MeasuredLfs};
use super::value::Lfs;
use super::vector::unit;

/// The reach of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshReach {
    /// It is not below this many mm, if between the vertices the surface bends no more than the facets say.
    pub lower_mm: f64,
    /// The best value, mm.
    pub mm: f64,
    /// The vertex where it is least.
    pub at_mm: PointMm,
}

/// Why a mesh proves no reach.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoReach {
    /// A side of a triangle does not belong to two that run along it in opposite directions.
    #[error("the mesh bounds no body: a side at ({}, {}, {}) mm belongs to {triangles} triangles in its direction or against it", at_mm[0], at_mm[1], at_mm[2])]
    NotClosed {
        /// An end of the side.
        at_mm: PointMm,
        /// The triangles along it.
        triangles: usize,
    },
    /// Two facets meet at a large angle.
    #[error("the mesh has an edge of {:.1}° at ({}, {}, {}) mm, and above {:.0}° it counts as sharp: a part with a sharp edge has no r", angle_rad.to_degrees(), at_mm[0], at_mm[1], at_mm[2], SHARP_RAD.to_degrees())]
    Sharp {
        /// The angle between the normals.
        angle_rad: f64,
        /// An end of the edge.
        at_mm: PointMm,
    },
    /// Facets are too coarse for what lies between them.
    #[error("the facets at ({}, {}, {}) mm are too coarse: its r may be anything up to {upper_mm} mm; a finer mesh proves more", at_mm[0], at_mm[1], at_mm[2])]
    Coarse {
        /// A vertex.
        at_mm: PointMm,
        /// What its local feature size is at most, mm.
        upper_mm: f64,
    },
    /// Vertices from which none is had.
    #[error(transparent)]
    Lfs(#[from] LfsError),
}

/// The reach of the body that a closed mesh shows, by medial balls on both sides.
///
/// Facets stand for a smooth surface through the vertices. Large ones are sampled between their vertices, with normals interpolated and
/// places on the quadric of these (T. Boubekeur, M. Alexa, Phong tessellation, ACM Trans. Graph. 27 (2008), with its α of ½).
/// Normals may be off by a 16th of the largest angle between facets, places between vertices by a 16th of the height of an arc over a facet; the
/// bound counts both.
///
/// # Errors
///
/// [`NoReach`]: a mesh that is open, has sharp edges or is too coarse.
///
/// # Panics
///
/// Where a triangle has a corner that is no point.
pub fn mesh_reach(points_mm: &[PointMm], triangles: &[[u32; 3]]) -> Result<MeshReach, NoReach> {
    let (points_mm, triangles) = &welded(points_mm, triangles);
    let (angle_rad, height_mm) = bent(points_mm, triangles)?;
    let sampled = Sampled::of(points_mm, triangles);
    // Vertices are on the surface; places between them are nearly so.
    let is_sampled = sampled.places_mm.len() > points_mm.len();
    let accuracy = Accuracy {
        gap_mm: sampled.gap_mm,
        position_mm: if is_sampled { height_mm / 16.0 } else { 0.0 },
        normal_rad: NORMAL_SHARE * angle_rad,
    };
    let mut lfs = MeasuredLfs::new(accuracy)?;
    let normals: Vec<Option<[f64; 3]>> =
        sampled.normals.iter().map(|&normal| unit(normal)).collect();
    lfs.insert(&sampled.places_mm, &normals)?;
    let axis = lfs.refresh();
    let mut least: Option<MeshReach> = None;
    for &at_mm in points_mm {
        let (mm, lower_mm) = match axis.at(at_mm) {
            Lfs::Known { mm, lower_mm, .. } => (mm, lower_mm),
            Lfs::Beyond { lower_mm } => (f64::INFINITY, lower_mm),
            Lfs::Hidden { upper_mm } => return Err(NoReach::Coarse { at_mm, upper_mm }),
            Lfs::Unknown(_) => return Err(NoReach::Coarse { at_mm, upper_mm: f64::INFINITY }),
        };
        if least.is_none_or(|least| lower_mm < least.lower_mm) {
            least = Some(MeshReach { lower_mm, mm, at_mm });
        }
    }
    least.ok_or(NoReach::Coarse { at_mm: [0.0; 3], upper_mm: f64::INFINITY })
}

/// The mesh with equal corners as one, for files that give each triangle its own, and without points of no triangle.
fn welded(points_mm: &[PointMm], triangles: &[[u32; 3]]) -> (Vec<PointMm>, Vec<[u32; 3]>) {
    let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut places_mm = Vec::new();
    let mut number = |corner: u32| {
        // 0 and −0 are one place.
        let place_mm = points_mm[corner as usize].map(|at| at + 0.0);
        *numbers.entry(place_mm.map(f64::to_bits)).or_insert_with(|| {
            places_mm.push(place_mm);
            places_mm.len() as u32 - 1
        })
    };
    let triangles: Vec<[u32; 3]> =
        triangles.iter().map(|corners| corners.map(&mut number)).collect();
    (places_mm, triangles)
}

/// An angle between facets above which the normals would be off by more than medial balls may have.
const SHARP_RAD: f64 = 0.53;

/// A facet along a side: whether the side runs upwards in it, its normal, and its height over the side in mm.
type Along = (bool, [f64; 3], f64);

/// The largest angle between facets, and the largest height of an arc over a facet, mm.
fn bent(points_mm: &[PointMm], triangles: &[[u32; 3]]) -> Result<(f64, f64), NoReach> {
    let place = |corner: u32| points_mm[corner as usize];
    let mut sides: BTreeMap<(u32, u32), Vec<Along>> = BTreeMap::new();
    for &[a, b, c] in triangles {
        let normal = cross(minus(place(b), place(a)), minus(place(c), place(a)));
        let Some(direction) = unit(normal) else { continue };
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let height_mm = length(normal) / length(minus(place(to), place(from)));
            let facets = sides.entry((from.min(to), from.max(to))).or_default();
            facets.push((from < to, direction, height_mm));
        }
    }
    let (mut angle_rad, mut arc_mm) = (0.0_f64, 0.0_f64);
    for (&(from, _), facets) in &sides {
        let at_mm = place(from);
        let [(up, one, one_mm), (down, other, other_mm)] = facets[..] else {
            return Err(NoReach::NotClosed { at_mm, triangles: facets.len() });
        };
        if up == down {
            return Err(NoReach::NotClosed { at_mm, triangles: 2 });
        }
        let angle = length(cross(one, other)).atan2(dot(one, other));
        if angle > SHARP_RAD {
            return Err(NoReach::Sharp { angle_rad: angle, at_mm });
        }
        angle_rad = angle_rad.max(angle);
        arc_mm = arc_mm.max(angle * one_mm.min(other_mm) / 8.0);
    }
    Ok((angle_rad, arc_mm))
}

/// Places on a mesh with normals.
struct Sampled {
    places_mm: Vec<PointMm>,
    normals: Vec<[f64; 3]>,
    /// No place of the mesh is farther from these, mm.
    gap_mm: f64,
}

impl Sampled {
    fn of(points_mm: &[PointMm], triangles: &[[u32; 3]]) -> Sampled {
        let place = |corner: u32| points_mm[corner as usize];
        let mut normals = vec![[0.0; 3]; points_mm.len()];
        let mut area_mm2 = 0.0;
        for &corners in triangles {
            let [a, b, c] = corners.map(place);
            let normal = cross(minus(b, a), minus(c, a));
            area_mm2 += length(normal) / 2.0;
            let Some(direction) = unit(normal) else { continue };
            // Weighted by the angle at the corner: so a face cut into more triangles counts no more.
            for (at, corner) in corners.into_iter().enumerate() {
                let [own, next, last] = [at, at + 1, at + 2].map(|at| place(corners[at % 3]));
                let (u, v) = (minus(next, own), minus(last, own));
                let angle = length(cross(u, v)).atan2(dot(u, v));
                let sum = &mut normals[corner as usize];
                *sum = [0, 1, 2].map(|axis| sum[axis] + angle * direction[axis]);
            }
        }
        let normals: Vec<[f64; 3]> =
            normals.into_iter().map(|normal| unit(normal).unwrap_or_default()).collect();
        let step_mm = (area_mm2 / SAMPLES).sqrt();
        let mut sampled =
            Sampled { places_mm: points_mm.to_vec(), normals: normals.clone(), gap_mm: 0.0 };
        for &corners in triangles {
            sampled.add(corners.map(place), corners.map(|at| normals[at as usize]), step_mm);
        }
        sampled
    }

    /// Samples a triangle whose sides are longer than a step.
    fn add(&mut self, corners: [PointMm; 3], normals: [[f64; 3]; 3], step_mm: f64) {
        let [a, b, c] = corners;
        let longest_mm =
            [minus(b, a), minus(c, b), minus(a, c)].map(length).into_iter().fold(0.0, f64::max);
        let pieces = (longest_mm / step_mm).ceil().clamp(1.0, MOST_PIECES) as u32;
        // The farthest place of a triangle is nearer to a corner than the longest side over √3.
        self.gap_mm = self.gap_mm.max(longest_mm / f64::from(pieces) / 3_f64.sqrt());
        if pieces == 1 {
            return;
        }
        for i in 0..=pieces {
            for j in 0..=pieces - i {
                let shares = [i, j, pieces - i - j].map(|at| f64::from(at) / f64::from(pieces));
                let mean = |of: [[f64; 3]; 3]| {
                    [0, 1, 2].map(|axis| (0..3).map(|at| shares[at] * of[at][axis]).sum::<f64>())
                };
                let flat = mean(corners);
                // Each corner's tangent plane lies twice as high above a facet of a quadric as the quadric does, in the mean.
                let mut place = flat;
                for at in 0..3 {
                    let height = dot(minus(corners[at], flat), normals[at]) * shares[at] / 2.0;
                    place = plus(place, height, normals[at]);
                }
                self.places_mm.push(place);
                self.normals.push(mean(normals));
            }
        }
    }
}

/// Share of the largest angle between facets by which a normal at a vertex is off. It is far less where facets are alike, and four times as
/// much where a plane goes over into an arc.
const NORMAL_SHARE: f64 = 1.0 / 16.0;

/// Samples that a mesh of few facets gets.
const SAMPLES: f64 = 2_500.0;

/// Most pieces of a side.
const MOST_PIECES: f64 = 400.0;
