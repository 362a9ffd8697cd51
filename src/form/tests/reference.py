"""Makes reference.txt: fits by SciPy, for the tests of the crate asphera-form.

Run: python3 reference.py [XYZ-FILE] > reference.txt
Needs numpy and scipy. The optional file is mirrors/xmf_02_hyperbolic_cylinder.xyz of the shared data;
without it the lines that begin with "xmf" are left out.

The orthogonal distance is computed here without any of the crate's formulas: the foot is found by a
bounded scalar root search on the meridian (brentq), and the Jacobian by SciPy's own three-point
differences. Points come from a Weyl sequence, which any language reproduces exactly enough.
"""

import sys

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.spatial.transform import Rotation

AL1815 = (11.65, -1.1, [3.69067205091e-5, -1.285461192617e-8, -1.400167659754e-10, -2.51311664812e-13,
                        5.01789877647e-16, 5.855871513042e-18, -1.127794407419e-20])


def sag(r, shape):
    radius, conic, a = shape
    c = 1.0 / radius
    z = c * r**2 / (1.0 + np.sqrt(1.0 - (1.0 + conic) * c**2 * r**2))
    return z + sum(value * r ** (4 + 2 * i) for i, value in enumerate(a))


def slope(r, shape):
    radius, conic, a = shape
    c = 1.0 / radius
    s = c * r / np.sqrt(1.0 - (1.0 + conic) * c**2 * r**2)
    return s + sum((4 + 2 * i) * value * r ** (3 + 2 * i) for i, value in enumerate(a))


def distance(points, pose, shape):
    """Signed orthogonal distance of points of the measured frame."""
    part = Rotation.from_euler("xyz", pose[3:]).inv().apply(points - pose[:3])
    out = []
    for x, y, zeta in part:
        rho = np.hypot(x, y)
        g = lambda s: (s - rho) + (sag(s, shape) - zeta) * slope(s, shape)
        s = rho if g(rho) == 0.0 else brentq(g, max(0.0, rho - 0.5), rho + 0.5, xtol=1e-15, rtol=1e-15)
        out.append(np.copysign(np.hypot(rho - s, zeta - sag(s, shape)), zeta - sag(s, shape)))
    return np.array(out)


def weyl(count, radius):
    """Places spread over a disc, and heights in [-1, 1)."""
    i = np.arange(1, count + 1)
    u, v, w = (np.mod(i * f, 1.0) for f in (0.8191725133961645, 0.6710436067037893, 0.5497004779019703))
    r, phi = radius * np.sqrt(u), 2.0 * np.pi * v
    return r * np.cos(phi), r * np.sin(phi), 2.0 * w - 1.0


def made(count, radius, shape, roughness, pose):
    x, y, w = weyl(count, radius)
    part = np.column_stack([x, y, sag(np.hypot(x, y), shape) + roughness * w])
    return Rotation.from_euler("xyz", pose[3:]).apply(part) + pose[:3]


def solve(function, start):
    return least_squares(function, start, jac="3-point", x_scale="jac", ftol=1e-15, xtol=1e-15, gtol=1e-15)


def line(name, result, count):
    sigma = np.sqrt(2.0 * result.cost / (count - len(result.x)))
    u = sigma * np.sqrt(np.diag(np.linalg.inv(result.jac.T @ result.jac)))
    numbers = [*result.x, *u, np.sqrt(2.0 * result.cost / count)]
    print(name, *(f"{number:.17e}" for number in numbers))


def asphere_rigid():
    pose = np.array([0.03, -0.02, 0.4, 5e-4, -3e-4, 0.0])
    points = made(400, 9.0, AL1815, 1e-3, pose)
    line("asphere_rigid", solve(lambda q: distance(points, np.append(q, 0.0), AL1815), pose[:5]), 400)


def asphere_shape():
    pose = np.array([0.03, -0.02, 0.4, 5e-4, -3e-4, 0.0])
    points = made(400, 9.0, AL1815, 1e-3, pose)
    function = lambda q: distance(points, np.append(q[:5], 0.0), (q[5], q[6], AL1815[2]))
    line("asphere_shape", solve(function, [*pose[:5], 11.65, -1.1]), 400)


def sphere_free():
    pose = np.array([120.0, -80.0, 15.0, 0.0, 0.0, 0.0])
    points = made(300, 12.0, (-40.0, 0.0, []), 1e-2, pose)

    def function(q):
        centre = q[:3] + [0.0, 0.0, q[3]]
        return np.sign(q[3]) * (abs(q[3]) - np.linalg.norm(points - centre, axis=1))

    line("sphere_free", solve(function, [*pose[:3], -40.0]), 300)


def mirror(path):
    points = np.loadtxt(path)

    def plane(q):
        return Rotation.from_euler("xyz", [q[1], q[2], 0.0]).inv().apply(points - [0.0, 0.0, q[0]])[:, 2]

    fitted = solve(plane, [0.0, 0.0, 0.0])
    # The smallest singular value of the centred points is the root of the same sum of squares.
    centred = points - points.mean(axis=0)
    rms = np.linalg.svd(centred, compute_uv=False)[-1] / np.sqrt(len(points))
    print("xmf_plane", *(f"{number:.17e}" for number in [*fitted.x, rms]))

    middle, scale = points.mean(axis=0), 1e4

    def sphere(q):
        # Scaled about the middle: vertex height and slopes in place of a centre metres away.
        vertex = middle + [q[0] * scale, q[1] * scale, q[2]]
        radius = q[3] * scale
        v = points - vertex
        square = (v**2).sum(axis=1) - 2.0 * v[:, 2] * radius
        return -square / (np.sqrt(square + radius**2) + radius)

    fitted = solve(sphere, [0.0, 0.0, 0.0, 3.0])
    rms = np.sqrt(2.0 * fitted.cost / len(points))
    print("xmf_sphere", f"{fitted.x[3] * scale:.17e}", f"{rms:.17e}")


if __name__ == "__main__":
    asphere_rigid()
    asphere_shape()
    sphere_free()
    if len(sys.argv) > 1:
        mirror(sys.argv[1])
