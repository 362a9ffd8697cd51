//! Every triangle against the target: its gap, its ε, its area in the aperture, and whether it is covered.
//!
//! One pass over the triangles in chunks of a fixed size, which rayon's threads share: sums are made chunk
//! by chunk and joined in their order, so the figures do not depend on how many threads there are.

use rayon::prelude::*;

use super::aperture::Aperture;
use super::border::{Border, Whereabouts};
use super::clip::common_area_mm2;
use super::density::{Crumpling, Density, Facet};
use super::spread::{Range, Weighted, quantiles};
use super::tally::Tally;
use super::target::Target;
use crate::area::Sum;
use crate::exact::Place;
use crate::point::place;
use crate::triangle::{Gap, Triangle, lesser, sizes};
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

/// The local feature size at each point in mm; NaN where it is not known.
pub(super) fn lfs_at_points_mm(
    points: &[PointMm],
    lfs_mm: &(impl Fn(f64, f64) -> Option<f64> + Sync),
) -> Vec<f64> {
    let at = |&[x, y, _]: &PointMm| sound_lfs(lfs_mm(x, y)).unwrap_or(f64::NAN);
    points.par_iter().with_min_len(CHUNK).map(at).collect()
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
    /// Whether the triangle lies inside as a whole and bridges nothing: a facet of the surface.
    pub(super) facets: Vec<bool>,
    /// Whether the triangle is covered and has a part in the aperture.
    pub(super) covered: Vec<bool>,
    /// Between which values gaps, ε and areas lie.
    pub(super) extents: Extents,
}

/// Between which values the figures of triangles lie that have an area in the aperture.
#[derive(Clone, Copy, Default)]
pub(super) struct Extents {
    pub(super) gaps_mm: Range,
    pub(super) epsilons: Range,
    pub(super) areas_mm2: Range,
}

impl Extents {
    /// An ε that is not known is NaN.
    #[inline(always)]
    fn note(&mut self, gap_mm: f64, epsilon: f64, area_mm2: f64) {
        self.gaps_mm.note(gap_mm);
        self.epsilons.note(epsilon);
        self.areas_mm2.note(area_mm2);
    }

    fn join(&mut self, other: Extents) {
        self.gaps_mm.join(other.gaps_mm);
        self.epsilons.join(other.epsilons);
        self.areas_mm2.join(other.areas_mm2);
    }
}

impl Columns {
    /// The quantiles of gaps, of ε and of the areas of facets.
    pub(super) fn quantiles(&self) -> [Option<[f64; 2]>; 3] {
        let Columns { gaps_mm, epsilons, areas_mm2, facets, extents, .. } = self;
        let of = |values, range| Weighted { values, areas: areas_mm2, chosen: None, range };
        let facets = Weighted { chosen: Some(facets), ..of(areas_mm2, extents.areas_mm2) };
        quantiles([of(gaps_mm, extents.gaps_mm), of(epsilons, extents.epsilons), facets])
    }
}

/// What triangles are gauged with.
pub(super) struct Gauger<'a, F> {
    pub(super) points: &'a [PointMm],
    pub(super) triangles: &'a [[VertexId; 3]],
    /// Indices, ascending, of triangles that are bridges whatever their gap.
    pub(super) left_out: &'a [usize],
    /// Gaps of triangles, by ascending index, that are not those of their corners.
    pub(super) refined: &'a [(usize, Gap)],
    /// Without one every triangle counts.
    pub(super) aperture: Option<(&'a Aperture, &'a Border)>,
    pub(super) target: &'a Target,
    pub(super) density: Option<&'a Density>,
    pub(super) lfs_mm: &'a F,
    /// The local feature size at each point in mm: see [`lfs_at_points_mm`].
    pub(super) at_points_mm: &'a [f64],
}

