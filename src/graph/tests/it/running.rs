//! The graph of a scan while it goes on is that of all its points.

use std::collections::BTreeSet;

use asphera_graph::{
    Change, Cloud, PointGraph, RunningError, RunningGraph, RunningPart, RunningSettings, Strips,
    parts,
};
use proptest::prelude::*;

use crate::bodies::{Body, Place, Random};
use crate::tray::tray;

const SETTINGS: RunningSettings =
    RunningSettings { axis: 1, is_reversed: false, tau_mm: 0.9, strip_mm: 1.7, keeps_points: true };

/// What a running graph gave.
struct Found {
    nodes: BTreeSet<NodeKey>,
    arcs: BTreeSet<(NodeKey, NodeKey, u64)>,
    parts: Vec<RunningPart>,
    changes: Vec<Change>,
    late: u64,
}

/// Strip, places and box of a node, which no two nodes share.
type NodeKey = (i64, u64, [[u64; 3]; 2]);

fn key(strip: i64, places: u64, box_mm: [Place; 2]) -> NodeKey {
    (strip, places, box_mm.map(|corner| corner.map(|value| (value + 0.0).to_bits())))
}

fn running(points: &[Place], settings: RunningSettings, batch: usize) -> Found {
    let mut graph = RunningGraph::new(settings).unwrap();
    let (mut closed, mut parts, mut changes) = (Vec::new(), Vec::new(), Vec::new());
    for points in points.chunks(batch) {
        graph.take(points).unwrap();
        closed.extend(graph.take_closed());
        parts.extend(graph.take_ended());
        changes.extend(graph.take_events().into_iter().map(|event| event.change));
    }
    graph.finish();
    closed.extend(graph.take_closed());
    parts.extend(graph.take_ended());
    changes.extend(graph.take_events().into_iter().map(|event| event.change));
    assert_eq!((graph.open_parts(), graph.waiting()), (0, 0));
    assert_eq!(graph.received(), points.len() as u64);
    let mut keys = Vec::new();
    for strip in &closed {
        assert_eq!(strip.first_node, keys.len() as u64);
        keys.extend(strip.nodes.iter().map(|node| key(strip.strip, node.places, node.box_mm)));
    }
    let arc = |&([a, b], mm): &([u64; 2], f64)| (keys[a as usize], keys[b as usize], mm.to_bits());
    let arcs = closed.iter().flat_map(|strip| &strip.arcs).map(arc).collect();
    Found { nodes: keys.iter().copied().collect(), arcs, parts, changes, late: graph.late() }
}

/// Nodes and arcs of all points at once, with the same strips.
fn whole(
    points: &[Place],
    settings: RunningSettings,
) -> (BTreeSet<NodeKey>, BTreeSet<(NodeKey, NodeKey, u64)>) {
    let cloud = Cloud::new(points).unwrap();
    let sign = if settings.is_reversed { -1.0 } else { 1.0 };
    let values: Vec<f64> = cloud.places().iter().map(|at| sign * at[settings.axis]).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let first = (low / settings.strip_mm).floor() as i64;
    let last = (high / settings.strip_mm).floor() as i64 + 1;
    let bounds: Vec<f64> = (first..=last).map(|at| at as f64 * settings.strip_mm).collect();
    // The last strip of a partition holds its upper bound, so one that no value reaches is taken.
    let end = bounds[bounds.len() - 1];
    let strips = Strips::between(low, end, &bounds).unwrap();
    let graph = PointGraph::new(&cloud, &values, strips, settings.tau_mm).unwrap();
    let number = |value: f64| (value / settings.strip_mm).floor() as i64;
    let keys: Vec<NodeKey> = graph
        .nodes()
        .iter()
        .map(|node| key(number(node.range[0]), u64::from(node.places), node.box_mm))
        .collect();
    let arc = |arc: &asphera_graph::Arc| {
        let [a, b] = arc.nodes.map(|node| keys[node as usize]);
        (a, b, arc.distance_mm.to_bits())
    };
    (keys.iter().copied().collect(), graph.arcs().iter().map(arc).collect())
}

/// The points as a scan along an axis gives them.
fn scanned(mut points: Vec<Place>, settings: RunningSettings) -> Vec<Place> {
    let sign = if settings.is_reversed { -1.0 } else { 1.0 };
    points.sort_by(|a, b| (sign * a[settings.axis]).total_cmp(&(sign * b[settings.axis])));
    points
}

