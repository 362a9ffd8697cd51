//! Programs of others on the same points: CGAL by a small program that is compiled here, SciPy by Python.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use asphera_geometry::PointMm;

const CGAL: &str = include_str!("cgal.cpp");
const SCIPY: &str = "
import sys, time, numpy
from scipy.spatial import cKDTree
points = numpy.fromfile(sys.argv[1]).reshape(-1, 3)
start = time.process_time()
cKDTree(points).query(points, k=int(sys.argv[2]) + 1)
print(time.process_time() - start)
";

/// What is there of the peers, in a folder of their own.
pub(crate) struct Peers {
    folder: PathBuf,
    cgal: Option<PathBuf>,
    python: Option<std::ffi::OsString>,
}

impl Peers {
    /// Compiles the program of CGAL (Debian: `libcgal-dev`); SciPy is that of `ASPHERA_PYTHON`.
    pub(crate) fn find() -> Peers {
        let folder = std::env::temp_dir().join(format!("asphera-peers-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for temporary files");
        let (source, program) = (folder.join("cgal.cpp"), folder.join("cgal"));
        std::fs::write(&source, CGAL).expect("a temporary file");
        let built = Command::new("g++")
            .args(["-O3", "-DNDEBUG", "-o"])
            .args([&program, &source])
            .args(["-lgmp", "-lmpfr"])
            .stderr(Stdio::null())
            .status();
        let cgal = built.is_ok_and(|status| status.success()).then_some(program);
        Peers { folder, cgal, python: std::env::var_os("ASPHERA_PYTHON") }
    }

    /// What is missing, in words.
    pub(crate) fn missing(&self) -> Vec<&'static str> {
        let cgal = "no CGAL: g++ with libcgal-dev cannot compile benches/common/cgal.cpp";
        let scipy = "no SciPy: ASPHERA_PYTHON names no Python";
        [(self.cgal.is_none(), cgal), (self.python.is_none(), scipy)]
            .into_iter()
            .filter_map(|(is_missing, words)| is_missing.then_some(words))
            .collect()
    }

    /// Processor seconds of CGAL: `front` of the advancing front, `delaunay` of the triangulation in bulk.
    pub(crate) fn cgal_s(&self, what: &str, points: &[PointMm]) -> Option<f64> {
        let file = self.written(points);
        seconds(Command::new(self.cgal.as_ref()?).arg(what).arg(file))
    }

    /// Processor seconds of SciPy's tree and the nearest `count` neighbours of all points.
    pub(crate) fn neighbours_s(&self, points: &[PointMm], count: usize) -> Option<f64> {
        let file = self.written(points);
        let mut python = Command::new(self.python.as_ref()?);
        seconds(python.args(["-c", SCIPY]).arg(file).arg(count.to_string()))
    }

    fn written(&self, points: &[PointMm]) -> PathBuf {
        let file = self.folder.join("points.bin");
        let bytes: Vec<u8> =
            points.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        std::fs::write(&file, bytes).expect("room for the points");
        file
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // A temporary folder that stays harms nobody.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn seconds(command: &mut Command) -> Option<f64> {
    let output = command.stderr(Stdio::inherit()).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}
