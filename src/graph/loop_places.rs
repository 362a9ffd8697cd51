//! The places by which loops are counted, and the thin strips between which they are.

use crate::auto::{STRIP, auto_tau_mm};
use crate::cloud::{Cloud, PlaceId};
use crate::extract::ExtractError;
use crate::fine_loops::{FineError, FineLoop, Wanted, fine_loops};
use crate::functions::Field;
use crate::graph::PointGraph;
use crate::links::Links;
use crate::loops::Loop;
use crate::saddles::Spans;
use crate::strips::{MOST_STRIPS, Strips, StripsError};
use crate::thinned::Thinned;

/// Strips of τ/9 in space; `share` times as many.
pub(crate) fn thin_strips(
    strips: &Strips,
    field: &Field,
    tau_mm: f64,
    share: f64,
) -> Result<Strips, StripsError> {
    let bounds = strips.bounds();
    if field.is_length {
        return of_range([bounds[0], bounds[bounds.len() - 1]], tau_mm, share);
    }
    strips.divided((STRIP * THIN * share).round() as usize)
}

/// Strips of τ/9 of a range of lengths in mm; `share` times as many.
fn of_range([low, high]: [f64; 2], tau_mm: f64, share: f64) -> Result<Strips, StripsError> {
    let count = (THIN * share * (high - low) / tau_mm).ceil();
    Strips::uniform(low, high, (count as usize).clamp(1, MOST_STRIPS))
}

/// The places by which loops are counted.
#[derive(Clone, Copy)]
pub(crate) struct LoopPlaces<'a, const D: usize> {
    cloud: &'a Cloud<D>,
    values: &'a [f64],
    /// Their links, if these are known.
    known: Option<&'a Links>,
    /// The place of the graph of each, where they are others.
    original: Option<&'a [PlaceId]>,
    /// Links lead to consecutive strips of the graph alone: where a function jumps nothing is joined.
    by_strips: bool,
    pub(crate) tau_mm: f64,
}

impl<'a, const D: usize> LoopPlaces<'a, D> {
    /// Those of the graph.
    pub(crate) fn of_graph(
        cloud: &'a Cloud<D>,
        values: &'a [f64],
        known: Option<&'a Links>,
        tau_mm: f64,
    ) -> LoopPlaces<'a, D> {
        LoopPlaces { cloud, values, known, original: None, by_strips: true, tau_mm }
    }

    /// Those of the middle of a layer, in which lengths differ by more than between places of the graph.
    pub(crate) fn thinned(thinned: &'a Thinned<D>, known: Option<&'a Links>) -> LoopPlaces<'a, D> {
        let Thinned { cloud, values, original, .. } = thinned;
        let tau_mm = auto_tau_mm(cloud).unwrap_or(1.0);
        LoopPlaces { cloud, values, known, original: Some(original), by_strips: false, tau_mm }
    }

    pub(crate) fn cloud(&self) -> &'a Cloud<D> {
        self.cloud
    }

    /// The node of a place.
    fn node(&self, place: PlaceId, graph: &PointGraph<D>) -> u32 {
        let place = self.original.map_or(place, |original| original[place as usize]);
        graph.nodes_of_places()[place as usize]
    }

    /// A loop between thin strips as one of the graph.
    pub(crate) fn loop_of_graph(
        &self,
        found: &FineLoop,
        graph: &PointGraph<D>,
        thin: &Strips,
    ) -> Loop {
        let nodes = found.places.map(|place| self.node(place, graph));
        let strips = nodes.map(|node| graph.nodes()[node as usize].strip);
        Loop { nodes, strips, range: open_range(found, thin) }
    }

    /// Loops between thin strips, `share` times as many as usual, by links within the components of the graph.
    pub(crate) fn loops(
        &self,
        is_length: bool,
        graph: &PointGraph<D>,
        (thin, share): (&Strips, f64),
        tau_mm: f64,
    ) -> Result<Vec<FineLoop>, ExtractError> {
        let reach_mm = LINK * tau_mm;
        let width = thin.bounds()[1] - thin.bounds()[0];
        // Lengths change by no more than the way gone; by little more in the middle of noisy ones.
        let most = if self.original.is_some() { 2.0 * reach_mm } else { reach_mm };
        let margin = (is_length && width > 0.0).then(|| (most / width) as usize + 1);
        let (component_of_node, _) = graph.components();
        let may_link = |link: [PlaceId; 2]| {
            let [a, b] = link.map(|place| self.node(place, graph) as usize);
            let strips = [a, b].map(|node| graph.nodes()[node].strip);
            component_of_node[a] == component_of_node[b]
                && (!self.by_strips || strips[0].abs_diff(strips[1]) <= 1)
        };
        let (known, spans) = (self.known, Spans::of(share));
        let wanted = Wanted { tau_mm, reach_mm, may_link: &may_link, known, spans };
        fine_loops(self.cloud, self.values, thin, wanted, margin).map_err(|error| match error {
            FineError::Graph(error) => error.into(),
            FineError::Cloud(error) => error.into(),
        })
    }

    /// How many loops of heights of these places are no gaps, and open over `min_loop_mm` or more. τ and strips are `of_tau` and `of_strips` times
    /// the usual ones.
    pub(crate) fn count_along(
        &self,
        heights_mm: &Field,
        graph: &PointGraph<D>,
        min_loop_mm: f64,
        (of_tau, of_strips): (f64, f64),
    ) -> Result<usize, ExtractError> {
        let Some([low, high]) = heights_mm.range().filter(|[low, high]| low < high) else {
            return Ok(0);
        };
        let thin = of_range([low, high], self.tau_mm, of_strips)?;
        let places = LoopPlaces { values: &heights_mm.values, by_strips: false, ..*self };
        let found = places.loops(true, graph, (&thin, of_strips), self.tau_mm * of_tau)?;
        let is_loop = |one: &&FineLoop| {
            let [low, high] = open_range(one, &thin);
            one.is_no_gap && high - low >= min_loop_mm
        };
        Ok(found.iter().filter(is_loop).count())
    }
}

/// The range in which a loop is surely open.
fn open_range(found: &FineLoop, thin: &Strips) -> [f64; 2] {
    let bounds = thin.bounds();
    [bounds[found.strips[0] as usize + 1], bounds[found.strips[1] as usize]]
}

/// Thin strips over τ.
const THIN: f64 = 9.0;

/// Links reach so many τ; most are shorter.
const LINK: f64 = 1.5;
