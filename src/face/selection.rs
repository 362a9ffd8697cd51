//! The part of a surface that a nominal describes.

use asphera_form::{Aperture, Nominal, Pose};
use asphera_surface::Plane;

use crate::body::Skin;
use asphera_geometry::vector::{Vector, dot};

/// Vertices of a surface that belong to a face.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Selection {
    /// Their numbers, ascending.
    pub(crate) vertices: Vec<u32>,
    /// Vertices that fit too, but hang together with none of these.
    pub(crate) apart: u64,
    /// Vertices near the nominal that stand steeper to it than [`STEEPEST_DEG`].
    pub(crate) steep: u64,
}

/// Where a nominal lies.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    pub(crate) nominal: &'a Nominal,
    pub(crate) aperture: &'a Aperture,
    /// The frame in which the pose is one.
    pub(crate) plane: &'a Plane,
    pub(crate) pose: &'a Pose,
}

/// The largest piece of the surface within the aperture, grown by `margin_mm`, whose normals are within [`STEEPEST_DEG`] of
/// the nominal's.
pub(crate) fn select(skin: &Skin, at: Place<'_>, margin_mm: f64, near_mm: f64) -> Selection {
    let motion = at.pose.motion();
    let rotation = at.pose.rotation();
    let aperture = at.aperture.widened(margin_mm);
    let least = STEEPEST_DEG.to_radians().cos();
    let axes = at.plane.axes();
    let mut steep = 0;
    let mut fits = vec![false; skin.places_mm.len()];
    for (vertex, fits) in fits.iter_mut().enumerate() {
        let [x, y, z] = motion.to_part(at.plane.to_plane(skin.places_mm[vertex]));
        if !aperture.contains(x, y) {
            continue;
        }
        let Some(jet) = at.nominal.jet(x, y) else { continue };
        let normal = axes.map(|axis| dot(axis, skin.normals[vertex]));
        // The inverse of the rotation is its transpose.
        let normal = [0, 1, 2].map(|i| (0..3).map(|j| rotation[j][i] * normal[j]).sum::<f64>());
        let [gx, gy] = jet.gradient;
        let long = (1.0 + gx * gx + gy * gy).sqrt();
        let cosine = (normal[2] - gx * normal[0] - gy * normal[1]) / long;
        *fits = cosine >= least;
        let is_steep = !*fits && cosine > 0.0 && (z - jet.z_mm).abs() < near_mm * long;
        steep += u64::from(is_steep && at.aperture.contains(x, y));
    }
    let (vertices, apart) = largest_piece(&skin.surface.triangles, &fits);
    Selection { vertices, apart, steep }
}

/// The largest piece of those vertices that hang together by triangles, and how many others there are. Of equal ones the piece with
/// the lowest number.
pub(crate) fn largest_piece(triangles: &[[u32; 3]], is_in: &[bool]) -> (Vec<u32>, u64) {
    let mut parents: Vec<u32> = (0..is_in.len() as u32).collect();
    fn root(parents: &mut [u32], mut item: u32) -> u32 {
        while parents[item as usize] != item {
            parents[item as usize] = parents[parents[item as usize] as usize];
            item = parents[item as usize];
        }
        item
    }
    for &[a, b, c] in triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if is_in[a as usize] && is_in[b as usize] {
                let (a, b) = (root(&mut parents, a), root(&mut parents, b));
                parents[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut counts = vec![0_u64; is_in.len()];
    let members = || (0..is_in.len() as u32).filter(|&vertex| is_in[vertex as usize]);
    for vertex in members() {
        counts[root(&mut parents, vertex) as usize] += 1;
    }
    let all: u64 = counts.iter().sum();
    let first = (0_usize, 0_u64);
    let (largest, most) = counts
        .iter()
        .enumerate()
        .fold(first, |best, (piece, &count)| if count > best.1 { (piece, count) } else { best });
    let vertices = members().filter(|&vertex| root(&mut parents, vertex) as usize == largest);
    let vertices: Vec<u32> = if most == 0 { Vec::new() } else { vertices.collect() };
    (vertices, all - most)
}

/// The steepest slope of the nominal over the aperture as an angle; infinite without an aperture.
pub(crate) fn steepest_rad(nominal: &Nominal, aperture: &Aperture) -> f64 {
    let Some([half_x_mm, half_y_mm]) = aperture.half_extents_mm() else { return f64::INFINITY };
    let mut steepest = 0.0_f64;
    for i in -LOOKS..=LOOKS {
        for j in -LOOKS..=LOOKS {
            let place = [(i, half_x_mm), (j, half_y_mm)]
                .map(|(step, half_mm)| f64::from(step) / f64::from(LOOKS) * half_mm);
            let jet = nominal.jet(place[0], place[1]);
            let inside = aperture.contains(place[0], place[1]);
            if let Some(jet) = jet.filter(|_| inside) {
                steepest = steepest.max(jet.gradient[0].hypot(jet.gradient[1]));
            }
        }
    }
    steepest.atan()
}

/// The vertices whose normals are nearer to `axis` than `angle_rad`, the largest piece of them.
pub(crate) fn facing(skin: &Skin, axis: Vector, angle_rad: f64) -> Vec<u32> {
    let least = angle_rad.cos();
    let is_in: Vec<bool> = skin.normals.iter().map(|&normal| dot(normal, axis) >= least).collect();
    largest_piece(&skin.surface.triangles, &is_in).0
}

/// The largest angle between the normals of surface and nominal.
pub(crate) const STEEPEST_DEG: f64 = 30.0;
/// Places looked at from the middle of the aperture to its border.
const LOOKS: i32 = 16;
