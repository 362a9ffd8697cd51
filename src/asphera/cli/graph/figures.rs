//! The figures of a graph as JSON writes them: `asphera.graph/1`.

use std::fmt::Write as _;

use asphera_graph::{
    Arc, Choices, Cloud, ExtractError, Extraction, Loop, Node, PointGraph, Resolution, extract,
};
use asphera_report::parts::PartFigures;
use asphera_report::words::counted;
use serde::Serialize;

use super::super::output::Failure;
use super::super::progress::Progress;
use super::super::summary::short;
use super::function::FunctionChoice;
use super::resolutions::{ResolutionCounts, ResolutionFigures, counts, halved};
use crate::parts::parts_of;

/// The figures of a graph. Lengths are mm of the file's frame.
#[derive(Clone, Debug, Serialize)]
pub(in crate::cli) struct GraphReport {
    format: &'static str,
    pub(super) file: String,
    pub(super) points: u64,
    pub(super) spacing_mm: f64,
    pub(super) tau_mm: f64,
    pub(super) strips: usize,
    pub(super) function: FunctionFigures,
    pub(super) nodes: usize,
    pub(super) arcs: usize,
    pub(super) components: u32,
    pub(super) loops: usize,
    /// Whether as many loops are found with τ times 0.8 and 1.25, and with 0.7 and 1.4 times as many strips.
    pub(super) loops_stable: bool,
    /// The most loops along this function and heights near the principal axes; of a closed body the number of its handles.
    pub(super) most_loops: MostLoopsFigures,
    pub(super) loop_ranges: Vec<LoopFigures>,
    /// Loops too small to count.
    pub(super) minor_loops: Vec<LoopFigures>,
    /// The radius of discs of whose middle loops were counted; none where points lie on surfaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) loops_thinned_mm: Option<f64>,
    /// Graphs of wider strips, the coarsest first, with `--halvings`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) halved: Vec<ResolutionCounts>,
    pub(super) parts: Vec<PartFigures>,
    /// Pieces of too few points to be parts.
    pub(super) islands: usize,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct FunctionFigures {
    kind: String,
    range: [f64; 2],
    /// Another function would do as well, as where the cloud has no longest axis.
    multiple: bool,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct MostLoopsFigures {
    loops: usize,
    stable: bool,
    /// The direction of the height that has more than the function; of length 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    along: Option<[f64; 3]>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct LoopFigures {
    /// The range of the function in which the loop is surely open.
    range: [f64; 2],
    extent: f64,
    strips: u32,
}

/// The report with what the files hold.
pub(super) struct Outcome {
    pub(super) report: GraphReport,
    pub(super) cloud: Cloud<3>,
    pub(super) values: Vec<f64>,
    pub(super) found: Extraction<3>,
    /// The part of each place, from 0; −1 of islands.
    pub(super) part_of_place: Vec<i32>,
    pub(super) resolutions: Vec<Resolution<3>>,
}

/// The report with all nodes and arcs, as graph.json holds them.
#[derive(Serialize)]
pub(super) struct WholeGraph<'a> {
    #[serde(flatten)]
    report: &'a GraphReport,
    strip_bounds: &'a [f64],
    node_list: Vec<NodeFigures>,
    arc_list: Vec<ArcFigures>,
    /// Chains of nodes between ends and branches.
    segments: Vec<Vec<u32>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    resolutions: Vec<ResolutionFigures<'a>>,
}

#[derive(Serialize)]
pub(super) struct NodeFigures {
    strip: u32,
    places: u32,
    centroid_mm: [f64; 3],
    box_mm: [[f64; 3]; 2],
    range: [f64; 2],
}

#[derive(Serialize)]
pub(super) struct ArcFigures {
    nodes: [u32; 2],
    distance_mm: f64,
}

/// Makes the graph of points.
pub(super) fn of(
    (file, points): (&str, &[[f64; 3]]),
    (function, values): (&FunctionChoice, Option<&[f64]>),
    (choices, halvings): (&Choices, u32),
    progress: &Progress,
) -> Result<Outcome, Failure> {
    let failed = |error: ExtractError| -> Failure { format!("{file}: {error}").into() };
    progress.stage("sorting points");
    let cloud = Cloud::new(points).map_err(|error| format!("{file}: {error}"))?;
    progress.stage(function.kind());
    let field = function.field(&cloud, values).map_err(|error| format!("{file}: {error}"))?;
    progress.stage("joining pieces");
    let found = extract(&cloud, &field, choices).map_err(failed)?;
    progress.stage("trying other strips");
    let stability = found.stability(&cloud, &field, choices).map_err(failed)?;
    let resolutions = match halvings {
        0 => Vec::new(),
        _ => halved(&cloud, &field, (&choices.strips, halvings), found.tau_mm)
            .map_err(|error| format!("{file}: {error}"))?,
    };
    progress.stage("parts");
    let parts = parts_of(&cloud, found.tau_mm)?;
    let mut part_of_place = vec![-1; cloud.len()];
    for (number, part) in (0..).zip(&parts.parts) {
        part.places.iter().for_each(|&place| part_of_place[place as usize] = number);
    }
    // A loop lies in the part of any place of its upper node.
    let mut place_of_node = vec![0; found.graph.nodes().len()];
    for (place, &node) in found.graph.nodes_of_places().iter().enumerate() {
        place_of_node[node as usize] = place;
    }
    let part_of = |one: &Loop| part_of_place[place_of_node[one.nodes[1] as usize]];
    let part_figures = (0..).zip(&parts.parts).map(|(number, part)| PartFigures {
        points: part.points,
        box_mm: part.box_mm,
        centre_mm: part.centre_mm,
        loops: found.loops.iter().filter(|one| part_of(one) == number).count(),
    });
    let part_figures = part_figures.collect();
    let [low, high] = field.range().unwrap_or([f64::NAN; 2]);
    let report = GraphReport {
        format: "asphera.graph/1",
        file: file.to_owned(),
        points: points.len() as u64,
        spacing_mm: found.spacing_mm,
        tau_mm: found.tau_mm,
        strips: found.graph.strips().count(),
        function: FunctionFigures {
            kind: function.kind(),
            range: [low, high],
            multiple: field.is_multiple,
        },
        nodes: found.graph.nodes().len(),
        arcs: found.graph.arcs().len(),
        components: found.graph.components().1,
        loops: found.loops.len(),
        loops_stable: stability.is_stable,
        most_loops: MostLoopsFigures {
            loops: stability.most.loops,
            stable: stability.most.is_stable,
            along: stability.most.along,
        },
        loop_ranges: found.loops.iter().map(loop_figures).collect(),
        minor_loops: found.minor_loops.iter().map(loop_figures).collect(),
        loops_thinned_mm: found.thinned_mm(),
        halved: resolutions.iter().map(counts).collect(),
        parts: part_figures,
        islands: parts.islands.len(),
    };
    Ok(Outcome { report, cloud, values: field.values, found, part_of_place, resolutions })
}

fn loop_figures(found: &Loop) -> LoopFigures {
    LoopFigures { range: found.range, extent: found.extent(), strips: found.span() }
}

impl Outcome {
    pub(super) fn whole(&self) -> WholeGraph<'_> {
        let graph = &self.found.graph;
        WholeGraph {
            report: &self.report,
            strip_bounds: graph.strips().bounds(),
            node_list: node_figures(graph),
            arc_list: arc_figures(graph),
            segments: graph.segments().into_iter().map(|segment| segment.nodes).collect(),
            resolutions: self.resolutions.iter().map(super::resolutions::figures).collect(),
        }
    }
}

