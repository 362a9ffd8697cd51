"""Volumes with the topology that gudhi and scikit-image find, and meshes judged by VTK.

    python3 volume_peers.py make FOLDER     writes NAME.nrrd and cases.json: Betti numbers by gudhi, Euler numbers by gudhi (and, where it
                                            is installed, scikit-image)
    python3 volume_peers.py mesh FILE.ply   prints what VTK finds of a mesh as JSON
"""

import json
import sys
from pathlib import Path

STEP_MM = 0.1


def volumes():
    """Names and arrays, z first, nothing of which touches the border."""
    import numpy as np
    from scipy.ndimage import gaussian_filter

    random = np.random.default_rng(5)
    for index in range(6):
        yield f"noise-{index}", np.pad(random.random((14, 11, 12)) < 0.1 + 0.15 * index, 2)
    for index in range(6):
        smooth = gaussian_filter(random.standard_normal((26, 24, 25)), 1.2 + 0.4 * index)
        yield f"smooth-{index}", np.pad(smooth > 0.3 * smooth.std(), 3)
    z, y, x = np.mgrid[-12:13, -12:13, -12:13] + 0.3
    yield "torus", (np.hypot(np.hypot(x, y) - 7.0, z)) < 3.0
    radius = np.sqrt(x * x + y * y + z * z)
    yield "hollow", (radius < 9.0) & (radius > 4.0)
    yield "two", (np.hypot(np.hypot(x - 5, y), z) < 4.0) | (np.hypot(np.hypot(x + 6, y), z) < 3.5)


def betti(complex_):
    """Betti numbers of the cells of value 0."""
    complex_.compute_persistence(homology_coeff_field=2)
    return [int(number) for number in complex_.persistent_betti_numbers(0.0, 0.5)[:3]]


def make(folder):
    import gudhi
    import numpy as np

    try:
        from skimage.measure import euler_number
    except ImportError:
        euler_number = None
    cases = []
    for name, solid in volumes():
        sizes = " ".join(str(side) for side in reversed(solid.shape))
        head = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {sizes}\nencoding: raw\nspacings: {STEP_MM} {STEP_MM} {STEP_MM}\n\n"
        (folder / f"{name}.nrrd").write_bytes(head.encode() + (solid * np.uint8(255)).tobytes())
        level = np.where(solid, 0.0, 1.0)
        # Samples as corners of cells are connected across faces; closed voxels across corners, too.
        corners = betti(gudhi.CubicalComplex(vertices=level))
        voxels = betti(gudhi.CubicalComplex(top_dimensional_cells=level))
        case = {"name": name, "betti": corners}
        case["euler"] = [b[0] - b[1] + b[2] for b in (corners, voxels)]
        case["skimage"] = euler_number and [int(euler_number(solid, connectivity=c)) for c in (1, 3)]
        cases.append(case)
    (folder / "cases.json").write_text(json.dumps(cases))


def mesh(path):
    import vtk

    reader = vtk.vtkPLYReader()
    reader.SetFileName(path)
    reader.Update()
    mass = vtk.vtkMassProperties()
    mass.SetInputConnection(reader.GetOutputPort())
    found = {"triangles": reader.GetOutput().GetNumberOfPolys(), "area": mass.GetSurfaceArea(), "volume": mass.GetVolume()}
    for name, turned_on in (("open", "BoundaryEdgesOn"), ("branching", "NonManifoldEdgesOn")):
        edges = vtk.vtkFeatureEdges()
        edges.SetInputConnection(reader.GetOutputPort())
        edges.BoundaryEdgesOff()
        edges.FeatureEdgesOff()
        edges.ManifoldEdgesOff()
        edges.NonManifoldEdgesOff()
        getattr(edges, turned_on)()
        edges.Update()
        found[name] = edges.GetOutput().GetNumberOfLines()
    print(json.dumps(found))


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(Path(sys.argv[2]))
    else:
        mesh(sys.argv[2])
