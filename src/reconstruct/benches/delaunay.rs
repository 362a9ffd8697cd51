//! Time and memory of the Delaunay triangulation in space.
//!
//! `cargo bench -p asphera-reconstruct --bench delaunay` triangulates 100,000 points of each kind in one thread: the least processor time of 3 runs.
//! `ASPHERA_BENCH_POINTS` sets another number. Where `ASPHERA_PYTHON` has CGAL or SciPy, both triangulate the same points, one
//! run each (SciPy no exact scans, which take Qhull many minutes); CGAL's time holds its insertion of all points at once, without the conversion of the points.

use std::process::{Command, Stdio};

use asphera_geometry::PointMm;
use asphera_reconstruct::Delaunay;
use rayon::ThreadPoolBuilder;

mod common {
    pub(crate) mod clock;
    pub(crate) mod clouds;
    pub(crate) mod memory;
}

use self::common::clock::timed;
use self::common::clouds::{
    SEED, asphere_grid, ball_spiral, exact_ball, lens_grid, random_cube, torus_rings,
};
use self::common::memory::peak_bytes;

/// Points of a kind, so many.
type Kind = fn(usize) -> Vec<PointMm>;

const RUNS: usize = 3;
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
        ("random cube", random_cube),
        ("ball along a spiral, 5 nm", ball_spiral),
        ("exact ball", exact_ball),
        ("exact torus rings", torus_rings),
        ("exact raster on a lens", lens_grid),
        ("raster on a lens, 5 nm", asphere_grid),
    ];
    let one = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for (name, kind) in kinds {
        let points = kind(count);
        let before = peak_bytes();
        let mut least = f64::INFINITY;
        let mut cells = 0;
        for _ in 0..RUNS {
            let (made, seconds) =
                one.install(|| timed(|| Delaunay::new(&points).expect("points in space")));
            least = least.min(seconds);
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
