//! Hybrid parameters: slopes and the developed area.

use super::{Grid, Mesh, Parameter, Support, Surface, Unknown};
use crate::Figure;

/// The hybrid parameters of ISO 25178-2:2021, 4.4, of the surface interpolated linearly on triangles.
///
/// On a mesh these are its own, and the figures exact for it. On a grid a cell of four measured corners
/// counts as the mean of its two divisions into triangles (D.3, Eq. D.15), so that no diagonal is preferred;
/// one of three counts as the one triangle these make; others are gaps. Without gaps Sdq is then the root of
/// half the mean over cells of the squared differences along their four edges, the same for either diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HybridParameters {
    /// Root mean square gradient in µrad, that is nm per mm.
    pub sdq_urad: f64,
    /// Share in percent by which the surface exceeds its projection.
    pub sdr_percent: f64,
    /// Triangles that count.
    pub triangles: usize,
    /// What they rest on; the area measured is that of the triangles.
    pub support: Support,
}

impl HybridParameters {
    /// Both.
    pub fn figures(&self) -> Vec<Figure> {
        let known =
            [(Parameter::Sdq, Some(self.sdq_urad)), (Parameter::Sdr, Some(self.sdr_percent))];
        Parameter::known(&known)
    }
}

/// The slopes and the developed area of a surface. `O(n)`. Unknown if no triangle is measured.
pub fn hybrid_parameters(surface: Surface<'_>) -> Result<HybridParameters, Unknown> {
    let support = surface.nodes()?.support;
    let (sums, total) = match surface {
        Surface::Grid(grid) => {
            (of_cells(grid), (grid.rows() - 1) as f64 * (grid.columns() - 1) as f64)
        }
        Surface::Mesh(mesh) => (of_triangles(mesh), mesh.total_mm2()),
    };
    if sums.area == 0.0 {
        return Err(Unknown::NoTriangle);
    }
    Ok(HybridParameters {
        sdq_urad: (sums.square / sums.area).sqrt() / RAD_PER_URAD,
        sdr_percent: 100.0 * sums.excess / sums.area,
        triangles: sums.triangles,
        support: Support { measured: sums.area / total, ..support },
    })
}

/// Sums over triangles, areas in any unit.
#[derive(Default)]
struct Sums {
    area: f64,
    square: f64,
    excess: f64,
    triangles: usize,
}

impl Sums {
    fn add(&mut self, area: f64, gradient: [f64; 2]) {
        let square = gradient[0] * gradient[0] + gradient[1] * gradient[1];
        self.triangles += 1;
        self.area += area;
        self.square += area * square;
        // √(1 + g²) − 1 without cancellation: optical surfaces have slopes of 1e-6.
        self.excess += area * square / (1.0 + (1.0 + square).sqrt());
    }
}

/// Sums over the cells of a grid, areas in cells.
fn of_cells(grid: &Grid) -> Sums {
    let mut sums = Sums::default();
    let [dx, dy] = grid.spacing_mm();
    let scale = [RAD_PER_URAD / dx, RAD_PER_URAD / dy];
    for row in 1..grid.rows() {
        for column in 1..grid.columns() {
            let at = |i: usize, j: usize| grid.at((row - 1 + j) * grid.columns() + column - 1 + i);
            // A triangle has one edge along x and one along y, which meet at its right angle (i, j).
            let triangle = |i: usize, j: usize| {
                let along_x = (at(1, j)? - at(0, j)?) * scale[0];
                let along_y = (at(i, 1)? - at(i, 0)?) * scale[1];
                Some([along_x, along_y])
            };
            let found = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| triangle(i, j));
            let whole = found.iter().flatten().count() == 4;
            for gradient in found.into_iter().flatten() {
                sums.add(if whole { 0.25 } else { 0.5 }, gradient);
            }
        }
    }
    sums
}

fn of_triangles(mesh: &Mesh) -> Sums {
    let mut sums = Sums::default();
    for [(a, za), (b, zb), (c, zc)] in mesh.whole_triangles() {
        let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let doubled = p[0] * q[1] - p[1] * q[0];
        if doubled == 0.0 {
            continue;
        }
        let (u, v) = ((zb - za) * RAD_PER_URAD / doubled, (zc - za) * RAD_PER_URAD / doubled);
        sums.add(0.5 * doubled.abs(), [u * q[1] - v * p[1], v * p[0] - u * q[0]]);
    }
    sums
}

/// nm per mm is µrad.
const RAD_PER_URAD: f64 = 1e-6;
