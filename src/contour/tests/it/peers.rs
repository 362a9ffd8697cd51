//! SciPy's Delaunay and Voronoi diagrams (Qhull) and spanning tree, and unions of triangles by shapely (GEOS), against ours.
//!
//! `ASPHERA_PYTHON` names a python with SciPy and shapely; without it the tests say that they are skipped.

use std::io::Write as _;
use std::process::{Command, Stdio};

use asphera_contour::benchmark::{Distribution, Shape};
use asphera_contour::curves::{cocone, crust};
use asphera_contour::graphs::{delaunay, emst, gabriel};
use asphera_contour::regions::alpha_shape;
use asphera_contour::{Method, PlaceMm};

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
v = Voronoi(p)
middle = p.mean(axis=0)
rays, sides = [[] for _ in p], []
for (a, b), (s, e) in zip(v.ridge_points, v.ridge_vertices):
    if min(s, e) < 0:
        way = np.array([p[b][1] - p[a][1], p[a][0] - p[b][0]])
        way *= np.sign(way @ (p[a] + p[b] - 2 * middle)) / np.linalg.norm(way)
        rays[a].append(way); rays[b].append(way)
        sides.append((a, b, v.vertices[max(s, e)], way, True))
    else:
        sides.append((a, b, v.vertices[s], v.vertices[e], False))
def pole(i):
    if rays[i]:
        return sum(rays[i])
    ways = v.vertices[v.regions[v.point_region[i]]] - p[i]
    return ways[np.argmax((ways ** 2).sum(axis=1))]
poles = [pole(i) for i in range(n)]
def meets(i, first, last, is_ray):
    ways = [first - p[i], last if is_ray else last - p[i]]
    cos = [w @ poles[i] / np.linalg.norm(w) / np.linalg.norm(poles[i]) for w in ways]
    off = [abs(c) > np.cos(3 * np.pi / 8) for c in cos]
    return not (all(off) and cos[0] * cos[1] > 0)
best = {}
for a, b, *side in sides:
    if meets(a, *side) and meets(b, *side):
        for i, j in ((a, b), (b, a)):
            way = p[j] - p[i]
            key = (i, poles[i][0] * way[1] > poles[i][1] * way[0])
            best[key] = min(best.get(key, (9e9, -1)), (way @ way, j))
kept = {(i, j) for (i, _), (_, j) in best.items()}
show((i, j) for i, j in kept if i < j and (j, i) in kept)
";

/// Reads α, then points from stdin; writes area, perimeter, parts and holes of the union of all triangles of circles up to α.
const UNION: &str = "
import sys, numpy as np, shapely
from scipy.spatial import Delaunay
alpha = float(sys.stdin.readline())
p = np.loadtxt(sys.stdin)
t = p[Delaunay(p).simplices]
a, b, c = (np.linalg.norm(t[:, i] - t[:, (i + 1) % 3], axis=1) for i in range(3))
u, v = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
area = abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
union = shapely.union_all([shapely.Polygon(x) for x in t[a * b * c <= 4 * area * alpha]])
parts = [x for x in getattr(union, 'geoms', [union]) if not x.is_empty]
print(union.area, union.length, len(parts), sum(len(x.interiors) for x in parts))
";

/// Reads true lines, a blank line, points; writes the intersection over union of the best of ten concave hulls of GEOS.
const CONCAVE: &str = "
import sys, numpy as np, shapely
head, points = sys.stdin.read().split('\\n\\n')
truth = shapely.Polygon()
for line in head.strip().split('\\n'):
    numbers = np.array(line.split(), float).reshape(-1, 2)
    truth = truth.symmetric_difference(shapely.Polygon(numbers))
points = shapely.MultiPoint(np.array(points.split(), float).reshape(-1, 2))
holes = any(len(part.interiors) for part in getattr(truth, 'geoms', [truth]))
best = 0
for ratio in np.geomspace(0.005, 0.5, 10):
    hull = shapely.concave_hull(points, ratio=ratio, allow_holes=holes)
    best = max(best, hull.intersection(truth).area / hull.union(truth).area)
