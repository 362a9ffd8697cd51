//! The report of a contour, made of what a method found.

use asphera_contour::{
    Chain, Choice, FoundCurve, Graph, Kind, Method, Parameters, Part, PlaceMm, Region, SampleId,
    Samples, Triangulation,
};
use asphera_report::contour::{
    CONTOUR_FORMAT, ChainFigures, ContourReport, InputFigures, RegionFigures,
};

use super::sampled::sampled;

/// The figures of a part of a region.
fn region_of(part: &Part, samples: &Samples) -> RegionFigures {
    let mut lines_mm = part.lines_mm(samples).into_iter();
    RegionFigures {
        label: None,
        area_mm2: part.area_mm2(samples),
        perimeter_mm: part.perimeter_mm(samples),
        outline_mm: lines_mm.next().unwrap_or_default(),
        holes_mm: lines_mm.collect(),
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
pub(super) fn line_mm(places_mm: &[PlaceMm], closed: bool) -> f64 {
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
pub(super) const MOST_CHECKED: usize = 200_000;

const TAKEN_FOR_CURVE: &str = "kind: points are taken for samples of a curve, not of an area";

/// The report of a region that a method made.
pub(super) fn region_report(
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
        regions: Some(region.parts().iter().map(|part| region_of(part, samples)).collect()),
        left_out,
        unknown: vec![
            "sampling: whether the points meet the method's condition is not checked".to_owned(),
            "kind: points are taken for samples of an area or its border as the method takes them"
                .to_owned(),
        ],
        ..curve_report(triangulation, method, parameters, &FoundCurve::default())
    }
}

/// The report with what the points say of themselves and of the method.
pub(super) fn with_choice(mut report: ContourReport, choice: &Choice) -> ContourReport {
    report.input.kind = Some(if choice.is_area { "area" } else { "border" }.to_owned());
    report.input.outliers = Some(choice.outliers.len());
    report.reason = Some(choice.reason());
    report.unknown.retain(|unknown| !unknown.starts_with("kind: "));
    report
}

/// The report of a graph or a curve that a method made.
pub(super) fn curve_report(
    triangulation: &Triangulation,
    method: Method,
    parameters: &Parameters,
    curve: &FoundCurve,
) -> ContourReport {
    let samples = triangulation.samples();
    let is_checked = method.kind() == Kind::Curve && samples.len() <= MOST_CHECKED;
    let mut distances_mm: Vec<f64> = (0..samples.len() as SampleId)
        .filter_map(|sample| triangulation.nearest(sample))
        .map(|spoke| triangulation.length_mm(spoke.edge))
        .collect();
    distances_mm.sort_by(f64::total_cmp);
    ContourReport {
        sampling: is_checked.then(|| sampled(&curve.sampling(triangulation), method)),
        unknown: match (method.kind(), is_checked) {
            (Kind::Curve, true) => vec![
                "sampling: it is that of the curve found; parts without points do not show"
                    .to_owned(),
                TAKEN_FOR_CURVE.to_owned(),
            ],
            (Kind::Curve, false) => not_checked(samples),
            (Kind::Graph | Kind::Region, _) => Vec::new(),
        },
        ..found_report(
            samples,
            (method, parameters),
            curve,
            distances_mm.get(distances_mm.len() / 2).copied(),
        )
    }
}

/// The report of a curve of more points than are checked, which a method found without a mesh.
pub(super) fn unmeshed_report(
    samples: &Samples,
    by: (Method, &Parameters),
    curve: &FoundCurve,
    spacing_median_mm: Option<f64>,
) -> ContourReport {
    let unknown = not_checked(samples);
    ContourReport { unknown, ..found_report(samples, by, curve, spacing_median_mm) }
}

fn not_checked(samples: &Samples) -> Vec<String> {
    let why = format!(
        "sampling: not checked of {} points, at most of {MOST_CHECKED}: it would take minutes",
        samples.len()
    );
    vec![why, TAKEN_FOR_CURVE.to_owned()]
}

/// The report of a graph or a curve without what is not known of it.
fn found_report(
    samples: &Samples,
    (method, parameters): (Method, &Parameters),
    curve: &FoundCurve,
    spacing_median_mm: Option<f64>,
) -> ContourReport {
    let graph = &curve.graph;
    let chains = match method.kind() {
        Kind::Curve => graph.chains(samples.len()),
        Kind::Graph | Kind::Region => Vec::new(),
    };
    let value = |name: &str| (name.to_owned(), parameters.value(&method, name));
    ContourReport {
        format: CONTOUR_FORMAT.to_owned(),
        input: InputFigures {
            points: samples.points(),
            distinct: samples.len(),
            noise_sigma_mm: curve.sigma_mm,
            spacing_median_mm,
            ..InputFigures::default()
        },
        method: method.name().to_owned(),
        parameters: method.parameters().iter().map(|parameter| value(parameter.name)).collect(),
        guarantee: method.guarantee().to_owned(),
        edges: graph.edges_by_row(samples),
        chains: figures(curve.places_mm.as_deref().unwrap_or(samples.places()), &chains),
        ends: rows(samples, graph.ends(samples.len())),
        junctions: rows(samples, graph.junctions(samples.len())),
        left_out: rows(samples, graph.alone(samples.len())),
        ..ContourReport::default()
    }
}

/// The true contour of points made of a known curve: its edges by rows, and its lines as places close together.
pub(crate) fn truth_report(
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
        format: CONTOUR_FORMAT.to_owned(),
        input: InputFigures {
            points: count,
            distinct: count,
            spacing_median_mm: edge_mm.get(edge_mm.len() / 2).copied(),
            ..InputFigures::default()
        },
        method: "truth".to_owned(),
        guarantee: "the curve itself".to_owned(),
        edges: graph.edges().to_vec(),
        chains: chains.collect(),
        ends: graph.ends(count),
        junctions: graph.junctions(count),
        left_out: graph.alone(count),
        ..ContourReport::default()
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
