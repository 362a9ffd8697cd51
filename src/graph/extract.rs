//! A graph by default or by choice, and its loops.

use thiserror::Error;

use crate::auto::{auto_strips, auto_tau_mm};
use crate::cloud::{Cloud, CloudError};
use crate::fine_loops::is_one_run;
use crate::functions::Field;
use crate::graph::{GraphError, PointGraph};
use crate::grown::{Growth, grown_graph};
use crate::links::Links;
use crate::loop_places::{LoopPlaces, thin_strips};
use crate::loops::Loop;
use crate::saddles::Spans;
use crate::strips::{Strips, StripsError};
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
    pub(crate) thinned: Option<Thinned<D>>,
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
            Some(thinned) => LoopPlaces::thinned(thinned, None),
            None => LoopPlaces::of_graph(cloud, &field.values, links, tau_mm),
        };
        let mut found = Vec::new();
        let thin = thin_strips(&graph.strips, field, places.tau_mm, 1.0)?;
        for one in places.loops(field.is_length, &graph, (&thin, 1.0), places.tau_mm)? {
            if one.span() >= Spans::of(1.0).short {
                found.push((one.is_no_gap, places.loop_of_graph(&one, &graph, &thin)));
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
pub(crate) fn is_fine(choices: &Choices, field: &Field) -> bool {
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

impl<const D: usize> Extraction<D> {
    /// The radius in mm of discs of whose middle loops were counted: noise makes a thick layer of the places. `None` of those that lie
    /// on surfaces.
    pub fn thinned_mm(&self) -> Option<f64> {
        self.thinned.as_ref().map(|thinned| thinned.radius_mm)
    }
}

pub(crate) fn counts(found: &Loop, min_loop: f64) -> bool {
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
