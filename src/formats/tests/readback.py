"""Reads back with independent software what asphera-formats writes, and makes files for it to read.

    python readback.py written FOLDER   compare map.x3p, cloud.x3p and mesh.ply with the values beside
                                        them, bit for bit; exit code 1 at the first difference
    python readback.py make FOLDER      write NAME.x3p with x3pio and, beside it, NAME.f64: its points
                                        in the global frame in mm, and NAME.txt: how many are missing
    python readback.py heights IN OUT   heights of a map in metres as SurfaceTopography reads it, rows
                                        in the order of the file, x fastest, missing ones NaN

`*.f64` and `*.i32` are raw little-endian numbers. x3pio is needed for `written` and `make`;
SurfaceTopography and plyfile are used where they are installed, and named in the output.
"""

import sys
from pathlib import Path

import numpy as np


def same(what, found, expected):
    """Compare two arrays bit for bit, any NaN being equal to any other."""
    found, expected = np.asarray(found, float).ravel(), np.asarray(expected, float).ravel()
    if found.shape != expected.shape:
        sys.exit(f"{what}: {found.size} values, expected {expected.size}")
    both_nan = np.isnan(found) & np.isnan(expected)
    different = np.flatnonzero(~both_nan & (found.view(np.int64) != expected.view(np.int64)))
    if different.size:
        at = different[0]
        sys.exit(f"{what}: value {at} is {found[at]!r}, expected {expected[at]!r}")
    print(f"same: {what}, {found.size} values")


def written(folder):
    import x3pio

    nx, ny, *lengths_m = np.fromfile(folder / "map.f64", "<f8", 6)
    nx, ny = int(nx), int(ny)
    z_m = np.fromfile(folder / "map.f64", "<f8", offset=48).reshape(ny, nx)
    surface = x3pio.read(folder / "map.x3p")
    header, offset = surface.header, surface.placement.offset
    same("x3pio, map", surface.layers[0].z, z_m)
    found = [header.x.increment, header.y.increment, offset[0], offset[1]]
    same("x3pio, increments and offsets", found, lengths_m)
    same("x3pio, offset and increment of z", [offset[2], header.z.increment], [0.0, 1.0])

    cloud = x3pio.read(folder / "cloud.x3p")
    same("x3pio, cloud", cloud.layers[0].points(), np.fromfile(folder / "cloud.f64", "<f8"))

    try:
        from SurfaceTopography import open_topography
    except ImportError:
        print("skipped: SurfaceTopography not found")
    else:
        topography = open_topography(str(folder / "map.x3p")).topography()
        heights = np.ma.filled(topography.heights(), np.nan).T
        same("SurfaceTopography, map", heights, z_m)

    try:
        from plyfile import PlyData
    except ImportError:
        print("skipped: plyfile not found")
    else:
        ply = PlyData.read(str(folder / "mesh.ply"))
        vertex = ply["vertex"].data
        columns = np.column_stack([vertex[name] for name in ("x", "y", "z", "deviation_mm")])
        same("plyfile, vertices", columns, np.fromfile(folder / "mesh.f64", "<f8"))
        corners = np.vstack(ply["face"].data["vertex_indices"])
        same("plyfile, triangles", corners, np.fromfile(folder / "mesh.i32", "<i4"))
        if ply.comments != ["lengths in mm"]:
            sys.exit(f"plyfile, comments: {ply.comments}")


def make(folder):
    import x3pio

    rng = np.random.default_rng(20260131)
    y, x = np.mgrid[0:7, 0:11] * 1e-6
    z = 1e-6 * rng.normal(size=x.shape)
    z[2, 3:6] = np.nan
    grid = np.stack([x + 0.3e-6 * rng.normal(size=x.shape), y, z], axis=-1)
    placement = x3pio.Placement.translation(1e-3, -2e-3, 0.5) @ x3pio.Placement.from_axis_angle(
        [1.0, 2.0, 3.0], 0.7
    )
    placed = {"placement": placement, "coordinate_system": x3pio.CoordinateSystem.VIEW}
    shifted = {**placed, "placement": x3pio.Placement.translation(1e-3, -2e-3, 0.5)}
    scales = {"x_scale": 1e-6, "y_scale": 2e-6}
    types = x3pio.DataType
    files = {
        "shifted": x3pio.Surface.from_array(z, **scales, **shifted),
        "placed": x3pio.Surface.from_array(z, **scales, **placed),
        "irregular": x3pio.Surface.from_points(grid),
        "irregular_placed": x3pio.Surface.from_points(grid, **placed),
        "cloud_placed": x3pio.PointCloud.from_points(grid[~np.isnan(z)], **placed),
    }
    for data_type in (types.INT16, types.INT32, types.FLOAT32):
        name = data_type.name.lower()
        files[f"map_{name}"] = x3pio.Surface.from_array(z, **scales, z_type=data_type)
        files[f"cloud_{name}"] = x3pio.PointCloud.from_points(
            grid[~np.isnan(z)], data_type=data_type
        )
    for name, file in files.items():
        for storage in x3pio.DataStorage:
            path = folder / f"{name}_{storage.name.lower()}.x3p"
            file.save(path, storage=storage)
            # Read anew, so that the points are rounded to the stored type.
            layer = x3pio.read(path).layers[0]
            points = layer.points(coordinate_system=x3pio.CoordinateSystem.GLOBAL).reshape(-1, 3)
            measured = np.isfinite(points).all(axis=1)
            (points[measured] * 1e3).astype("<f8").tofile(path.with_suffix(".f64"))
            path.with_suffix(".txt").write_text(str(int((~measured).sum())))
    layers = x3pio.Surface.from_layers([z, z], **scales)
    layers.save(folder / "layers.x3p")
    x3pio.Profile.from_array(z[0], x_scale=1e-6).save(folder / "profile.x3p")


def heights(source, target):
    from SurfaceTopography import open_topography

    topography = open_topography(str(source)).topography()
    factor = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9}[topography.unit]
    z_m = np.ma.filled(topography.heights(), np.nan).T * factor
    z_m.astype("<f8").tofile(target)


if __name__ == "__main__":
    command, *paths = sys.argv[1:]
    {"written": written, "make": make, "heights": heights}[command](*map(Path, paths))
