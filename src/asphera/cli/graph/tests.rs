//! The command from its arguments to its files.

use clap::Parser as _;
use serde_json::Value;

use super::run;
use crate::cli::{Cli, Command};

/// Two rings side by side and a stray point, as text.
fn rings() -> String {
    let mut text = String::new();
    for step in 0..2000 {
        let angle = f64::from(step) * std::f64::consts::TAU / 1000.0;
        let x = angle.cos() + if step < 1000 { 0.0 } else { 5.0 };
        text += &format!("{x} {} 0\n", angle.sin());
    }
    text + "2.5 9 0\n"
}

/// Runs a command on the rings and gives the folder of its files.
fn done(words: &[&str]) -> Result<tempfile::TempDir, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rings.xyz");
    std::fs::write(&file, rings()).unwrap();
    let out = folder.path().join("out");
    let mut all = vec!["asphera", words[0], file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    all.extend(&words[1..]);
    let cli = Cli::try_parse_from(all).map_err(|error| error.to_string())?;
    let exit = match cli.command {
        Command::Graph(args) => run(&args),
        Command::Parts(args) => crate::cli::parts::run(&args),
        _ => panic!("another command"),
    };
    exit.map_err(|error| error.to_string())?;
    Ok(folder)
}

fn json(folder: &tempfile::TempDir, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.path().join("out").join(name)).unwrap()).unwrap()
}

#[test]
fn two_rings_have_a_loop_each_and_a_stray_point_is_an_island() {
    let folder = done(&["graph", "--function", "height:x", "--json"]).unwrap();
    let found = json(&folder, "graph.json");
    assert_eq!(found["format"], "asphera.graph/1");
    assert_eq!((&found["loops"], &found["components"]), (&2.into(), &3.into()));
    assert_eq!(
        (found["parts"][0]["loops"].as_u64(), found["islands"].as_u64()),
        (Some(1), Some(1))
    );
    assert_eq!(found["loops_stable"], true);
    assert_eq!(found["most_loops"], serde_json::json!({ "loops": 2, "stable": true }));
    assert_eq!(
        found["node_list"].as_array().unwrap().len() as u64,
        found["nodes"].as_u64().unwrap()
    );
    for name in ["graph.ply", "points.ply"] {
        let bytes = std::fs::read(folder.path().join("out").join(name)).unwrap();
        let count = asphera_formats::read(name, &bytes).unwrap().points().count() as u64;
        let expected = if name == "graph.ply" { found["nodes"].as_u64().unwrap() } else { 2001 };
        assert_eq!(count, expected);
    }
}

#[test]
fn loops_that_lie_in_one_height_are_told_of_another() {
    let folder = done(&["graph", "--function", "height:z", "--json"]).unwrap();
    let found = json(&folder, "graph.json");
    let most = &found["most_loops"];
    assert_eq!((&found["loops"], &most["loops"]), (&0.into(), &2.into()));
    assert_eq!(most["stable"], true);
    assert!(most["along"][2].as_f64().unwrap().abs() < 0.2, "{most}");
}

#[test]
fn parts_have_their_place_and_their_holes() {
    let folder = done(&["parts"]).unwrap();
    let found = json(&folder, "parts.json");
    let parts = found["parts"].as_array().unwrap();
    assert_eq!((parts.len(), found["islands"].as_u64()), (2, Some(1)));
    for (part, x) in parts.iter().zip([0.0, 5.0]) {
        assert!((part["centre_mm"][0].as_f64().unwrap() - x).abs() < 1e-9);
        assert_eq!((&part["points"], &part["loops"]), (&1000.into(), &1.into()));
    }
    assert!(folder.path().join("out/part-2.ply").is_file());
}

/// A ring measured turn by turn outwards: by arrival each turn is a piece of its own, in a row without a loop. By height it has a loop.
#[test]
fn the_order_of_arrival_is_a_function() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turns.xyz");
    let mut text = String::new();
    for (ring, turn) in (0..12).flat_map(|ring| (0..200).map(move |turn| (ring, turn))) {
        let radius = 10.0 + 0.3 * f64::from(ring);
        let (sin, cos) = (f64::from(turn) / 200.0 * std::f64::consts::TAU).sin_cos();
        text += &format!("{} {} 0\n", radius * cos, radius * sin);
    }
    std::fs::write(&file, text).unwrap();
    let done = |more: &[&str]| {
        let out = folder.path().join("out");
        let (file, out) = (file.to_str().unwrap(), out.to_str().unwrap());
        let words = [&["asphera", "graph", file, "--out", out, "--force"], more].concat();
        let Command::Graph(args) = Cli::try_parse_from(words).unwrap().command else { panic!() };
        run(&args).map(|_| json(&folder, "graph.json")).map_err(|error| error.to_string())
    };
    let arrival = done(&["--function", "arrival", "--strips", "12"]).unwrap();
    assert_eq!(arrival["function"]["kind"], "arrival");
    assert_eq!(arrival["function"]["range"], serde_json::json!([0.0, 2399.0]));
    assert_eq!((&arrival["nodes"], &arrival["loops"]), (&12.into(), &0.into()));
    assert_eq!(done(&["--function", "height:x"]).unwrap()["loops"], 1);
    let refused = done(&["--function", "arrival", "--sample", "100"]).unwrap_err();
    assert!(refused.contains("--sample"), "{refused}");
}

