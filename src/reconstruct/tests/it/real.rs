//! Bodies of reference data, where they are at hand.

use std::path::{Path, PathBuf};

use asphera_geometry::PointMm;
use asphera_reconstruct::{local, prove};

/// Where reference data is kept: beside the repository, or where `ASPHERA_DATA` says.
fn solids() -> PathBuf {
    std::env::var_os("ASPHERA_DATA")
        .map_or_else(
            || Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).to_owned(),
            PathBuf::from,
        )
        .join("solids")
}

/// The points of an OFF file, or of text whose first columns are x, y, z; `None` where the file is not there.
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn points(name: &str) -> Option<Vec<PointMm>> {
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
