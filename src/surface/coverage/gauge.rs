//! Every triangle against the target: its gap, its ε, its area in the aperture, and whether it is covered.
//!
//! One pass over the triangles in chunks of a fixed size, which rayon's threads share: sums are made chunk
//! by chunk and joined in their order, so the figures do not depend on how many threads there are.

use asphera_geometry::{Gap, PointMm, Sum, Triangle, VertexId, place};
use rayon::prelude::*;

use super::aperture::Aperture;
use super::block::{BLOCK, Block, Limits, largest, smallest, total};
use super::border::{Border, Whereabouts};
use super::bridges::find_bridges;
use super::clip::common_area_mm2;
use super::clipped_gap::clipped_gap;
use super::density::{Crumpling, Density, Facet};
use super::facet_median::{Distribution, Window};
use super::nearer::{Surface, is_blunt, is_doubtful};
use super::percentiles::{Placed, Places, Values, values_of};
use super::tally::Tally;
use super::target::Target;

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
    /// The smallest local feature size at its corners.
    pub(super) lfs_mm: Option<f64>,
    pub(super) whereabouts: Whereabouts,
    /// Its area in the plane inside the aperture.
    pub(super) area_mm2: f64,
    /// The share of that whose places are not within the target.
    pub(super) beyond: f64,
    /// Whether it lies inside the aperture as a whole.
    pub(super) is_whole: bool,
    /// Whether samples that are none of its corners may bring its gap within the target.
    is_doubtful: bool,
}

impl Gauged {
    /// One that is taken to lie inside the aperture as a whole, until more is known of it.
    fn whole(index: usize, triangle: &Triangle, lfs_mm: Option<f64>) -> Gauged {
        Gauged {
            index,
            standing: Standing::Undersampled,
            gap: triangle.gap(),
            lfs_mm,
            whereabouts: Whereabouts::Inside,
            area_mm2: triangle.projected_area_mm2().max(0.0),
            beyond: 0.0,
            is_whole: true,
            is_doubtful: false,
        }
    }

    pub(super) fn epsilon(&self) -> Option<f64> {
        self.lfs_mm.map(|lfs_mm| self.gap.mm / lfs_mm)
    }

    /// Whether it is a facet of the surface.
    pub(super) fn is_facet(&self) -> bool {
        self.is_whole && self.standing != Standing::Bridge
    }

    /// Its area in the plane inside the aperture of places that are not within the target.
    pub(super) fn beyond_mm2(&self) -> f64 {
        self.beyond * self.area_mm2
    }

    /// As it counts for percentiles.
    pub(super) fn placed(&self, triangle: &Triangle) -> Placed {
        let whole_mm2 = triangle.projected_area_mm2();
        Placed {
            nearness: triangle.nearness(self.gap.mm),
            weight: if self.area_mm2 > 0.0 { self.area_mm2 / whole_mm2 } else { 0.0 },
            lfs_mm: self.lfs_mm.unwrap_or(f64::NAN),
        }
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
    /// The figures of the covered ones.
    pub(super) covered: Tally,
    /// How the areas of those that are facets are distributed.
    pub(super) facets: Distribution,
    /// What those hold up to the values that were asked for.
    pub(super) places: Places,
    /// Those of them, by ascending index, that were not measured plainly.
    pub(super) cared: Vec<(usize, Placed)>,
    /// Whether each triangle is covered and has a part in the aperture.
    pub(super) is_covered: Vec<bool>,
    /// Those that are not covered, by ascending index.
    pub(super) open: Vec<Gauged>,
    /// Area in space of all triangles, wherever they are.
    pub(super) area_mm2: f64,
}

/// Where medians and percentiles lie, as some of the triangles tell.
#[derive(Clone, Copy)]
pub(super) struct Guess {
    pub(super) facets: Window,
    pub(super) places: Values,
}

/// What triangles are gauged with.
pub(super) struct Gauger<'a> {
    pub(super) points: &'a [PointMm],
    pub(super) triangles: &'a [[VertexId; 3]],
    /// Indices, ascending, of triangles that are bridges whatever their gap.
    pub(super) left_out: &'a [usize],
    /// Triangles, by ascending index, whose circumcentre lies beyond the hull, with upper bounds of their gaps.
    pub(super) refined: &'a [(usize, Gap)],
    /// Without one every triangle counts.
    pub(super) aperture: Option<(&'a Aperture, &'a Border)>,
    pub(super) target: &'a Target,
    pub(super) density: Option<&'a Density>,
    /// The local feature size at each point in mm: see [`lfs_at_points_mm`].
    pub(super) at_points_mm: &'a [f64],
}