pub(super) fn node_figures(graph: &PointGraph<3>) -> Vec<NodeFigures> {
    let of = |node: &Node<3>| NodeFigures {
        strip: node.strip,
        places: node.places,
        centroid_mm: node.centroid_mm,
        box_mm: node.box_mm,
        range: node.range,
    };
    graph.nodes().iter().map(of).collect()
}

pub(super) fn arc_figures(graph: &PointGraph<3>) -> Vec<ArcFigures> {
    let of = |arc: &Arc| ArcFigures { nodes: arc.nodes, distance_mm: arc.distance_mm };
    graph.arcs().iter().map(of).collect()
}

impl GraphReport {
    /// Lines for a terminal.
    pub(super) fn summary(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: String| {
            // Writing into a String cannot fail.
            let _ = writeln!(text, "{name:<10} {value}");
        };
        line("points", format!("{}, {} mm apart", self.points, short(self.spacing_mm)));
        let [low, high] = self.function.range.map(short);
        let multiple = if self.function.multiple { "; one of several that would do" } else { "" };
        line("function", format!("{}, {low} to {high}{multiple}", self.function.kind));
        line("strips", format!("{}, tau {} mm", self.strips, short(self.tau_mm)));
        line(
            "graph",
            [
                counted(self.nodes as u64, "node"),
                counted(self.arcs as u64, "arc"),
                counted(self.components.into(), "component"),
            ]
            .join(", "),
        );
        let holds = |is_stable| match is_stable {
            true => "also with other tau and strips",
            false => "not with every other tau and strips",
        };
        let minor = self.minor_loops.len();
        line("loops", format!("{}, {}; {minor} minor", self.loops, holds(self.loops_stable)));
        if let MostLoopsFigures { loops, stable, along: Some(along) } = &self.most_loops {
            let [x, y, z] = along.map(short);
            line(
                "",
                format!(
                    "{loops} along height:{x},{y},{z}, {}: a closed body has as many along every height, \
                     some open too briefly to count",
                    holds(*stable)
                ),
            );
        }
        if let Some(radius_mm) = self.loops_thinned_mm {
            let discs = short(radius_mm);
            line(
                "",
                format!(
                    "counted in the middle of a thick layer of points, by discs of radius {discs} mm"
                ),
            );
        }
        for found in self.loop_ranges.iter().take(SHOWN) {
            let [low, high] = found.range.map(short);
            line("", format!("open from {low} to {high}"));
        }
        for one in &self.halved {
            let ResolutionCounts { strips, nodes, arcs, loops } = one;
            let graph = [(strips, "strip"), (nodes, "node"), (arcs, "arc"), (loops, "loop")]
                .map(|(number, what)| counted(*number as u64, what));
            line("halved", graph.join(", "));
        }
        line(
            "parts",
            format!("{}, and {}", self.parts.len(), counted(self.islands as u64, "island")),
        );
        for part in self.parts.iter().take(SHOWN) {
            line("", part_line(part));
        }
        text
    }
}

/// A part in a line.
pub(in crate::cli) fn part_line(part: &PartFigures) -> String {
    let [x, y, z] = part.centre_mm.map(short);
    let size: Vec<String> =
        (0..3).map(|axis| short(part.box_mm[1][axis] - part.box_mm[0][axis])).collect();
    format!(
        "{} points at ({x}, {y}, {z}) mm, {} mm, loops: {}",
        part.points,
        size.join(" × "),
        part.loops
    )
}

/// Loops and parts that are shown at most.
const SHOWN: usize = 12;
