//! The Point Cloud Graph beside SciPy, VTK and potpourri3d, in one run.
//!
//!     cargo bench -p asphera-graph --bench peers -- [ROW…] [--points N] [--many N] [--json]
//!
//! Rows are `neighbours`, `graph`, `eigen`, `geodesic`, `growth` and `threads`; without one all are run. Processor seconds of
//! one thread, each peer on the same points next to ours. N is 100,000 where it is not said; `--many` is the larger cloud of
//! `growth`, 10,000,000. Two threads are held against one by the clock, which needs a machine that does nothing else. Peers are those of
//! the Python that `ASPHERA_PYTHON` names: `scipy`, `vtk`, `potpourri3d` and `pygeodesic`. Without it the rows say ours alone.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it found")]
#![expect(clippy::unwrap_used, reason = "a benchmark ends where something is not as it must be")]

#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/it/bodies.rs"]
mod bodies;
mod common {
    #[path = "../../../reconstruct/benches/common/clock.rs"]
    pub(crate) mod clock;
    pub(crate) mod clouds;
    pub(crate) mod peer;
}

use std::time::Instant;

use asphera_graph::functions::{eigenfunctions, geodesic, height};
use asphera_graph::{Choices, Cloud, extract};
use rayon::{ThreadPool, ThreadPoolBuilder};

use self::bodies::{Body, Place, Random};
use self::common::clock::timed;
use self::common::clouds::{Known, cone, plane, sphere, torus};
use self::common::peer::Peers;

const SEED: u64 = 1;
/// Corners of the mesh whose Reeb graph others have timed.
const CORNERS: usize = 145_726;
const DIRECTION: Place = [1.0, 0.2, 0.1];
/// Neighbours in the row of neighbours, and in those of functions.
const NEIGHBOURS: [usize; 2] = [10, 12];
const EIGENFUNCTIONS: usize = 10;
const ROWS: [&str; 6] = ["neighbours", "graph", "eigen", "geodesic", "growth", "threads"];

/// Times of the same work, and what else is to be said.
struct Row {
    of: &'static str,
    cloud: String,
    points: usize,
    ours_s: f64,
    peer: &'static str,
    peer_s: Option<f64>,
    remark: String,
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let is_json = words.iter().any(|word| word == "--json");
    let number = |name: &str, default: usize| {
        let at = words.iter().position(|word| word == name);
        at.map_or(default, |at| words[at + 1].replace('_', "").parse().unwrap())
    };
    let (count, many) = (number("--points", 100_000), number("--many", 10_000_000));
    let is_asked = |row: &str| {
        words.iter().any(|word| word == row) || !words.iter().any(|word| ROWS.contains(&&**word))
    };
    let peers = Peers::find();
    if !is_json {
        if !peers.are_there() {
            println!("no peers: ASPHERA_PYTHON names no Python");
        }
        let [points, ours, theirs, ratio] = ["points", "ours, s", "theirs, s", "ratio"];
        println!("{points:>63}{ours:>10}{theirs:>25}{ratio:>8}");
    }
    let show = |row: Row| if is_json { print_json(&row) } else { print_line(&row) };
    // The first one, so that nothing before it counts as memory.
    if is_asked("growth") {
        growth(many, &show);
    }
    if is_asked("neighbours") {
        neighbours(count, &peers, &show);
    }
    if is_asked("graph") {
        graph(&peers, &show);
    }
    if is_asked("eigen") {
        eigen(count, &peers, &show);
    }
    if is_asked("geodesic") {
        geodesics(count, &peers, &show);
    }
    if is_asked("threads") {
        threads(count, &show);
    }
}

fn random() -> Random {
    Random::new(SEED)
}

fn neighbours(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    let [k, _] = NEIGHBOURS;
    let body = Body::row(2);
    let points = body.sample(count, &mut random());
    let ours_s = best(|| drop(Cloud::new(&points).unwrap().nearest(k).unwrap()));
    let peer_s = peers.neighbours(&points, k).map(|found| found[0]);
    let (of, peer, remark) = ("tree and 10 neighbours", "cKDTree", String::new());
    show(Row { of, cloud: body.name, points: count, ours_s, peer, peer_s, remark });
}

