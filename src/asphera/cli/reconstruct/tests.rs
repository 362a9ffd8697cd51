//! The command on a file, and what it writes.

use asphera_geometry::PointMm;
use clap::Parser as _;

use super::{made, written};
use crate::cli::{Cli, Command};

/// Points of an octahedron whose sides are cut into `n` pieces, on a ball.
fn ball(n: i32) -> Vec<PointMm> {
    let mut points = Vec::new();
    for (x, y) in (-n..=n).flat_map(|x| (-n..=n).map(move |y| (x, y))) {
        let z = n - x.abs() - y.abs();
        if z < 0 {
            continue;
        }
        for z in if z == 0 { vec![0] } else { vec![-z, z] } {
            let place = [x, y, z].map(f64::from);
            let length = place.iter().map(|value| value * value).sum::<f64>().sqrt();
            points.push(place.map(|value| 5.0 * value / length));
        }
    }
    points
}

#[test]
fn a_ball_in_a_file_is_closed_and_written_in_four_formats() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.xyz");
    let text: String = ball(20).iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    std::fs::write(&file, text).unwrap();
    let cli = Cli::try_parse_from(["asphera", "reconstruct", file.to_str().unwrap()]).unwrap();
    let Command::Reconstruct(args) = cli.command else { panic!("another command") };
    let (report, points, facets) = made(&args).unwrap();
    let figures = &serde_json::to_value(&report).unwrap()["mesh"]["reconstruction"];
    assert_eq!(facets.len(), 2 * points.len() - 4);
    assert_eq!(figures["genus"], 0);
    assert_eq!(figures["closed"], true);
    assert_eq!(figures["betti"], serde_json::json!([1, 0, 1]));
    assert!(report.summary().contains("closed, two-sided, components 1, genus 0"));
    for name in ["a.ply", "a.stl", "a.obj", "a.off"] {
        written::write(&folder.path().join(name), &points, &facets).unwrap();
    }
    let off = std::fs::read_to_string(folder.path().join("a.off")).unwrap();
    assert_eq!(off.lines().count(), 2 + points.len() + facets.len());
    let obj = std::fs::read_to_string(folder.path().join("a.obj")).unwrap();
    assert!(obj.lines().last().unwrap().starts_with("f "));
    assert!(written::kind_of(&folder.path().join("a.step")).is_err());
}

#[test]
fn the_graph_method_gives_a_coarse_closed_ball_with_its_stages_and_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.xyz");
    let text: String = ball(60).iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    std::fs::write(&file, text).unwrap();
    let file = file.to_str().unwrap();
    let parsed = |more: &[&str]| {
        let words = ["asphera", "reconstruct", file, "--method", "graph"];
        let cli = Cli::try_parse_from(words.iter().chain(more)).unwrap();
        let Command::Reconstruct(args) = cli.command else { panic!("another command") };
        args
    };
    let (report, points, facets) = made(&parsed(&["--hops", "4"])).unwrap();
    let figures = &serde_json::to_value(&report).unwrap()["mesh"]["reconstruction"];
    assert_eq!((&figures["method"], &figures["closed"]), (&"graph".into(), &true.into()));
    assert_eq!(figures["genus"], 0);
    let pruned = figures["left_out"]["a landmark stands for it"].as_u64().unwrap();
    // A closed surface of genus 0 has twice as many facets as vertices, less four.
    assert_eq!(facets.len() as u64, 2 * (points.len() as u64 - pruned) - 4);
    assert!(figures["stages_s"]["neighbours"].as_f64().unwrap() > 0.0);
    assert!(report.summary().contains("\nstages "));

    // The same topology through all points.
    let (report, points, facets) = made(&parsed(&["--hops", "4", "--put-back"])).unwrap();
    let figures = &serde_json::to_value(&report).unwrap()["mesh"]["reconstruction"];
    assert_eq!(facets.len(), 2 * points.len() - 4);
    assert_eq!(figures["facets"].as_u64().unwrap() as usize, facets.len());
    assert_eq!((&figures["genus"], &figures["closed"]), (&0.into(), &true.into()));
    assert_eq!(figures["left_out"], serde_json::json!({}));
    assert!(figures["stages_s"]["put_back"].as_f64().unwrap() > 0.0);
    assert!(report.summary().contains(", put back "), "{}", report.summary());

    // Another order of the landmarks is another coarse surface.
    let coarse = |order: &str| made(&parsed(&["--hops", "4", "--order", order])).unwrap().2;
    assert_ne!(coarse("sweep"), coarse("priority"));

    let table = parsed(&["--sweep"]).graph.table(&points).unwrap();
    assert_eq!(table.rows.len(), 14);
    // More hops give no more faces.
    let fewer = table.rows[..7].windows(2).all(|pair| pair[0].faces >= pair[1].faces);
    assert!(fewer, "{}", table.summary());
    assert_eq!(table.rows[3].genus, 0.0);

    // What belongs to the graph method is not left out in silence.
    for more in [&["--hops", "4"][..], &["--order", "priority"], &["--put-back"]] {
        let cli = Cli::try_parse_from(["asphera", "reconstruct", file].iter().chain(more)).unwrap();
        let Command::Reconstruct(args) = cli.command else { panic!() };
        assert!(super::run(&args).unwrap_err().to_string().contains("belong to --method graph"));
    }

    // Points along a line have no surface, and the words say so.
    let line: String = (0..200).map(|x| format!("{} 0 0\n", 0.7 * f64::from(x))).collect();
    std::fs::write(folder.path().join("ball.xyz"), line).unwrap();
    let Err(refused) = made(&parsed(&["--hops", "2"])) else { panic!("a surface of a line") };
    assert!(refused.to_string().contains("the points lie along a line"), "{refused}");
}

