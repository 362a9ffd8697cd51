"""Makes minimum_zone.txt: minimum zones by SciPy, for the tests of the crate asphera-form.

Run: python3 minimum_zone.py > minimum_zone.txt
Needs numpy and scipy (the file there: numpy 2.4.6, scipy 1.17.1).

The distances are those of reference.py, without any of the crate's formulas. From a least-squares start the
problem is made linear by central differences, solved by the simplex method of HiGHS, and made linear anew
until the zone no longer becomes narrower. A line holds the case, the parameters, the offset and the width of
the zone, in mm and rad.
"""

import numpy as np
from reference import AL1815, distance, made, solve
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

STEPS = {"mm": 1e-4, "rad": 1e-5, "conic": 1e-3}


def zone(name, function, start, units, offset):
    q = solve(function, start).x
    best = None
    for _ in range(30):
        d = function(q)
        jacobian = np.empty((len(d), len(q)))
        for j, unit in enumerate(units):
            h = np.zeros(len(q))
            h[j] = STEPS[unit]
            jacobian[:, j] = (function(q + h) - function(q - h)) / (2.0 * h[j])
        middle = 0.5 * (d.max() + d.min()) if offset else 0.0
        half = np.abs(d - middle).max()
        if best is not None and half > best[0] * (1.0 - 1e-13):
            break
        best = (half, q, middle)
        # Unknowns: scaled steps, offset, half width; all in half widths.
        lengths = np.linalg.norm(jacobian, axis=0) / np.sqrt(len(d))
        a = np.column_stack([jacobian / lengths, -np.ones(len(d)) if offset else np.zeros(len(d))])
        b = (d - middle) / half
        one = np.ones((len(d), 1))
        found = linprog(
            [0.0] * a.shape[1] + [1.0],
            A_ub=np.vstack([np.hstack([a, -one]), np.hstack([-a, -one])]),
            b_ub=np.concatenate([-b, b]),
            bounds=[(-100.0, 100.0)] * a.shape[1] + [(0.0, None)],
            method="highs-ds",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        assert found.status == 0, found.message
        q = q + found.x[: len(q)] * half / lengths
    half, q, middle = best
    print(name, *(f"{number:.17e}" for number in [*q, middle, 2.0 * half]))


def asphere():
    pose = np.array([0.03, -0.02, 0.4, 5e-4, -3e-4, 0.0])
    points = made(400, 9.0, AL1815, 1e-3, pose)
    rigid = lambda q: distance(points, np.append(q, 0.0), AL1815)
    units = ["mm"] * 3 + ["rad"] * 2
    zone("asphere_range", rigid, pose[:5], units, True)
    zone("asphere_centred", rigid, pose[:5], units, False)
    shape = lambda q: distance(points, np.append(q[:5], 0.0), (q[5], q[6], AL1815[2]))
    zone("asphere_shape", shape, [*pose[:5], 11.65, -1.1], [*units, "mm", "conic"], False)


def sphere():
    pose = np.array([120.0, -80.0, 15.0, 0.0, 0.0, 0.0])
    points = made(300, 12.0, (-40.0, 0.0, []), 1e-2, pose)

    def function(q):
        centre = q[:3] + [0.0, 0.0, q[3]]
        return np.sign(q[3]) * (abs(q[3]) - np.linalg.norm(points - centre, axis=1))

    zone("sphere_free", function, [*pose[:3], -40.0], ["mm"] * 4, False)
    zone("sphere_range", lambda q: function(np.append(q, -40.0)), pose[:3], ["mm"] * 3, True)


def plane():
    pose = np.array([0.0, 0.0, 7.0, 0.3, -0.2, 0.0])
    points = made(500, 12.0, (np.inf, 0.0, []), 1e-3, pose)

    def function(q):
        return Rotation.from_euler("xyz", [q[1], q[2], 0.0]).inv().apply(points - [0.0, 0.0, q[0]])[:, 2]

    zone("plane", function, [7.0, 0.3, -0.2], ["mm", "rad", "rad"], False)


asphere()
sphere()
plane()
