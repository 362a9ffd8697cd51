//! Every triangle against the target: its gap, its ε, its area in the aperture, and whether it is covered.
//!
//! One pass over the triangles in chunks of a fixed size, which rayon's threads share: sums are made chunk
//! by chunk and joined in their order, so the figures do not depend on how many threads there are.

use rayon::prelude::*;

use super::aperture::Aperture;
use super::border::{Border, Whereabouts};
use super::clip::common_area_mm2;
use super::density::Density;
use super::tally::Tally;
use super::target::Target;
use crate::area::Sum;
use crate::point::place;
use crate::rim::{Outline, refined_gaps_along};
use crate::triangle::{Gap, Triangle};
use crate::{PointMm, VertexId};

/// What a triangle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// Its gap is not within the target, or the target cannot be told there; but at one of its corners
    /// samples are about as far apart as here.
    Undersampled,
    /// Its gap is not within the target, and far above those at all of its corners: it bridges what
    /// nobody scanned.
    Bridge,
}

/// A triangle that is not covered, with a part in the aperture or near it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gauged {
    pub(super) index: usize,
    pub(super) standing: Standing,
    pub(super) gap: Gap,
    /// The smallest local feature size at its corners and at the place of its gap.
    pub(super) lfs_mm: Option<f64>,
    pub(super) whereabouts: Whereabouts,
    /// Its area in the plane inside the aperture.
    pub(super) area_mm2: f64,
}

impl Gauged {
    pub(super) fn epsilon(&self) -> Option<f64> {
        self.lfs_mm.map(|lfs_mm| self.gap.mm / lfs_mm)
    }
}

/// The local feature size as a caller tells it, or none if it is no positive number.
pub(super) fn sound_lfs(lfs_mm: Option<f64>) -> Option<f64> {
    lfs_mm.filter(|&lfs_mm| lfs_mm > 0.0)
}

/// All triangles against the target.
pub(super) struct Gauges {
    /// One for each triangle.
    pub(super) columns: Columns,
    /// The figures of the covered ones.
    pub(super) covered: Tally,
    /// Those that are not covered, by ascending index.
    pub(super) open: Vec<Gauged>,
    /// Area in space of all triangles, wherever they are.
    pub(super) area_mm2: f64,
}

/// Figures of the triangles, one each.
#[derive(Default)]
pub(super) struct Columns {
    pub(super) gaps_mm: Vec<f64>,
    /// NaN where the local feature size is not known.
    pub(super) epsilons: Vec<f64>,
    /// The area in space inside the aperture.
    pub(super) areas_mm2: Vec<f64>,
    /// The area in space of facets that lie inside as a whole and bridge nothing, else 0.
    pub(super) facets_mm2: Vec<f64>,
    /// Whether the triangle is covered and has a part in the aperture.
    pub(super) covered: Vec<bool>,
}

/// What triangles are gauged with.
pub(super) struct Gauger<'a, F> {
    pub(super) points: &'a [PointMm],
    pub(super) triangles: &'a [[VertexId; 3]],
    /// Indices, ascending, of triangles that are bridges whatever their gap.
    pub(super) left_out: &'a [usize],
    pub(super) outline: &'a Outline,
    /// Without one every triangle counts.
    pub(super) aperture: Option<(&'a Aperture, &'a Border)>,
    pub(super) target: &'a Target,
    pub(super) density: Option<&'a Density>,
    pub(super) lfs_mm: &'a F,
}

