"""Heights of shapes and their derivatives in 60 decimal digits, for sixty_digits.rs.

Every shape is written here as its definition, without care for rounding; derivatives are central differences
with a step of 1e-12, which in 60 digits are good to 20 and more. Needs nothing but Python:

    python3 tables.py > tables.txt

A line: kind; numbers of the shape; x, y; z; dz/dx, dz/dy; d2z/dx2, d2z/dxdy, d2z/dy2; dz/dparameter ....
"""

from decimal import Decimal, getcontext
from math import comb

getcontext().prec = 60
D = Decimal
STEP = D(10) ** -12


def conic(radius, kappa, t):
    return t / radius / (1 + (1 - (1 + kappa) * t / radius**2).sqrt())


def sin_cos(angle):
    sine, term, n = D(0), angle, 1
    while abs(term) > D(10) ** -65:
        sine += term
        term = -term * angle * angle / ((n + 1) * (n + 2))
        n += 2
    return sine, (1 - sine * sine).sqrt()


def even(p, x, y):
    radius, kappa, a2, a4, a10 = p
    t = x * x + y * y
    return conic(radius, kappa, t) + a2 * t + a4 * t**2 + a10 * t**5


def odd(p, x, y):
    radius, kappa, a1, a3, a4 = p
    t = x * x + y * y
    r = t.sqrt()
    return conic(radius, kappa, t) + a1 * r + a3 * r**3 + a4 * r**4


def acylinder(p, x, y):
    radius, kappa, a4 = p
    return conic(radius, kappa, x * x) + a4 * x**4


def biconic(p, x, y):
    rx, kx, ry, ky = p
    root = 1 - (1 + kx) * x * x / rx**2 - (1 + ky) * y * y / ry**2
    return (x * x / rx + y * y / ry) / (1 + root.sqrt())


def toroid(p, x, y):
    rotation, radius, kappa, a2, a6 = p
    f = conic(radius, kappa, y * y) + a2 * y**2 + a6 * y**6
    root = ((rotation - f) ** 2 - x * x).sqrt()
    return rotation - root.copy_sign(rotation)


def q_bfs_polynomials(x, count):
    f, g, h = [D(2), D(19).sqrt() / 2], [D("-0.5")], [D("-0.5")]
    g.append(-(1 + g[0] * h[0]) / f[1])
    h.append(-D(3) / f[1])
    big, q = [D(2), 6 - 8 * x], [D(1), (13 - 16 * x) / D(19).sqrt()]
    for n in range(2, count):
        f.append((n * (n + 1) + 3 - g[n - 1] ** 2 - h[n - 2] ** 2).sqrt())
        g.append(-(1 + g[n - 1] * h[n - 1]) / f[n])
        h.append(-D((n + 2) * (n + 1)) / (2 * f[n]))
        big.append((2 - 4 * x) * big[-1] - big[-2])
        q.append((big[n] - g[n - 1] * q[n - 1] - h[n - 2] * q[n - 2]) / f[n])
    return q


def q_bfs(projection, rho_max):
    def sag(p, x, y):
        radius, kappa, *a = p
        t = x * x + y * y
        w, u2 = t / radius**2, t / rho_max**2
        sphere = 1 / (1 - w).sqrt() if w < 1 else None
        factor = {
            "axis": D(1),
            "sphere": sphere,
            "conic": ((1 - kappa * w) / (1 - (1 + kappa) * w)).sqrt(),
        }[projection]
        total = sum(c * q for c, q in zip(a, q_bfs_polynomials(u2, max(2, len(a)))))
        return conic(radius, kappa, t) + factor * u2 * (1 - u2) * total

    return sag


def q_con(rho_max):
    def jacobi(m, x):
        """P_m^(0,4)(2x-1) by its sum (DLMF 18.5.8)."""
        terms = (comb(m, s) * comb(m + 4, m - s) * (x - 1) ** (m - s) * x**s for s in range(m + 1))
        return sum(terms)

    def sag(p, x, y):
        radius, kappa, *a = p
        t = x * x + y * y
        u2 = t / rho_max**2
        total = sum(c * jacobi(m, u2) for m, c in enumerate(a))
        return conic(radius, kappa, t) + u2 * u2 * total

    return sag


def newton(function, guess):
    """The zero of a function next to a guess, by Newton's method with differences."""
    z = guess
    for _ in range(60):
        rate = (function(z + STEP) - function(z - STEP)) / (2 * STEP)
        change = function(z) / rate
        z -= change
        if abs(change) < D(10) ** -45:
            return z
    raise ArithmeticError("no zero")