impl<F: Fn(f64, f64) -> Option<f64> + Sync> Gauger<'_, F> {
    /// Gauges all triangles. Linear time.
    pub(super) fn gauge(&self) -> Gauges {
        let count = self.triangles.len();
        let column = || vec![0.0; count];
        let mut columns = Columns {
            gaps_mm: column(),
            epsilons: column(),
            areas_mm2: column(),
            facets: vec![false; count],
            covered: vec![false; count],
            extents: Extents::default(),
        };
        let aperture_mm2 = self.aperture.map_or(0.0, |(aperture, _)| aperture.area_mm2());
        let chunk = Chunk { gauger: self, aperture_mm2 };
        let parts: Vec<Part> = columns
            .gaps_mm
            .par_chunks_mut(CHUNK)
            .zip(columns.epsilons.par_chunks_mut(CHUNK))
            .zip(columns.areas_mm2.par_chunks_mut(CHUNK))
            .zip(columns.facets.par_chunks_mut(CHUNK))
            .zip(columns.covered.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(number, ((((gaps_mm, epsilons), areas_mm2), facets), covered))| {
                let rows = Rows { gaps_mm, epsilons, areas_mm2, facets, covered };
                chunk.gauge(number * CHUNK, rows)
            })
            .collect();
        let (mut covered, mut open, mut area) = (Tally::default(), Vec::new(), Sum::default());
        for part in parts {
            covered.join(part.covered);
            open.extend(part.open);
            area.join(part.area);
            columns.extents.join(part.extents);
        }
        let mut gauges = Gauges { columns, covered, open, area_mm2: area.total() };
        self.find_bridges(&mut gauges);
        gauges
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
    facets: &'a mut [bool],
    covered: &'a mut [bool],
}

/// What a chunk comes to.
#[derive(Default)]
struct Part {
    covered: Tally,
    open: Vec<Gauged>,
    area: Sum,
    extents: Extents,
}

/// What the triangles of a chunk are gauged with.
struct Chunk<'a, F> {
    gauger: &'a Gauger<'a, F>,
    aperture_mm2: f64,
}

