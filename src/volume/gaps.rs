//! Gaps of a scan, missing samples and the border: where a surface ends, and what may lie in them.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use crate::blur::area_to_border;
use crate::cells::mixed_codes;
use crate::fractions::marching_areas;
use crate::scan::{Gaps, Scan};
use crate::{BlurredArea, Samples, Surface, blurred_area};

impl Surface {
    /// The surface without the triangles that reach into a cell with a corner in a gap; it ends there. The vertices must be in samples,
    /// of a volume of `size` columns, rows and slices.
    ///
    /// A triangle in a face between two cells reaches into both. Vertices without a triangle are dropped; all others stay in their
    /// order.
    pub fn without_gaps(self, size: [usize; 3], gaps: Gaps<'_>) -> Surface {
        let is_beyond = |cells: &RangeInclusive<i64>, side: usize| {
            *cells.start() < 0 || *cells.end() + 1 >= side as i64
        };
        let reaches = |triangle: &[u32; 3]| {
            let corners = triangle.map(|corner| self.vertices[corner as usize]);
            let along = [0, 1, 2].map(|axis| cells_along(corners.map(|at| at[axis])));
            if gaps.at_border && along.iter().zip(size).any(|(cells, side)| is_beyond(cells, side))
            {
                return true;
            }
            let Some(missing) = gaps.missing else { return false };
            let [x, y, z] = along;
            let mut cells = z.flat_map(|z| y.clone().map(move |y| (y, z)));
            cells.any(|(y, z)| x.clone().any(|x| is_near(missing, [x, y, z])))
        };
        let mut triangles = self.triangles.clone();
        triangles.retain(|triangle| !reaches(triangle));
        let mut number = vec![u32::MAX; self.vertices.len()];
        triangles.as_flattened().iter().for_each(|&corner| number[corner as usize] = 0);
        let mut vertices = Vec::new();
        for (number, vertex) in number.iter_mut().zip(self.vertices) {
            if *number == 0 {
                *number = vertices.len() as u32;
                vertices.push(vertex);
            }
        }
        triangles
            .as_flattened_mut()
            .iter_mut()
            .for_each(|corner| *corner = number[*corner as usize]);
        Surface { vertices, triangles }
    }
}

/// The cells along one axis, by their lowest samples, that three coordinates reach into; both, of a face between two.
fn cells_along(corners: [f64; 3]) -> RangeInclusive<i64> {
    let low = corners.into_iter().fold(f64::INFINITY, f64::min);
    let high = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let (first, last) = ((low + TOUCH).floor() as i64, (high - TOUCH).ceil() as i64 - 1);
    first.min(last)..=first.max(last)
}

/// Distance from the border of a cell, spacings, within which a vertex lies on it.
const TOUCH: f64 = 1e-9;

/// Whether the cell with this lowest sample has a corner on a missing sample.
fn is_near(missing: &Samples, [x, y, z]: [i64; 3]) -> bool {
    (0..8).any(|corner| missing.get([x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)]))
}

/// The area of the surface outside the gaps, by blurring; see [`blurred_area`].
///
/// At an open border the surface ends in the outermost samples. Missing samples first take the value of most of their neighbours, layer by layer, so that the surface goes on
/// through them. Of the area that this volume has, the cells without a missing corner have the share that marching cubes give them.
/// `u` counts how far the ratio of the two areas, and the surface that was put in, may be off: a tenth of the share that was taken off,
/// for the area of marching cubes is 2 to 15 % too large, by the direction of the surface.
///
/// # Panics
///
/// Where the sizes differ.
pub fn open_area(samples: &Samples, gaps: Gaps<'_>) -> BlurredArea {
    let filled = gaps.missing.map(|missing| filled(samples, missing));
    let scanned = filled.as_ref().unwrap_or(samples);
    let found = if gaps.at_border { area_to_border(scanned) } else { blurred_area(scanned) };
    let Some(missing) = gaps.missing else { return found };
    let at_border = Gaps { missing: None, ..gaps };
    let whole = marching_area(Scan::new(scanned, at_border));
    let open = marching_area(Scan::new(scanned, Gaps { missing: Some(missing), ..gaps }));
    if whole <= open {
        return found;
    }
    let area = found.area * open / whole;
    let of_gaps = FILLED_SHARE * found.area * (1.0 - open / whole) * (open / whole);
    let u = (found.u * open / whole).hypot(of_gaps);
    BlurredArea { area, u, ..found }
}