print(best)
";

const SKIPPED: &str = "skipped: ASPHERA_PYTHON names no python with SciPy and shapely";

/// The output of a script; none if no python is named.
fn output(script: &str, input: &str) -> Option<String> {
    let python = std::env::var_os("ASPHERA_PYTHON")?;
    let mut peer = Command::new(&python)
        .args(["-c", script])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A script that ends at once does not read it all.
    let written = peer.stdin.take().unwrap().write_all(input.as_bytes());
    let output = peer.wait_with_output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    if words.contains("ModuleNotFoundError") {
        return None;
    }
    assert!(written.is_ok() && output.status.success(), "{words}");
    Some(String::from_utf8(output.stdout).unwrap())
}

fn listed(points: &[PlaceMm]) -> String {
    points.iter().map(|[x, y]| format!("{x} {y}\n")).collect()
}

#[test]
fn shapely_gives_the_same_alpha_shapes() {
    for seed in 0..3 {
        let points = scattered(1500, seed + 720);
        let set = triangulation(&points);
        for alpha in [0.15, 0.2, 0.3, 0.6] {
            let Some(text) = output(UNION, &format!("{alpha}\n{}", listed(&points))) else {
                println!("{SKIPPED}");
                return;
            };
            let theirs: Vec<f64> =
                text.split_whitespace().map(|word| word.parse().unwrap()).collect();
            let found = alpha_shape(&set, alpha);
            let parts = found.parts();
            let holes: usize = parts.iter().map(|part| part.holes.len()).sum();
            let perimeter: f64 = parts.iter().map(|part| part.perimeter_mm(set.samples())).sum();
            assert!((found.area_mm2(set.samples()) - theirs[0]).abs() < 1e-9 * theirs[0]);
            assert!((perimeter - theirs[1]).abs() < 1e-9 * theirs[1]);
            assert_eq!([parts.len() as f64, holes as f64], theirs[2..], "seed {seed} α {alpha}");
        }
    }
}

#[test]
fn scipy_gives_the_same_graphs() {
    for seed in 0..4 {
        let points = scattered(400, seed + 700);
        let Some(output) = output(SCRIPT, &listed(&points)) else {
            println!("{SKIPPED}");
            return;
        };
        let set = triangulation(&points);
        let ours = [delaunay(&set), emst(&set), gabriel(&set), crust(&set), cocone(&set)];
        assert_eq!(output.lines().count(), ours.len());
        for (line, graph) in output.lines().zip(ours) {
            let numbers: Vec<u32> = line.split(' ').map(|word| word.parse().unwrap()).collect();
            let theirs: Vec<[u32; 2]> = numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect();
            assert_eq!(by_row(&graph, &set), theirs);
        }
    }
}

#[test]
fn auto_beats_the_best_of_ten_concave_hulls() {
    let mut worse = Vec::new();
    for shape in Shape::ALL {
        let trial = shape.trial(Distribution::Random, 8_000, 1, 0);
        let line = |places: &[PlaceMm]| listed(places).replace('\n', " ");
        let truth: Vec<String> = trial.truth_mm().iter().map(|ring| line(ring)).collect();
        let points = listed(trial.triangulation.samples().places());
        let Some(best) = output(CONCAVE, &format!("{}\n\n{points}", truth.join("\n"))) else {
            println!("{SKIPPED}");
            return;
        };
        let best: f64 = best.trim().parse().unwrap();
        let iou = trial.score(Method::Auto).unwrap().iou;
        let loss = (1.0 - iou) / (1.0 - best);
        println!("{:<10} IoU {iou:.5}, GEOS {best:.5}, loss {loss:.2}", shape.name());
        worse.extend((iou <= best).then(|| shape.name()));
    }
    assert!(worse.is_empty(), "{worse:?}");
}
