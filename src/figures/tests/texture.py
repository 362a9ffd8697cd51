"""Makes texture.txt: texture of a surface by other software, for the tests of the crate asphera-figures.

Run: python3 texture.py > texture.txt
Needs numpy, scipy, surfalize and SurfaceTopography; made with numpy 2.4.6, scipy 1.17.1, surfalize 0.19.2 and
SurfaceTopography 1.27.1.

Parameters are those of the two packages. Filters are scipy.ndimage's Gaussian of the heights over that of the
mask, or dense least squares by numpy node after node; nothing here uses the crate's formulas.
"""

import numpy as np
from scipy import ndimage
from surfalize import Surface
from surfalize.abbottfirestone import AbbottFirestoneCurve
from SurfaceTopography import Topography

ROWS, COLUMNS, DX, DY = 120, 150, 0.0025, 0.002
ALPHA = np.sqrt(np.log(2.0) / np.pi)
ALPHA_2 = 0.7309134280946759


def weyl(i, f):
    return np.mod(i * f, 1.0)


def height(x, y):
    z = np.zeros_like(x)
    for k in range(1, 41):
        fx, fy = 16.0 * weyl(k, 0.8191725133961645), 44.0 * weyl(k, 0.6710436067037893) - 22.0
        z += 12.0 * np.cos(2.0 * np.pi * (fx * x + fy * y + weyl(k * k, 0.5497004779019703)))
    return z - 0.003 * z * z


def grid(rows, columns):
    j, i = np.meshgrid(np.arange(columns), np.arange(rows))
    index = i * columns + j + 1
    return height(j * DX, i * DY) + 6.0 * weyl(index, 0.3247179572447460), index


def show(name, *values):
    print(name, *(repr(float(v)) for v in np.concatenate([np.ravel(v) for v in values])))


def level(z):
    i, j = np.indices(z.shape)
    columns = np.column_stack([np.ones(z.size), j.ravel(), i.ravel()])
    return z - (columns @ np.linalg.lstsq(columns, z.ravel(), rcond=None)[0]).reshape(z.shape)


z, index = grid(ROWS, COLUMNS)
flat = level(z)
surface = Surface(flat / 1e3, 1e3 * DX, 1e3 * DY)
show("heights", *(1e3 * v for v in (surface.Sa(), surface.Sq(), surface.Sp(), surface.Sv(), surface.Sz())),
     surface.Ssk(), surface.Sku())
# Heights and sizes in mm. SurfaceTopography's first axis is x.
topography = Topography((flat * 1e-6).T, (COLUMNS * DX, ROWS * DY))
show("topography", 1e6 * topography.rms_height_from_area(), 1e6 * topography.rms_gradient())
show("sdq", 1e6 * surface.Sdq())
right, down = np.diff(flat, axis=1) / DX, np.diff(flat, axis=0) / DY
show("sdq_cells", np.sqrt(np.mean(right[1:] ** 2 + right[:-1] ** 2 + down[:, 1:] ** 2 + down[:, :-1] ** 2) / 2.0))
# Heights a thousand times larger, so that the area does not drown in rounding.
show("sdr", Surface(flat, 1e3 * DX, 1e3 * DY).Sdr())
core = AbbottFirestoneCurve(surface, nbins=1_000_001)
show("core", 1e3 * core.k(), 1e3 * core.pk(), 1e3 * core.vk(), core.mr1(), core.mr2())
show("spatial", surface.Sal(), surface.Str())

# Filters: a quarter of the nodes are gaps.
CUTOFF = 0.03
mask = (weyl(index, 0.7548776662466927) >= 0.25).astype(float)


def regression(z, weights):
    sigma = [ALPHA * CUTOFF / np.sqrt(2.0 * np.pi) / d for d in (DY, DX)]
    radius = [int(CUTOFF / d) for d in (DY, DX)]
    blur = lambda a: ndimage.gaussian_filter(a, sigma, mode="constant", radius=radius)
    return blur(z * weights) / blur(weights)


STEP = 97
show("order0", regression(z, np.ones_like(z)).ravel()[::STEP])
show("order0_gaps", regression(z, mask).ravel()[::STEP][mask.ravel()[::STEP] > 0])

