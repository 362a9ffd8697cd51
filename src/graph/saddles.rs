//! Saddles: where the branches of a loop part, and where they meet again.
//!
//! A gap of the sampling parts a level, too, but its sides join again above it. So does every hole that is small. At a saddle of
//! the surface the branches go different ways.

use asphera_geometry::{BoundsMm, Sets};

use crate::cloud::{Cloud, CloudError, PlaceId};
use crate::fine_loops::Wanted;
use crate::graph::NodeId;
use crate::links::Links;
use crate::loops::Merged;
use crate::tree::squared_distance;

/// Thin strips that a loop spans which no gap of the sampling makes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spans {
    /// If it has saddles.
    pub(crate) short: u32,
    /// If its ends lie farther apart than gaps are wide.
    pub(crate) wide: u32,
    /// At any rate.
    pub(crate) long: u32,
}

impl Spans {
    /// Where there are `share` times as many thin strips as usual: ⅔ τ, 1.2 τ and 1.8 τ. Of 100,000 points at random on a surface,
    /// single gaps span up to 12, two gaps on one level up to 7, and up to 5 with what seem to be saddles (benches/README.md).
    pub(crate) fn of(share: f64) -> Spans {
        let [short, wide, long] = [6.0, 11.0, 16.0].map(|strips| (strips * share).round() as u32);
        Spans { short, wide, long }
    }
}

/// The pieces of thin strips that the branches of loops go through.
#[derive(Clone, Copy)]
pub(crate) struct Branches<'a, const D: usize> {
    pub(crate) cloud: &'a Cloud<D>,
    /// The places of each thin strip.
    pub(crate) of_strip: &'a [Vec<PlaceId>],
    /// The strip of each piece, ascending.
    pub(crate) strip_of: &'a [u32],
    /// The piece of each place.
    pub(crate) piece_of: &'a [NodeId],
    pub(crate) wanted: Wanted<'a>,
}

impl<const D: usize> Branches<'_, D> {
    /// Whether a loop from one strip to another has saddles as ends, [`APART`] or more apart. Those of a wide one are not asked where they
    /// lie [`ABOUT`] apart. `nodes` are the pieces of both branches next to each end, as those that they count as one with.
    ///
    /// # Errors
    ///
    /// Those of a cloud of the places about an end.
    pub(crate) fn have_saddles(
        &self,
        strips: [u32; 2],
        nodes: [[NodeId; 2]; 2],
        merged: &mut Merged,
    ) -> Result<bool, CloudError> {
        let ends = nodes.map(|of_end| {
            let [a, b] = of_end.map(|node| self.places(node, merged));
            nearest_pair(self.cloud, a, b)
        });
        let [Some(low), Some(high)] = ends else { return Ok(false) };
        let [p, q] = [low, high].map(|pair| self.between(pair));
        let apart = squared_distance(&p, &q).sqrt() / self.wanted.tau_mm;
        if apart < APART {
            return Ok(false);
        }
        if apart >= ABOUT && strips[1] - strips[0] >= self.wanted.spans.wide {
            return Ok(true);
        }
        let first = self.first_of(strips[0] + 1);
        let end = self.first_of(strips[1]);
        Ok(self.is_saddle(low, &|node| node >= first)?
            && self.is_saddle(high, &|node| node < end)?)
    }

    /// The first piece of a strip, or of those above.
    fn first_of(&self, strip: u32) -> NodeId {
        self.strip_of.partition_point(|&other| other < strip) as NodeId
    }

    /// The places of all pieces that count as one with a piece.
    fn places(&self, node: NodeId, merged: &mut Merged) -> Vec<PlaceId> {
        let of_strip = self.of_strip[self.strip_of[node as usize] as usize].iter();
        let is_of_branch = |&&place: &&PlaceId| merged.root(self.piece_of[place as usize]) == node;
        of_strip.filter(is_of_branch).copied().collect()
    }

    /// The middle between two places.
    fn between(&self, pair: [PlaceId; 2]) -> [f64; D] {
        let [a, b] = pair.map(|place| self.cloud.places()[place as usize]);
        std::array::from_fn(|axis| f64::midpoint(a[axis], b[axis]))
    }

    /// Whether no links join two places within [`ABOUT`] of them, among pieces that are `beyond` the end of the loop.
    fn is_saddle(
        &self,
        [a, b]: [PlaceId; 2],
        beyond: &(dyn Fn(NodeId) -> bool + Sync),
    ) -> Result<bool, CloudError> {
        let all = self.cloud.places();
        let about_mm = ABOUT * self.wanted.tau_mm;
        // A neighbour of a neighbour decides which links there are.
        let reach_mm = about_mm + 2.0 * self.wanted.reach_mm;
        let mut near = vec![a, b];
        for place in [a, b] {
            self.cloud.visit_within(place, reach_mm, |other, _| near.push(other));
        }
        near.sort_unstable();
        near.dedup();
        let own: Vec<[f64; D]> = near.iter().map(|&place| all[place as usize]).collect();
        let local = Cloud::new(&own)?;
        let rows = local.places_of_rows();
        let mut place_of = vec![0; near.len()];
        rows.iter().zip(&near).for_each(|(&row, &place)| place_of[row as usize] = place);
        let is_in = |at: u32| {
            let place = place_of[at as usize];
            let from = |end: PlaceId| squared_distance(&all[place as usize], &all[end as usize]);
            beyond(self.piece_of[place as usize]) && from(a).min(from(b)) < about_mm * about_mm
        };
        let may_link = |[p, q]: [u32; 2]| {
            let places = [p, q].map(|at| place_of[at as usize]);
            is_in(p) && is_in(q) && (self.wanted.may_link)(places)
        };
        let every: Vec<u32> = (0..near.len() as u32).collect();
        let links = Links::new(&local).pairs(&local, &every, self.wanted.reach_mm, &may_link);
        let mut sets = Sets::new(near.len());
        links.iter().for_each(|link| {
            sets.join(link[0] as usize, link[1] as usize);
        });
        let at = |place: PlaceId| near.partition_point(|&other| other < place);
        let [a, b] = [a, b].map(|place| rows[at(place)] as usize);
        Ok(sets.root(a) != sets.root(b))
    }
}

