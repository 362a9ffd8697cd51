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