impl Gauger<'_> {
    /// Gauges all triangles. Linear time.
    pub(super) fn gauge(&self, guess: Guess) -> Gauges {
        let mut is_covered = vec![false; self.triangles.len()];
        let parts: Vec<Part> = is_covered
            .par_chunks_mut(CHUNK)
            .enumerate()
            .map_init(Block::new, |block, (number, rows)| {
                Chunk::new(self, guess).gauge(number * CHUNK, rows, block)
            })
            .collect();
        let mut gauges = Gauges {
            covered: Tally::default(),
            facets: Distribution::new(guess.facets),
            places: Places::up_to(guess.places),
            cared: Vec::new(),
            is_covered,
            open: Vec::new(),
            area_mm2: 0.0,
        };
        let mut area = Sum::default();
        let mut unnoted = Vec::new();
        for mut part in parts {
            area.join(part.area);
            unnoted.append(&mut part.unnoted);
            gauges.join(part);
        }
        gauges.area_mm2 = area.total();
        self.settle(&mut gauges, unnoted, guess);
        find_bridges(self.points, self.triangles, self.refined, &mut gauges.open);
        gauges
    }

    /// Settles the gaps that samples beside their triangles may bring down, as far as that matters.
    fn settle(&self, gauges: &mut Gauges, mut unnoted: Vec<Gauged>, guess: Guess) {
        let [gap_mm, epsilon] = gauges.most().map(|most| most * (1.0 + ROUNDING));
        unnoted.retain(|it| it.gap.mm > gap_mm || it.epsilon().is_some_and(|own| own > epsilon));
        let open = gauges.open.iter_mut().filter(|gauged| gauged.is_doubtful);
        let doubtful: Vec<&mut Gauged> = unnoted.iter_mut().chain(open).collect();
        if doubtful.is_empty() {
            return;
        }
        let chosen: Vec<_> = doubtful.iter().map(|gauged| (gauged.index, gauged.gap)).collect();
        let border = self.aperture.map(|(_, border)| border);
        let surface = Surface { points: self.points, triangles: self.triangles, border };
        let mut chunk = Chunk::new(self, guess);
        for (gauged, gap) in doubtful.into_iter().zip(surface.gaps(&chosen)) {
            gauged.gap = gap;
            if !gauged.is_doubtful {
                gauges.covered.note(gap, gauged.lfs_mm);
                continue;
            }
            let triangle = Triangle::new(self.points, self.triangles[gauged.index]);
            gauges.is_covered[gauged.index] = chunk.count(*gauged, &triangle, false);
            if let Some(settled) = chunk.part.open.pop() {
                *gauged = settled;
            }
        }
        // What is doubtful still was found covered.
        gauges.open.retain(|gauged| !gauged.is_doubtful);
        gauges.join(chunk.part);
        gauges.cared.sort_by_key(|(index, _)| *index);
    }

    /// Where medians and percentiles lie, as some of the triangles tell.
    pub(super) fn guess(&self) -> Guess {
        let count = self.triangles.len();
        // An odd step does not always meet the same of the two triangles of a square.
        let step = (count / SAMPLE) | 1;
        let sampled: Vec<Vec<Placed>> = (0..count.div_ceil(step * BLOCK))
            .into_par_iter()
            .with_min_len(SAMPLE / BLOCK / 8)
            .map_init(Block::new, |block, number| self.sample(number * step * BLOCK, step, block))
            .collect();
        let sampled = sampled.concat();
        let areas_mm2 = sampled.iter().map(|placed| placed.nearness.area_mm2).collect();
        let facets = if step == 1 { Window::ALL } else { Window::about(areas_mm2) };
        Guess { facets, places: values_of(&sampled) }
    }

    /// What [`BLOCK`] triangles come to, so many apart, as far as they lie inside.
    fn sample(&self, first: usize, step: usize, block: &mut Block) -> Vec<Placed> {
        let corners = self.triangles[first..].iter().copied().step_by(step);
        let count = block.measure(self.points, self.at_points_mm, corners);
        let inside = |&row: &usize| self.whereabouts(block, row) == Whereabouts::Inside;
        let placed = |row: usize| {
            let (nearness, lfs_mm) = (block.nearness(row), block.lfs_mm[row]);
            Placed { nearness, weight: 1.0, lfs_mm }
        };
        (0..count).filter(inside).map(placed).collect()
    }

    /// What all covered triangles hold up to other values; those that were not measured plainly are given.
    pub(super) fn places(
        &self,
        values: Values,
        is_covered: &[bool],
        cared: &[(usize, Placed)],
    ) -> Places {
        let parts: Vec<Places> = is_covered
            .par_chunks(CHUNK)
            .enumerate()
            .map_init(Block::new, |block, (number, is_covered)| {
                let first = number * CHUNK;
                let from = cared.partition_point(|(index, _)| *index < first);
                let to = cared.partition_point(|(index, _)| *index < first + is_covered.len());
                self.places_of(first, values, (is_covered, &cared[from..to]), block)
            })
            .collect();
        let mut places = Places::up_to(values);
        parts.into_iter().for_each(|part| places.join(part));
        places
    }

    fn places_of(
        &self,
        first: usize,
        values: Values,
        (is_covered, cared): (&[bool], &[(usize, Placed)]),
        block: &mut Block,
    ) -> Places {
        let mut places = Places::up_to(values);
        let mut with_care = cared.iter().map(|(index, _)| *index).peekable();
        for (number, is_covered) in is_covered.chunks(BLOCK).enumerate() {
            let first = first + number * BLOCK;
            let corners = self.triangles[first..first + is_covered.len()].iter().copied();
            block.measure(self.points, self.at_points_mm, corners);
            for (row, is_covered) in is_covered.iter().enumerate() {
                let is_cared = with_care.next_if_eq(&(first + row)).is_some();
                if !is_covered || is_cared {
                    block.take_out(row);
                }
            }
            places.add_block(block, total(|row| block.area_mm2[row]));
        }
        cared.iter().for_each(|(_, placed)| places.add(placed));
        places
    }

    /// Where a triangle of a block lies; near also where rounding may spoil its figures.
    #[inline(always)]
    fn whereabouts(&self, block: &Block, row: usize) -> Whereabouts {
        let long_mm2 = block.long_mm2[row];
        match self.aperture {
            _ if long_mm2 == f64::INFINITY => Whereabouts::Near,
            None => Whereabouts::Inside,
            Some((aperture, border)) => {
                let corner = block.place(row);
                match border.whereabouts_of(corner, long_mm2) {
                    Whereabouts::Near => aperture.whereabouts_about(corner, long_mm2.sqrt()),
                    clear => clear,
                }
            }
        }
    }
}