impl<F: Fn(f64, f64) -> Option<f64> + Sync> Chunk<'_, F> {
    /// Gauges the triangles from `first` on, as many as there are rows.
    fn gauge(&self, first: usize, mut rows: Rows<'_>) -> Part {
        let Gauger { triangles, left_out, target, density, .. } = *self.gauger;
        let from = self.gauger.refined.partition_point(|&(index, _)| index < first);
        let mut refined = self.gauger.refined[from..].iter().peekable();
        let from = left_out.partition_point(|&index| index < first);
        let mut left_out = left_out[from..].iter().peekable();
        let mut part = Part::default();
        let (mut plain, mut block) = (Plain::new(target, density), Block::default());
        let last = first + rows.covered.len();
        let mut next = first;
        while next < last {
            // Up to the next triangle of which something is known beforehand.
            let thin = refined.peek().map_or(last, |(index, _)| *index);
            let marked = left_out.peek().map_or(last, |index| **index);
            let until = last.min(thin).min(marked).min(next + BLOCK);
            self.measure(&triangles[next..until], &mut block);
            for (index, figures) in (next..until).zip(&block.figures) {
                let row = index - first;
                if figures.whereabouts == Whereabouts::Outside {
                    rows.gaps_mm[row] = figures.gap_mm;
                    part.area.add(figures.facet.area_mm2);
                } else if plain.takes(figures) {
                    let corners = triangles[index];
                    self.add_plainly(corners, row, figures, &mut rows, &mut part, &mut plain);
                } else {
                    self.gauge_with_care(index, None, false, row, &mut rows, &mut part);
                }
            }
            next = until;
            if until < last && (until == thin || until == marked) {
                let gap = refined.next_if(|&&(index, _)| index == until).map(|&(_, gap)| gap);
                let is_left_out = left_out.next_if(|&&index| index == until).is_some();
                self.gauge_with_care(until, gap, is_left_out, until - first, &mut rows, &mut part);
                next += 1;
            }
        }
        part.area.join(plain.area);
        part.covered.add_plain(&plain);
        part
    }

    /// Finds the figures of up to [`BLOCK`] triangles. In two steps, each of which is short enough that the
    /// processor works on several triangles at a time.
    fn measure(&self, triangles: &[[VertexId; 3]], block: &mut Block) {
        let Gauger { points, aperture, lfs_mm, .. } = *self.gauger;
        let border = aperture.map(|(_, border)| border);
        let rows = block.figures.iter_mut().zip(&mut block.places);
        for (&corners, (figures, gap_at)) in triangles.iter().zip(rows) {
            // One by one: as an array they would go through memory.
            let [a, b, c] = corners;
            let (p, q, r) = (points[a as usize], points[b as usize], points[c as usize]);
            let sizes = sizes(p, q, r);
            let [short_mm2, middle_mm2, long_mm2] = sizes.squares_mm2;
            let [sharp, blunt, third] = sizes.weights();
            let at = |index: usize| &points[corners[index] as usize];
            let (s, o, t) = (at(sizes.sharp), at(sizes.blunt), at(sizes.third()));
            *gap_at = [0, 1].map(|axis| sharp * s[axis] + blunt * o[axis] + third * t[axis]);
            let whereabouts = match border {
                _ if !sizes.is_stout() => Whereabouts::Near,
                Some(border) => border.whereabouts_of(place(p), long_mm2),
                None => Whereabouts::Inside,
            };
            *figures = PlainFigures {
                whereabouts,
                gap_mm: sizes.gap_mm,
                lfs_mm: f64::NAN,
                facet: Facet {
                    area_mm2: sizes.area_mm2,
                    projected_mm2: sizes.projected_area_mm2,
                    squares_mm2: short_mm2 + middle_mm2 + long_mm2,
                },
            };
        }
        let rows = block.figures.iter_mut().zip(&block.places);
        for (&[a, b, c], (figures, &[x_mm, y_mm])) in triangles.iter().zip(rows) {
            let at_mm = self.gauger.at_points_mm;
            let (a, b, c) = (at_mm[a as usize], at_mm[b as usize], at_mm[c as usize]);
            let gap = lfs_mm(x_mm, y_mm).unwrap_or(f64::NAN);
            // NaN where one of them is.
            let all = (a + b) + (c + gap);
            let least = lesser(lesser(a, b), lesser(c, gap));
            figures.lfs_mm = if all > 0.0 { least } else { f64::NAN };
        }
    }

    /// Counts a triangle that is covered and lies inside as a whole.
    #[inline(always)]
    fn add_plainly(
        &self,
        corners: [VertexId; 3],
        row: usize,
        &PlainFigures { gap_mm, lfs_mm, facet, .. }: &PlainFigures,
        rows: &mut Rows<'_>,
        part: &mut Part,
        plain: &mut Plain,
    ) {
        let epsilon = gap_mm / lfs_mm;
        let Extents { gaps_mm, epsilons, .. } = &part.extents;
        if gaps_mm.is_below(gap_mm) || epsilons.is_below(epsilon) {
            let gap = Triangle::new(self.gauger.points, corners).gap();
            part.covered.note(gap, Some(lfs_mm));
        }
        part.extents.note(gap_mm, epsilon, facet.area_mm2);
        rows.gaps_mm[row] = gap_mm;
        rows.epsilons[row] = epsilon;
        rows.areas_mm2[row] = facet.area_mm2;
        rows.facets[row] = true;
        rows.covered[row] = true;
        plain.count += 1;
        plain.lfs_min_mm = lesser(lfs_mm, plain.lfs_min_mm);
        plain.projected.add(facet.projected_mm2);
        plain.area.add(facet.area_mm2);
        if let Some(crumpling) = &mut plain.crumpling {
            crumpling.add(&facet);
        }
    }

    /// Gauges any triangle, whose gap is that of its corners where none is given.
    fn gauge_with_care(
        &self,
        index: usize,
        gap: Option<Gap>,
        is_left_out: bool,
        row: usize,
        rows: &mut Rows<'_>,
        part: &mut Part,
    ) {
        let Gauger { points, triangles, aperture, target, density, lfs_mm, .. } = *self.gauger;
        let triangle = Triangle::new(points, triangles[index]);
        let in_space_mm2 = triangle.area_mm2();
        part.area.add(in_space_mm2);
        let gap = gap.unwrap_or_else(|| triangle.gap());
        rows.gaps_mm[row] = gap.mm;
        let [a, b, c] = triangles[index].map(|corner| corner as usize);
        let places = [place(points[a]), place(points[b]), place(points[c])];
        let whereabouts =
            aperture.map_or(Whereabouts::Inside, |(_, border)| border.whereabouts(places));
        if whereabouts == Whereabouts::Outside {
            return;
        }
        let projected_mm2 = triangle.projected_area_mm2();
        let whole_mm2 = projected_mm2.max(0.0);
        let area_mm2 = match (whereabouts, aperture) {
            (Whereabouts::Near, Some((aperture, border))) => {
                common_area_mm2(aperture, self.aperture_mm2, border, places).min(whole_mm2)
            }
            _ => whole_mm2,
        };
        let at = self.gauger.at_points_mm;
        let at_gap = sound_lfs(lfs_mm(gap.at_mm[0], gap.at_mm[1]));
        let lfs_mm = at_gap.map(|at_gap| smaller(smaller(at[a], at[b]), smaller(at[c], at_gap)));
        let lfs_mm = lfs_mm.filter(|lfs_mm| !lfs_mm.is_nan());
        rows.epsilons[row] = lfs_mm.map_or(f64::NAN, |lfs_mm| gap.mm / lfs_mm);
        if area_mm2 > 0.0 {
            rows.areas_mm2[row] = in_space_mm2 * (area_mm2 / whole_mm2);
            rows.facets[row] = area_mm2 >= whole_mm2 * (1.0 - ROUNDING);
            part.extents.note(gap.mm, rows.epsilons[row], rows.areas_mm2[row]);
        }
        let gap_limit_mm = target.gap_mm(lfs_mm);
        let is_covered = !is_left_out
            && gap_limit_mm.is_some_and(|limit_mm| gap.mm <= limit_mm * (1.0 + ROUNDING));
        if is_covered {
            if area_mm2 > 0.0 {
                rows.covered[row] = true;
                part.covered.add(gap, lfs_mm, area_mm2);
            }
            if let Some(density) = density.filter(|_| rows.facets[row]) {
                part.covered.add_facet(density, &Facet::of(&triangle));
            }
        } else {
            let standing = if is_left_out { Standing::Bridge } else { Standing::Undersampled };
            part.open.push(Gauged { index, standing, gap, lfs_mm, whereabouts, area_mm2 });
        }
    }
}

