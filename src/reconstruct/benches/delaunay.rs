//! Time and memory of the Delaunay triangulation in space.
//!
//! `cargo bench -p asphera-reconstruct --bench delaunay` triangulates 100,000 points of each kind in one thread: the least processor time of 3 runs.
//! `ASPHERA_BENCH_POINTS` sets another number. Where `ASPHERA_PYTHON` has CGAL or SciPy, both triangulate the same points, one
//! run each (SciPy no exact scans, which take Qhull many minutes); CGAL's time holds its insertion of all points at once, without the conversion of the points.

use std::f64::consts::TAU;
use std::process::{Command, Stdio};

use asphera_geometry::PointMm;
use asphera_reconstruct::Delaunay;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;
use rayon::ThreadPoolBuilder;

/// Points of a kind, so many.
type Kind = fn(usize) -> Vec<PointMm>;

const RUNS: usize = 3;
const SEED: u64 = 1;
const PEERS: &str = "
import sys, time, numpy
points = numpy.fromfile(sys.argv[1]).reshape(-1, 3)
try:
    from CGAL.CGAL_Kernel import Point_3
    from CGAL.CGAL_Triangulation_3 import Delaunay_triangulation_3
    listed = [Point_3(*map(float, p)) for p in points]
    start = time.process_time()
    made = Delaunay_triangulation_3()
    made.insert(listed)
    print('CGAL %.2f s, %d cells' % (time.process_time() - start, made.number_of_finite_cells()), end='; ')
except ImportError: print('no CGAL', end='; ')
if sys.argv[2] == 'exact': sys.exit()
try:
    from scipy.spatial import Delaunay
    start = time.process_time()
    made = Delaunay(points)
    print('Qhull %.2f s, %d cells' % (time.process_time() - start, len(made.simplices)))
except ImportError: print('no SciPy')
";

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let count = std::env::var("ASPHERA_BENCH_POINTS").map_or(100_000, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    });
    println!("{count} points, seed {SEED}, one thread; least processor seconds of {RUNS} runs");
    let kinds: [(&str, Kind); 6] = [
        ("random cube", cube),
        ("ball, 5 nm", |count| ball(count, 5e-6)),
        ("exact ball", |count| ball(count, 0.0)),
        ("exact torus rings", torus),
        ("exact grid on a lens", |count| lens(count, 0.0)),
        ("grid on a lens, 5 nm", |count| lens(count, 5e-6)),
    ];
    let one = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for (name, kind) in kinds {
        let points = kind(count);
        let before = peak_bytes();
        let mut least = f64::INFINITY;
        let mut cells = 0;
        for _ in 0..RUNS {
            let start = processor_s();
            let made = one.install(|| Delaunay::new(&points)).expect("points in space");
            least = least.min(processor_s() - start);
            cells = made.tetrahedra().len();
        }
        let bytes = peak_bytes().zip(before).map(|(after, before)| (after - before) / count as u64);
        println!("{name}: {least:.3} s, {cells} cells; growth of the peak {bytes:?} bytes a point");
        if let Some(words) = peers(&points, name) {
            println!("    {}", words.trim());
        }
    }
}

fn peers(points: &[PointMm], name: &str) -> Option<String> {
    let python = std::env::var_os("ASPHERA_PYTHON")?;
    let kind = if name.starts_with("exact") { "exact" } else { "noisy" };
    let file = std::env::temp_dir().join(format!("asphera-delaunay-{}.bin", std::process::id()));
    let bytes: Vec<u8> =
        points.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(&file, bytes).ok()?;
    let output = Command::new(python)
        .args(["-c", PEERS])
        .arg(&file)
        .arg(kind)
        .stderr(Stdio::inherit())
        .output();
    let _ = std::fs::remove_file(&file);
    String::from_utf8(output.ok()?.stdout).ok()
}

fn unit(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 * 2_f64.powi(-53)
}

fn cube(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count).map(|_| [0; 3].map(|_| unit(&mut random))).collect()
}

fn ball(count: usize, noise_mm: f64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count)
        .map(|index| {
            let z = 1.0 - (2 * index + 1) as f64 / count as f64;
            let turn = 2.399_963_229_728_653 * index as f64;
            let radius_mm = 10.0 + noise_mm * (2.0 * unit(&mut random) - 1.0);
            let out = radius_mm * (1.0 - z * z).sqrt();
            [out * turn.cos(), out * turn.sin(), radius_mm * z]
        })
        .collect()
}

fn torus(count: usize) -> Vec<PointMm> {
    let around = (count as f64 / 3.0).sqrt() as usize;
    (0..count)
        .map(|at| {
            let turn = |at: usize, of: usize| TAU * at as f64 / of as f64;
            let (u, v) = (turn(at / around, count / around), turn(at % around, around));
            let out = 3.0 + v.cos();
            [out * u.cos(), out * u.sin(), v.sin()]
        })
        .collect()
}

fn lens(count: usize, noise_mm: f64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    let side = (count as f64).sqrt() as usize;
    (0..side * side)
        .map(|at| {
            let [x, y] = [at % side, at / side].map(|at| 10.0 * at as f64 / side as f64 - 5.0);
            let squared = x * x + y * y;
            let sag = squared / (20.0 * (1.0 + (1.0 - squared / 400.0).sqrt()))
                + 1e-5 * squared * squared;
            [x, y, sag + noise_mm * (2.0 * unit(&mut random) - 1.0)]
        })
        .collect()
}

/// Processor time of this process, in ticks of 10 ms (Linux).
fn processor_s() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).map(|ticks| ticks.parse().unwrap_or(0.0)).sum::<f64>() / 100.0
}

fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| 1024 * kib)
}
