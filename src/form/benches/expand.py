"""The peer of expand.rs: prysm's Fringe terms and `lstsq` on a grid of 1000 x 1000 over the unit disc.

Prints seconds, the least of three: evaluation of the 37 terms, and their least squares.
"""

import time

import numpy as np
from prysm import polynomials
from prysm.coordinates import cart_to_polar, make_xy_grid

orders = [polynomials.fringe_to_nm(index) for index in range(1, 37)] + [(12, 0)]
x, y = make_xy_grid(1000, diameter=2)
r, t = cart_to_polar(x, y)
evaluation, squares = [], []
for _ in range(3):
    begin = time.perf_counter()
    modes = np.asarray(list(polynomials.zernike_nm_sequence(orders, r, t, norm=False)))
    evaluation.append(time.perf_counter() - begin)
    truth = np.arange(1, 38) / 10.0
    values = np.tensordot(truth, modes, 1)
    values[r > 1] = np.nan
    begin = time.perf_counter()
    found = polynomials.lstsq(modes, values)
    squares.append(time.perf_counter() - begin)
    assert np.abs(found - truth).max() < 1e-9
print(min(evaluation), min(squares), int(np.isfinite(values).sum()))
