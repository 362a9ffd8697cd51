//! Links between near places: what hangs together at the finest scale that the points allow.

use asphera_geometry::greater;
use rayon::prelude::*;

use crate::auto::{self, tau_by};
use crate::cloud::{Cloud, PlaceId};
use crate::nearest::Entry;
use crate::tree::{by_coordinates, squared_distance};

/// The places that each place is linked with, however far they are.
///
/// A place is linked with its twelve nearest, and with farther ones where it has no nearer link within 45° of their direction. So
/// links bridge gaps of the sampling, and are short elsewhere. Which links there are does not hang on the numbers of places. Links
/// shorter than a reach are those that the places within that reach have.
pub(crate) struct Links {
    /// Where the links of each place begin, and the end.
    starts: Vec<u32>,
    /// The places linked with: those among the nearest first.
    ids: Vec<PlaceId>,
    /// The largest square of a distance in mm² at which each place is linked with all others.
    base: Vec<f64>,
    /// Distances in mm to the nearest place and to the tenth, or the last, of each place.
    near_mm: Vec<[f64; 2]>,
}

/// The links of a run of places that follow one another.
#[derive(Default)]
struct Run {
    /// Links of each place.
    counts: Vec<u32>,
    ids: Vec<PlaceId>,
    base: Vec<f64>,
    near_mm: Vec<[f64; 2]>,
    /// Memory for the squares of one place, as bits.
    squares: Vec<u64>,
}

impl Links {
    /// The links of all places. Some n·log n time.
    pub(crate) fn new<const D: usize>(cloud: &Cloud<D>) -> Links {
        let runs = cloud.of_nearest(NEIGHBOURS + 1, |place, found, run: &mut Run| {
            linked(cloud, place, found, run)
        });
        let count = runs.iter().map(|run| run.ids.len()).sum();
        let mut links = Links {
            starts: Vec::with_capacity(cloud.len() + 1),
            ids: Vec::with_capacity(count),
            base: Vec::with_capacity(cloud.len()),
            near_mm: Vec::with_capacity(cloud.len()),
        };
        links.starts.push(0);
        let mut end = 0;
        for run in runs {
            for count in run.counts {
                end += count;
                links.starts.push(end);
            }
            links.ids.extend(run.ids);
            links.base.extend(run.base);
            links.near_mm.extend(run.near_mm);
        }
        // A single place has no links.
        links.starts.resize(cloud.len() + 1, end);
        links
    }

    /// The spacing as of [`Cloud::spacing_mm`].
    pub(crate) fn spacing_mm<const D: usize>(&self, cloud: &Cloud<D>) -> Option<f64> {
        let nearest_mm: Vec<f64> = self.near_mm.iter().map(|[nearest, _]| *nearest).collect();
        (cloud.len() > 1).then(|| cloud.mean_by_leaves(&nearest_mm))
    }

    /// τ as of [`auto_tau_mm`](crate::auto_tau_mm).
    pub(crate) fn tau_mm<const D: usize>(&self, cloud: &Cloud<D>) -> Option<f64> {
        let some = cloud.some_places(auto::SOME);
        (cloud.len() > 1)
            .then(|| some.map(|place| self.near_mm[place as usize][1]).collect())
            .and_then(tau_by)
    }