#[test]
fn methods_over_the_delaunay_triangulation_say_whether_their_condition_is_met() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.xyz");
    let text: String = ball(40).iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    std::fs::write(&file, text).unwrap();
    let file = file.to_str().unwrap();
    let args = |more: &[&str]| {
        let cli = Cli::try_parse_from(["asphera", "reconstruct", file].iter().chain(more)).unwrap();
        let Command::Reconstruct(args) = cli.command else { panic!("another command") };
        args
    };
    for (words, method) in [
        (&["--method", "cocone"][..], "cocone"),
        (&["--method", "convection"][..], "convection"),
        (&["--method", "sculpture"][..], "sculpture"),
        (&["--method", "alpha", "--alpha", "9"][..], "alpha"),
        (&["--method", "natural"][..], "natural"),
        (&["--method", "wrap"][..], "wrap"),
        (&["--method", "wrap", "--alpha", "9"][..], "wrap"),
        (&["--method", "tangential"][..], "tangential"),
        (&["--method", "loccocone"][..], "loccocone"),
        (&["--method", "super-cocone"][..], "super-cocone"),
        (&["--method", "robust-cocone"][..], "robust-cocone"),
    ] {
        let (report, points, facets) = made(&args(words)).unwrap();
        let figures = &serde_json::to_value(&report).unwrap()["mesh"]["reconstruction"];
        assert_eq!((&figures["method"], &figures["closed"]), (&method.into(), &true.into()));
        assert_eq!(
            (facets.len(), &figures["genus"]),
            (2 * points.len() - 4, &0.into()),
            "{method}"
        );
        let guarantee = figures["guarantee"].as_str().unwrap();
        let bound = match method {
            "natural" => Some(0.25),
            "tangential" => Some(0.09),
            "cocone" | "loccocone" | "super-cocone" | "robust-cocone" => Some(0.05),
            "wrap" if words.len() == 2 => Some(0.01),
            _ => None,
        };
        assert_eq!(figures["epsilon_bound"].as_f64(), bound, "{method}");
        // The points are some 0.03 of the radius apart: dense enough for all bounds but that of wrap.
        let first = match method {
            "robust-cocone" | "super-cocone" => "unknown",
            _ if bound.is_some_and(|bound| bound > 0.01) => "holds",
            _ => "none",
        };
        assert!(guarantee.starts_with(first), "{method}: {guarantee}");
    }
    let (report, _, _) = made(&args(&["--method", "cocone"])).unwrap();
    assert!(report.summary().contains("\nsampling "), "{}", report.summary());
    for words in [&["--alpha", "3"][..], &["--method", "alpha"]] {
        let refused = super::run(&args(words)).unwrap_err().to_string();
        assert!(refused.contains("belong together"), "{refused}");
    }
    let flat: String = (0..100).map(|at| format!("{} {} 1\n", at % 10, at / 10)).collect();
    std::fs::write(folder.path().join("ball.xyz"), flat).unwrap();
    let Err(refused) = made(&args(&["--method", "cocone"])) else { panic!("a body of a plane") };
    assert!(refused.to_string().contains("exactly in a plane"), "{refused}");
}