/// The figures of a triangle, found without a branch that half of the triangles take. They differ by rounding
/// from those of [`Triangle`].
#[derive(Clone, Copy)]
struct PlainFigures {
    /// Near also where rounding may matter.
    whereabouts: Whereabouts,
    gap_mm: f64,
    /// The smallest local feature size at its corners and at the place of its gap; NaN where it is not known.
    lfs_mm: f64,
    facet: Facet,
}

/// Some triangles one after the other.
struct Block {
    figures: [PlainFigures; BLOCK],
    /// The places of the gaps.
    places: [Place; BLOCK],
}

impl Default for Block {
    fn default() -> Block {
        let none = PlainFigures {
            whereabouts: Whereabouts::Near,
            gap_mm: f64::NAN,
            lfs_mm: f64::NAN,
            facet: Facet::default(),
        };
        Block { figures: [none; BLOCK], places: [[0.0; 2]; BLOCK] }
    }
}

/// What triangles come to that are covered and lie inside as a whole, as nearly all do.
pub(super) struct Plain {
    /// The largest gap in mm wherever it is, and the largest ε.
    gap_limit_mm: f64,
    epsilon_limit: f64,
    pub(super) count: u64,
    /// The smallest local feature size.
    pub(super) lfs_min_mm: f64,
    /// Area in the plane.
    pub(super) projected: Sum,
    /// Area in space.
    pub(super) area: Sum,
    /// How far noise turns them, if that is asked and known.
    pub(super) crumpling: Option<Crumpling>,
}

impl Plain {
    fn new(target: &Target, density: Option<&Density>) -> Plain {
        Plain {
            gap_limit_mm: target.gap_anywhere_mm(),
            epsilon_limit: target.epsilon.unwrap_or(f64::INFINITY),
            count: 0,
            lfs_min_mm: f64::INFINITY,
            projected: Sum::default(),
            area: Sum::default(),
            crumpling: density.and_then(Crumpling::new),
        }
    }

    /// Whether a triangle with these figures is clearly one of them. What lies between the limit and the limit
    /// with [`ROUNDING`] is looked at with care.
    #[inline(always)]
    fn takes(&self, &PlainFigures { whereabouts, gap_mm, lfs_mm, facet }: &PlainFigures) -> bool {
        let limit_mm = lesser(self.gap_limit_mm, self.epsilon_limit * lfs_mm);
        // Written so that NaN is none.
        whereabouts == Whereabouts::Inside
            && lfs_mm > 0.0
            && facet.projected_mm2 > 0.0
            && gap_mm <= limit_mm * (1.0 + 0.5 * ROUNDING)
    }
}

/// NaN if either is.
fn smaller(left: f64, right: f64) -> f64 {
    if left < right || left.is_nan() { left } else { right }
}

/// Triangles of a chunk. Sums over it are part of the result.
const CHUNK: usize = 1 << 14;

/// Triangles of a block: its figures stay in the nearest cache.
const BLOCK: usize = 64;

/// A gap above its limit by so small a share is within: a raster at the target's spacing meets it.
const ROUNDING: f64 = 1e-9;

/// A triangle bridges if its gap is more than so many times the smallest gap at each of its corners.
/// On a raster that is a hole of about five spacings across; scattered samples rarely have it.
const BRIDGE: f64 = 3.0;
