//! Programs of others on the same points: CGAL and the authors' HNN-Crust by small programs that are compiled here, GEOS by Python.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use asphera_contour::PlaceMm;

const CGAL: &str = include_str!("cgal.cpp");
const HNN: &str = include_str!("hnn.cpp");
const GEOS: &str = "
import sys, time, numpy, shapely
points = shapely.MultiPoint(numpy.fromfile(sys.argv[1]).reshape(-1, 2))
start = time.process_time()
hull = shapely.concave_hull(points, ratio=float(sys.argv[2]), allow_holes=True)
print(time.process_time() - start, shapely.get_num_coordinates(hull))
";

/// What is there of the peers, in a folder of their own.
pub(crate) struct Peers {
    folder: PathBuf,
    cgal: Option<PathBuf>,
    hnn: Option<PathBuf>,
    python: Option<std::ffi::OsString>,
}

/// Processor seconds of a peer, and how many edges or corners it found.
#[derive(Clone, Copy)]
pub(crate) struct Found {
    pub(crate) seconds: f64,
    pub(crate) count: usize,
}

impl Peers {
    /// Compiles the program of CGAL (Debian: `libcgal-dev`), and that of HNN-Crust where `ASPHERA_HNN_CRUST` names the folder of its
    /// sources (with ANN, Debian: `libann-dev`). GEOS is that of shapely in `ASPHERA_PYTHON`.
    pub(crate) fn find() -> Peers {
        let folder = std::env::temp_dir().join(format!("asphera-peers-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for temporary files");
        let cgal = compiled(&folder, "cgal", CGAL, &["-lgmp", "-lmpfr"]);
        let hnn = std::env::var("ASPHERA_HNN_CRUST").ok().and_then(|sources| {
            let (include, file) = (format!("-I{sources}"), format!("{sources}/Reconstruct2D.cpp"));
            let more = std::env::var("ASPHERA_ANN").unwrap_or_default();
            let words: Vec<&str> = [include.as_str(), file.as_str()]
                .into_iter()
                .chain(more.split_whitespace())
                .chain(["-lann"])
                .collect();
            compiled(&folder, "hnn", HNN, &words)
        });
        Peers { folder, cgal, hnn, python: std::env::var_os("ASPHERA_PYTHON") }
    }

    /// What is missing, in words.
    pub(crate) fn missing(&self) -> Vec<&'static str> {
        let cgal = "no CGAL: g++ with libcgal-dev cannot compile benches/common/cgal.cpp";
        let hnn = "no HNN-Crust of its authors: ASPHERA_HNN_CRUST names no folder that compiles";
        let geos = "no GEOS: ASPHERA_PYTHON names no Python";
        [(self.cgal.is_none(), cgal), (self.hnn.is_none(), hnn), (self.python.is_none(), geos)]
            .into_iter()
            .filter_map(|(is_missing, words)| is_missing.then_some(words))
            .collect()
    }

    /// CGAL's work as `cgal.cpp` names it, with its number.
    pub(crate) fn cgal(&self, work: &str, points: &[PlaceMm], value: f64) -> Option<Found> {
        let file = self.written(points);
        found(Command::new(self.cgal.as_ref()?).arg(work).arg(file).arg(value.to_string()))
    }

    /// The program of HNN-Crust's authors.
    pub(crate) fn hnn_crust(&self, points: &[PlaceMm]) -> Option<Found> {
        let file = self.written(points);
        found(Command::new(self.hnn.as_ref()?).arg(file))
    }

    /// The concave hull of GEOS with holes; sides up to `ratio` between the shortest and the longest edge of its mesh stay.
    pub(crate) fn concave_hull(&self, points: &[PlaceMm], ratio: f64) -> Option<Found> {
        let file = self.written(points);
        let mut python = Command::new(self.python.as_ref()?);
        found(python.args(["-c", GEOS]).arg(file).arg(ratio.to_string()))
    }

    fn written(&self, points: &[PlaceMm]) -> PathBuf {
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

/// A program of C++ sources and more words for the compiler; none where it does not compile.
fn compiled(folder: &Path, name: &str, source: &str, words: &[&str]) -> Option<PathBuf> {
    let (file, program) = (folder.join(format!("{name}.cpp")), folder.join(name));
    std::fs::write(&file, source).expect("a temporary file");
    let built = Command::new("g++")
        .args(["-O3", "-DNDEBUG", "-o"])
        .args([&program, &file])
        .args(words)
        .stderr(Stdio::null())
        .status();
    built.is_ok_and(|status| status.success()).then_some(program)
}

fn found(command: &mut Command) -> Option<Found> {
    let output = command.stderr(Stdio::inherit()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut words = text.split_whitespace();
    let seconds = words.next()?.parse().ok()?;
    Some(Found { seconds, count: words.next()?.parse().ok()? })
}
