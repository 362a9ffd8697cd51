//! Which ends of a graph belong to one gap.

use std::cmp::Ordering;

use super::{GapCurve, GapEnd, GapError, gap_curve};
use crate::samples::{PlaceMm, SampleId};
use crate::triangulation::distance_mm;
use crate::{Chain, Graph};

/// A gap between two ends of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// The samples at its ends.
    pub ends: [SampleId; 2],
    /// Their distance in mm.
    pub width_mm: f64,
    /// The curve across it, from the first end to the second.
    pub curve: Result<GapCurve, GapError>,
}

/// The gaps of a graph that are at most so wide, in mm, the narrowest first, each with the curve across it.
///
/// The nearest two ends make a gap, then the nearest two that are left, and so on; equal widths go by the places of the ends. The two ends of one chain
/// are joined only if it is longer than twice their distance, or every dash would close on itself. Places are those of the samples in mm,
/// and the noise is their standard deviation in mm. Samples where three edges meet are no ends. e² time for e ends: none for more than
/// [`MOST_ENDS`].
pub fn gaps_of(
    graph: &Graph,
    places_mm: &[PlaceMm],
    widest_mm: f64,
    sigma_mm: f64,
) -> Option<Vec<Gap>> {
    let degrees = graph.degrees(places_mm.len());
    let chains = graph.chains(places_mm.len());
    let ends: Vec<End> = chains
        .iter()
        .enumerate()
        .filter(|(_, chain)| !chain.closed)
        .flat_map(|(index, chain)| [false, true].map(|is_last| End::of(index, chain, is_last)))
        .filter(|end| degrees[end.sample as usize] == 1)
        .collect();
    if ends.len() > MOST_ENDS {
        return None;
    }
    let place = |end: &End| places_mm[end.sample as usize];
    let lengths_mm: Vec<f64> = chains.iter().map(|chain| length_mm(chain, places_mm)).collect();
    let mut near: Vec<(f64, [usize; 2])> = Vec::new();
    for (q, to) in ends.iter().enumerate() {
        for (p, from) in ends[..q].iter().enumerate() {
            let width_mm = distance_mm(place(from), place(to));
            let is_dash = from.chain == to.chain && lengths_mm[from.chain] <= 2.0 * width_mm;
            if width_mm <= widest_mm && !is_dash {
                near.push((width_mm, ordered([p, q], |index| place(&ends[index]))));
            }
        }
    }
    near.sort_by(|(a, [p, q]), (b, [r, s])| {
        let by_place = |one: usize, other: usize| compare(place(&ends[one]), place(&ends[other]));
        a.total_cmp(b).then_with(|| by_place(*p, *r)).then_with(|| by_place(*q, *s))
    });
    let mut is_joined = vec![false; ends.len()];
    let mut gaps = Vec::new();
    for (width_mm, pair) in near {
        if pair.iter().any(|&index| is_joined[index]) {
            continue;
        }
        pair.iter().for_each(|&index| is_joined[index] = true);
        let [from, to] = pair.map(|index| ends[index].gap_end(&chains, places_mm, sigma_mm));
        let [from_mm, to_mm] = pair.map(|index| place(&ends[index]));
        let found = "fewer than three points before an end";
        let curve = match from.zip(to) {
            Some((from, to)) => gap_curve(from, to),
            None => Err(GapError::NoDirection { from_mm, to_mm, found }),
        };
        gaps.push(Gap { ends: pair.map(|index| ends[index].sample), width_mm, curve });
    }
    Some(gaps)
}

/// Most ends that [`gaps_of`] takes.
pub const MOST_ENDS: usize = 4_000;

/// An end of a chain.
struct End {
    chain: usize,
    is_last: bool,
    sample: SampleId,
}

impl End {
    fn of(index: usize, chain: &Chain, is_last: bool) -> End {
        let at = if is_last { chain.samples.len() - 1 } else { 0 };
        End { chain: index, is_last, sample: chain.samples[at] }
    }

    fn gap_end(&self, chains: &[Chain], places_mm: &[PlaceMm], sigma_mm: f64) -> Option<GapEnd> {
        let samples = &chains[self.chain].samples;
        let mut along: Vec<PlaceMm> =
            samples.iter().map(|&sample| places_mm[sample as usize]).collect();
        if !self.is_last {
            along.reverse();
        }
        GapEnd::of_places(&along, sigma_mm)
    }
}

fn length_mm(chain: &Chain, places_mm: &[PlaceMm]) -> f64 {
    let pairs = chain.samples.windows(2);
    pairs.map(|pair| distance_mm(places_mm[pair[0] as usize], places_mm[pair[1] as usize])).sum()
}

fn compare(p: PlaceMm, q: PlaceMm) -> Ordering {
    p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1]))
}

fn ordered([p, q]: [usize; 2], place: impl Fn(usize) -> PlaceMm) -> [usize; 2] {
    if compare(place(p), place(q)).is_le() { [p, q] } else { [q, p] }
}