impl Gauges {
    /// Adds what a chunk comes to.
    fn join(&mut self, part: Part) {
        self.covered.join(part.covered);
        self.facets.join(part.facets);
        self.places.join(part.places);
        self.cared.extend(part.cared);
        self.open.extend(part.open);
    }

    /// The largest gap in mm and the largest ε of what is not doubtful; 0 where none is known.
    fn most(&self) -> [f64; 2] {
        let open = self.open.iter().filter(|it| it.area_mm2 > 0.0 && !it.is_doubtful);
        open.fold(self.covered.most(), |[gap_mm, epsilon], gauged| {
            [gap_mm.max(gauged.gap.mm), epsilon.max(gauged.epsilon().unwrap_or(0.0))]
        })
    }
}

/// What a chunk comes to.
struct Part {
    covered: Tally,
    facets: Distribution,
    places: Places,
    cared: Vec<(usize, Placed)>,
    open: Vec<Gauged>,
    /// Covered ones that are counted but for their gap and ε, which nearer samples may bring down.
    unnoted: Vec<Gauged>,
    area: Sum,
}

/// The triangles of a chunk, as they are gauged.
struct Chunk<'a> {
    gauger: &'a Gauger<'a>,
    aperture_mm2: f64,
    limits: Limits,
    plain: Plain,
    part: Part,
}