    fn of(&self, place: PlaceId) -> &[PlaceId] {
        let at = place as usize;
        &self.ids[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    /// Pairs of positions whose places are linked and nearer than `reach_mm`, as far as they may be: each once, the smaller position first,
    /// sorted. Every position has a place of its own.
    pub(crate) fn pairs<const D: usize>(
        &self,
        cloud: &Cloud<D>,
        place_at: &[PlaceId],
        reach_mm: f64,
        may_link: &(dyn Fn([u32; 2]) -> bool + Sync),
    ) -> Vec<[u32; 2]> {
        let all = cloud.places();
        let mut position_of = vec![0; place_at.len()];
        (0..).zip(place_at).for_each(|(position, &place)| position_of[place as usize] = position);
        let position_of = &position_of;
        let square = |a: PlaceId, b: PlaceId| squared_distance(&all[a as usize], &all[b as usize]);
        let is_pair = |pair: [u32; 2], square: f64| square.sqrt() < reach_mm && may_link(pair);
        // Links that the place of the smaller position does not have.
        let others = (0..all.len() as PlaceId).into_par_iter().with_min_len(RUN);
        let mut others: Vec<[u32; 2]> = others
            .flat_map_iter(|place| {
                let upper = position_of[place as usize];
                self.of(place).iter().filter_map(move |&other| {
                    let lower = position_of[other as usize];
                    if upper < lower {
                        return None;
                    }
                    let square = square(place, other);
                    let is_known =
                        square <= self.base[other as usize] || self.of(other).contains(&place);
                    (!is_known && is_pair([lower, upper], square)).then_some([lower, upper])
                })
            })
            .collect();
        others.par_sort_unstable();
        let runs = place_at.par_chunks(RUN).enumerate().map(|(run, places)| {
            let first = (run * RUN) as u32;
            let others = &others[others.partition_point(|pair| pair[0] < first)..];
            let mut others = others.iter().copied().peekable();
            let mut pairs = Vec::new();
            for (lower, &place) in (first..).zip(places) {
                let begun = pairs.len();
                for &other in self.of(place) {
                    let upper = position_of[other as usize];
                    if lower < upper && is_pair([lower, upper], square(place, other)) {
                        pairs.push([lower, upper]);
                    }
                }
                while let Some(pair) = others.next_if(|pair| pair[0] == lower) {
                    pairs.push(pair);
                }
                pairs[begun..].sort_unstable();
            }
            pairs
        });
        runs.collect::<Vec<_>>().concat()
    }
}

/// Adds the links of a place to a run, by places that hold its nearest; gives the square of the distance to the farthest of these. Places as far
/// away as one that the nearest lack are not linked.
fn linked<const D: usize>(cloud: &Cloud<D>, place: PlaceId, found: &[Entry], run: &mut Run) -> f64 {
    let all = cloud.places();
    let from = &all[place as usize];
    let way = |of: Entry| -> [f64; D] {
        let to = &all[of.id() as usize];
        std::array::from_fn(|axis| to[axis] - from[axis])
    };
    run.squares.clear();
    run.squares.extend(found.iter().map(|entry| entry.square().to_bits()));
    let Near { last, end, base, near_mm } = Near::new(&mut run.squares);
    // Every place is written to both lists, and stays if it belongs there: that spares branches that nobody can foresee.
    let (mut inner, mut outer) =
        ([Entry::default(); NEIGHBOURS + 1], [Entry::default(); NEIGHBOURS + 1]);
    let (mut inner_count, mut outer_count) = (0, 0);
    for &entry in found {
        let square = entry.square();
        inner[inner_count] = entry;
        inner_count += usize::from(square <= base);
        outer[outer_count] = entry;
        outer_count += usize::from((base < square) & (square < end));
    }
    let begun = run.ids.len();
    let mut known = [[[0.0; LANES]; D]; (NEIGHBOURS + LANES) / LANES];
    for (at, &entry) in inner[..inner_count].iter().enumerate() {
        let mm = entry.square().sqrt();
        let way = way(entry);
        (0..D).for_each(|axis| known[at / LANES][axis][at % LANES] = way[axis] / mm);
        run.ids.push(entry.id());
    }
    let known = &known[..inner_count.div_ceil(LANES)];
    let mut farther: Vec<(f64, PlaceId, [f64; D])> = Vec::new();
    for &entry in &outer[..outer_count] {
        let (square, way) = (entry.square(), way(entry));
        let along = largest_dot(known, &way);
        // Most are near a direction for certain, and need no root.
        if along * along > COSINE * COSINE * (1.0 + 1e-8) * square {
            continue;
        }
        let mm = square.sqrt();
        let direction = way.map(|side| side / mm);
        if largest_dot(known, &direction) < COSINE {
            farther.push((mm, entry.id(), direction));
        }
    }
    farther.sort_by(|a, b| {
        let [p, q] = [a, b].map(|of| &all[of.1 as usize]);
        a.0.total_cmp(&b.0).then_with(|| by_coordinates(p, q))
    });
    let mut taken: Vec<[f64; D]> = Vec::new();
    for (_, other, direction) in farther {
        if taken.iter().all(|known| dot(known, &direction) < COSINE) {
            taken.push(direction);
            run.ids.push(other);
        }
    }
    run.counts.push((run.ids.len() - begun) as u32);
    run.base.push(base);
    run.near_mm.push(near_mm);
    last
}

/// How far the nearest of a place are.
struct Near {
    /// Square of the distance to the farthest of them, mm².
    last: f64,
    /// Places with this square, or a larger one, are not linked.
    end: f64,
    /// Places up to this square are linked all.
    base: f64,
    /// Distances to the first and the tenth, or the last, mm.
    near_mm: [f64; 2],
}

impl Near {
    /// `squares` are bits of squares of distances in mm², which are in the order of these.
    fn new(squares: &mut [u64]) -> Near {
        let count = squares.len().min(NEIGHBOURS + 1);
        // Sorting networks are faster here than a selection.
        squares.sort_unstable();
        let square = |at: usize| f64::from_bits(squares[at.min(count - 1)]);
        let last = square(NEIGHBOURS);
        let near_mm = [0, auto::NEIGHBOURS - 1].map(|at| square(at).sqrt());
        let end = if count > NEIGHBOURS { least_of_root(last) } else { f64::INFINITY };
        let is_full = count >= NEAREST && square(NEAREST - 1) < end;
        let base = if is_full { largest_of_root(square(NEAREST - 1)) } else { end.next_down() };
        Near { last, end, base, near_mm }
    }
}

/// The least number whose rounded root is that of `square`: equal distances may have unequal squares.
fn least_of_root(mut square: f64) -> f64 {
    let root = square.sqrt();
    while square.next_down().sqrt() >= root {
        square = square.next_down();
    }
    square
}

/// The largest number whose rounded root is that of `square`.
fn largest_of_root(mut square: f64) -> f64 {
    let root = square.sqrt();
    while square.next_up().sqrt() <= root {
        square = square.next_up();
    }
    square
}

/// The largest product of a vector with some others, which lie in lanes; 0 if all are less.
fn largest_dot<const D: usize>(others: &[[[f64; LANES]; D]], vector: &[f64; D]) -> f64 {
    let mut most = [0.0; LANES];
    for others in others {
        for (lane, most) in most.iter_mut().enumerate() {
            let along: f64 = (0..D).map(|axis| others[axis][lane] * vector[axis]).sum();
            *most = greater(*most, along);
        }
    }
    most.into_iter().fold(0.0, greater)
}

fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|axis| a[axis] * b[axis]).sum()
}

