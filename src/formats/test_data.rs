//! Real files for tests, kept beside the project.

use std::path::PathBuf;

use crate::xyz::TextOptions;
use crate::{HeightMap, ReadError, Topography};

/// The bytes of a file of the shared data folder, or `None`, said on standard error, where it is
/// absent. The folder is the environment variable `ASPHERA_DATA`, or `../shared/data` beside the
/// repository.
pub(crate) fn shared(path: &str) -> Option<Vec<u8>> {
    let folder = std::env::var_os("ASPHERA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = folder.join(path);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        eprintln!("skipped: {} not found", path.display());
    }
    bytes
}

/// Holds a reader to it that a file which is cut at any byte is refused, or gives the same as the whole one, and that one with any
/// byte changed is read or refused, without a panic.
pub(crate) fn hold_against_damage(
    whole: &[u8],
    read: impl Fn(&[u8]) -> Result<Topography, ReadError>,
) {
    let expected = format!("{:?}", read(whole).unwrap());
    for len in 0..whole.len() {
        if let Ok(found) = read(&whole[..len]) {
            assert_eq!(format!("{found:?}"), expected, "cut to {len} of {} bytes", whole.len());
        }
    }
    hold_against_changes(whole, read);
}

/// The second half of [`hold_against_damage`].
pub(crate) fn hold_against_changes(
    whole: &[u8],
    read: impl Fn(&[u8]) -> Result<Topography, ReadError>,
) {
    let mut changed = whole.to_vec();
    for at in 0..whole.len() {
        for value in [whole[at] ^ 1, whole[at] ^ 0x80, !whole[at], 0, 0xFF, b'9', b' ', b'\n'] {
            changed[at] = value;
            // Whatever it says, it says.
            let _ = read(&changed);
        }
        changed[at] = whole[at];
    }
}

/// Holds the reader of meshes to it that a file which is cut or changed at any byte is read or refused, without a panic, and that
/// every triangle it gives has its corners.
pub(crate) fn hold_mesh_against_damage(name: &str, whole: &[u8]) {
    let hold = |bytes: &[u8]| {
        if let Ok(Some(mesh)) = crate::read_triangles(name, bytes, &TextOptions::default()) {
            let corners = mesh.triangles.iter().flatten();
            let has = |&corner: &u32| mesh.points_mm[corner as usize].iter().all(|v| v.is_finite());
            assert!(corners.into_iter().all(has));
        }
    };
    (0..whole.len()).for_each(|len| hold(&whole[..len]));
    let mut changed = whole.to_vec();
    for at in 0..whole.len() {
        for value in [whole[at] ^ 1, whole[at] ^ 0x80, !whole[at], 0, 0xFF, b'9', b' ', b'\n'] {
            changed[at] = value;
            hold(&changed);
        }
        changed[at] = whole[at];
    }
}

/// Root mean square of a complete map about its least-squares polynomial of degree 1 or 2, in mm.
///
/// On a complete grid the terms x, y, xy, x² and y², each less its mean and counted from the middle,
/// are orthogonal, so that each coefficient stands alone.
pub(crate) fn sq_about_polynomial_mm(map: &HeightMap, degree: usize) -> f64 {
    let (nx, ny) = (map.nx as f64, map.ny as f64);
    let place = |index: usize| {
        let (column, row) = ((index % map.nx) as f64, (index / map.nx) as f64);
        // The mean square of n whole steps about their middle is (n² − 1) / 12.
        let (x, y) = (column - (nx - 1.0) / 2.0, row - (ny - 1.0) / 2.0);
        [1.0, x, y, x * y, x * x - (nx * nx - 1.0) / 12.0, y * y - (ny * ny - 1.0) / 12.0]
    };
    let mut rest = map.z_mm.clone();
    for term in 0..[1, 3, 6][degree] {
        let (mut product, mut square) = (0.0, 0.0);
        for (index, z_mm) in rest.iter().enumerate() {
            let value = place(index)[term];
            product += value * z_mm;
            square += value * value;
        }
        for (index, z_mm) in rest.iter_mut().enumerate() {
            *z_mm -= product / square * place(index)[term];
        }
    }
    (rest.iter().map(|z_mm| z_mm * z_mm).sum::<f64>() / rest.len() as f64).sqrt()
}