impl<'a> Chunk<'a> {
    fn new(gauger: &'a Gauger<'a>, guess: Guess) -> Chunk<'a> {
        Chunk {
            gauger,
            aperture_mm2: gauger.aperture.map_or(0.0, |(aperture, _)| aperture.area_mm2()),
            // What lies between the limit and the limit with all of that is looked at with care.
            limits: Limits::of(gauger.target, 1.0 + 0.5 * ROUNDING),
            plain: Plain::new(gauger.density),
            part: Part {
                covered: Tally::default(),
                facets: Distribution::new(guess.facets),
                places: Places::up_to(guess.places),
                cared: Vec::new(),
                open: Vec::new(),
                unnoted: Vec::new(),
                area: Sum::default(),
            },
        }
    }

    /// Gauges the triangles from `first` on, as many as there are rows.
    fn gauge(mut self, first: usize, is_covered: &mut [bool], block: &mut Block) -> Part {
        let Gauger { refined, left_out, .. } = *self.gauger;
        let from = refined.partition_point(|&(index, _)| index < first);
        let mut refined = refined[from..].iter().peekable();
        let from = left_out.partition_point(|&index| index < first);
        let mut left_out = left_out[from..].iter().peekable();
        let last = first + is_covered.len();
        let mut next = first;
        while next < last {
            // Up to the next triangle of which something is known beforehand.
            let thin = refined.peek().map_or(last, |(index, _)| *index);
            let marked = left_out.peek().map_or(last, |index| **index);
            let until = last.min(thin).min(marked).min(next + BLOCK);
            self.gauge_block(next, &mut is_covered[next - first..until - first], block);
            next = until;
            if until < last && (until == thin || until == marked) {
                let gap = refined.next_if(|&&(index, _)| index == until).map(|&(_, gap)| gap);
                let is_left_out = left_out.next_if(|&&index| index == until).is_some();
                is_covered[until - first] = self.gauge_with_care(until, gap, is_left_out);
                next += 1;
            }
        }
        self.part.area.join(self.plain.area);
        self.part.covered.add_plain(&self.plain);
        self.part
    }

    /// Gauges up to [`BLOCK`] triangles: those that are covered and lie inside as a whole, as nearly all do, at
    /// once; the others one by one.
    fn gauge_block(&mut self, first: usize, is_covered: &mut [bool], block: &mut Block) {
        let Gauger { points, triangles, at_points_mm, .. } = *self.gauger;
        let triangles = &triangles[first..first + is_covered.len()];
        block.measure(points, at_points_mm, triangles.iter().copied());
        let mut within = [false; BLOCK];
        block.within(&self.limits, &mut within);
        for (row, is_covered) in is_covered.iter_mut().enumerate() {
            match self.gauger.whereabouts(block, row) {
                Whereabouts::Inside if within[row] => {
                    *is_covered = true;
                    self.plain.count += 1;
                }
                Whereabouts::Outside => {
                    self.part.area.add(block.area_mm2[row]);
                    block.take_out(row);
                }
                Whereabouts::Inside | Whereabouts::Near => {
                    *is_covered = self.gauge_with_care(first + row, None, false);
                    block.take_out(row);
                }
            }
        }
        self.add_plainly(first, triangles, block);
    }

    /// Counts all that is left in a block, which begins with the triangle `first`.
    fn add_plainly(&mut self, first: usize, triangles: &[[VertexId; 3]], block: &Block) {
        let Plain { largest_gap_mm, largest_epsilon, .. } = &mut self.plain;
        let (gap_mm, epsilon) = (largest(&block.gap_mm), largest(&block.epsilon));
        if gap_mm > *largest_gap_mm || epsilon > *largest_epsilon {
            for (row, &corners) in triangles.iter().enumerate() {
                let (gap_mm, epsilon) = (block.gap_mm[row], block.epsilon[row]);
                if gap_mm > *largest_gap_mm || epsilon > *largest_epsilon {
                    let triangle = Triangle::new(self.gauger.points, corners);
                    if let Some((_, border)) = self.gauger.aperture
                        && is_blunt(&triangle)
                        && is_doubtful(&triangle, border)
                    {
                        let lfs_mm = Some(block.lfs_mm[row]);
                        self.part.unnoted.push(Gauged::whole(first + row, &triangle, lfs_mm));
                        continue;
                    }
                    self.part.covered.note(triangle.gap(), Some(block.lfs_mm[row]));
                    *largest_gap_mm = largest_gap_mm.max(gap_mm);
                    *largest_epsilon = largest_epsilon.max(epsilon);
                }
            }
        }
        let area_mm2 = total(|row| block.area_mm2[row]);
        self.plain.area.add(area_mm2);
        self.plain.projected.add(total(|row| block.projected_mm2[row]));
        self.plain.lfs_min_mm = self.plain.lfs_min_mm.min(smallest(&block.lfs_mm));
        if let Some(crumpling) = &mut self.plain.crumpling {
            crumpling.add_block(block);
        }
        self.part.facets.add_block(block, area_mm2);
        self.part.places.add_block(block, area_mm2);
    }

    /// Gauges any triangle, whose gap is that of its corners where none is given; says whether it is covered and
    /// has a part in the aperture.
    fn gauge_with_care(&mut self, index: usize, gap: Option<Gap>, is_left_out: bool) -> bool {
        let Gauger { points, triangles, aperture, at_points_mm, .. } = *self.gauger;
        let triangle = Triangle::new(points, triangles[index]);
        self.part.area.add(triangle.area_mm2());
        let [a, b, c] = triangles[index].map(|corner| corner as usize);
        let places = [place(points[a]), place(points[b]), place(points[c])];
        let whereabouts =
            aperture.map_or(Whereabouts::Inside, |(_, border)| border.whereabouts(places));
        if whereabouts == Whereabouts::Outside {
            return false;
        }
        let is_thin = gap.is_some();
        let mut gauged = Gauged::whole(index, &triangle, None);
        gauged.gap = gap.unwrap_or(gauged.gap);
        let whole_mm2 = gauged.area_mm2;
        let mut is_clipped = false;
        if let (Whereabouts::Near, Some((aperture, border))) = (whereabouts, aperture) {
            let area_mm2 = common_area_mm2(aperture, self.aperture_mm2, border, places);
            gauged.area_mm2 = area_mm2.min(whole_mm2);
            is_clipped = gauged.area_mm2 > 0.0 && gauged.area_mm2 < whole_mm2;
            if is_clipped {
                gauged.gap = clipped_gap(&triangle, gauged.gap, border);
            }
        }
        let lfs_mm = smaller(smaller(at_points_mm[a], at_points_mm[b]), at_points_mm[c]);
        gauged.lfs_mm = Some(lfs_mm).filter(|lfs_mm| !lfs_mm.is_nan());
        gauged.whereabouts = whereabouts;
        gauged.is_whole = gauged.area_mm2 > 0.0 && gauged.area_mm2 >= whole_mm2 * (1.0 - ROUNDING);
        if is_left_out {
            gauged.standing = Standing::Bridge;
        }
        // The circumcentre of a thin one lies beyond the hull.
        let lies_beyond = |(_, border)| is_doubtful(&triangle, border);
        let is_doubtful = !is_left_out
            && (is_thin
                || (is_clipped || is_blunt(&triangle)) && aperture.is_some_and(lies_beyond));
        self.count(gauged, &triangle, is_doubtful)
    }

    /// Counts a triangle, as far as its gap is not doubtful; says whether it is covered and has a part in the aperture.
    fn count(&mut self, mut gauged: Gauged, triangle: &Triangle, is_doubtful: bool) -> bool {
        let Gauger { target, density, .. } = *self.gauger;
        let part = &mut self.part;
        let is_left_out = gauged.standing == Standing::Bridge;
        let Gauged { index, gap, lfs_mm, area_mm2, .. } = gauged;
        let has_area = area_mm2 > 0.0;
        let limit_mm = target.gap_mm(lfs_mm).map(|limit_mm| limit_mm * (1.0 + ROUNDING));
        if is_left_out || limit_mm.is_none_or(|limit_mm| gap.mm > limit_mm) {
            gauged.is_doubtful = has_area && is_doubtful;
            gauged.beyond = match limit_mm {
                Some(limit_mm) if !is_left_out => triangle.nearness(gap.mm).share_beyond(limit_mm),
                _ => 1.0,
            };
            part.open.push(gauged);
            return false;
        }
        if has_area {
            part.covered.add(lfs_mm, area_mm2);
            if is_doubtful {
                part.unnoted.push(gauged);
            } else {
                part.covered.note(gap, lfs_mm);
            }
            let placed = gauged.placed(triangle);
            part.places.add(&placed);
            part.cared.push((index, placed));
            if gauged.is_whole {
                part.facets.add(triangle.area_mm2());
                if let Some(density) = density {
                    part.covered.add_facet(density, &Facet::of(triangle));
                }
            }
        }
        has_area
    }
}

/// What triangles come to that are covered and lie inside as a whole, as nearly all do.
pub(super) struct Plain {
    pub(super) count: u64,
    largest_gap_mm: f64,
    largest_epsilon: f64,
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
    fn new(density: Option<&Density>) -> Plain {
        Plain {
            count: 0,
            // Those of what does not count in a block are below.
            largest_gap_mm: -0.5,
            largest_epsilon: -0.5,
            lfs_min_mm: f64::INFINITY,
            projected: Sum::default(),
            area: Sum::default(),
            crumpling: density.and_then(Crumpling::new),
        }
    }
}

/// NaN if either is.
fn smaller(left: f64, right: f64) -> f64 {
    if left < right || left.is_nan() { left } else { right }
}

/// Triangles of a chunk. Sums over it are part of the result.
const CHUNK: usize = 1 << 14;

/// So many triangles or a few more are a sample.
const SAMPLE: usize = 1 << 13;

/// A gap above its limit by so small a share is within: a raster at the target's spacing meets it.
const ROUNDING: f64 = 1e-9;
