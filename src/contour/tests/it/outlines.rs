//! Outlines of real shapes (MPEG-7 CE Shape-1), every third place of them: how many edges each method finds.

use std::path::PathBuf;

use asphera_contour::{Graph, Kind, Method, Parameters, PlaceMm, agreement};

use crate::places::{thins, triangulation};

/// The outlines as places in order, by name; none where the data are not there.
fn outlines() -> Vec<Vec<PlaceMm>> {
    let data = std::env::var_os("ASPHERA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let Ok(folder) = std::fs::read_dir(data.join("contours/mpeg7")) else { return Vec::new() };
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let places = text.lines().map(|line| {
            let mut words = line.split_whitespace().map(|word| word.parse().unwrap());
            [words.next().unwrap(), words.next().unwrap()]
        });
        places.step_by(3).collect()
    };
    files.into_iter().map(read).collect()
}

#[test]
fn most_edges_of_real_outlines_are_found() {
    let outlines = outlines();
    if outlines.is_empty() {
        println!("skipped: no outlines in ASPHERA_DATA");
        return;
    }
    let sets: Vec<_> = outlines.iter().map(|places| triangulation(places)).collect();
    // lee thins, so edges are no measure of it.
    let of_curves = |method: &Method| method.kind() == Kind::Curve && !thins(method);
    for method in Method::ALL.into_iter().filter(of_curves) {
        let (mut precision, mut recall) = (0.0, 0.0);
        for (set, places) in sets.iter().zip(&outlines) {
            let samples = set.samples();
            let count = places.len();
            let truth = Graph::new(
                (0..count).map(|row| [samples.of_row(row), samples.of_row((row + 1) % count)]),
            );
            let found = agreement(&method.run(set, &Parameters::new()).unwrap(), &truth);
            precision += found.precision / sets.len() as f64;
            recall += found.recall / sets.len() as f64;
        }
        println!("{:<20} precision {precision:.4} recall {recall:.4}", method.name());
        // Crust and its kin join corners wrongly here and there: pixels turn by 90°.
        assert!(precision > 0.9 && recall > 0.85, "{} {precision} {recall}", method.name());
    }
}