def mirror(revolved):
    """The place where the distances to source and image, with signs, add up to p + q."""

    def sag(parameters, x, y):
        p, q, theta = parameters
        sine, cosine = sin_cos(theta)
        y = y if revolved else D(0)

        def excess(z):
            before = ((x + p * cosine) ** 2 + y * y + (z - p * sine) ** 2).sqrt()
            after = ((x - q * cosine) ** 2 + y * y + (z - q * sine) ** 2).sqrt()
            return before.copy_sign(p) + after.copy_sign(q) - p - q

        h = 1 / (1 / p + 1 / q)
        return newton(excess, (sine * x * x + y * y / sine) / (4 * h))

    return sag


def off_axis(parent, numbers, dx, dy):
    """The parent in the frame at (dx, dy) whose z is the normal of the parent with these numbers."""
    slope_x, slope_y = gradient(parent, numbers, dx, dy)
    length = (1 + slope_x**2 + slope_y**2).sqrt()
    a, b, c = -slope_x / length, -slope_y / length, 1 / length
    e1 = (1 - a * a / (1 + c), -a * b / (1 + c), -a)
    e2 = (-a * b / (1 + c), 1 - b * b / (1 + c), -b)

    def sag(p, u, v):
        origin = (dx, dy, parent(p, dx, dy))

        def above(w):
            x, y, z = (o + u * i + v * j + w * k for o, i, j, k in zip(origin, e1, e2, (a, b, c)))
            return z - parent(p, x, y)

        return newton(above, D(0))

    return sag


def gradient(sag, p, x, y):
    h = STEP
    return (
        (sag(p, x + h, y) - sag(p, x - h, y)) / (2 * h),
        (sag(p, x, y + h) - sag(p, x, y - h)) / (2 * h),
    )


def line(kind, sag, numbers, places, fixed=()):
    p = [D(n) for n in numbers]
    h = STEP
    for place in places:
        x, y = D(place[0]), D(place[1])
        z = sag(p, x, y)
        xx = (sag(p, x + h, y) - 2 * z + sag(p, x - h, y)) / h**2
        yy = (sag(p, x, y + h) - 2 * z + sag(p, x, y - h)) / h**2
        corners = sag(p, x + h, y + h) - sag(p, x + h, y - h) - sag(p, x - h, y + h)
        xy = (corners + sag(p, x - h, y - h)) / (4 * h**2)
        by = []
        for i in range(len(p)):
            step = STEP * max(abs(p[i]), D("1e-6"))
            up, down = [[*p[:i], p[i] + s, *p[i + 1 :]] for s in (step, -step)]
            by.append((sag(up, x, y) - sag(down, x, y)) / (2 * step))
        fields = [
            (*numbers, *fixed),
            place,
            (z,),
            gradient(sag, p, x, y),
            (xx, xy, yy),
            by,
        ]
        texts = (" ".join(repr(float(n)) for n in field) for field in fields)
        print("; ".join([kind, *texts]))


def main():
    near = [(2.0, -1.5), (0.0, 3.0), (-0.01, 0.02)]
    far = [(6.0, 5.0), (-3.0, 7.0)]
    line("even", even, (11.65, -1.1, 1e-4, 3.7e-5, -1e-10), near + far)
    line("even", even, (-300.0, 2.5, -2e-5, 1e-7, 1e-13), near + far)
    line("odd", odd, (40.0, -0.5, 0.01, -2e-4, 1e-5), near + far)
    line("acylinder", acylinder, (-25.0, 0.7, 1e-5), near + far)
    line("biconic", biconic, (20.0, -0.3, -35.0, 1.7), near + far)
    line("biconic", biconic, (1e6, 0.0, 50.0, -4.0), near + far)
    line("toroid", toroid, (100.0, 50.0, -0.5, 1e-5, 1e-9), near + far)
    line("toroid", toroid, (-30.0, 25.0, -3.0, 1e-4, -2e-8), near + far)
    line("toroid", toroid, (1e5, -2e4, 0.0, 0.0, 0.0), near + far)
    a = (-0.81, -0.32, 0.1, -0.05, 0.01, -0.002)
    for projection in ("axis", "sphere", "conic"):
        sag = q_bfs(projection, D(13.0))
        line(f"q_bfs_{projection}", sag, (17.37, -0.676, *a), near + far, (13.0,))
    line("q_con", q_con(D(13.0)), (-17.37, 0.4, *a), near + far, (13.0,))
    along = [(-120.0, 0.0), (0.5, 0.3), (150.0, -0.8)]
    for p, q, theta in [
        (30000.0, 500.0, 0.003),
        (1000.0, 1000.0, 0.02),
        (400.0, -3000.0, 0.01),
        (-5000.0, 300.0, 0.02),
        (-400.0, -900.0, 0.3),
        (2500.0, 800.0, 0.8),
    ]:
        line("cylindrical", mirror(False), (p, q, theta), along)
        line("revolved", mirror(True), (p, q, theta), along)
    parent = (60.0, -0.8, 1e-4, 2e-6, 0.0)
    section = off_axis(even, [D(n) for n in parent], D(9.0), D(-4.0))
    line("off_axis", section, parent, near, (9.0, -4.0))


if __name__ == "__main__":
    main()
