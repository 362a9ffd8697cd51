//! Programs of others on the same points, in a Python of their own.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::bodies::Place;

/// Begins every script: the points, and the seconds that something takes.
const PRELUDE: &str = "
import sys, time, warnings, numpy
warnings.filterwarnings('ignore')
points = numpy.fromfile(sys.argv[1]).reshape(-1, 3)
def timed(work):
    start = time.process_time()
    found = work()
    return time.process_time() - start, found
";

const NEIGHBOURS: &str = "
from scipy.spatial import cKDTree
print(timed(lambda: cKDTree(points).query(points, k=int(sys.argv[2]) + 1))[0])
";

/// The mesh is ready before the clock starts.
const REEB: &str = "
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
triangles = numpy.fromfile(sys.argv[2], dtype=numpy.uint32).reshape(-1, 3).astype(numpy.int64)
places = vtk.vtkPoints()
places.SetData(numpy_to_vtk(points, deep=1))
cells = vtk.vtkCellArray()
rows = numpy.c_[numpy.full(len(triangles), 3), triangles].ravel()
cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(rows, deep=1))
mesh = vtk.vtkPolyData()
mesh.SetPoints(places)
mesh.SetPolys(cells)
height = numpy_to_vtk(points @ numpy.array([float(word) for word in sys.argv[3:6]]), deep=1)
height.SetName('height')
mesh.GetPointData().SetScalars(height)
graph = vtk.vtkPolyDataToReebGraphFilter()
graph.SetInputData(mesh)
graph.SetFieldId(0)
seconds = timed(graph.Update)[0]
found = graph.GetOutput()
print(seconds, found.GetNumberOfEdges() - found.GetNumberOfVertices() + 1)
";

/// The Laplacian is ready before the clock starts; it is that of the crate, by the formulas of its documentation.
const EIGEN: &str = "
from scipy.sparse import coo_matrix, diags, identity
from scipy.sparse.linalg import eigsh
from scipy.spatial import cKDTree
k, count, n = int(sys.argv[2]), int(sys.argv[3]), len(points)
distances, others = cKDTree(points).query(points, k=k + 1)
rows = numpy.repeat(numpy.arange(n), k)
one_way = coo_matrix((distances[:, 1:].ravel(), (rows, others[:, 1:].ravel())), (n, n)).tocsr()
both = one_way.maximum(one_way.T).tocoo()
likeness = numpy.exp(-(both.data / both.data.mean()) ** 2)
density = 1 + numpy.bincount(both.row, likeness, n)
weights = likeness / (density[both.row] * density[both.col])
roots = numpy.sqrt(numpy.bincount(both.row, weights, n))
twin = coo_matrix((weights / (roots[both.row] * roots[both.col]), (both.row, both.col)), (n, n))
operator = (identity(n) - twin).tocsc()
seconds, (values, vectors) = timed(lambda: eigsh(operator, k=count + 1, sigma=-1e-6, tol=1e-9))
left = numpy.linalg.norm(operator @ vectors - vectors * values, axis=0)
print(seconds, left.max(), *numpy.sort(values)[1:])
";

/// Solver and distances; the largest error is a share of the largest distance.
const HEAT: &str = "
import potpourri3d
truth = numpy.fromfile(sys.argv[2])
source = int(sys.argv[3])
seconds, found = timed(lambda: potpourri3d.PointCloudHeatSolver(points).compute_distance(source))
print(seconds, abs(found - truth).max() / truth.max())
";

/// Exact distances on a mesh (Mitchell, Mount and Papadimitriou), written to a file.
const EXACT: &str = "
import pygeodesic.geodesic
triangles = numpy.fromfile(sys.argv[2], dtype=numpy.uint32).reshape(-1, 3)
search = pygeodesic.geodesic.PyGeodesicAlgorithmExact(points, triangles)
seconds, found = timed(lambda: search.geodesicDistances(numpy.array([int(sys.argv[3])]), None)[0])
found.tofile(sys.argv[4])
print(seconds)
";

