"""Makes reference.txt: values of polynomial bases, for the tests of the crate asphera-form.

Run: python3 reference.py > reference.txt
Needs numpy, scipy, prysm 0.21.1 and poppy 1.1.2.

"exact" lines are made in rational arithmetic from the explicit sum of the radial polynomial, so that they
are correct to the last digit whatever the order; the others are what the named packages say.
"""

from fractions import Fraction as F
from math import factorial

import numpy as np
from poppy import zernike as poppy
from prysm.polynomials import qpoly, zernike as prysm
from scipy import special


# prysm 0.21.1 relies on (-1)!! = 1, which SciPy no longer gives.
factorial2 = special.factorial2
qpoly.special = type("Special", (), {
    "factorial": staticmethod(special.factorial),
    "factorial2": staticmethod(lambda n: 1.0 if n == -1 else factorial2(n)),
})


def power(u, v, m):
    re, im = F(1), F(0)
    for _ in range(m):
        re, im = re * u - im * v, re * v + im * u
    return re, im


def exact(n, m, u, v):
    """Value, gradient and Hessian of the term of unit height, from sums of monomials."""
    a, s = abs(m), u * u + v * v
    top = (n - a) // 2
    coefficients = {
        top - k: F((-1) ** k * factorial(n - k), factorial(k) * factorial((n + a) // 2 - k) * factorial(top - k))
        for k in range(top + 1)
    }
    p = sum(c * s**j for j, c in coefficients.items())
    p1 = sum(c * j * s ** (j - 1) for j, c in coefficients.items() if j > 0)
    p2 = sum(c * j * (j - 1) * s ** (j - 2) for j, c in coefficients.items() if j > 1)
    pick = (lambda pair: pair[0]) if m >= 0 else (lambda pair: pair[1])
    turned = lambda pair: (-pair[1], pair[0])
    zero = (F(0), F(0))
    one = tuple(a * x for x in power(u, v, a - 1)) if a > 0 else zero
    two = tuple(a * (a - 1) * x for x in power(u, v, a - 2)) if a > 1 else zero
    h, hu, hv, huu, huv = pick(power(u, v, a)), pick(one), pick(turned(one)), pick(two), pick(turned(two))
    return [
        p * h,
        2 * u * p1 * h + p * hu,
        2 * v * p1 * h + p * hv,
        (2 * p1 + 4 * u * u * p2) * h + 4 * u * p1 * hu + p * huu,
        4 * u * v * p2 * h + 2 * u * p1 * hv + 2 * v * p1 * hu + p * huv,
        (2 * p1 + 4 * v * v * p2) * h + 4 * v * p1 * hv - p * huu,
    ]


def line(name, *numbers):
    print(name, *(repr(float(x)) for x in numbers))


places = [(0.3, -0.7), (-0.1, 0.05), (0.6, 0.8), (0.0, 0.0), (-0.95, 0.2)]

for n, m in [(0, 0), (1, -1), (2, 2), (3, -1), (4, 0), (5, 3), (8, -6), (11, 1), (20, 0), (20, -14), (37, 5),
             (60, 0), (60, 2), (60, -30), (60, 60), (59, -57)]:
    for u, v in [(F(3, 8), F(-5, 8)), (F(0), F(0)), (F(-1, 64), F(1, 128)), (F(3, 4), F(5, 8)), (F(1), F(0))]:
        line("exact", n, m, u, v, *exact(n, m, u, v))

for n in range(11):
    for m in range(-n, n + 1, 2):
        for u, v in places:
            r, t = np.hypot(u, v), np.arctan2(v, u)
            r, t = np.array([r]), np.array([t])
            line("prysm", n, m, u, v, prysm.zernike_nm(n, m, r, t, norm=False)[0],
                 prysm.zernike_nm(n, m, r, t, norm=True)[0])
            line("poppy", n, m, u, v, poppy.zernike(n, m, rho=r, theta=t, outside=0.0)[0])

for n in range(0, 11):
    for m in [0, 1, -1, 2, -2, 3, -4, 5, -8]:
        for u, v in places:
            r, t = np.array([np.hypot(u, v)]), np.array([np.arctan2(v, u)])
            line("q2d", n, m, u, v, qpoly.Q2d(n, m, r, t)[0])

for i, j in [(0, 0), (1, 0), (0, 2), (3, 4), (7, 7), (20, 3), (63, 31)]:
    for u, v in places:
        line("chebyshev", i, j, u, v, special.eval_chebyt(i, u) * special.eval_chebyt(j, v))
        line("legendre", i, j, u, v, special.eval_legendre(i, u) * special.eval_legendre(j, v))
        line("powers", i, j, u, v, u**i * v**j)
