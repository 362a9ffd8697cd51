//! A contour as the command writes it.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use asphera_contour::{
    Chain, Choice, FoundCurve, Graph, Kind, Method, Parameters, Part, PlaceMm, Region, SampleId,
    Samples, Triangulation,
};
use serde::{Deserialize, Serialize};

use super::features::FeatureFigures;
use super::figures::{CircleFigures, DeviationFigures};
use super::sampled::SampledFigures;
use crate::cli::summary::short;

/// What a file of this kind says of itself.
pub(in crate::cli) const FORMAT: &str = "asphera-contour 1";

/// The outcome of `asphera contour`. Lengths are mm; rows are those of points, counted from 0.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct ContourReport {
    /// [`FORMAT`].
    pub(in crate::cli) format: String,
    /// What was read.
    pub(in crate::cli) input: InputFigures,
    /// The method or graph.
    pub(in crate::cli) method: String,
    /// Why this method; where it was chosen by the points only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) reason: Option<String>,
    /// Its parameters with their values.
    pub(in crate::cli) parameters: BTreeMap<String, f64>,
    /// The condition under which its edges are proven to be those of the curve.
    pub(in crate::cli) guarantee: String,
    /// Pairs of rows, the smaller first, sorted. Of points in one place the first row stands for all.
    pub(in crate::cli) edges: Vec<[u32; 2]>,
    /// Runs of edges; none of a graph. Of a region the lines round its parts and holes come first.
    pub(in crate::cli) chains: Vec<ChainFigures>,
    /// Area of all parts in mm²; the next three are there for a region only, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) area_mm2: Option<f64>,
    /// How many parts there are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) parts: Option<usize>,
    /// How many holes all parts have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) holes: Option<usize>,
    /// The parts, by the samples of their outlines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) regions: Option<Vec<RegionFigures>>,
    /// Rows with one edge.
    pub(in crate::cli) ends: Vec<u32>,
    /// Rows with more than two.
    pub(in crate::cli) junctions: Vec<u32>,
    /// Rows without any, of a region those that no part holds: what the method left out.
    pub(in crate::cli) left_out: Vec<u32>,
    /// Whether the points suffice for the curve; of a curve only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) sampling: Option<SampledFigures>,
    /// The circle of the points; of one curve that is near a circle only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) circle: Option<CircleFigures>,
    /// Lines, arcs, corners and what they make; of a curve only.
    #[serde(default)]
    pub(in crate::cli) features: Vec<FeatureFigures>,
    /// Deviations from the nominal outline; where one is given only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) deviation: Option<DeviationFigures>,
    /// What is not known, and why.
    pub(in crate::cli) unknown: Vec<String>,
}

/// The points that were read.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct InputFigures {
    /// How many.
    pub(in crate::cli) points: usize,
    /// How many different places.
    pub(in crate::cli) distinct: usize,
    /// Whether they are of an area or of a border; where the method was chosen by the points only, as the next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) kind: Option<String>,
    /// How many of them are outliers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) outliers: Option<usize>,
    /// The standard deviation of their distances to the curve, where noise was taken away, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) noise_sigma_mm: Option<f64>,
    /// Median of the distances of places to their nearest one, mm.
    pub(in crate::cli) spacing_median_mm: f64,
}

/// A run of edges.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct ChainFigures {
    /// Whether its last place is joined to its first.
    pub(in crate::cli) closed: bool,
    /// Its length in mm, the closing edge included.
    pub(in crate::cli) length_mm: f64,
    /// Its places in order; of a closed one the first is not repeated.
    pub(in crate::cli) points_mm: Vec<PlaceMm>,
}

/// A part of a region.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct RegionFigures {
    /// Its area less its holes in mm².
    pub(in crate::cli) area_mm2: f64,
    /// Length of its outline and of the lines round its holes in mm.
    pub(in crate::cli) perimeter_mm: f64,
    /// Its outline, counter-clockwise; the first place is not repeated.
    pub(in crate::cli) outline_mm: Vec<PlaceMm>,
    /// The lines round its holes, clockwise.
    pub(in crate::cli) holes_mm: Vec<Vec<PlaceMm>>,
}

impl RegionFigures {
    fn new(part: &Part, samples: &Samples) -> RegionFigures {
        let mut lines_mm = part.lines_mm(samples).into_iter();
        RegionFigures {
            area_mm2: part.area_mm2(samples),
            perimeter_mm: part.perimeter_mm(samples),
            outline_mm: lines_mm.next().unwrap_or_default(),
            holes_mm: lines_mm.collect(),
        }
    }
}

/// The runs of a region's border that enclose nothing.
fn open_runs(region: &Region, samples: usize) -> Vec<Chain> {
    let round = region.parts().iter().flat_map(Part::lines);
    let sides = Graph::new(round.flat_map(|line| {
        let next = line.iter().cycle().skip(1);
        line.iter().zip(next).map(|(&p, &q)| [p, q])
    }));
    let other = region.border().edges().iter().copied().filter(|&[p, q]| !sides.joins(p, q));
    Graph::new(other).chains(samples)
}

