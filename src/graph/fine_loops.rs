//! Loops between levels that lie closer than the strips of a graph.

use std::ops::Range;

use rayon::prelude::*;

use crate::cloud::{Cloud, CloudError, PlaceId};
use crate::graph::{GraphError, sorted_by_strip};
use crate::level_sets::{Linked, ThinStrip};
use crate::links::Links;
use crate::loops::{Closes, Merged};
use crate::saddles::{Branches, Spans};
use crate::strips::Strips;

/// A loop by thin strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FineLoop {
    /// The thin strips where its branches part and where they meet again.
    pub(crate) strips: [u32; 2],
    /// A place of the piece where they part, and one of the piece where they meet.
    pub(crate) places: [PlaceId; 2],
    /// No gap of the sampling makes it, by [`Spans`].
    pub(crate) is_no_gap: bool,
}

impl FineLoop {
    /// Thin strips from one end to the other.
    pub(crate) fn span(&self) -> u32 {
        self.strips[1] - self.strips[0]
    }
}

/// The links that make loops.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// τ in mm.
    pub(crate) tau_mm: f64,
    /// They are shorter, in mm.
    pub(crate) reach_mm: f64,
    /// Whether two places may be linked.
    pub(crate) may_link: &'a (dyn Fn([PlaceId; 2]) -> bool + Sync),
    /// Those of the whole cloud, if they are known.
    pub(crate) known: Option<&'a Links>,
    /// How many thin strips a loop spans that no gap makes.
    pub(crate) spans: Spans,
}

/// Whether strips of a cloud are passed in one run, which takes the links of the whole cloud.
pub(crate) fn is_one_run<const D: usize>(cloud: &Cloud<D>) -> bool {
    cloud.len() < RUN
}

/// Reason why there are no such loops.
pub(crate) enum FineError {
    Graph(GraphError),
    Cloud(CloudError),
}

/// All loops between thin strips, for the links that are wanted. Gaps of the sampling make loops that span few strips.
///
/// With a `margin` the strips are passed in runs of many places, so that memory grows with these and not with the cloud. Then no
/// two places nearer than the reach of links may be more than so many strips apart.
pub(crate) fn fine_loops<const D: usize>(
    cloud: &Cloud<D>,
    values: &[f64],
    strips: &Strips,
    wanted: Wanted<'_>,
    margin: Option<usize>,
) -> Result<Vec<FineLoop>, FineError> {
    let of_strip = sorted_by_strip(cloud, values, strips).map_err(FineError::Graph)?;
    let runs = match margin {
        Some(margin) => runs(&of_strip, margin, RUN),
        None => std::iter::once(0..of_strip.len()).collect(),
    };
    in_runs(cloud, &of_strip, runs, wanted, margin).map_err(FineError::Cloud)
}

/// The loops of strips that are passed in runs.
fn in_runs<const D: usize>(
    cloud: &Cloud<D>,
    of_strip: &[Vec<PlaceId>],
    runs: Vec<Range<usize>>,
    wanted: Wanted<'_>,
    margin: Option<usize>,
) -> Result<Vec<FineLoop>, CloudError> {
    let mut places_of_pieces = Vec::new();
    let mut strip_of = Vec::new();
    let mut arcs = Vec::new();
    let mut piece_of = vec![0; cloud.len()];
    // Pieces of the level below, each with the node under it.
    let mut under: Vec<u32> = Vec::new();
    for run in runs {
        // A neighbour of a neighbour decides which links there are.
        let about = 2 * margin.unwrap_or(of_strip.len()) + 2;
        let members = run.start.saturating_sub(about)..(run.end + about).min(of_strip.len());
        let (thin, places) = thin_strips(cloud, of_strip, (members, run.clone()), wanted)?;
        for (strip, thin) in run.zip(thin) {
            let first = strip_of.len() as u32;
            let below = thin.below.iter().zip(&under);
            arcs.extend(below.map(|(&piece, &lower)| (first + piece, lower)));
            under = thin.above.iter().map(|&piece| first + piece).collect();
            strip_of.extend(thin.pieces.iter().map(|_| strip as u32));
            places_of_pieces.extend(thin.pieces.iter().map(|&at| places[at as usize]));
            let own = of_strip[strip].iter().zip(&thin.own);
            own.for_each(|(&place, &piece)| piece_of[place as usize] = first + piece);
        }
    }
    arcs.sort_unstable();
    let branches = Branches { cloud, of_strip, strip_of: &strip_of, piece_of: &piece_of, wanted };
    let mut merged = Merged::new(strip_of.len());
    let mut found = Vec::new();
    for (upper, lower) in arcs {
        if let Some(closes) = merged.closes(upper, lower) {
            let Closes { ends, branches: nodes } = closes;
            let mut one = FineLoop {
                strips: ends.map(|node| strip_of[node as usize]),
                places: ends.map(|node| places_of_pieces[node as usize]),
                is_no_gap: false,
            };
            one.is_no_gap = one.span() >= wanted.spans.long
                || one.span() >= wanted.spans.short
                    && branches.have_saddles(one.strips, nodes, &mut merged)?;
            found.push(one);
        }
        merged.join(upper, lower);
    }
    Ok(found)
}

/// Runs of strips that hold some `most` places each, and are long against the margin.
fn runs(of_strip: &[Vec<PlaceId>], margin: usize, most: usize) -> Vec<Range<usize>> {
    let (mut runs, mut start, mut places) = (Vec::new(), 0, 0);
    for (strip, own) in of_strip.iter().enumerate() {
        places += own.len();
        if places >= most && strip + 1 - start >= LONG * margin {
            runs.push(start..strip + 1);
            (start, places) = (strip + 1, 0);
        }
    }
    if start < of_strip.len() {
        runs.push(start..of_strip.len());
    }
    runs
}