/// Python with SciPy, VTK, potpourri3d and pygeodesic, and a folder for what it reads.
pub(crate) struct Peers {
    folder: PathBuf,
    python: Option<OsString>,
}

impl Peers {
    /// The Python that `ASPHERA_PYTHON` names.
    pub(crate) fn find() -> Peers {
        let folder = std::env::temp_dir().join(format!("asphera-peers-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Peers { folder, python: std::env::var_os("ASPHERA_PYTHON") }
    }

    /// Whether there is one.
    pub(crate) fn are_there(&self) -> bool {
        self.python.is_some()
    }

    /// Seconds of SciPy's tree and the nearest `count` neighbours of all points.
    pub(crate) fn neighbours(&self, points: &[Place], count: usize) -> Option<Vec<f64>> {
        self.run(NEIGHBOURS, points, &[count.to_string()])
    }

    /// Seconds and loops of VTK's Reeb graph of a mesh, by height along a direction.
    pub(crate) fn reeb(
        &self,
        points: &[Place],
        triangles: &[[u32; 3]],
        direction: Place,
    ) -> Option<Vec<f64>> {
        let mut words =
            vec![self.written("triangles", triangles.as_flattened().iter(), |at| {
                at.to_le_bytes().to_vec()
            })];
        words.extend(direction.map(|value| value.to_string()));
        self.run(REEB, points, &words)
    }

    /// Seconds and the largest residual of SciPy's `eigsh` with shift and invert, then the eigenvalues.
    pub(crate) fn eigen(&self, points: &[Place], k: usize, count: usize) -> Option<Vec<f64>> {
        self.run(EIGEN, points, &[k.to_string(), count.to_string()])
    }

    /// Seconds of potpourri3d's heat method on points, and its largest error over the largest distance.
    pub(crate) fn heat(&self, points: &[Place], truth: &[f64], source: usize) -> Option<Vec<f64>> {
        let truth = self.written("truth", truth.iter(), |value| value.to_le_bytes().to_vec());
        self.run(HEAT, points, &[truth, source.to_string()])
    }

    /// Exact distances on a mesh.
    pub(crate) fn exact(
        &self,
        points: &[Place],
        triangles: &[[u32; 3]],
        source: usize,
    ) -> Option<Vec<f64>> {
        let triangles = self
            .written("triangles", triangles.as_flattened().iter(), |at| at.to_le_bytes().to_vec());
        let into = self.folder.join("exact");
        let words = [triangles, source.to_string(), into.to_str()?.to_owned()];
        self.run(EXACT, points, &words)?;
        let bytes = std::fs::read(into).ok()?;
        let value = |eight: &[u8]| f64::from_le_bytes(eight.try_into().unwrap_or_default());
        Some(bytes.chunks_exact(8).map(value).collect())
    }

    /// The numbers that a script prints, of one thread.
    fn run(&self, script: &str, points: &[Place], words: &[String]) -> Option<Vec<f64>> {
        let mut python = Command::new(self.python.as_ref()?);
        let file = self
            .written("points", points.as_flattened().iter(), |value| value.to_le_bytes().to_vec());
        let output = python
            .envs(["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"].map(|name| (name, "1")))
            .arg("-c")
            .arg(format!("{PRELUDE}{script}"))
            .arg(file)
            .args(words)
            .stderr(Stdio::inherit())
            .output()
            .ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        let found: Vec<f64> =
            text.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
        (!found.is_empty()).then_some(found)
    }

    fn written<T>(
        &self,
        name: &str,
        values: impl Iterator<Item = T>,
        bytes: impl Fn(T) -> Vec<u8>,
    ) -> String {
        let file = self.folder.join(name);
        std::fs::write(&file, values.flat_map(bytes).collect::<Vec<u8>>()).unwrap();
        file.to_str().unwrap().to_owned()
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // A temporary folder that stays harms nobody.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
