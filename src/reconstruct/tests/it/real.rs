//! Bodies of reference data, where they are at hand.

use std::path::{Path, PathBuf};

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    FaceRule, GraphChoices, PointGraph, cocone, local, natural, prove, robust_cocone, wrap,
};

/// Where reference data is kept: beside the repository, or where `ASPHERA_DATA` says.
fn solids() -> PathBuf {
    std::env::var_os("ASPHERA_DATA")
        .map_or_else(
            || Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).to_owned(),
            PathBuf::from,
        )
        .join("solids")
}

/// The points of an OFF file, of a PLY file in text with x, y, z first, or of text whose first columns are x, y, z; `None` where the file is not there.
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
pub(crate) fn points(name: &str) -> Option<Vec<PointMm>> {
    let Ok(text) = std::fs::read_to_string(solids().join(name)) else {
        eprintln!("skipped: no {name}; ASPHERA_DATA names the folder of reference data");
        return None;
    };
    let mut lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let mut count = usize::MAX;
    if name.ends_with(".off") {
        let first = lines.next()?.trim_start_matches("OFF").trim().to_owned();
        let counts = if first.is_empty() { lines.next()?.to_owned() } else { first };
        count = counts.split_whitespace().next()?.parse().ok()?;
    }
    if name.ends_with(".ply") {
        let vertices = lines.find_map(|line| line.strip_prefix("element vertex "))?;
        count = vertices.trim().parse().ok()?;
        lines.find(|line| *line == "end_header")?;
    }
    let row = |line: &str| {
        let mut fields = line.split_whitespace().map(|field| field.parse().unwrap_or(f64::NAN));
        std::array::from_fn(|_| fields.next().unwrap_or(f64::NAN))
    };
    Some(lines.take(count).map(row).collect())
}

/// The surface is closed with as many handles, and every point is a vertex.
fn assert_closed(name: &str, genus: i64) {
    let Some(points) = points(name) else { return };
    let made = local(&points).unwrap();
    let proof = prove(&points, &made.facets).unwrap();
    assert_eq!((proof.is_closed, proof.genus), (true, Some(genus)), "{name}");
    assert_eq!(made.facets.len() as i64, 2 * points.len() as i64 - 4 + 4 * genus, "{name}");
    assert_eq!((proof.components, proof.self_intersections.count), (1, 0), "{name}");
    assert_eq!(made.left_out, [], "{name}");
}

#[test]
fn smooth_bodies_are_closed() {
    assert_closed("kitten.xyz", 1);
    assert_closed("knot1.off", 1);
    assert_closed("eight.off", 2);
}

#[test]
fn sharp_edges_are_closed() {
    assert_closed("anchor_dense.off", 4);
}

#[test]
fn what_is_sampled_too_coarsely_stays_open_but_sound() {
    for name in ["elk.off", "blade.off", "hand.xyz", "vase.xyz"] {
        let Some(points) = points(name) else { continue };
        let made = local(&points).unwrap();
        let proof = prove(&points, &made.facets).unwrap();
        assert_eq!(proof.nonmanifold_edges.count + proof.self_intersections.count, 0, "{name}");
        assert!(!proof.is_closed && !proof.border_loops.is_empty(), "{name}");
    }
}

