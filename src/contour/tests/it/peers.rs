//! SciPy's Delaunay and Voronoi diagrams (Qhull) and spanning tree, against ours.
//!
//! `ASPHERA_PYTHON` names a python with SciPy; without it the test says that it is skipped.

use std::io::Write as _;
use std::process::{Command, Stdio};

use asphera_contour::curves::crust;
use asphera_contour::graphs::{delaunay, emst, gabriel};

use crate::places::{by_row, scattered, triangulation};

/// Reads points from stdin, writes a line of edges for each graph.
const SCRIPT: &str = "
import sys, numpy as np
from scipy.spatial import Delaunay, Voronoi, cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import minimum_spanning_tree
p = np.loadtxt(sys.stdin)
n = len(p)
def edges(tri):
    s = tri.simplices
    e = np.sort(np.vstack([s[:, [0, 1]], s[:, [1, 2]], s[:, [2, 0]]]), axis=1)
    return np.unique(e, axis=0)
def show(e):
    e = sorted(tuple(sorted(map(int, x))) for x in e)
    print(' '.join(f'{a} {b}' for a, b in e))
dt = edges(Delaunay(p))
show(dt)
w = np.linalg.norm(p[dt[:, 0]] - p[dt[:, 1]], axis=1)
t = minimum_spanning_tree(coo_matrix((w, (dt[:, 0], dt[:, 1])), shape=(n, n))).tocoo()
show(zip(t.row, t.col))
near = cKDTree(p).query((p[dt[:, 0]] + p[dt[:, 1]]) / 2)[0]
show(dt[near >= w / 2 * (1 - 1e-12)])
both = edges(Delaunay(np.vstack([p, Voronoi(p).vertices])))
show(both[(both < n).all(axis=1)])
";

#[test]
fn scipy_gives_the_same_graphs() {
    let Some(python) = std::env::var_os("ASPHERA_PYTHON") else {
        println!("skipped: ASPHERA_PYTHON names no python with SciPy");
        return;
    };
    for seed in 0..4 {
        let points = scattered(400, seed + 700);
        let mut peer = Command::new(&python)
            .args(["-c", SCRIPT])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let text: String = points.iter().map(|[x, y]| format!("{x} {y}\n")).collect();
        peer.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        let output = peer.wait_with_output().unwrap();
        assert!(output.status.success(), "scipy failed; is it installed?");
        let output = String::from_utf8(output.stdout).unwrap();
        let set = triangulation(&points);
        let ours = [delaunay(&set), emst(&set), gabriel(&set), crust(&set)];
        assert_eq!(output.lines().count(), ours.len());
        for (line, graph) in output.lines().zip(ours) {
            let numbers: Vec<u32> = line.split(' ').map(|word| word.parse().unwrap()).collect();
            let theirs: Vec<[u32; 2]> = numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect();
            assert_eq!(by_row(&graph, &set), theirs);
        }
    }
}