/// A bowl seen from above: its facets face the probe by every method, and a ball stays turned outwards.
#[test]
fn open_parts_face_the_probe() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bowl.xyz");
    let all = ball(24);
    let volume_of = |points: &[PointMm], toward: &str, method: &str| {
        let text: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
        std::fs::write(&file, text).unwrap();
        let path = file.to_str().unwrap();
        let words = ["asphera", "reconstruct", path, "--method", method, "--toward", toward];
        let Command::Reconstruct(args) = Cli::try_parse_from(words).unwrap().command else {
            panic!()
        };
        let (_, points, facets) = made(&args).unwrap();
        // About the middle: above 0 where facets are turned outwards.
        let volume = |facet: &[u32; 3]| {
            let [a, b, c] = facet.map(|corner| points[corner as usize]);
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        };
        facets.iter().map(volume).sum::<f64>()
    };
    let bowl: Vec<PointMm> = all.iter().copied().filter(|[_, _, z]| *z < -1.0).collect();
    for method in ["local", "cocone", "tangential"] {
        assert!(volume_of(&bowl, "0,0,-1", method) > 0.0, "{method}");
        assert!(volume_of(&bowl, "0,0,1", method) < 0.0, "{method}");
        assert!(volume_of(&all, "0,0,1", "local") > 0.0);
    }
    for word in ["0,0,0", "1,2", "1,2,x", "0,0,1,1", "nan,0,0"] {
        let words = ["asphera", "reconstruct", "bowl.xyz", "--toward", word];
        let refused = Cli::try_parse_from(words).err().expect("no way").to_string();
        assert!(refused.contains("like 0,0,1"), "{refused}");
    }
}

#[test]
fn all_methods_are_compared_with_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.xyz");
    let points = ball(20);
    let text: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    std::fs::write(&file, text).unwrap();
    let truth = folder.path().join("truth.off");
    // The same points, joined: a surface whose places are off the ball by a known sagitta.
    let facets = asphera_reconstruct::local(&points).unwrap().facets;
    written::write(&truth, &points, &facets).unwrap();
    let [file, truth] = [&file, &truth].map(|path| path.to_str().unwrap());
    let words = ["asphera", "reconstruct", file, "--compare", "--truth", truth, "--alpha", "9"];
    let Command::Reconstruct(args) = Cli::try_parse_from(words).unwrap().command else { panic!() };
    let table = super::compared(&args).unwrap();
    let json = serde_json::to_value(&table).unwrap();
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 12);
    for row in rows.iter().filter(|row| row["method"] != "graph") {
        assert_eq!((&row["closed"], &row["genus"]), (&true.into(), &0.into()), "{row}");
        assert_eq!((&row["defects"], &row["points_left_out"]), (&0.into(), &0.into()), "{row}");
        assert!(row["points_off_mm"].as_f64().unwrap() < 1e-12);
        // Facets may differ by a diagonal, whose middle lies no deeper than the sagitta of a side of 0.6 mm.
        for way in ["to_truth_mm", "from_truth_mm"] {
            let largest = row[way][1].as_f64().unwrap();
            assert!(largest < 0.6 * 0.6 / 8.0 / 5.0, "{row}");
        }
    }
    let text = table.summary();
    assert_eq!(text.lines().count(), 13, "{text}");
    assert!(text.contains("from mm") && text.contains("\nloccocone "), "{text}");
    // Points alone are no truth, and the words say so.
    let words = ["asphera", "reconstruct", file, "--compare", "--truth", file];
    let Command::Reconstruct(args) = Cli::try_parse_from(words).unwrap().command else { panic!() };
    let refused = super::compared(&args).unwrap_err().to_string();
    assert!(refused.contains("expected a mesh with triangles"), "{refused}");
}

