//! Graphs of strips that are halved again and again, as graph.json holds them.

use asphera_graph::functions::Field;
use asphera_graph::{
    Cloud, MOST_STRIPS, Resolution, StripChoice, Strips, auto_strips, resolutions,
};
use serde::Serialize;

use super::super::output::Failure;
use super::super::usage::misused;
use super::figures::{ArcFigures, NodeFigures, arc_figures, node_figures};

/// Counts of one resolution.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ResolutionCounts {
    pub(super) strips: usize,
    pub(super) nodes: usize,
    pub(super) arcs: usize,
    /// Arcs less nodes plus components.
    pub(super) loops: usize,
}

/// The graph of one resolution, and how it maps onto the coarser one.
#[derive(Serialize)]
pub(super) struct ResolutionFigures<'a> {
    #[serde(flatten)]
    counts: ResolutionCounts,
    strip_bounds: &'a [f64],
    node_list: Vec<NodeFigures>,
    arc_list: Vec<ArcFigures>,
    /// Of each node the node of the coarser graph that holds it; none of the coarsest.
    coarser: &'a [u32],
}

/// The graphs of strips that are halved until they are those asked for. Automatic strips become as many as can be halved.
pub(super) fn halved(
    cloud: &Cloud<3>,
    field: &Field,
    (choice, halvings): (&StripChoice, u32),
    tau_mm: f64,
) -> Result<Vec<Resolution<3>>, Failure> {
    let parts = 1_usize << halvings;
    let [low, high] = field.range().unwrap_or([f64::NAN; 2]);
    let coarsest = match choice {
        StripChoice::Uniform(count) if count % parts == 0 => {
            Strips::uniform(low, high, count / parts)?
        }
        StripChoice::Uniform(count) => {
            let next = count.div_ceil(parts) * parts;
            return Err(misused(format!(
                "--halvings {halvings} with {count} strips: expected a multiple of {parts}; take --strips {}",
                next.min(MOST_STRIPS)
            )));
        }
        StripChoice::Auto => auto_strips(cloud, field, tau_mm * parts as f64)?,
        StripChoice::EqualCount(_) | StripChoice::Between(_) => {
            return Err(misused(format!(
                "--halvings {halvings}: expected --strips auto or a number, whose strips can be halved"
            )));
        }
    };
    Ok(resolutions(cloud, field, &coarsest, tau_mm, halvings)?)
}

pub(super) fn counts(of: &Resolution<3>) -> ResolutionCounts {
    ResolutionCounts {
        strips: of.graph.strips().count(),
        nodes: of.graph.nodes().len(),
        arcs: of.graph.arcs().len(),
        loops: of.graph.loops().len(),
    }
}

pub(super) fn figures(of: &Resolution<3>) -> ResolutionFigures<'_> {
    ResolutionFigures {
        counts: counts(of),
        strip_bounds: of.graph.strips().bounds(),
        node_list: node_figures(&of.graph),
        arc_list: arc_figures(&of.graph),
        coarser: &of.coarser,
    }
}
