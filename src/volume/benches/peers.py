"""The gyroid of volumes.rs by VTK and scikit-image: CPU seconds of one thread, best of N.

Run with `python3 src/volume/benches/peers.py SIDE RUNS`; needs vtk, scikit-image and numpy.
"""

import sys
import time

import numpy as np
import skimage
import skimage.measure
import vtk
from vtk.util.numpy_support import numpy_to_vtk

side = int(sys.argv[1]) if len(sys.argv) > 1 else 256
runs = int(sys.argv[2]) if len(sys.argv) > 2 else 5

wave = np.arange(side) * (16 * np.pi / side)
sine, cosine = np.sin(wave), np.cos(wave)
volume = np.empty((side, side, side), np.uint8)
for z in range(side):
    value = np.outer(cosine, sine) + np.outer(sine, np.full(side, cosine[z])) + sine[z] * cosine[None, :]
    volume[z] = np.where(value > 0.9, 200, 10)

vtk.vtkSMPTools.SetBackend("Sequential")
image = vtk.vtkImageData()
image.SetDimensions(side, side, side)
image.GetPointData().SetScalars(numpy_to_vtk(volume.ravel(), deep=False))


def flying_edges():
    contour = vtk.vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 100)
    contour.ComputeNormalsOff()
    contour.ComputeGradientsOff()
    contour.ComputeScalarsOff()
    contour.Update()
    return contour.GetOutput().GetNumberOfPolys()


def marching_cubes():
    return len(skimage.measure.marching_cubes(volume, 100)[1])


def euler():
    return skimage.measure.euler_number(volume > 100, connectivity=1)


print(f"gyroid, {side}³ bytes, VTK {vtk.vtkVersion.GetVTKVersion()}, scikit-image {skimage.__version__}, best of {runs}")
for name, work, count in [
    ("FlyingEdges3D", flying_edges, runs),
    ("marching_cubes of scikit-image", marching_cubes, min(runs, 2)),
    ("euler_number of scikit-image", euler, min(runs, 2)),
]:
    best = float("inf")
    for _ in range(count):
        start = time.process_time()
        figure = work()
        best = min(best, time.process_time() - start)
    print(f"  {name}: {side**3 / best / 1e6:.1f} M/s, {best:.3f} s ({figure})", flush=True)


def dgtal_area():
    """Area of a ball of 30 spacings by the integral invariants of DGtal, in a pose; surfels times normals."""
    from tempfile import NamedTemporaryFile

    from dgtal import SH3

    grid = np.indices((65, 65, 65)) - np.array([32.13, 31.71, 32.38])[:, None, None, None]
    head = "X: 65\nY: 65\nZ: 65\nVoxel-Size: 1\nAlpha-Color: 0\nInt-Endian: 0123\nVoxel-Endian: 0\n"
    head += "Res-X: 1.0\nRes-Y: 1.0\nRes-Z: 1.0\nVersion: 2\n.\n"
    options = SH3.defaultParameters()
    for key, value in (("r-radius", 5.0), ("verbose", 0), ("surfaceComponents", "All")):
        options.set(key, value)
    with NamedTemporaryFile(suffix=".vol") as file:
        file.write(head.encode() + (((grid**2).sum(0) < 900) * np.uint8(255)).tobytes())
        file.flush()
        image = SH3.makeBinaryImage(file.name, options)
    start = time.process_time()
    space = SH3.getKSpace(image, options)
    surfels = SH3.getSurfelRange(SH3.makeLightDigitalSurface(image, space, options), options)
    normals = SH3.getIINormalVectors(image, surfels, options)
    across = ([at % 2 for at in space.sKCoords(surfel)].index(0) for surfel in surfels)
    area = sum(abs(normal[axis]) for axis, normal in zip(across, normals))
    return area / (3600 * np.pi) - 1, time.process_time() - start


try:
    error, seconds = dgtal_area()
    print(f"  DGtal, area of a ball of 30 spacings: {100 * error:+.2f} %, {seconds:.2f} s")
except ImportError:
    print("  DGtal: SKIPPED, it is not installed (pip install dgtal)")
