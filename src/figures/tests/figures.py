"""Makes figures.txt: figures of a deviation by NumPy, SciPy and prysm, for the tests of the crate asphera-figures.

Run: python3 figures.py > figures.txt
Needs numpy, scipy and prysm; made with numpy 2.4.6, scipy 1.17.1, prysm 0.21.1.

Nothing here uses the crate's formulas: fits are dense least squares on prysm's polynomials, the azimuthal
mean on numpy.interp's hat functions, slopes plain planes by brute force. Points come from a Weyl sequence.
"""

import numpy as np
from prysm.interferogram import psd
from prysm.polynomials import Qbfs_sequence, fringe_to_nm, zernike_nm_sequence

RADIUS = 2.0


def sample(count):
    i = np.arange(1, count + 1)
    u, v, w, a = (np.mod(i * f, 1.0) for f in (0.8191725133961645, 0.6710436067037893, 0.5497004779019703,
                                               0.3247179572447460))
    r, phi = RADIUS * np.sqrt(u), 2.0 * np.pi * v
    x, y = r * np.cos(phi), r * np.sin(phi)
    return x, y, height(x, y) + 5.0 * (2.0 * w - 1.0), 1.0 + a


def height(x, y):
    return 80.0 * np.sin(1.3 * x + 0.5 * y) + 40.0 * x * y * np.exp(-0.3 * (x * x + y * y)) + 30.0 * (x * x + y * y)


def show(name, *values):
    print(name, *(repr(float(v)) for v in np.concatenate([np.ravel(v) for v in values])))


def fit(columns, z, weights):
    root = np.sqrt(weights)
    return np.linalg.lstsq(columns * root[:, None], z * root, rcond=None)[0]


def fringe(x, y, last):
    r, t = np.hypot(x, y) / RADIUS, np.arctan2(y, x)
    # prysm counts on beyond 36 by rule, (6, 6); the set of the University of Arizona ends with (12, 0).
    orders = [(12, 0) if j == 37 else fringe_to_nm(j) for j in range(1, last + 1)]
    return np.column_stack(list(zernike_nm_sequence(orders, r, t, norm=False)))


def rms(z, weights):
    return np.sqrt(np.average(z**2, weights=weights))


x, y, z, a = sample(3000)
one = np.ones_like(z)
show("rms", rms(z, a), rms(z - np.average(z, weights=a), a))
low, high = (np.quantile(s * z, 0.005, weights=a, method="inverted_cdf") for s in (1, -1))
show("robust", -high - low)
show("fringe", fit(fringe(x, y, 37), z, a))
for last in (36, 37):
    columns = fringe(x, y, last)
    fitted = columns @ fit(columns, z, one)
    show(f"pvr{last}", np.ptp(fitted) + 3.0 * rms(z - fitted, one))

# Piston, tilt, coma removed.
columns = fringe(x, y, 8)[:, [0, 1, 2, 6, 7]]
left = z - columns @ fit(columns, z, a)
show("removed", np.ptp(left), rms(left, a))

# ISO 10110-5 with ten intervals.
r = np.hypot(x, y)
knots = np.linspace(r.min(), r.max(), 11)
hats = np.column_stack([np.interp(r, knots, np.eye(11)[k]) for k in range(11)])
for name, form in (("quadratic", lambda r: r**2), ("sphere", lambda r: np.sqrt(3.0**2 - r**2))):
    columns = np.column_stack([one, x, y, form(r)])
    c = fit(columns, z, a)
    irregularity = z - columns @ c
    sphere = c[3] * form(r)
    total = irregularity + sphere - np.average(sphere, weights=a)
    mean = hats @ fit(hats, irregularity, a)
    show(name, abs(c[3] * (form(RADIUS) - form(0.0))), np.ptp(irregularity), np.ptp(mean), rms(total, a),
         rms(irregularity, a), rms(irregularity - mean, a))

u = r / RADIUS
# Coma, astigmatism of two orders and trefoil beside the series.
t = np.arctan2(y, x)
beside = [wave(m * t) * u**n for m, n in ((1, 3), (2, 2), (2, 4), (3, 3)) for wave in (np.cos, np.sin)]
qbfs = np.column_stack([u**2, *Qbfs_sequence(range(6), u), one, x, y, *beside])
show("qbfs", fit(qbfs, z, a)[:7])

# Slopes over 0.5 mm at every 0.25 mm.
found, unmeasured = [], 0
for j in range(-8, 9):
    for i in range(-8, 9):
        at = np.array([0.25 * i, 0.25 * j])
        if np.hypot(*at) > RADIUS:
            continue
        near = np.hypot(x - at[0], y - at[1]) <= 0.25
        p, q, w = (x[near] - at[0]) / 0.25, (y[near] - at[1]) / 0.25, a[near]
        good = near.sum() >= 6
        if good:
            spread = np.cov(p, q, aweights=w, ddof=0)
            centroid = np.hypot(np.average(p, weights=w), np.average(q, weights=w))
            good = centroid <= 0.25 and np.linalg.eigvalsh(spread)[0] >= 0.125
        if not good:
            unmeasured += 1
            continue
        g = fit(np.column_stack([np.ones_like(p), p, q]), z[near], w)[1:] / 0.25
        distance = np.hypot(*at)
        found.append((abs(g @ at) / distance if distance > 0 else np.hypot(*g), np.hypot(*g)))
found = np.array(found)
show("slopes", found[:, 0].max(), rms(found[:, 0], None), found[:, 1].max(), rms(found[:, 1], None), len(found), unmeasured)

gx, gy = np.meshgrid(0.25 * np.arange(10), 0.25 * np.arange(9))
data = height(gx, gy)
data = data - data.mean()
# The inverse of the shift prysm ends with, which for odd sizes is not its own.
show("psd", np.fft.fftshift(psd(data, 0.25, window=np.ones_like(data))[2]))
window = np.outer(*(np.sin(np.pi * (np.arange(k) + 0.5) / k) ** 2 for k in (9, 10)))
show("psd_hann", np.fft.fftshift(psd(data, 0.25, window=window)[2]))