#[test]
fn tiles_give_the_surface_of_memory_and_their_number() {
    let folder = tempfile::tempdir().unwrap();
    let (text, binary) = (folder.path().join("ball.xyz"), folder.path().join("ball.ply"));
    let points = ball(60);
    let lines: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    std::fs::write(&text, lines).unwrap();
    written::write(&binary, &points, &[]).unwrap();
    let args = |file: &std::path::Path, more: &[&str]| {
        let words = ["asphera", "reconstruct", file.to_str().unwrap(), "--method", "graph"];
        let cli = Cli::try_parse_from(words.iter().chain(more)).unwrap();
        let Command::Reconstruct(args) = cli.command else { panic!("another command") };
        args
    };
    let (report, _, facets) = made(&args(&text, &[])).unwrap();
    let expected = serde_json::to_value(&report).unwrap()["mesh"].clone();
    for file in [&text, &binary] {
        let (report, landmarks, found) = made(&args(file, &["--tiles", "1"])).unwrap();
        let mesh = serde_json::to_value(&report).unwrap()["mesh"].clone();
        assert_eq!(
            (&mesh["points"], &mesh["vertices"]),
            (&expected["points"], &expected["vertices"])
        );
        let figures = &mesh["reconstruction"];
        for name in ["facets", "left_out", "genus", "closed", "betti", "area_mm2", "as_of_points"] {
            assert_eq!(figures[name], expected["reconstruction"][name], "{name}");
        }
        assert_eq!(figures["tiles"], points.len().div_ceil(1024));
        assert!(report.summary().contains("\ntiles      15\n"), "{}", report.summary());
        let places = |facets: &[[u32; 3]], points: &[PointMm]| -> Vec<[PointMm; 3]> {
            facets.iter().map(|facet| facet.map(|corner| points[corner as usize])).collect()
        };
        assert_eq!(places(&found, &landmarks), places(&facets, &points));
    }
    // Half a file says where it ends.
    let bytes = std::fs::read(&binary).unwrap();
    std::fs::write(&binary, &bytes[..bytes.len() - 5]).unwrap();
    let Err(refused) = made(&args(&binary, &["--tiles", "1"])) else { panic!("half a file") };
    assert!(refused.to_string().contains("ball.ply: PLY file, byte"), "{refused}");
    let Err(refused) = made(&args(&text, &["--tiles", "1", "--order", "priority"])) else {
        panic!("tiles by priority")
    };
    assert!(refused.to_string().contains("leave the order of priority out"), "{refused}");
}

#[test]
fn batches_give_the_surface_of_all_points_by_priority_and_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.ply");
    written::write(&file, &ball(40), &[]).unwrap();
    let made = |more: &[&str]| {
        let words = ["asphera", "reconstruct", file.to_str().unwrap(), "--method", "graph"];
        let cli = Cli::try_parse_from(words.iter().chain(more)).unwrap();
        let Command::Reconstruct(args) = cli.command else { panic!("another command") };
        made(&args)
    };
    let (_, _, expected) = made(&["--order", "priority"]).unwrap();
    let (report, points, facets) = made(&["--order", "priority", "--batch", "500"]).unwrap();
    assert_eq!(facets, expected);
    let stages = &serde_json::to_value(&report).unwrap()["mesh"]["reconstruction"]["stages_s"];
    assert_eq!(stages["batches"]["count"], points.len().div_ceil(500));
    let seconds = |name: &str| stages["batches"][name].as_f64().unwrap();
    assert!(0.0 < seconds("median") && seconds("median") <= seconds("p99"));
    assert!(seconds("p99") <= seconds("longest") && seconds("longest") < seconds("total"));
    assert!(report.summary().contains(" batches "), "{}", report.summary());
    let Err(refused) = made(&["--batch", "500"]) else { panic!("batches along the sweep") };
    assert!(refused.to_string().contains("--batch needs --order priority"), "{refused}");
}

#[test]
fn points_without_a_facet_are_no_surface() {
    let folder = tempfile::tempdir().unwrap();
    let made_of = |text: &str, words: &[&str]| {
        let file = folder.path().join("few.xyz");
        std::fs::write(&file, text).unwrap();
        let words = [&["asphera", "reconstruct", file.to_str().unwrap()], words].concat();
        let cli = Cli::try_parse_from(words).unwrap();
        let Command::Reconstruct(args) = cli.command else { panic!("another command") };
        made(&args).map(|_| ()).unwrap_err().to_string()
    };
    let said = made_of("1 2 3\n", &[]);
    assert!(said.contains("few.xyz: expected points that span an area, found 1"), "{said}");
    let text: String = ball(6).iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let said = made_of(&text, &["--method", "alpha", "--alpha", "0.000001"]);
    assert!(said.contains("give a larger --alpha"), "{said}");
}