fn check(points: Vec<Place>, settings: RunningSettings) -> Found {
    let points = scanned(points, settings);
    let found = running(&points, settings, 100);
    assert_eq!(found.late, 0);
    let (nodes, arcs) = whole(&points, settings);
    assert!(
        found.nodes == nodes && found.arcs == arcs,
        "{} and {} nodes",
        found.nodes.len(),
        nodes.len()
    );
    // Parts are the τ-components of all points.
    let cloud = Cloud::new(&points).unwrap();
    let all = parts(&cloud, settings.tau_mm, 0).unwrap().parts;
    assert_eq!(all.len(), found.parts.len());
    let mut rows_seen = 0;
    for part in &found.parts {
        assert_eq!(part.rows.len() as u64, part.points);
        rows_seen += part.rows.len();
        let place = cloud.places_of_rows()[part.rows[0].0 as usize];
        let twin = all.iter().find(|twin| twin.places.binary_search(&place).is_ok()).unwrap();
        assert_eq!((part.points, part.places), (twin.points, twin.places.len() as u64));
        assert_eq!(part.box_mm, twin.box_mm);
        for axis in 0..3 {
            assert!((part.centre_mm[axis] - twin.centre_mm[axis]).abs() < 1e-9);
        }
        for &(row, at_mm) in &part.rows {
            assert_eq!(points[row as usize], at_mm);
            let place = cloud.places_of_rows()[row as usize];
            assert!(twin.places.binary_search(&place).is_ok());
        }
    }
    assert_eq!(rows_seen, points.len());
    found
}

/// `ASPHERA_TRAYS=500` takes more of them.
#[test]
fn trays_have_the_graph_and_the_parts_of_the_whole_file() {
    let asked = std::env::var("ASPHERA_TRAYS").ok().and_then(|words| words.parse().ok());
    for seed in 0..asked.unwrap_or(8) {
        for (axis, is_reversed) in [(0, false), (1, true), (1, false)] {
            let settings = RunningSettings { axis, is_reversed, ..SETTINGS };
            let points = tray(seed, 0.3).points;
            let found = check(points, settings);
            let begun = found.changes.iter().filter(|change| **change == Change::Begun).count();
            let ended = found.changes.iter().filter(|change| **change == Change::Ended).count();
            assert_eq!(ended, found.parts.len());
            assert!(begun >= ended);
        }
    }
}

#[test]
fn batches_and_the_order_within_a_strip_change_nothing() {
    let points = scanned(tray(3, 0.3).points, SETTINGS);
    let usual = running(&points, SETTINGS, 100);
    let mut random = Random::new(4);
    for batch in [1, 7, 1000, points.len()] {
        let mut mixed = points.clone();
        let strip = |at: &Place| (at[1] / SETTINGS.strip_mm).floor();
        let in_strips = mixed.chunk_by_mut(|a, b| strip(a) == strip(b));
        in_strips.for_each(|some| random.shuffle(some));
        let found = running(&mixed, SETTINGS, batch);
        assert_eq!(found.late, 0);
        assert!(found.nodes == usual.nodes && found.arcs == usual.arcs, "batches of {batch}");
        assert_eq!(found.changes, usual.changes);
        let bare = |parts: &[RunningPart]| -> Vec<RunningPart> {
            parts.iter().map(|part| RunningPart { rows: Vec::new(), ..part.clone() }).collect()
        };
        assert_eq!(bare(&found.parts), bare(&usual.parts));
    }
}

#[test]
fn a_torus_begins_splits_joins_and_ends_with_one_loop() {
    let points = Body::torus().sample(20_000, &mut Random::new(5));
    let settings = RunningSettings { axis: 0, tau_mm: 0.15, strip_mm: 0.25, ..SETTINGS };
    let found = check(points, settings);
    let [part] = &found.parts[..] else { panic!("{} parts", found.parts.len()) };
    assert_eq!((part.loops, part.is_open), (1, true));
    assert_eq!(
        found.changes,
        [
            Change::Begun,
            Change::Split { branches: 2 },
            Change::Joined { branches: 2 },
            Change::Ended
        ]
    );
}