/// Standard uncertainty of the area that was taken off, as a share of it.
const FILLED_SHARE: f64 = 0.1;

/// The area of marching cubes.
fn marching_area(scan: Scan<'_>) -> f64 {
    let of_code = marching_areas();
    let of_layer = |z: usize| {
        let mut area = 0.0;
        scan.mixed_words(z, |_, word, corners, mixed| {
            mixed_codes(word, corners, mixed, |_, code| area += of_code[usize::from(code)]);
        });
        area
    };
    let layers: Vec<f64> = (0..=scan.samples.size()[2]).into_par_iter().map(of_layer).collect();
    layers.into_iter().sum()
}

/// The volume with missing samples foreground, too: the most that may be material.
///
/// # Panics
///
/// Where the sizes differ.
pub fn with_missing(samples: &Samples, missing: &Samples) -> Samples {
    assert_eq!(samples.size(), missing.size(), "missing samples have the size of the volume");
    let mut most = samples.clone();
    let [_, ny, nz] = samples.size();
    for z in 1..=nz {
        for y in 1..=ny {
            let row = most.row_mut(y, z).iter_mut();
            row.zip(missing.row(y, z)).for_each(|(word, missing)| *word |= missing);
        }
    }
    most
}

/// The volume with missing samples filled from their neighbours, layer by layer: each takes the value of most of its 26 neighbours that
/// have one, foreground where they are as many. Beyond [`LAYERS`] layers they stay background.
fn filled(samples: &Samples, missing: &Samples) -> Samples {
    let (mut samples, mut missing) = (samples.clone(), missing.clone());
    for _ in 0..LAYERS {
        let layer = layer(&samples, &missing);
        if layer.is_empty() {
            break;
        }
        for (place, is_inside) in layer {
            samples.set(place, is_inside);
            missing.set(place, false);
        }
    }
    samples
}

/// Layers that are filled: wider gaps end a surface that goes into them.
const LAYERS: usize = 64;

/// Missing samples that have a neighbour with a value, and what most of these neighbours are.
fn layer(samples: &Samples, missing: &Samples) -> Vec<([usize; 3], bool)> {
    let [nx, ny, nz] = samples.size();
    let of_slice = |z: usize| {
        let mut found = Vec::new();
        for y in 0..ny {
            for (word, &bits) in missing.row(y + 1, z + 1).iter().enumerate() {
                let mut bits = bits;
                while bits != 0 {
                    let place = [word * 64 + bits.trailing_zeros() as usize - 1, y, z];
                    bits &= bits - 1;
                    let value = most_about(samples, missing, place, [nx, ny, nz]);
                    found.extend(value.map(|value| (place, value)));
                }
            }
        }
        found
    };
    (0..nz).into_par_iter().flat_map_iter(of_slice).collect()
}

/// The value of most neighbours of a sample that have one; `None` where none has.
fn most_about(
    samples: &Samples,
    missing: &Samples,
    place: [usize; 3],
    size: [usize; 3],
) -> Option<bool> {
    let (mut known, mut inside) = (0, 0);
    for step in 0..27 {
        let to = [step % 3, step / 3 % 3, step / 9];
        let [x, y, z] = [0, 1, 2].map(|axis| place[axis] + to[axis]);
        // Neighbours count from 1, as rows of the padded volume do; beyond the volume nothing is known.
        let is_within =
            (1..=size[0]).contains(&x) && (1..=size[1]).contains(&y) && (1..=size[2]).contains(&z);
        if is_within && !missing.padded_bit(x, y, z) {
            known += 1;
            inside += u32::from(samples.padded_bit(x, y, z));
        }
    }
    (known > 0).then_some(2 * inside >= known)
}
