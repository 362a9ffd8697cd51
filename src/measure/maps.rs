//! Maps of the sampling: what was seen of the mesh, on the cells of the deviation map.

use asphera_form::{Aperture, Grid as MapGrid, Pose};
use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;
use asphera_report::{MAPS_FORMAT, MapLayer, SamplingMaps};
use asphera_surface::noise::{Along, Noise};
use asphera_surface::{Criteria, Facets, Grid, RasterError, chart};

use super::assessment::Assessment;
use crate::Part;

/// Where the maps of a part lie, and which they are.
pub(super) struct Raster<'a> {
    /// Their cells, in the part frame.
    pub(super) grid: &'a MapGrid,
    /// Tells them from others of the same part.
    pub(super) version: u64,
}

/// Maps of what was seen. A part is taken to lie at `pose` in the frame of the mesh, with a local feature size of
/// `lfs_mm` there.
///
/// # Errors
///
/// When the grid is none.
pub(super) fn maps(
    mesh: &Mesh,
    look: &Assessment,
    part: &Part,
    pose: &Pose,
    Raster { grid, version }: Raster<'_>,
    lfs_mm: impl Fn(f64, f64) -> Option<f64>,
) -> Result<SamplingMaps, RasterError> {
    let points = mesh.points();
    let sampling = &look.sampling;
    let sigma_nm = sampling.noise_sigma_nm;
    let noise = sigma_nm.and_then(|sigma_nm| Noise::new(1e-6 * sigma_nm, Along::Z).ok());
    let nodes = nodes(grid);
    let criteria = Criteria {
        gap_limit_mm: sampling.gap_allowed_mm(),
        epsilon_limit: sampling.epsilon_target,
        aperture_area_mm2: None,
    };
    let (turn, shift_mm) = (pose.rotation(), [pose.tx_mm, pose.ty_mm, pose.tz_mm]);
    // As `Pose::to_part`, which would make the rotation anew for every point.
    let on_chart = |point: PointMm| {
        [0, 1].map(|column| {
            (0..3).map(|row| turn[row][column] * (point[row] - shift_mm[row])).sum::<f64>()
        })
    };
    // What counts is where the centre of a triangle lies.
    let inside = |corners: &[VertexId; 3]| {
        let places = corners.map(|corner| on_chart(points[corner as usize]));
        let [x, y] = [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / 3.0);
        part.aperture.contains(x, y)
    };
    let triangles: Vec<[VertexId; 3]> = look.triangles.iter().copied().filter(inside).collect();
    let facets = Facets { points, triangles: &triangles };
    let found = chart(facets, &criteria, noise, &nodes, on_chart, lfs_mm)?;
    let layer = |values: &[Option<f64>], limit: Option<f64>| MapLayer {
        limit,
        values: values.iter().map(|value| value.and_then(four_digits)).collect(),
    };
    let in_mrad: Vec<Option<f64>> =
        found.tilt_rad.iter().map(|tilt| tilt.map(|rad| 1e3 * rad)).collect();
    Ok(SamplingMaps {
        format: MAPS_FORMAT,
        version,
        as_of_points: sampling.as_of_points,
        nx: nodes.nx,
        ny: nodes.ny,
        x0_mm: nodes.x0_mm,
        y0_mm: nodes.y0_mm,
        dx_mm: nodes.dx_mm,
        dy_mm: nodes.dy_mm,
        gap_mm: layer(&found.gap_mm, sampling.gap_allowed_mm()),
        epsilon: layer(&found.epsilon, sampling.epsilon_target),
        // Noise may turn a facet by as much as the surface may turn over a gap.
        tilt_mrad: layer(&in_mrad, sampling.share_allowed().map(|share| 1e3 * share)),
        undersampled: layer(&whole(&found.undersampled, &nodes, &part.aperture), None),
        noise_sigma_nm: sigma_nm,
        noise_unknown: (look.noise_unknown.clone())
            .or_else(|| sigma_nm.is_none().then(|| "it was not estimated".to_owned())),
    })
}

/// A node in the middle of every cell.
fn nodes(grid: &MapGrid) -> Grid {
    let dx_mm = (grid.x_max_mm - grid.x_min_mm) / grid.nx as f64;
    let dy_mm = (grid.y_max_mm - grid.y_min_mm) / grid.ny as f64;
    Grid {
        x0_mm: grid.x_min_mm + dx_mm / 2.0,
        y0_mm: grid.y_min_mm + dy_mm / 2.0,
        dx_mm,
        dy_mm,
        nx: grid.nx,
        ny: grid.ny,
    }
}

/// Where the middle of a cell lies in the aperture and no triangle reaches, all is missing.
fn whole(shares: &[Option<f64>], nodes: &Grid, aperture: &Aperture) -> Vec<Option<f64>> {
    let inside = |cell: usize| {
        let x_mm = nodes.x0_mm + (cell % nodes.nx) as f64 * nodes.dx_mm;
        let y_mm = nodes.y0_mm + (cell / nodes.nx) as f64 * nodes.dy_mm;
        *aperture != Aperture::None && aperture.contains(x_mm, y_mm)
    };
    shares
        .iter()
        .enumerate()
        .map(|(cell, share)| share.or_else(|| inside(cell).then_some(1.0)))
        .collect()
}

/// As many as a colour tells, and no more to send.
fn four_digits(value: f64) -> Option<f64> {
    if value == 0.0 {
        return Some(0.0);
    }
    let places = (10.0_f64).powi(3 - value.abs().log10().floor() as i32);
    let rounded = (value * places).round() / places;
    rounded.is_finite().then_some(rounded)
}