outliers = z + 900.0 * (weyl(index, 0.4301597090019467) < 0.04)
weights, limits = mask.copy(), []
for _ in range(6):
    r = np.abs(outliers - regression(outliers, weights))
    limits.append(4.4478 * np.median(r[mask > 0]))
    weights = mask * np.where(r < limits[-1], (1.0 - (r / limits[-1]) ** 2) ** 2, 0.0)
show("robust", limits[-1], regression(outliers, weights).ravel()[::STEP][mask.ravel()[::STEP] > 0])


def quadric(x, y, z, weights, at, radius, disc):
    reach = np.sqrt(np.pi / np.log(2.0)) * ALPHA_2 * radius * (1.0 + 1e-12)
    u, v = x - x[at], y - y[at]
    near = (np.hypot(u, v) <= reach if disc else (np.abs(u) <= reach) & (np.abs(v) <= reach)) & (weights > 0)
    u, v = u[near] / (ALPHA_2 * radius), v[near] / (ALPHA_2 * radius)
    root = np.sqrt(weights[near] * np.exp(-np.pi * (u * u + v * v)))
    columns = np.column_stack([np.ones_like(u), u, v, u * u, u * v, v * v])
    return np.linalg.lstsq(columns * root[:, None], z[near] * root, rcond=None)[0][0]


j, i = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
places = [(j * DX).ravel(), (i * DY).ravel()]
nodes = [n for n in range(0, z.size, STEP) if mask.ravel()[n] > 0]
show("order2_gaps", [quadric(*places, z.ravel(), mask.ravel(), n, CUTOFF, False) for n in nodes])

# A mesh: a lattice of 30 × 40 with moved nodes, each cell divided along the same diagonal, every seventh a gap.
rows, columns, pitch = 30, 40, 0.01
j, i = np.meshgrid(np.arange(columns), np.arange(rows))
n = (i * columns + j).ravel()
x = pitch * (j.ravel() + 0.6 * weyl(n + 1, 0.8191725133961645))
y = pitch * (i.ravel() + 0.6 * weyl(n + 1, 0.6710436067037893))
zm = height(x, y)
measured = n % 7 != 3
corner = (i[:-1, :-1] * columns + j[:-1, :-1]).ravel()
triangles = np.vstack([np.column_stack([corner, corner + 1, corner + columns]),
                       np.column_stack([corner + 1, corner + columns + 1, corner + columns])])
whole = triangles[measured[triangles].all(axis=1)]


def corners(t):
    return np.stack([x[t], y[t], zm[t] * 1e-6], axis=-1)


def areas(points):
    return 0.5 * np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1)


def projected(t):
    points = corners(t)
    points[:, :, 2] = 0.0
    return areas(points)


area = np.zeros_like(x)
np.add.at(area, whole.ravel(), np.repeat(projected(whole) / 3.0, 3))
mean = np.average(zm, weights=area)
used = area > 0
show("mesh_heights", np.average(np.abs(zm - mean), weights=area), np.sqrt(np.average((zm - mean) ** 2, weights=area)),
     area.sum() / projected(triangles).sum())
edges = corners(whole)
p, q = edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]
gradient = np.array([np.linalg.solve([a[:2], b[:2]], [a[2], b[2]]) for a, b in zip(p, q)])
square = np.sum(gradient**2, axis=1)
show("mesh_hybrid", 1e6 * np.sqrt(np.average(square, weights=projected(whole))),
     100.0 * np.average(square / 2.0 - square**2 / 8.0, weights=projected(whole)))


def mean_of(at, radius):
    distance = np.hypot(x - x[at], y - y[at])
    weights = np.where(distance <= radius, area * np.exp(-np.pi * (distance / (ALPHA * radius)) ** 2), 0.0)
    return np.sum(weights * np.where(measured, zm, 0.0)) / np.sum(weights)


nodes = [k for k in range(0, n.size, 11) if measured[k]]
show("mesh_order0", [mean_of(k, 0.05) for k in nodes])
show("mesh_order2", [quadric(x, y, zm, area, k, 0.05, True) for k in nodes])