impl<F: Fn(f64, f64) -> Option<f64> + Sync> Gauger<'_, F> {
    /// Gauges all triangles. Linear time.
    pub(super) fn gauge(&self) -> Gauges {
        let (at_points_mm, refined) = rayon::join(
            || self.lfs_at_points_mm(),
            || refined_gaps_along(self.points, self.triangles, self.outline),
        );
        let count = self.triangles.len();
        let column = || vec![0.0; count];
        let mut columns = Columns {
            gaps_mm: column(),
            epsilons: column(),
            areas_mm2: column(),
            facets_mm2: column(),
            covered: vec![false; count],
        };
        let aperture_mm2 = self.aperture.map_or(0.0, |(aperture, _)| aperture.area_mm2());
        let chunk =
            Chunk { gauger: self, at_points_mm: &at_points_mm, refined: &refined, aperture_mm2 };
        let parts: Vec<Part> = columns
            .gaps_mm
            .par_chunks_mut(CHUNK)
            .zip(columns.epsilons.par_chunks_mut(CHUNK))
            .zip(columns.areas_mm2.par_chunks_mut(CHUNK))
            .zip(columns.facets_mm2.par_chunks_mut(CHUNK))
            .zip(columns.covered.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(number, ((((gaps_mm, epsilons), areas_mm2), facets_mm2), covered))| {
                let rows = Rows { gaps_mm, epsilons, areas_mm2, facets_mm2, covered };
                chunk.gauge(number * CHUNK, rows)
            })
            .collect();
        let (mut covered, mut open, mut area) = (Tally::default(), Vec::new(), Sum::default());
        for part in parts {
            covered.join(part.covered);
            open.extend(part.open);
            area.join(part.area);
        }
        let mut gauges = Gauges { columns, covered, open, area_mm2: area.total() };
        self.find_bridges(&mut gauges);
        gauges
    }

    /// NaN where it is not known.
    fn lfs_at_points_mm(&self) -> Vec<f64> {
        let at = |&[x, y, _]: &PointMm| sound_lfs((self.lfs_mm)(x, y)).unwrap_or(f64::NAN);
        self.points.par_iter().with_min_len(CHUNK).map(at).collect()
    }

    /// Which open triangles are bridges: for each vertex the smallest gap of a triangle there tells how far
    /// apart samples are about it. A bridge has a large gap, but of the triangles at a sample on the rim of a
    /// hole some are surface.
    fn find_bridges(&self, gauges: &mut Gauges) {
        if gauges.open.iter().all(|gauged| gauged.standing == Standing::Bridge) {
            return;
        }
        let mut about_mm = vec![f64::NAN; self.points.len()];
        for gauged in &gauges.open {
            for corner in self.triangles[gauged.index] {
                about_mm[corner as usize] = f64::INFINITY;
            }
        }
        for (corners, &gap_mm) in self.triangles.iter().zip(&gauges.columns.gaps_mm) {
            for &corner in corners {
                let about_mm = &mut about_mm[corner as usize];
                // NaN stays: nobody asks there.
                if gap_mm < *about_mm {
                    *about_mm = gap_mm;
                }
            }
        }
        for gauged in &mut gauges.open {
            let corners = self.triangles[gauged.index].iter();
            let about_mm = corners.map(|&corner| about_mm[corner as usize]).fold(0.0, f64::max);
            if gauged.gap.mm > BRIDGE * about_mm {
                gauged.standing = Standing::Bridge;
            }
        }
    }
}

/// The rows of a chunk.
struct Rows<'a> {
    gaps_mm: &'a mut [f64],
    epsilons: &'a mut [f64],
    areas_mm2: &'a mut [f64],
    facets_mm2: &'a mut [f64],
    covered: &'a mut [bool],
}

/// What a chunk comes to.
struct Part {
    covered: Tally,
    open: Vec<Gauged>,
    area: Sum,
}

/// What the triangles of a chunk are gauged with.
struct Chunk<'a, F> {
    gauger: &'a Gauger<'a, F>,
    at_points_mm: &'a [f64],
    refined: &'a [(usize, Gap)],
    aperture_mm2: f64,
}

