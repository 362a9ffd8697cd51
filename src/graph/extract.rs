//! A graph by default or by choice, its loops, and whether they hold.

use thiserror::Error;

use crate::auto::{STRIP, auto_strips, auto_tau_mm};
use crate::cloud::{Cloud, CloudError, PlaceId};
use crate::fine_loops::{FineError, FineLoop, Wanted, fine_loops, is_one_run};
use crate::functions::Field;
use crate::graph::{GraphError, PointGraph};
use crate::grown::{Growth, grown_graph};
use crate::links::Links;
use crate::loops::Loop;
use crate::saddles::Spans;
use crate::strips::{MOST_STRIPS, Strips, StripsError};
use crate::thinned::Thinned;

/// How a graph is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// τ in mm; `None` chooses it from the points.
    pub tau_mm: Option<f64>,
    /// The strips.
    pub strips: StripChoice,
    /// How pieces of strips are found.
    pub pieces: Pieces,
    /// Loops open over less of the function's range are minor.
    pub min_loop: f64,
}

impl Default for Choices {
    fn default() -> Choices {
        Choices { tau_mm: None, strips: StripChoice::Auto, pieces: Pieces::Exact, min_loop: 0.0 }
    }
}

/// How the range of a function is parted.
#[derive(Clone, Debug, PartialEq)]
pub enum StripChoice {
    /// Equal widths of 1.5 τ or more in space.
    Auto,
    /// This many of equal width.
    Uniform(usize),
    /// This many of equally many places.
    EqualCount(usize),
    /// Between these values.
    Between(Vec<f64>),
}

/// How the pieces of a strip are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pieces {
    /// Places nearer than τ belong together.
    Exact,
    /// Growth among the nearest places with a τ that follows their spacing.
    Grown(Growth),
}

/// A graph with its loops and what it was made with.
#[derive(Clone, Debug)]
pub struct Extraction<const D: usize> {
    /// The graph.
    pub graph: PointGraph<D>,
    /// Mean distance to the nearest other place in mm; 0 of a single place.
    pub spacing_mm: f64,
    /// τ in mm, of grown pieces the one to begin with.
    pub tau_mm: f64,
    /// The loops that count, the widest first.
    pub loops: Vec<Loop>,
    /// Loops that do not count. Of automatic strips: open over ⅔ to 1.8 τ in space, as gaps of the sampling are, or less than `min_loop`.
    /// Otherwise: spanning fewer than two strips, or less than `min_loop`.
    pub minor_loops: Vec<Loop>,
    /// The places by which loops were counted, where noise makes a thick layer of them.
    thinned: Option<Thinned<D>>,
}

/// The number of loops where τ and strips change.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// τ in mm, strips and loops of each trial.
    pub trials: Vec<(f64, usize, usize)>,
    /// All trials have as many loops as the graph.
    pub is_stable: bool,
}

