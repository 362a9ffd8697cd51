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


HEAD = (
    "X: {0}\nY: {0}\nZ: {0}\nVoxel-Size: 1\nAlpha-Color: 0\nInt-Endian: 0123\nVoxel-Endian: 0\n"
    "Res-X: 1.0\nRes-Y: 1.0\nRes-Z: 1.0\nVersion: 2\n.\n"
)


def bodies(is_long):
    """Name, what is inside, reach and area of the bodies, in spacings."""
    import numpy as np
    from scipy.special import ellipeinc, ellipkinc

    def ellipsoid(c, b, a):
        angle = np.arccos(c / a)
        m = a * a * (b * b - c * c) / (b * b * (a * a - c * c))
        curved = ellipeinc(angle, m) * np.sin(angle) ** 2 + ellipkinc(angle, m) * np.cos(angle) ** 2
        return 2 * np.pi * (c * c + a * b / np.sin(angle) * curved)

    def sphere(r):
        return f"sphere-{r}", lambda p: (p**2).sum(0) < r * r, r, 4 * np.pi * r * r

    def torus(ring, tube):
        inside = lambda p: np.hypot(np.hypot(p[0], p[1]) - ring, p[2]) < tube
        return f"torus-{ring}-{tube}", inside, ring + tube, 4 * np.pi**2 * ring * tube

    yield sphere(10)
    yield torus(20, 5)
    yield "cube-40", lambda p: (np.abs(p) < 20).all(0), 20 * 3**0.5, 6 * 40 * 40
    if is_long:
        yield sphere(20)
        yield sphere(30)
        yield torus(30, 10)
        sides = np.array([15.0, 30.0, 45.0])[:, None, None, None]
        yield "ellipsoid", lambda p: ((p / sides) ** 2).sum(0) < 1, 45, ellipsoid(15, 30, 45)


def dgtal_area(path):
    """Surfels times the normals of integral invariants."""
    from dgtal import SH3

    options = SH3.defaultParameters()
    for key, value in (("r-radius", 5.0), ("verbose", 0), ("surfaceComponents", "All")):
        options.set(key, value)
    image = SH3.makeBinaryImage(str(path), options)
    space = SH3.getKSpace(image, options)
    surfels = SH3.getSurfelRange(SH3.makeLightDigitalSurface(image, space, options), options)
    normals = SH3.getIINormalVectors(image, surfels, options)
    # A surfel lies across the axis along which its coordinate is even.
    across = ([at % 2 for at in space.sKCoords(surfel)].index(0) for surfel in surfels)
    return sum(abs(normal[axis]) for axis, normal in zip(across, normals))


def areas(folder, is_long):
    import numpy as np
    from scipy.spatial.transform import Rotation

    random = np.random.default_rng(35)
    cases = []
    for name, is_inside, reach, area in bodies(is_long):
        for pose in range(20 if is_long else 1):
            side = 2 * int(np.ceil(reach)) + 5
            grid = np.indices((side,) * 3) - side // 2 + random.uniform(-0.5, 0.5, (3, 1, 1, 1))
            turn = Rotation.random(random_state=random).as_matrix()
            solid = is_inside(np.tensordot(turn, grid, 1))
            file = folder / f"{name}-{pose}.vol"
            file.write_bytes(HEAD.format(side).encode() + (solid * np.uint8(255)).tobytes())
            cases.append({"body": name, "file": file.name, "area": area, "dgtal": dgtal_area(file)})
    (folder / "areas.json").write_text(json.dumps(cases))


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(Path(sys.argv[2]))
    elif sys.argv[1] in ("areas", "areas-long"):
        areas(Path(sys.argv[2]), sys.argv[1] == "areas-long")
    else:
        mesh(sys.argv[2])