impl<F: Fn(f64, f64) -> Option<f64> + Sync> Chunk<'_, F> {
    fn gauge(&self, first: usize, rows: Rows<'_>) -> Part {
        let Gauger { points, triangles, left_out, aperture, target, density, lfs_mm, .. } =
            *self.gauger;
        let from = self.refined.partition_point(|&(index, _)| index < first);
        let mut refined = self.refined[from..].iter().peekable();
        let from = left_out.partition_point(|&index| index < first);
        let mut left_out = left_out[from..].iter().peekable();
        let mut part = Part { covered: Tally::default(), open: Vec::new(), area: Sum::default() };
        let Rows { gaps_mm, epsilons, areas_mm2, facets_mm2, covered } = rows;
        for row in 0..gaps_mm.len() {
            let index = first + row;
            let corners = triangles[index];
            let [a, b, c] = corners;
            // Written out, for speed: through a closure each corner is a call.
            let (p, q, r) = (points[a as usize], points[b as usize], points[c as usize]);
            let triangle = Triangle::of([p, q, r], corners);
            let in_space_mm2 = triangle.area_mm2();
            part.area.add(in_space_mm2);
            let gap = match refined.next_if(|&&(thin, _)| thin == index) {
                Some(&(_, gap)) => gap,
                None => triangle.gap(),
            };
            gaps_mm[row] = gap.mm;
            let is_left_out = left_out.next_if(|&&other| other == index).is_some();
            let places = [place(p), place(q), place(r)];
            let whereabouts =
                aperture.map_or(Whereabouts::Inside, |(_, border)| border.whereabouts(places));
            if whereabouts == Whereabouts::Outside {
                continue;
            }
            let whole_mm2 = triangle.projected_area_mm2().max(0.0);
            let area_mm2 = match (whereabouts, aperture) {
                (Whereabouts::Near, Some((aperture, border))) => {
                    common_area_mm2(aperture, self.aperture_mm2, border, places).min(whole_mm2)
                }
                _ => whole_mm2,
            };
            let at = self.at_points_mm;
            let (a, b, c) = (at[a as usize], at[b as usize], at[c as usize]);
            let at_gap = sound_lfs(lfs_mm(gap.at_mm[0], gap.at_mm[1]));
            let lfs_mm = at_gap.map(|at_gap| smaller(smaller(a, b), smaller(c, at_gap)));
            let lfs_mm = lfs_mm.filter(|lfs_mm| !lfs_mm.is_nan());
            epsilons[row] = lfs_mm.map_or(f64::NAN, |lfs_mm| gap.mm / lfs_mm);
            if area_mm2 > 0.0 {
                areas_mm2[row] = in_space_mm2 * (area_mm2 / whole_mm2);
                if area_mm2 >= whole_mm2 * (1.0 - ROUNDING) {
                    facets_mm2[row] = in_space_mm2;
                }
            }
            let gap_limit_mm = target.gap_mm(lfs_mm);
            let is_covered = !is_left_out
                && gap_limit_mm.is_some_and(|limit_mm| gap.mm <= limit_mm * (1.0 + ROUNDING));
            if is_covered {
                if area_mm2 > 0.0 {
                    covered[row] = true;
                    part.covered.add(gap, lfs_mm, area_mm2);
                }
                if let Some(density) = density.filter(|_| facets_mm2[row] > 0.0) {
                    part.covered.add_facet(density, &triangle, in_space_mm2);
                }
            } else {
                let standing = if is_left_out { Standing::Bridge } else { Standing::Undersampled };
                part.open.push(Gauged { index, standing, gap, lfs_mm, whereabouts, area_mm2 });
            }
        }
        part
    }
}

/// NaN if either is.
fn smaller(left: f64, right: f64) -> f64 {
    if left < right || left.is_nan() { left } else { right }
}

/// Triangles of a chunk. Sums over it are part of the result.
const CHUNK: usize = 1 << 14;

/// A gap above its limit by so small a share is within: a raster at the target's spacing meets it.
const ROUNDING: f64 = 1e-9;

/// A triangle bridges if its gap is more than so many times the smallest gap at each of its corners.
/// On a raster that is a hole of about five spacings across; scattered samples rarely have it.
const BRIDGE: f64 = 3.0;