/// Makes a graph. Some n·log n time.
///
/// # Errors
///
/// No points; choices that do not fit them.
pub fn extract<const D: usize>(
    cloud: &Cloud<D>,
    field: &Field,
    choices: &Choices,
) -> Result<Extraction<D>, ExtractError> {
    if cloud.is_empty() {
        return Err(ExtractError::NoPoints);
    }
    // The spacing and τ come with the links, where these are those of the whole cloud.
    let links = known_links(cloud, field, choices);
    let links = links.as_ref();
    let spacing_mm = links.map_or_else(|| cloud.spacing_mm(), |links| links.spacing_mm(cloud));
    let spacing_mm = spacing_mm.unwrap_or(0.0);
    let tau_mm = match (choices.tau_mm, choices.pieces) {
        (Some(tau_mm), _) => tau_mm,
        (None, Pieces::Grown(_)) if spacing_mm > 0.0 => SEED_TAU * spacing_mm,
        // A single place has no spacing; any τ gives the same graph.
        (None, _) => {
            let tau_mm = links.map_or_else(|| auto_tau_mm(cloud), |links| links.tau_mm(cloud));
            tau_mm.unwrap_or(1.0)
        }
    };
    let strips = strips(cloud, field, &choices.strips, tau_mm)?;
    let graph = match choices.pieces {
        Pieces::Exact => PointGraph::new(cloud, &field.values, strips, tau_mm)?,
        Pieces::Grown(growth) => grown_graph(cloud, &field.values, strips, tau_mm, growth)?,
    };
    // A τ that was asked for stays.
    let thinned = match choices.tau_mm {
        None if is_fine(choices, field) => Thinned::of(cloud, &field.values, spacing_mm)?,
        _ => None,
    };
    let (loops, minor_loops) = if is_fine(choices, field) {
        let places = match &thinned {
            Some(thinned) => LoopPlaces::thinned(thinned),
            None => {
                LoopPlaces { cloud, values: &field.values, known: links, original: None, tau_mm }
            }
        };
        let mut found = Vec::new();
        let thin = thin_strips(&graph.strips, field, places.tau_mm, 1.0)?;
        for one in between_thin_strips(&places, field, &graph, (&thin, 1.0), places.tau_mm)? {
            if one.span() >= Spans::of(1.0).short {
                found.push((one.is_no_gap, places.of_graph(&one, &graph, &thin)));
            }
        }
        found.sort_by(|(_, a), (_, b)| {
            b.extent().total_cmp(&a.extent()).then(a.nodes.cmp(&b.nodes))
        });
        let (loops, minor): (Vec<_>, Vec<_>) = found
            .into_iter()
            .partition(|(is_no_gap, one)| *is_no_gap && one.extent() >= choices.min_loop);
        [loops, minor].map(|found| found.into_iter().map(|(_, one)| one).collect()).into()
    } else {
        graph.loops().into_iter().partition(|found| counts(found, choices.min_loop))
    };
    Ok(Extraction { graph, spacing_mm, tau_mm, loops, minor_loops, thinned })
}

/// Whether loops are counted between levels closer than the strips of the graph.
///
/// Where a function that is no length jumps, a link would lead from one end of its range to the other, and make a loop.
fn is_fine(choices: &Choices, field: &Field) -> bool {
    field.is_length && choices.strips == StripChoice::Auto && choices.pieces == Pieces::Exact
}

/// The links of the whole cloud, if loops are counted by these.
fn known_links<const D: usize>(
    cloud: &Cloud<D>,
    field: &Field,
    choices: &Choices,
) -> Option<Links> {
    (is_fine(choices, field) && is_one_run(cloud)).then(|| Links::new(cloud))
}

/// Strips of τ/9 in space; `share` times as many.
fn thin_strips(
    strips: &Strips,
    field: &Field,
    tau_mm: f64,
    share: f64,
) -> Result<Strips, StripsError> {
    let bounds = strips.bounds();
    if field.is_length {
        let (low, high) = (bounds[0], bounds[bounds.len() - 1]);
        let count = (THIN * share * (high - low) / tau_mm).ceil();
        return Strips::uniform(low, high, (count as usize).clamp(1, MOST_STRIPS));
    }
    strips.divided((STRIP * THIN * share).round() as usize)
}

/// The places by which loops are counted.
struct LoopPlaces<'a, const D: usize> {
    cloud: &'a Cloud<D>,
    values: &'a [f64],
    /// Their links, if these are known.
    known: Option<&'a Links>,
    /// The place of the graph of each, where they are others.
    original: Option<&'a [PlaceId]>,
    tau_mm: f64,
}