/// Two legs that meet are one part, with the lower number; what lies apart ends before.
#[test]
fn legs_that_meet_are_merged() {
    let line = |x: f64, from: f64, to: f64| {
        let steps = ((to - from) / 0.1) as usize;
        (0..=steps).map(move |step| [x, from + 0.1 * step as f64, 0.0])
    };
    let across = (0..=100).map(|step| [0.1 * f64::from(step), 10.0, 0.0]);
    let points =
        line(0.0, 0.0, 10.0).chain(line(10.0, 0.0, 10.0)).chain(across).chain(line(20.0, 0.0, 5.0));
    let settings = RunningSettings { tau_mm: 0.3, strip_mm: 1.0, ..SETTINGS };
    let found = check(points.collect(), settings);
    assert_eq!(found.parts.iter().map(|part| part.id).collect::<Vec<_>>(), [2, 0]);
    let others: Vec<&Change> = found
        .changes
        .iter()
        .filter(|change| !matches!(change, Change::Begun | Change::Ended))
        .collect();
    assert_eq!(others, [&Change::Merged { absorbed: vec![1] }]);
    assert_eq!(found.parts.iter().map(|part| part.is_open).collect::<Vec<_>>(), [false, true]);
}

#[test]
fn points_that_come_too_late_are_counted() {
    let mut points: Vec<Place> = (0..1000).map(|step| [0.0, 0.1 * f64::from(step), 0.0]).collect();
    points.push([0.0, 3.0, 0.0]);
    let found = running(&points, SETTINGS, 10);
    assert_eq!(found.late, 1);
    assert_eq!(found.parts.iter().map(|part| part.points).sum::<u64>(), 1000);
}

/// Otherwise one wild point would close all strips between, and all that follow would come too late.
#[test]
fn a_spike_ahead_of_all_others_closes_nothing() {
    let mut points: Vec<Place> = (0..1000).map(|step| [0.0, 0.1 * f64::from(step), 0.0]).collect();
    points.insert(100, [0.0, 1e8, 0.0]);
    points.insert(200, [0.0, 2e8, 0.0]);
    let found = running(&points, SETTINGS, 10);
    assert_eq!((found.late, found.parts.len()), (0, 3));
}

#[test]
fn memory_is_that_of_some_strips_where_points_are_not_wanted() {
    let settings = RunningSettings { keeps_points: false, ..SETTINGS };
    let mut graph = RunningGraph::new(settings).unwrap();
    let mut random = Random::new(6);
    let mut most = 0;
    for row in 0..4000 {
        let profile: Vec<Place> =
            (0..50).map(|at| [0.3 * f64::from(at), 0.1 * f64::from(row), random.unit()]).collect();
        graph.take(&profile).unwrap();
        graph.take_closed();
        assert!(graph.take_ended().is_empty());
        most = most.max(graph.waiting());
    }
    // 17 or 18 profiles a strip; a strip is closed when three points lie two ahead.
    assert!(most <= 2 * 18 * 50 + 50, "{most}");
    graph.finish();
    let ended = graph.take_ended();
    assert_eq!((ended.len(), ended[0].points, ended[0].rows.len()), (1, 200_000, 0));
}

#[test]
fn bad_input_is_refused_with_the_cure() {
    let new = |settings| RunningGraph::new(settings).map(|_| ()).unwrap_err();
    assert_eq!(new(RunningSettings { axis: 3, ..SETTINGS }), RunningError::Axis { axis: 3 });
    for tau_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(new(RunningSettings { tau_mm, ..SETTINGS }), RunningError::Graph(_)));
    }
    for strip_mm in [0.5, f64::NAN] {
        assert!(matches!(
            new(RunningSettings { strip_mm, ..SETTINGS }),
            RunningError::Strip { .. }
        ));
    }
    let mut graph = RunningGraph::new(SETTINGS).unwrap();
    graph.take(&[[0.0; 3]; 5]).unwrap();
    // Other points count on, with their rows.
    graph.take(&[[0.0, f64::NAN, 0.0], [1e12, 0.0, 0.0], [f64::INFINITY; 3]]).unwrap();
    assert_eq!((graph.received(), graph.outside()), (8, 3));
    graph.finish();
    let ended = graph.take_ended();
    assert_eq!((ended.len(), ended[0].points, ended[0].places), (1, 5, 1));
    let mut none = RunningGraph::new(SETTINGS).unwrap();
    none.finish();
    assert!(none.take_ended().is_empty() && none.take_events().is_empty());
}

proptest! {
    /// Few points with many equal distances, on lattices and apart, far from the origin too.
    #[test]
    fn any_points_have_the_graph_of_the_whole(
        cells in prop::collection::vec([0_i32..12, 0..40, 0..3], 1..200),
        step in 0.3_f64..1.2,
        far in prop::sample::select(vec![0.0, -1e3, 1e6]),
        axis in 0_usize..3,
    ) {
        let at = |cell: [i32; 3]| cell.map(|value| far + step * f64::from(value));
        let points: Vec<Place> = cells.into_iter().map(at).collect();
        check(points, RunningSettings { axis, ..SETTINGS });
    }
}