/// Loops of the same torus must be one in either graph.
fn graph(peers: &Peers, show: &dyn Fn(Row)) {
    let mesh = torus(CORNERS, &mut random());
    let ours_s = best(|| assert_eq!(loops(&mesh.points), 1));
    let found = peers.reeb(&mesh.points, &mesh.triangles, DIRECTION);
    if let Some(found) = &found {
        assert_eq!(found[1], 1.0, "loops of the peer");
    }
    let (of, peer, points) = ("graph by height", "VTK Reeb", CORNERS);
    let peer_s = found.map(|found| found[0]);
    let remark = "1 loop; the peer has a mesh".to_owned();
    show(Row { of, cloud: "torus, even".to_owned(), points, ours_s, peer, peer_s, remark });
    let body = Body::row(2);
    let points = body.sample(CORNERS, &mut random());
    let ours_s = best(|| assert_eq!(loops(&points), 2));
    let (points, peer_s, remark) = (CORNERS, None, "2 loops".to_owned());
    show(Row { of, cloud: body.name, points, ours_s, peer, peer_s, remark });
}

/// Loops of a cloud with everything that leads to them.
fn loops(points: &[Place]) -> usize {
    let cloud = Cloud::new(points).unwrap();
    let field = height(&cloud, DIRECTION).unwrap();
    extract(&cloud, &field, &Choices::default()).unwrap().loops.len()
}

fn eigen(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    let [_, k] = NEIGHBOURS;
    let torus = torus(count, &mut random()).points;
    for (cloud, points) in [
        ("row of 2", Body::row(2).sample(count, &mut random())),
        ("torus, even", torus),
        ("sphere", sphere(count, &mut random()).points),
    ] {
        let own = Cloud::new(&points).unwrap();
        let nearest = own.nearest(k).unwrap();
        let work = || timed(|| eigenfunctions(&own, &nearest, EIGENFUNCTIONS).unwrap());
        let (found, ours_s) = pool(1).install(work);
        let worst = found.residuals.iter().copied().fold(0.0, f64::max);
        let theirs = peers.eigen(&points, k, EIGENFUNCTIONS);
        let mut remark = format!("residuals {worst:.1e}");
        if let Some(theirs) = &theirs {
            let pairs = found.eigenvalues.iter().zip(&theirs[2..]);
            let apart = pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
            remark += &format!(", theirs {:.1e}; eigenvalues apart {apart:.1e}", theirs[1]);
        }
        let (of, peer, peer_s) = ("10 eigenfunctions", "eigsh", theirs.map(|found| found[0]));
        show(Row { of, cloud: cloud.to_owned(), points: count, ours_s, peer, peer_s, remark });
    }
}

/// Distances from the first point, with neighbours; errors over the largest distance.
fn geodesics(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    for made in [plane, cone, sphere] {
        geodesic_row(&made(count, &mut random()), peers, show);
    }
    // The exact distances of the torus take the peer half a minute.
    let mesh = torus(count, &mut random());
    if let Some(truth) = peers.exact(&mesh.points, &mesh.triangles, 0) {
        geodesic_row(&Known { name: "torus, even", points: mesh.points, truth }, peers, show);
    }
}

fn geodesic_row(cloud: &Known, peers: &Peers, show: &dyn Fn(Row)) {
    let (points, truth) = (&cloud.points, &cloud.truth);
    let work = || {
        let own = Cloud::new(points).unwrap();
        let nearest = own.nearest(NEIGHBOURS[1]).unwrap();
        let of_row = own.places_of_rows().to_vec();
        (geodesic(&own, &nearest, &[of_row[0]]).unwrap().values, of_row)
    };
    let ours_s = best(|| drop(work()));
    let (values, of_row) = work();
    let apart = |(&place, truth): (&u32, &f64)| (values[place as usize] - truth).abs();
    let worst = of_row.iter().zip(truth).map(apart).fold(0.0, f64::max);
    let largest = truth.iter().copied().fold(0.0, f64::max);
    let theirs = peers.heat(points, truth, 0);
    let mut remark = format!("error {:.2} %", 100.0 * worst / largest);
    if let Some(theirs) = &theirs {
        remark += &format!(", theirs {:.2} %", 100.0 * theirs[1]);
    }
    let (of, peer) = ("geodesic distances", "heat method");
    let peer_s = theirs.map(|found| found[0]);
    let (cloud, points) = (cloud.name.to_owned(), points.len());
    show(Row { of, cloud, points, ours_s, peer, peer_s, remark });
}