/// Length of a line in mm, with the side that closes it.
fn line_mm(places_mm: &[PlaceMm], closed: bool) -> f64 {
    let sides = places_mm.len().saturating_sub(usize::from(!closed));
    let next = places_mm.iter().cycle().skip(1);
    let sides = places_mm.iter().zip(next).take(sides);
    sides.map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).sum()
}

/// The lines round the parts and holes of a region, then those that enclose nothing.
fn lines(region: &Region, samples: &Samples) -> Vec<ChainFigures> {
    let round = region.parts().iter().flat_map(|part| part.lines_mm(samples));
    let closed = |points_mm: Vec<PlaceMm>| ChainFigures {
        closed: true,
        length_mm: line_mm(&points_mm, true),
        points_mm,
    };
    let open = figures(samples.places(), &open_runs(region, samples.len()));
    round.map(closed).chain(open).collect()
}

/// Points of which the sampling is checked: above them it takes longer than the curve itself by far.
const MOST_CHECKED: usize = 200_000;

const TAKEN_FOR_CURVE: &str = "kind: points are taken for samples of a curve, not of an area";

impl ContourReport {
    /// The report of a region that a method made.
    pub(super) fn of_region(
        triangulation: &Triangulation,
        method: Method,
        parameters: &Parameters,
        region: &Region,
    ) -> ContourReport {
        let samples = triangulation.samples();
        let graph = region.border();
        let left_out = rows(samples, region.left_out().to_vec());
        ContourReport {
            edges: graph.edges_by_row(samples),
            ends: rows(samples, graph.ends(samples.len())),
            junctions: rows(samples, graph.junctions(samples.len())),
            chains: lines(region, samples),
            area_mm2: Some(region.area_mm2(samples)),
            parts: Some(region.parts().len()),
            holes: Some(region.parts().iter().map(|part| part.holes.len()).sum()),
            regions: Some(
                region.parts().iter().map(|part| RegionFigures::new(part, samples)).collect(),
            ),
            left_out,
            unknown: vec![
                "sampling: whether the points meet the method's condition is not checked".to_owned(),
                "kind: points are taken for samples of an area or its border as the method takes them"
                    .to_owned(),
            ],
            ..ContourReport::new(triangulation, method, parameters, &FoundCurve::default())
        }
    }

    /// The same with what the points say of themselves and of the method.
    pub(super) fn chosen(mut self, choice: &Choice) -> ContourReport {
        self.input.kind = Some(if choice.is_area { "area" } else { "border" }.to_owned());
        self.input.outliers = Some(choice.outliers.len());
        self.reason = Some(choice.reason());
        self.unknown.retain(|unknown| !unknown.starts_with("kind: "));
        self
    }

    /// The report of a graph or a curve that a method made.
    pub(super) fn new(
        triangulation: &Triangulation,
        method: Method,
        parameters: &Parameters,
        curve: &FoundCurve,
    ) -> ContourReport {
        let graph = &curve.graph;
        let samples = triangulation.samples();
        let is_curve = method.kind() == Kind::Curve;
        let is_checked = is_curve && samples.len() <= MOST_CHECKED;
        let chains = if is_curve { graph.chains(samples.len()) } else { Vec::new() };
        let mut distances_mm: Vec<f64> = (0..samples.len() as SampleId)
            .filter_map(|sample| triangulation.nearest(sample))
            .map(|spoke| triangulation.length_mm(spoke.edge))
            .collect();
        distances_mm.sort_by(f64::total_cmp);
        let value = |name: &str| (name.to_owned(), parameters.value(&method, name));
        ContourReport {
            format: FORMAT.to_owned(),
            input: InputFigures {
                points: samples.points(),
                distinct: samples.len(),
                kind: None,
                outliers: None,
                noise_sigma_mm: curve.sigma_mm,
                spacing_median_mm: distances_mm[distances_mm.len() / 2],
            },
            method: method.name().to_owned(),
            reason: None,
            parameters: method.parameters().iter().map(|parameter| value(parameter.name)).collect(),
            guarantee: method.guarantee().to_owned(),
            edges: graph.edges_by_row(samples),
            chains: figures(curve.places_mm.as_deref().unwrap_or(samples.places()), &chains),
            area_mm2: None,
            parts: None,
            holes: None,
            regions: None,
            ends: rows(samples, graph.ends(samples.len())),
            junctions: rows(samples, graph.junctions(samples.len())),
            left_out: rows(samples, graph.alone(samples.len())),
            sampling: is_checked
                .then(|| SampledFigures::new(&curve.sampling(triangulation), method)),
            circle: None,
            features: Vec::new(),
            deviation: None,
            unknown: match (is_curve, is_checked) {
                (false, _) => Vec::new(),
                (true, true) => vec![
                    "sampling: it is that of the curve found; parts without points do not show"
                        .to_owned(),
                    TAKEN_FOR_CURVE.to_owned(),
                ],
                (true, false) => vec![
                    format!(
                        "sampling: not checked of {} points, at most of {MOST_CHECKED}: it would take minutes",
                        samples.len()
                    ),
                    TAKEN_FOR_CURVE.to_owned(),
                ],
            },
        }
    }

