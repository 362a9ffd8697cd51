//! Alpha complexes and their Betti numbers by GUDHI, against ours.
//!
//! `ASPHERA_PYTHON` names a python with gudhi; without it the tests say that they are skipped.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

use asphera_geometry::PointMm;
use asphera_reconstruct::{AlphaStanding, Delaunay, wrap};
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, torus, uniform};

/// Reads diameters, then points; writes for each diameter the Betti numbers, then the facets of the complex that are not between two of
/// its tetrahedra.
const SCRIPT: &str = "
import sys, gudhi
from collections import Counter
diameters = [float(x) for x in sys.stdin.readline().split()]
points = [[float(x) for x in line.split()] for line in sys.stdin]
tree = gudhi.AlphaComplex(points=points, precision='exact').create_simplex_tree()
for d in diameters:
    limit = d * d / 4
    cut = gudhi.SimplexTree(tree)
    cut.prune_above_filtration(limit)
    cut.compute_persistence(homology_coeff_field=2, persistence_dim_max=True)
    b = cut.betti_numbers() + [0, 0, 0]
    print(*b[:3])
    inside = Counter()
    facets = []
    for s, _ in cut.get_simplices():
        if len(s) == 4:
            for i in range(4):
                inside[tuple(sorted(s[:i] + s[i + 1:]))] += 1
        if len(s) == 3:
            facets.append(tuple(sorted(s)))
    print(*[f'{a},{b},{c}' for a, b, c in sorted(f for f in facets if inside[f] < 2)])
";

/// The lines of the script; `None` if no python with gudhi is named.
fn output(diameters: &[f64], points: &[PointMm]) -> Option<Vec<String>> {
    let python = std::env::var_os("ASPHERA_PYTHON")?;
    let has_it = Command::new(&python).args(["-c", "import gudhi"]).stderr(Stdio::null()).status();
    if !has_it.unwrap().success() {
        return None;
    }
    let words: Vec<String> = diameters.iter().map(f64::to_string).collect();
    let mut input = words.join(" ");
    for [x, y, z] in points {
        write!(input, "\n{x} {y} {z}").unwrap();
    }
    let mut child = Command::new(python)
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(input.as_bytes()).unwrap();
    drop(stdin);
    let found = child.wait_with_output().unwrap();
    assert!(found.status.success(), "gudhi failed");
    Some(String::from_utf8(found.stdout).unwrap().lines().map(str::to_owned).collect())
}

#[test]
fn gudhi_finds_the_same_alpha_facets_and_betti_numbers() {
    let mut random = Pcg64::seed_from_u64(51);
    let cloud = (0..1_500).map(|_| [0; 3].map(|_| 10.0 * uniform(&mut random))).collect();
    for points in [ball(1_500, 1e-3, 52), torus(60, 25).0, cloud] {
        let diameters = [0.1, 0.35, 0.5, 0.7, 1.0, 1.6, 3.0, 5.0, 9.9, 20.5];
        let Some(lines) = output(&diameters, &points) else {
            eprintln!("skipped: ASPHERA_PYTHON names no python with gudhi");
            return;
        };
        let delaunay = Delaunay::new(&points).unwrap();
        for (diameter, lines) in diameters.into_iter().zip(lines.chunks(2)) {
            let made = wrap(&points, Some(diameter)).unwrap();
            let [components, tunnels, cavities] = made.betti;
            assert_eq!(format!("{components} {tunnels} {cavities}"), lines[0], "{diameter}");
            let facets = delaunay.alpha_facets(diameter).unwrap();
            let shown: Vec<String> = (facets.iter())
                .filter(|(_, standing)| *standing != AlphaStanding::Interior)
                .map(|([a, b, c], _)| format!("{a},{b},{c}"))
                .collect();
            let mut expected: Vec<&str> = lines[1].split_whitespace().collect();
            let mut found: Vec<&str> = shown.iter().map(String::as_str).collect();
            expected.sort_unstable();
            found.sort_unstable();
            assert_eq!(found, expected, "{diameter}");
        }
    }
}