/// The angle about the axis of a ring as a column: cut along it the ring is open at one end and has no loop.
#[test]
fn a_column_of_the_file_is_a_function() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ring.csv");
    let mut text = "x,y,z,turn,note\n".to_owned();
    for step in 0..1000 {
        let angle = f64::from(step) * std::f64::consts::TAU / 1000.0;
        text += &format!("{},{},0,{angle},a\n", angle.cos(), angle.sin());
    }
    std::fs::write(&file, text).unwrap();
    let done = |function: &str| {
        let out = folder.path().join("out");
        let (file, out) = (file.to_str().unwrap(), out.to_str().unwrap());
        let words = ["asphera", "graph", file, "--out", out, "--force", "--function", function];
        let Command::Graph(args) = Cli::try_parse_from(words).unwrap().command else { panic!() };
        run(&args).map(|_| json(&folder, "graph.json")).map_err(|error| error.to_string())
    };
    let (places, column) = (done("height:x").unwrap(), done("column:1").unwrap());
    assert_eq!([&places["loops"], &column["loops"]], [1, 1]);
    let turn = done("column:4").unwrap();
    assert_eq!((&turn["function"]["kind"], &turn["loops"]), (&"column:4".into(), &0.into()));
    let high = turn["function"]["range"][1].as_f64().unwrap();
    assert!((high - 0.999 * std::f64::consts::TAU).abs() < 1e-12, "{high}");
    assert!(done("column:5").unwrap_err().contains("line 2, column 5: expected a number"));
    assert!(done("column:6").unwrap_err().contains("expected column 6, counted from 1"));
}

#[test]
fn what_is_no_function_strip_or_tau_is_told() {
    for (words, expected) in [
        (["graph", "--function", "height:q"], "expected height:x"),
        (["graph", "--strips", "0"], "expected auto, a number"),
        (["graph", "--tau", "-1"], "expected auto or a length"),
        (["graph", "--strips", "2000000"], "expected 1 to 1000000"),
        (["graph", "--function", "height:0,0,0"], "not 0"),
        (["graph", "--function", "geodesic:0"], "0 sources"),
        (["graph", "--function", "laplacian:0"], "0 eigenfunctions"),
        (["graph", "--function", "heat:0"], "above 0"),
        (["graph", "--function", "column:0"], "heat:T, arrival or column:N"),
    ] {
        let [verb, flag, value] = words;
        let message = done(&[verb, &format!("{flag}={value}")]).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

/// Graphs of halved strips: each node lies in one of the coarser graph, and the finest is the graph asked for.
#[test]
fn halved_strips_give_graphs_that_map_onto_each_other() {
    let words = ["graph", "--function", "height:x", "--strips", "24", "--halvings", "2", "--json"];
    let found = json(&done(&words).unwrap(), "graph.json");
    let all = found["resolutions"].as_array().unwrap();
    let strips: Vec<u64> = all.iter().map(|one| one["strips"].as_u64().unwrap()).collect();
    assert_eq!(strips, [6, 12, 24]);
    assert_eq!(all[2]["node_list"], found["node_list"]);
    assert_eq!(all[2]["arc_list"], found["arc_list"]);
    assert_eq!(found["halved"][1]["nodes"], all[1]["nodes"]);
    for pair in all.windows(2) {
        let [coarse, fine] = [&pair[0], &pair[1]].map(|one| one["node_list"].as_array().unwrap());
        let holders = pair[1]["coarser"].as_array().unwrap();
        assert_eq!(holders.len(), fine.len());
        let mut places = vec![0; coarse.len()];
        for (node, holder) in fine.iter().zip(holders) {
            let holder = holder.as_u64().unwrap() as usize;
            assert_eq!(
                node["strip"].as_u64().unwrap() / 2,
                coarse[holder]["strip"].as_u64().unwrap()
            );
            places[holder] += node["places"].as_u64().unwrap();
        }
        let expected: Vec<u64> =
            coarse.iter().map(|node| node["places"].as_u64().unwrap()).collect();
        assert_eq!(places, expected);
    }
    // Automatic strips can be halved, too.
    let found = json(&done(&["graph", "--halvings", "3"]).unwrap(), "graph.json");
    assert_eq!(found["resolutions"].as_array().unwrap().len(), 4);
}

#[test]
fn strips_that_cannot_be_halved_are_told_with_the_cure() {
    let failed =
        |words: &[&str]| done(&[&["graph", "--halvings", "3"], words].concat()).unwrap_err();
    assert!(failed(&["--strips", "30"]).contains("expected a multiple of 8; take --strips 32"));
    assert!(failed(&["--strips", "equal:16"]).contains("expected --strips auto or a number"));
    assert!(failed(&["--components", "grown"]).contains("expected --components exact"));
}