    /// The true contour of points made of a known curve: its edges by rows, and its lines as places close together.
    pub(in crate::cli) fn of_truth(
        points_mm: &[PlaceMm],
        edges: &[[u32; 2]],
        lines: Vec<(Vec<PlaceMm>, bool)>,
    ) -> ContourReport {
        let graph = Graph::new(edges.iter().copied());
        let chains = lines.into_iter().map(|(points_mm, closed)| ChainFigures {
            closed,
            length_mm: line_mm(&points_mm, closed),
            points_mm,
        });
        let count = points_mm.len();
        let mut edge_mm: Vec<f64> = edges
            .iter()
            .map(|edge| edge.map(|row| points_mm[row as usize]))
            .map(|[p, q]| (p[0] - q[0]).hypot(p[1] - q[1]))
            .collect();
        edge_mm.sort_by(f64::total_cmp);
        ContourReport {
            format: FORMAT.to_owned(),
            input: InputFigures {
                points: count,
                distinct: count,
                kind: None,
                outliers: None,
                noise_sigma_mm: None,
                spacing_median_mm: edge_mm.get(edge_mm.len() / 2).copied().unwrap_or(0.0),
            },
            method: "truth".to_owned(),
            reason: None,
            parameters: BTreeMap::new(),
            guarantee: "the curve itself".to_owned(),
            edges: graph.edges().to_vec(),
            chains: chains.collect(),
            area_mm2: None,
            parts: None,
            holes: None,
            regions: None,
            ends: graph.ends(count),
            junctions: graph.junctions(count),
            left_out: graph.alone(count),
            sampling: None,
            circle: None,
            features: Vec::new(),
            deviation: None,
            unknown: Vec::new(),
        }
    }

    /// The outcome as a person reads it.
    pub(super) fn summary(&self) -> String {
        let mut text = String::new();
        // Writing into a String cannot fail.
        let _ = self.write_summary(&mut text);
        text
    }

    fn write_summary(&self, text: &mut String) -> std::fmt::Result {
        let InputFigures { points, distinct, spacing_median_mm, .. } = &self.input;
        writeln!(
            text,
            "points     {points}, {distinct} places, spacing {} mm (median)",
            short(*spacing_median_mm)
        )?;
        write!(text, "method     {}", self.method)?;
        for (name, value) in &self.parameters {
            write!(text, " {name}={value}")?;
        }
        writeln!(text, "; proven for: {}", self.guarantee)?;
        if let Some(reason) = &self.reason {
            writeln!(text, "chosen     {reason}")?;
        }
        if let Some(sigma_mm) = self.input.noise_sigma_mm {
            writeln!(text, "noise      {} mm (standard deviation), taken away", short(sigma_mm))?;
        }
        writeln!(text, "edges      {}", self.edges.len())?;
        if !self.chains.is_empty() {
            let closed = self.chains.iter().filter(|chain| chain.closed).count();
            let length_mm: f64 = self.chains.iter().map(|chain| chain.length_mm).sum();
            let open = self.chains.len() - closed;
            let length = short(length_mm);
            writeln!(text, "curves     {closed} closed, {open} open, {length} mm together")?;
        }
        if let (Some(area_mm2), Some(parts), Some(holes)) = (self.area_mm2, self.parts, self.holes)
        {
            writeln!(text, "area       {} mm², {parts} parts, {holes} holes", short(area_mm2))?;
        }
        writeln!(
            text,
            "unjoined   {} ends, {} junctions, {} points left out",
            self.ends.len(),
            self.junctions.len(),
            self.left_out.len()
        )?;
        if let Some(sampling) = &self.sampling {
            sampling.write_summary(text)?;
        }
        if let Some(circle) = &self.circle {
            circle.write_summary(text)?;
        }
        self.features.iter().try_for_each(|feature| feature.write_summary(text))?;
        if let Some(deviation) = &self.deviation {
            deviation.write_summary(text)?;
        }
        self.unknown.iter().try_for_each(|unknown| writeln!(text, "unknown    {unknown}"))
    }
}

/// The rows of samples, sorted.
fn rows(samples: &Samples, found: Vec<SampleId>) -> Vec<u32> {
    let mut rows: Vec<u32> = found.into_iter().map(|sample| samples.row_of(sample)).collect();
    rows.sort_unstable();
    rows
}

fn figures(places: &[PlaceMm], chains: &[Chain]) -> Vec<ChainFigures> {
    let figures = |chain: &Chain| {
        let points_mm: Vec<PlaceMm> =
            chain.samples.iter().map(|&sample| places[sample as usize]).collect();
        let length_mm = line_mm(&points_mm, chain.closed);
        ChainFigures { closed: chain.closed, length_mm, points_mm }
    };
    chains.iter().map(figures).collect()
}
