//! Designs and meshes as entries of a library.

use asphera_formats::Triangles;
use asphera_geometry::vector::{dot, minus};
use asphera_geometry::{PointMm, sampled_surface};
use asphera_graph::library::LibraryEntry;
use asphera_measure::Part;
use asphera_reconstruct::prove;

/// Where the middle of the aperture of a nominal lies in the frame that `measure` takes its points in, x y z in mm. A surface that
/// slides has no place of its own, and counts from there.
pub(super) fn middle_mm(part: &Part) -> PointMm {
    match part.nominal.slides() {
        [false, false] => [0.0; 3],
        _ => [part.centre_mm[0], part.centre_mm[1], 0.0],
    }
}

/// Places of a design over its aperture, mm, in that frame; or why there are none, and the cure.
pub(super) fn places_of(part: &Part) -> Result<Vec<PointMm>, String> {
    if part.reference.is_some() {
        return Err(
            "a nominal without a design: expected a surface of another kind than unknown; give a scan of the part instead"
                .to_owned(),
        );
    }
    let half_mm = part.aperture.half_extents_mm().ok_or(
        "a nominal without an aperture: expected a table [aperture], which says how large the part is; add it",
    )?;
    let step_mm = (part.aperture.area_mm2() / GRID as f64).sqrt();
    let [columns, rows] = half_mm.map(|half_mm| (half_mm / step_mm).ceil() as i64);
    let [dx_mm, dy_mm] = [half_mm[0] / columns as f64, half_mm[1] / rows as f64];
    let middle_mm = middle_mm(part);
    let mut places = Vec::new();
    for row in -rows..=rows {
        for column in -columns..=columns {
            let [x_mm, y_mm] = [column as f64 * dx_mm, row as f64 * dy_mm];
            let height_mm = part.nominal.height_mm(x_mm, y_mm);
            if let Some(z_mm) = height_mm.filter(|_| part.aperture.contains(x_mm, y_mm)) {
                places.push([x_mm + middle_mm[0], y_mm + middle_mm[1], z_mm + middle_mm[2]]);
            }
        }
    }
    Ok(places)
}

/// A mesh as an entry: a body if it encloses one, else a face seen from its +z side; or why it is neither, and the cure.
pub(super) fn entry_of(name: &str, mesh: &Triangles) -> Result<LibraryEntry, String> {
    let Triangles { points_mm, triangles } = mesh;
    let proof = prove(points_mm, triangles).map_err(|error| error.to_string())?;
    if proof.is_closed && !proof.is_oriented {
        return Err(
            "a closed mesh whose triangles do not all turn the same way: expected counter-clockwise ones seen from outside; \
             orient it in the program that wrote it"
                .to_owned(),
        );
    }
    let places = sampled_surface(points_mm, triangles, SAMPLES, SEED);
    let points: Vec<PointMm> = places.iter().map(|place| place.at_mm).collect();
    // Of what encloses a body, but for small holes, the normals add up to nothing.
    let mean =
        |axis: usize| places.iter().map(|place| place.normal[axis]).sum::<f64>() / SAMPLES as f64;
    let sum = [0, 1, 2].map(mean);
    let is_body = proof.is_closed || (proof.is_oriented && dot(sum, sum).sqrt() < OPEN);
    let found = if is_body {
        let middle =
            [0, 1, 2].map(|axis| points.iter().map(|at| at[axis]).sum::<f64>() / SAMPLES as f64);
        // The volume of cones from the middle is positive where normals point outwards.
        let volume: f64 =
            places.iter().map(|place| dot(minus(place.at_mm, middle), place.normal)).sum();
        let outwards = |normal: [f64; 3]| normal.map(|side| side * volume.signum());
        let normals: Vec<PointMm> = places.iter().map(|place| outwards(place.normal)).collect();
        LibraryEntry::body(name, &points, &normals)
    } else {
        LibraryEntry::face(name, &points)
    };
    found.map_err(|error| error.to_string())
}

/// Places of a nominal in a library, about.
const GRID: usize = 4000;

/// Places drawn of a mesh in a library, and their seed.
const SAMPLES: usize = 20_000;
const SEED: u64 = 1;

/// Length of the mean normal from which on a mesh with borders is a face and no body with holes.
const OPEN: f64 = 0.05;