impl<'a, const D: usize> LoopPlaces<'a, D> {
    fn thinned(thinned: &'a Thinned<D>) -> LoopPlaces<'a, D> {
        let Thinned { cloud, values, original, .. } = thinned;
        let tau_mm = auto_tau_mm(cloud).unwrap_or(1.0);
        LoopPlaces { cloud, values, known: None, original: Some(original), tau_mm }
    }

    /// The node of a place.
    fn node(&self, place: PlaceId, graph: &PointGraph<D>) -> u32 {
        let place = self.original.map_or(place, |original| original[place as usize]);
        graph.of_place[place as usize]
    }

    /// A loop between thin strips as one of the graph.
    fn of_graph(&self, found: &FineLoop, graph: &PointGraph<D>, thin: &Strips) -> Loop {
        let nodes = found.places.map(|place| self.node(place, graph));
        let strips = nodes.map(|node| graph.nodes[node as usize].strip);
        let bounds = thin.bounds();
        let range = [bounds[found.strips[0] as usize + 1], bounds[found.strips[1] as usize]];
        Loop { nodes, strips, range }
    }
}

/// Loops between thin strips, `share` times as many as usual, by links within the components of the graph.
fn between_thin_strips<const D: usize>(
    places: &LoopPlaces<'_, D>,
    field: &Field,
    graph: &PointGraph<D>,
    (thin, share): (&Strips, f64),
    tau_mm: f64,
) -> Result<Vec<FineLoop>, ExtractError> {
    let reach_mm = LINK * tau_mm;
    let width = thin.bounds()[1] - thin.bounds()[0];
    // Lengths change by no more than the way gone; by little more in the middle of noisy ones.
    let most = if places.original.is_some() { 2.0 * reach_mm } else { reach_mm };
    let margin = (field.is_length && width > 0.0).then(|| (most / width) as usize + 1);
    let (component_of_node, _) = graph.components();
    // Arcs lead to consecutive strips alone: where a function jumps nothing is joined. In a thick layer lengths differ by more.
    let may_link = |link: [PlaceId; 2]| {
        let [a, b] = link.map(|place| places.node(place, graph) as usize);
        component_of_node[a] == component_of_node[b]
            && (places.original.is_some()
                || graph.nodes[a].strip.abs_diff(graph.nodes[b].strip) <= 1)
    };
    let (known, spans) = (places.known, Spans::of(share));
    let wanted = Wanted { tau_mm, reach_mm, may_link: &may_link, known, spans };
    fine_loops(places.cloud, places.values, thin, wanted, margin).map_err(|error| match error {
        FineError::Graph(error) => error.into(),
        FineError::Cloud(error) => error.into(),
    })
}

impl<const D: usize> Extraction<D> {
    /// The radius in mm of discs of whose middle loops were counted: noise makes a thick layer of the places. `None` of those that lie
    /// on surfaces.
    pub fn thinned_mm(&self) -> Option<f64> {
        self.thinned.as_ref().map(|thinned| thinned.radius_mm)
    }

    /// Counts the loops again with τ times 0.8 and 1.25, and with 0.7 and 1.4 times as many strips. Up to four times the time of the graph.
    ///
    /// # Errors
    ///
    /// Errors as of [`extract`].
    pub fn stability(
        &self,
        cloud: &Cloud<D>,
        field: &Field,
        choices: &Choices,
    ) -> Result<Stability, ExtractError> {
        let count = self.graph.strips().count();
        let mut trials = Vec::new();
        let links = known_links(cloud, field, choices);
        let places = match &self.thinned {
            Some(thinned) => LoopPlaces::thinned(thinned),
            None => LoopPlaces {
                cloud,
                values: &field.values,
                known: links.as_ref(),
                original: None,
                tau_mm: self.tau_mm,
            },
        };
        for (of_tau, of_strips) in [(0.8, 1.0), (1.25, 1.0), (1.0, 0.7), (1.0, 1.4)] {
            let tau_mm = self.tau_mm * of_tau;
            if is_fine(choices, field) {
                let strips = (self.graph.strips.count() as f64 * of_strips).round().max(1.0);
                let thin = thin_strips(&self.graph.strips, field, places.tau_mm, of_strips)?;
                let found = between_thin_strips(
                    &places,
                    field,
                    &self.graph,
                    (&thin, of_strips),
                    places.tau_mm * of_tau,
                )?;
                let is_loop = |one: &&FineLoop| {
                    one.is_no_gap
                        && places.of_graph(one, &self.graph, &thin).extent() >= choices.min_loop
                };
                let loops = found.iter().filter(is_loop).count();
                trials.push((tau_mm, strips as usize, loops));
                continue;
            }
            let strips = self.changed_strips(field, &choices.strips, of_strips)?;
            let tried = strips.count();
            let graph = match choices.pieces {
                Pieces::Exact => PointGraph::new(cloud, &field.values, strips, tau_mm)?,
                Pieces::Grown(growth) => grown_graph(cloud, &field.values, strips, tau_mm, growth)?,
            };
            // A single strip has no loops, and that of a small cloud cannot be parted less.
            if of_strips == 1.0 || tried != count {
                let loops = graph.loops();
                let loops = loops.iter().filter(|found| counts(found, choices.min_loop)).count();
                trials.push((tau_mm, tried, loops));
            }
        }
        let is_stable = trials.iter().all(|&(_, _, loops)| loops == self.loops.len());
        Ok(Stability { trials, is_stable })
    }