/// The nearest places that a place is linked with at any rate; more where several are equally near.
const NEAREST: usize = 12;

/// The nearest places that it may be linked with.
const NEIGHBOURS: usize = 36;

/// Cosine of the angle between links beyond the nearest: 45°.
const COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Directions that are compared at a time.
const LANES: usize = 4;

/// Places that one job takes.
const RUN: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_bridge_a_gap_and_are_short_elsewhere() {
        // A lattice without two columns in the middle.
        let columns = (0..21).filter(|x| !(9..11).contains(x));
        let points: Vec<[f64; 2]> =
            columns.flat_map(|x| (0..21).map(move |y| [f64::from(x), f64::from(y)])).collect();
        let cloud = Cloud::new(&points).unwrap();
        let links = |reach_mm: f64| {
            let all: Vec<PlaceId> = (0..cloud.len() as PlaceId).collect();
            Links::new(&cloud).pairs(&cloud, &all, reach_mm, &|_| true)
        };
        let across = |reach_mm: f64| {
            let sides = |link: &&[PlaceId; 2]| {
                let [a, b] = link.map(|place| cloud.places()[place as usize][0] < 10.0);
                a != b
            };
            links(reach_mm).iter().filter(sides).count()
        };
        // The twelve nearest of a place at the gap lie on its side, within √5; over the gap it is 3.
        assert_eq!((across(3.0), across(3.1)), (0, 21));
        // Every inner place is linked with the twelve within 2 steps; the next ones lie in directions that are taken.
        let inner = cloud.places().iter().position(|place| *place == [4.0, 10.0]).unwrap() as u32;
        let count = |reach_mm| links(reach_mm).iter().filter(|link| link.contains(&inner)).count();
        assert_eq!((count(2.1), count(1.1)), (12, 4));
    }

    /// Links of a place by the definition, among all places within reach.
    fn by_definition(all: &[[f64; 3]], place: usize, reach_mm: f64) -> Vec<u32> {
        let from = &all[place];
        let mut others: Vec<(f64, u32)> = (0..all.len() as u32)
            .filter(|&other| other as usize != place)
            .map(|other| (squared_distance(from, &all[other as usize]).sqrt(), other))
            .collect();
        others.sort_by(|a, b| {
            let [p, q] = [a, b].map(|of| &all[of.1 as usize]);
            a.0.total_cmp(&b.0).then_with(|| by_coordinates(p, q))
        });
        let end_mm = others.get(NEIGHBOURS).map_or(f64::INFINITY, |other| other.0).min(reach_mm);
        others.retain(|other| other.0 < end_mm);
        let last_mm = others.get(NEAREST - 1).map_or(f64::INFINITY, |other| other.0);
        let (mut directions, mut found): (Vec<[f64; 3]>, Vec<u32>) = Default::default();
        for (mm, other) in others {
            let to = &all[other as usize];
            let direction = std::array::from_fn(|axis| (to[axis] - from[axis]) / mm);
            if mm <= last_mm || directions.iter().all(|known| dot(known, &direction) < COSINE) {
                directions.push(direction);
                found.push(other);
            }
        }
        found
    }

    #[test]
    fn links_spacing_and_tau_are_those_of_the_definition_whatever_the_reach() {
        let spread = |at: u32, step: f64| (f64::from(at) * step).fract();
        // Places of a bent sheet, those of a lattice with many equal distances, and few.
        let sheet = (0..400).map(|at| {
            let [x, y] = [0.618_034, 0.414_214].map(|step| 10.0 * spread(at, step));
            [x, y, (x * y).sin()]
        });
        let lattice =
            (0..343).map(|at| [at % 7, at / 7 % 7, at / 49].map(|at| f64::from(at) / 3.0));
        let few = (0..9).map(|at| [f64::from(at * at), f64::from(at), 0.0]);
        for points in [sheet.collect(), lattice.collect(), few.collect::<Vec<_>>()] {
            let cloud = Cloud::new(&points).unwrap();
            let backwards: Vec<PlaceId> = (0..cloud.len() as PlaceId).rev().collect();
            let links = Links::new(&cloud);
            assert_eq!(links.spacing_mm(&cloud), cloud.spacing_mm());
            assert_eq!(links.tau_mm(&cloud), crate::auto_tau_mm(&cloud));
            for reach_mm in [0.4, 0.8, 1.5, 100.0] {
                let mut expected = Vec::new();
                for place in 0..cloud.len() {
                    let found = by_definition(cloud.places(), place, reach_mm).into_iter();
                    let last = cloud.len() as u32 - 1;
                    expected.extend(found.map(|other| {
                        let [a, b] = [place as u32, other].map(|place| last - place);
                        [a.min(b), a.max(b)]
                    }));
                }
                expected.sort_unstable();
                expected.dedup();
                assert_eq!(links.pairs(&cloud, &backwards, reach_mm, &|_| true), expected);
            }
        }
    }
}