/// The nearest two places, one of either list: of pairs as near the one of the least numbers. `None` if a list is empty.
///
/// Both are passed along the widest side of the box of all. Time grows with places times those as near along that side.
fn nearest_pair<const D: usize>(
    cloud: &Cloud<D>,
    mut one: Vec<PlaceId>,
    mut other: Vec<PlaceId>,
) -> Option<[PlaceId; 2]> {
    let all = cloud.places();
    let both = one.iter().chain(&other);
    let size_mm = BoundsMm::about(both.map(|&place| all[place as usize])).size_mm();
    let axis = (1..D).fold(0, |best, axis| if size_mm[axis] > size_mm[best] { axis } else { best });
    let along = |place: PlaceId| all[place as usize][axis];
    for list in [&mut one, &mut other] {
        list.sort_unstable_by(|&a, &b| along(a).total_cmp(&along(b)).then(a.cmp(&b)));
    }
    let mut best: Option<(f64, [PlaceId; 2])> = None;
    for &a in &one {
        let middle = other.partition_point(|&b| along(b) < along(a));
        let (before, behind) = other.split_at(middle);
        for side in
            [&mut before.iter().rev() as &mut dyn Iterator<Item = &PlaceId>, &mut behind.iter()]
        {
            for &b in side {
                let gap = along(a) - along(b);
                if best.is_some_and(|(square, _)| gap * gap > square) {
                    break;
                }
                let square = squared_distance(&all[a as usize], &all[b as usize]);
                let pair = [a.min(b), a.max(b)];
                if best.is_none_or(|known| (square, pair) < known) {
                    best = Some((square, pair));
                }
            }
        }
    }
    best.map(|(_, pair)| pair)
}

/// The middles of two ends are so many τ apart, or more: a gap is as wide as it is high.
const APART: f64 = 2.0;

/// Branches that join within so many τ of an end go round a gap. Holes that were cut into the points, two spacings in radius, overlap and
/// are wider than 2.5 τ.
const ABOUT: f64 = 4.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_pair_is_that_of_all_pairs() {
        let spread = |at: u32, step: f64| (f64::from(at) * step).fract();
        // Places of a sheet, and those of a lattice with many equal distances.
        let sheet = (0..300).map(|at| [0.618_034, 0.414_214].map(|step| 9.0 * spread(at, step)));
        let lattice = (0..300).map(|at| [at % 20, at / 20].map(f64::from));
        for points in [sheet.collect(), lattice.collect::<Vec<_>>()] {
            let cloud = Cloud::new(&points).unwrap();
            for shares in 2..9 {
                let of = |share| (0..300).filter(|at| at * at % 11 % shares == share).collect();
                let [one, other]: [Vec<PlaceId>; 2] = [of(0), of(1)];
                let square = |[a, b]: [PlaceId; 2]| {
                    squared_distance(&cloud.places()[a as usize], &cloud.places()[b as usize])
                };
                let pairs =
                    one.iter().flat_map(|&a| other.iter().map(move |&b| [a.min(b), a.max(b)]));
                let expected =
                    pairs.min_by(|&p, &q| square(p).total_cmp(&square(q)).then(p.cmp(&q)));
                assert!(expected.is_some());
                assert_eq!(nearest_pair(&cloud, one, other), expected);
            }
            assert_eq!(nearest_pair(&cloud, vec![3], vec![]), None);
        }
    }
}