    fn changed_strips(
        &self,
        field: &Field,
        choice: &StripChoice,
        share: f64,
    ) -> Result<Strips, StripsError> {
        let own = self.graph.strips();
        let (bounds, count) = (own.bounds(), own.count());
        let is_even = matches!(choice, StripChoice::Auto) && field.is_length;
        let changed = ((count as f64 * share).round() as usize).max(1);
        match choice {
            _ if share == 1.0 => Ok(own.clone()),
            StripChoice::EqualCount(_) => Strips::equal_count(&field.values, changed),
            StripChoice::Between(_) | StripChoice::Auto if !is_even => {
                // Given bounds are moved along: bound i of the new ones lies at i / share of the old.
                let at = |bound: usize| {
                    let place = bound as f64 * count as f64 / changed as f64;
                    let below = (place as usize).min(count - 1);
                    bounds[below] + (place - below as f64) * (bounds[below + 1] - bounds[below])
                };
                let inner: Vec<f64> = (1..changed).map(at).collect();
                Strips::between(bounds[0], bounds[count], &inner)
            }
            _ => Strips::uniform(bounds[0], bounds[count], changed),
        }
    }
}

fn counts(found: &Loop, min_loop: f64) -> bool {
    found.span() >= 2 && found.extent() >= min_loop
}

fn strips<const D: usize>(
    cloud: &Cloud<D>,
    field: &Field,
    choice: &StripChoice,
    tau_mm: f64,
) -> Result<Strips, ExtractError> {
    let Some([low, high]) = field.range() else {
        let place = field.values.iter().position(|value| !value.is_finite()).unwrap_or(0);
        let value = field.values.get(place).copied().unwrap_or(f64::NAN);
        return Err(GraphError::NotFinite { place, value }.into());
    };
    let strips = match choice {
        StripChoice::Auto => return auto_strips(cloud, field, tau_mm),
        StripChoice::Uniform(count) => Strips::uniform(low, high, *count),
        StripChoice::EqualCount(count) => Strips::equal_count(&field.values, *count),
        StripChoice::Between(values) => Strips::between(low, high, values),
    };
    Ok(strips?)
}

/// Reason why there is no graph of these points with these choices.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ExtractError {
    /// The cloud has no places.
    #[error("no points: expected one at least; check the file")]
    NoPoints,
    /// The strips cannot be made.
    #[error(transparent)]
    Strips(#[from] StripsError),
    /// The graph cannot be made.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// Neighbours cannot be listed.
    #[error(transparent)]
    Cloud(#[from] CloudError),
}

/// τ over the spacing where pieces grow (the paper's τ₁).
const SEED_TAU: f64 = 5.0;

/// Thin strips over τ.
const THIN: f64 = 9.0;

/// Links reach so many τ; most are shorter.
const LINK: f64 = 1.5;