/// Table 2 of "Graph-based 2-manifold reconstruction": faces within 7 % for 3 hops and more and thresholds up to 15; no handle at 5
/// hops and thresholds of 6 to 11. The proof finds none at 4 hops either.
#[test]
fn the_bunny_has_the_faces_of_the_papers_table() {
    let Some(points) = points("bunny.ply") else { return };
    assert_eq!(points.len(), 35_947);
    let graph = PointGraph::new(&points, 15, &mut |_| {}).unwrap();
    let of = |hops, threshold| {
        let faces = FaceRule::Any;
        let choices = GraphChoices { hops, threshold, faces, ..GraphChoices::default() };
        graph.surface(&choices, &mut |_| {}).unwrap()
    };
    let by_hops = [(3, 3199.0), (4, 1620.0), (5, 976.0), (7, 457.0), (14, 94.0), (15, 80.0)];
    let by_threshold = [(2, 1024.0), (3, 1023.0), (6, 998.0), (11, 898.0), (15, 778.0)];
    let rows = (by_hops.map(|(hops, faces)| (hops, 7, faces)).into_iter())
        .chain(by_threshold.map(|(threshold, faces)| (5, threshold, faces)));
    for (hops, threshold, faces) in rows {
        let found = of(hops, threshold).map.faces.len() as f64;
        assert!((found / faces - 1.0).abs() < 0.07, "{hops} {threshold}: {found} of {faces}");
    }
    for threshold in [6, 7, 11] {
        assert_eq!(of(5, threshold).map.genus(), 0.0, "{threshold}");
    }
    for hops in [4, 5] {
        let proof = prove(&points, &of(hops, 7).reconstruction.facets).unwrap();
        assert_eq!((proof.is_closed, proof.genus), (true, Some(0)), "{hops}");
        assert_eq!(proof.self_intersections.count, 0, "{hops}");
    }
}

#[test]
fn a_kitten_has_its_handle_by_the_graph() {
    let Some(points) = points("kitten.xyz") else { return };
    let graph = PointGraph::new(&points, 15, &mut |_| {}).unwrap();
    for hops in [4, 5] {
        let choices = GraphChoices { hops, faces: FaceRule::Any, ..GraphChoices::default() };
        let made = graph.surface(&choices, &mut |_| {}).unwrap();
        assert_eq!((made.map.genus(), made.map.components), (1.0, 1), "{hops}");
    }
}

/// The number of candidates that a prototype found over Qhull's triangulation, for cocones of 22.5°.
#[test]
fn the_bunny_has_its_cocone_candidates_and_smooth_bodies_are_closed() {
    if let Some(points) = points("bunny.ply") {
        let made = cocone(&points).unwrap();
        assert!((made.candidates as f64 / 83_572.0 - 1.0).abs() < 0.01, "{}", made.candidates);
        // The base has holes, so the condition cannot be met; what is found is a sheet all the same.
        let proof = prove(&points, &made.surface.facets).unwrap();
        assert!(!made.sampling.is_met() && !proof.is_closed);
        assert_eq!((proof.nonmanifold_edges.count, proof.self_intersections.count), (0, 0));
        assert!(proof.facets > 71_500 && made.surface.left_out.len() < 5);
    }
    for (name, genus) in [("kitten.xyz", 1), ("knot1.off", 1), ("eight.off", 2)] {
        let Some(points) = points(name) else { continue };
        let made = cocone(&points).unwrap();
        let proof = prove(&points, &made.surface.facets).unwrap();
        assert_eq!((proof.is_closed, proof.genus), (true, Some(genus)), "{name}");
        assert_eq!(proof.self_intersections.count, 0, "{name}");
    }
}

/// Borders of the bunny: 33 by Cocone. By sides only the holes of its base stay open.
#[test]
fn methods_with_an_inside_close_what_cocone_leaves_open() {
    for (name, genus) in [("kitten.xyz", 1), ("knot1.off", 1), ("eight.off", 2)] {
        let Some(points) = points(name) else { continue };
        let made = [natural(&points).unwrap().surface, wrap(&points, None).unwrap().surface];
        for made in made {
            let proof = prove(&points, &made.facets).unwrap();
            assert_eq!((proof.is_closed, proof.genus), (true, Some(genus)), "{name}");
            assert_eq!((proof.self_intersections.count, made.left_out.len()), (0, 0), "{name}");
        }
    }
    let Some(points) = points("bunny.ply") else { return };
    let made = robust_cocone(&points).unwrap();
    let proof = prove(&points, &made.surface.facets).unwrap();
    assert_eq!((proof.border_loops.len(), proof.genus, proof.is_manifold), (2, Some(0), true));
    assert!(made.noise < 300 && made.lids < 40 && !made.sampling.is_met());
    assert_eq!(proof.self_intersections.count, 0);
}