/// Ten times as many points, and the memory that they take beside themselves.
fn growth(many: usize, show: &dyn Fn(Row)) {
    let body = Body::row(2);
    let [few, all] = [many / 10, many].map(|count| {
        let points = body.sample(count, &mut random());
        let before = memory("VmRSS");
        let reset = std::fs::write("/proc/self/clear_refs", "5").is_ok();
        let ours_s = seconds(|| assert_eq!(loops(&points), 2));
        let bytes = reset.then(|| (memory("VmHWM") - before) / count as f64);
        (ours_s, bytes)
    });
    let remark = all.1.map_or(String::new(), |bytes| format!("{bytes:.0} bytes a point"));
    let (of, peer) = ("graph by height", "10 × a tenth");
    let (ours_s, peer_s) = (all.0, Some(10.0 * few.0));
    show(Row { of, cloud: body.name, points: many, ours_s, peer, peer_s, remark });
}

/// One thread against two, by the clock.
fn threads(count: usize, show: &dyn Fn(Row)) {
    let points = Body::row(2).sample(count, &mut random());
    let cloud = Cloud::new(&points).unwrap();
    let nearest = cloud.nearest(NEIGHBOURS[1]).unwrap();
    let work: [(&'static str, &(dyn Fn() + Sync)); 3] = [
        ("tree and 10 neighbours", &|| {
            drop(Cloud::new(&points).unwrap().nearest(NEIGHBOURS[0]).unwrap());
        }),
        ("graph by height", &|| assert_eq!(loops(&points), 2)),
        ("10 eigenfunctions", &|| {
            drop(eigenfunctions(&cloud, &nearest, EIGENFUNCTIONS).unwrap());
        }),
    ];
    for (of, work) in work {
        let [one_s, two_s] = [1, 2].map(|threads| {
            let pool = pool(threads);
            let run = |_| {
                #[expect(clippy::disallowed_methods, reason = "a benchmark measures time")]
                let start = Instant::now();
                pool.install(work);
                start.elapsed().as_secs_f64()
            };
            (0..REPEATED).map(run).fold(f64::INFINITY, f64::min)
        });
        let (peer, remark) = ("one thread", "two threads, by the clock".to_owned());
        let (ours_s, peer_s) = (two_s, Some(one_s));
        let cloud = "row of 2".to_owned();
        show(Row { of, cloud, points: count, ours_s, peer, peer_s, remark });
    }
}

/// Processor seconds of one thread.
fn seconds(work: impl Fn() + Sync + Send) -> f64 {
    pool(1).install(|| timed(work)).1
}

/// The least of some runs: others on the machine make some longer.
fn best(work: impl Fn() + Sync + Send) -> f64 {
    (0..REPEATED).map(|_| seconds(&work)).fold(f64::INFINITY, f64::min)
}

const REPEATED: usize = 3;

/// A line of the kernel's account of this process, in bytes.
fn memory(name: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with(name)).unwrap();
    1024.0 * line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

fn print_line(row: &Row) {
    let Row { of, cloud, points, ours_s, peer, peer_s, remark } = row;
    let theirs = peer_s.map_or_else(
        || format!("{:>10}{:>8}", "-", "-"),
        |peer_s| format!("{peer_s:>10.2}{:>8.2}", peer_s / ours_s),
    );
    println!("{of:<26}{cloud:<26}{points:>11}{ours_s:>10.3}{peer:>15}{theirs}  {remark}");
}

fn print_json(row: &Row) {
    let Row { of, cloud, points, ours_s, peer, peer_s, remark } = row;
    let known = |value: Option<f64>| value.map_or("null".to_owned(), |value| format!("{value:.4}"));
    println!(
        "{{\"of\": \"{of}\", \"cloud\": \"{cloud}\", \"points\": {points}, \"seed\": {SEED}, \"ours_s\": {ours_s:.4}, \
         \"peer\": \"{peer}\", \"peer_s\": {}, \"ratio\": {}, \"remark\": \"{remark}\"}}",
        known(*peer_s),
        known(peer_s.map(|peer_s| peer_s / ours_s))
    );
}