/// The thin strips of a run, by the links among the places of `members`; and the place of each position.
fn thin_strips<const D: usize>(
    cloud: &Cloud<D>,
    of_strip: &[Vec<PlaceId>],
    (members, run): (Range<usize>, Range<usize>),
    Wanted { reach_mm, may_link, known, .. }: Wanted<'_>,
) -> Result<(Vec<ThinStrip>, Vec<PlaceId>), CloudError> {
    let places = of_strip[members.clone()].concat();
    let strip_of: Vec<u32> = members
        .clone()
        .flat_map(|strip| of_strip[strip].iter().map(move |_| strip as u32))
        .collect();
    let may_link = |link: [u32; 2]| may_link(link.map(|position| places[position as usize]));
    let links = if places.len() < cloud.len() {
        let all = cloud.places();
        let own: Vec<[f64; D]> = places.iter().map(|&place| all[place as usize]).collect();
        let own = Cloud::new(&own)?;
        Links::new(&own).pairs(&own, own.places_of_rows(), reach_mm, &may_link)
    } else if let Some(known) = known {
        known.pairs(cloud, &places, reach_mm, &may_link)
    } else {
        Links::new(cloud).pairs(cloud, &places, reach_mm, &may_link)
    };
    let rise = |link: &[u32; 2]| strip_of[link[1] as usize] - strip_of[link[0] as usize];
    let span = links.par_iter().map(rise).max().unwrap_or(0);
    let linked = Linked { links: &links, strip_of: &strip_of, span };
    let starts: Vec<u32> = (run.start as u32..run.end as u32).step_by(JOB).collect();
    let end = run.end as u32;
    let jobs = starts.into_par_iter();
    let thin = jobs.flat_map_iter(|start| linked.thin_strips(start..(start + JOB as u32).min(end)));
    Ok((thin.collect(), places))
}

/// Places of a run.
const RUN: usize = 400_000;

/// Strips of a run over those of its margin, at least.
const LONG: usize = 8;

/// Strips that one job takes.
const JOB: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rings in the plane, one of them a lattice of cells with many equal distances.
    fn rings() -> Cloud<2> {
        let mut points = Vec::new();
        for at in 0..3000_u32 {
            // Steps by the golden ratio and by √2 spread places evenly, yet not on a lattice.
            let [along, across] = [0.618_033_988_7, std::f64::consts::SQRT_2]
                .map(|step| (f64::from(at) * step).fract());
            let (angle, radius) = (along * std::f64::consts::TAU, 5.0 + across);
            points.push([radius * angle.cos(), radius * angle.sin()]);
        }
        for [x, y] in (0..60).flat_map(|x| (0..60).map(move |y| [x, y])) {
            if !(20..40).contains(&x) || !(20..40).contains(&y) {
                points.push([f64::from(x) * 0.2 + 8.0, f64::from(y) * 0.2 - 5.0]);
            }
        }
        Cloud::new(&points).unwrap()
    }

    #[test]
    fn runs_of_any_length_find_the_same_loops() {
        let cloud = rings();
        for axis in [0, 1] {
            let values: Vec<f64> = cloud.places().iter().map(|place| place[axis]).collect();
            let (low, high) = values.iter().fold((9.0_f64, -9.0_f64), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
            let strips = Strips::uniform(low, high, 150).unwrap();
            let of_strip = sorted_by_strip(&cloud, &values, &strips).unwrap();
            let margin = 0.6 / (strips.bounds()[1] - low);
            let margin = margin as usize + 1;
            let wanted = Wanted {
                tau_mm: 0.4,
                reach_mm: 0.6,
                may_link: &|_| true,
                known: None,
                spans: Spans::of(1.0),
            };
            let found = |runs: Vec<Range<usize>>| {
                let mut found = in_runs(&cloud, &of_strip, runs, wanted, Some(margin)).unwrap();
                found.sort_by_key(|one| (one.strips, one.places));
                found
            };
            let whole = std::iter::once(0..150).collect();
            let some = [runs(&of_strip, 1, 300), (0..150).map(|at| at..at + 1).collect()];
            assert!(some[0].len() > 5);
            let expected = found(whole);
            for runs in some {
                assert_eq!(found(runs), expected);
            }
            let long = expected.iter().filter(|one| one.span() > 15).count();
            assert_eq!(long, 2, "{expected:?}");
        }
    }

    #[test]
    fn links_to_other_components_make_no_loop() {
        // Two arcs that nearly touch at both ends.
        let points: Vec<[f64; 2]> = (0..600)
            .map(|at| (f64::from(at) + 0.5) * std::f64::consts::TAU / 600.0)
            .map(|angle| [angle.cos(), angle.sin()])
            .collect();
        let cloud = Cloud::new(&points).unwrap();
        let places = cloud.places();
        let values: Vec<f64> = places.iter().map(|place| place[0]).collect();
        let strips = Strips::uniform(-1.0, 1.0, 100).unwrap();
        let halves = |link: [PlaceId; 2]| {
            let [a, b] = link.map(|place| places[place as usize][1] > 0.0);
            a == b
        };
        let loops = |may_link: &(dyn Fn([PlaceId; 2]) -> bool + Sync)| {
            let wanted = Wanted {
                tau_mm: 0.03,
                reach_mm: 0.05,
                may_link,
                known: None,
                spans: Spans::of(1.0),
            };
            let found = fine_loops(&cloud, &values, &strips, wanted, None);
            found.ok().map(|found| found.len())
        };
        assert_eq!(loops(&|_| true), Some(1));
        assert_eq!(loops(&halves), Some(0));
    }
}
