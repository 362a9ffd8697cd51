//! Parts and samples the tests share.

mod lens;
mod places;

use asphera_form::Pose;

pub(crate) use lens::{al1815, misaligned, normals};
pub(crate) use places::{Noise, spiral};

/// Largest difference of two poses, mm and rad alike.
pub(crate) fn pose_difference(a: &Pose, b: &Pose) -> f64 {
    [
        a.tx_mm - b.tx_mm,
        a.ty_mm - b.ty_mm,
        a.tz_mm - b.tz_mm,
        a.rx_rad - b.rx_rad,
        a.ry_rad - b.ry_rad,
        a.rz_rad - b.rz_rad,
    ]
    .iter()
    .fold(0.0, |largest, difference| largest.max(difference.abs()))
}

/// Boustrophedon lines over the disc.
pub(crate) fn raster(count: usize, radius: f64) -> Vec<[f64; 2]> {
    let pitch = (std::f64::consts::PI * radius * radius / count as f64).sqrt();
    let lines = (2.0 * radius / pitch) as i32;
    let mut places = Vec::new();
    for line in 0..lines {
        let y = -radius + (f64::from(line) + 0.5) * pitch;
        let row = (0..lines).map(|column| -radius + (f64::from(column) + 0.5) * pitch);
        let mut row: Vec<[f64; 2]> =
            row.map(|x| [x, y]).filter(|p| p[0].hypot(p[1]) <= radius).collect();
        if line % 2 == 1 {
            row.reverse();
        }
        places.append(&mut row);
    }
    places
}
