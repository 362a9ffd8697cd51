"""Parts of every kind of nominal, made from their defining equations: python3 shapes.py FOLDER

For each kind it writes NAME.toml (the nominal) or NAME.zmx (a Zemax lens file whose surface 1 it is), NAME-true.xyz (the design moved,
nothing else), NAME-formed.xyz (with a form deviation) and, with the values that a fit must find, an entry of cases.json. Heights are those of NumPy and prysm 0.21 (Zernike and
Forbes polynomials) and of formulae written down here; nothing is taken from the program under test.

The deviation is made by Forbes and Minh, "Generation of numerical artefacts for geometric form and tolerance assessment" (Int. J.
Metrol. Qual. Eng. 3 (2012) 145): points x on the surface with normals n, any deviation d, of which the part is removed that lies in
the columns of the Jacobian of the distances by the parameters of the fit. Then x + d·n has the chosen parameters as its exact
orthogonal least-squares solution, and d as its residuals.
"""

import json
import sys
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev, legendre
from prysm import polynomials as prysm
from prysm.polynomials import qpoly
from scipy import special

# Forbes's constants take (-1)!! = 1, which SciPy no longer gives; without it prysm's terms with m = ±1 are not numbers.
qpoly.special = type("Special", (), {
    "factorial": staticmethod(special.factorial),
    "factorial2": staticmethod(lambda n: 1.0 if n == -1 else special.factorial2(n)),
})

POINTS = 5000
POSE = {"tx": 0.3, "ty": -0.2, "tz": 0.25, "rx": 0.0087, "ry": -0.007, "rz": 0.006}
ROUND = ("tx", "ty", "tz", "rx", "ry")
WHOLE = (*ROUND, "rz")


def conic(t, radius, kappa):
    """Height of a conic at t = r²."""
    c = 1 / radius
    return c * t / (1 + np.sqrt(1 - (1 + kappa) * c * c * t))


def powers(r, terms):
    return sum(value * r**order for order, value in terms.items())


def polar(x, y, scale):
    return np.hypot(x, y) / scale, np.arctan2(y, x)


def even(terms):
    def sag(x, y, p):
        t = x * x + y * y
        base = conic(t, p["radius"], p.get("conic", 0.0)) if "radius" in p else 0.0
        own = {order: p.get(f"A{order}", value) for order, value in terms.items()}
        return base + powers(np.sqrt(t), own)

    return sag


def forbes(kind, scale, coefficients):
    def sag(x, y, p):
        t = x * x + y * y
        u = np.sqrt(t) / scale
        flat = "radius" not in p
        c, k = (0.0, 0.0) if flat else (1 / p["radius"], p.get("conic", 0.0))
        base = 0.0 if flat else conic(t, p["radius"], k)
        slope = c * np.sqrt(t) / np.sqrt(1 - (1 + k) * c * c * t) if kind == "conic-normal" else 0.0
        factor = 1 / np.sqrt(1 - c * c * t) if kind == "sphere-normal" else np.sqrt(1 + slope**2)
        poly = prysm.Qcon if kind == "con" else prysm.Qbfs
        total = sum(p.get(f"Q{m}", value) * poly(m, u) for m, value in enumerate(coefficients))
        return base + total * factor

    return sag


def over_base(departure):
    def sag(x, y, p):
        base = conic(x * x + y * y, p["radius"], p.get("conic", 0.0)) if "radius" in p else 0.0
        return base + departure(x, y, p)

    return sag


def zernike(count, norm, scale, terms):
    orders = {
        # The 37th of the University of Arizona is the next of revolution; prysm counts on.
        "fringe": lambda index: (12, 0) if index == 37 else prysm.fringe_to_nm(index),
        "noll": prysm.noll_to_nm,
        "ansi": prysm.ansi_j_to_nm,
        "orders": lambda nm: nm,
    }[count]

    def departure(x, y, p):
        u, phi = polar(x, y, scale)
        total = 0.0
        for index, value in terms.items():
            n, m = orders(index)
            name = f"Z({n},{m})" if count == "orders" else f"Z{index}"
            total = total + p.get(name, value) * prysm.zernike_nm(n, m, u, phi, norm=norm)
        return total

    return over_base(departure)


def q2d(scale, terms):
    def sag(x, y, p):
        u, phi = polar(x, y, scale)
        c = 1 / p["radius"] if "radius" in p else 0.0
        t = x * x + y * y
        total = sum(value * prysm.Q2d(n, m, u, phi) for (n, m), value in terms.items())
        return (conic(t, 1 / c, 0.0) if c else 0.0) + total / np.sqrt(1 - c * c * t)

    return sag


def product(family, half_x, half_y, terms):
    table = np.zeros((1 + max(i for i, _ in terms), 1 + max(j for _, j in terms)))
    for (i, j), value in terms.items():
        table[i, j] = value
    value_of = {"chebyshev": chebyshev.chebval2d, "legendre": legendre.legval2d}.get(
        family, np.polynomial.polynomial.polyval2d
    )
    return over_base(lambda x, y, p: value_of(x / half_x, y / half_y, table))


def cylinder(along, terms):
    def sag(x, y, p):
        s = x if along == "y" else y
        own = {order: p.get(f"A{order}", value) for order, value in terms.items()}
        return conic(s * s, p["radius"], p.get("conic", 0.0)) + powers(s, own)

    return sag


def biconic(x, y, p):
    cx = 1 / p["radius_x"] if "radius_x" in p else 0.0
    cy = 1 / p["radius_y"] if "radius_y" in p else 0.0
    kx, ky = p.get("conic_x", 0.0), p.get("conic_y", 0.0)
    under = 1 - (1 + kx) * (cx * x) ** 2 - (1 + ky) * (cy * y) ** 2
    return (cx * x * x + cy * y * y) / (1 + np.sqrt(under))


def toroid(terms):
    def sag(x, y, p):
        curve = conic(y * y, p["radius"], p.get("conic", 0.0)) if "radius" in p else 0.0
        curve = curve + powers(y, terms)
        turn = p["rotation_radius"]
        # Not turn - root, which cancels: (turn - curve)² = (turn - z)² + x².
        root = np.sign(turn) * np.sqrt((turn - curve) ** 2 - x * x)
        return curve + x * x / (turn - curve + root)

    return sag


def mirror(figure):
    """The surface of equal path from source to image, by Newton's method on the path in extended precision."""

    def sag(x, y, p):
        x, y = np.asarray(x, np.longdouble), np.asarray(y, np.longdouble)
        if figure == "cylindrical":
            y = 0 * y
        cos, sin = np.cos(np.longdouble(p["theta"])), np.sin(np.longdouble(p["theta"]))
        z = np.zeros_like(x)
        for _ in range(60):
            path, slope = np.zeros_like(x), np.zeros_like(x)
            for distance, way in ((p["p"], -1), (p["q"], 1)):
                if np.isinf(distance):
                    # Against the light before, along it behind the mirror: counted from the plane through the origin.
                    path, slope = path - way * x * cos - z * sin, slope - sin
                    continue
                far = np.longdouble(distance)
                fx, fz = way * far * cos, far * sin
                length = np.sqrt((x - fx) ** 2 + y**2 + (z - fz) ** 2)
                path = path + np.sign(far) * length - far
                slope = slope + np.sign(far) * (z - fz) / length
            z = z - path / slope
        return z.astype(float)

    return sag


class Case:
    def __init__(self, name, surface, sag, values, aperture, pose=WHOLE, more=None, piece=None, lens=None):
        """values: the parameters in the file; more: what the part has instead, free in the fit; lens: a lens file instead of `surface`."""
        self.name, self.surface, self.sag, self.values = name, surface, sag, values
        self.aperture, self.pose, self.more, self.piece, self.lens = aperture, pose, more or {}, piece, lens

    def places(self):
        i = np.arange(1, POINTS + 1)
        a, b = np.mod(i * 0.7548776662466927, 1), np.mod(i * 0.5698402909980532, 1)
        shape, *size = self.aperture
        if shape == "circle":
            r, phi = 0.95 * size[0] * np.sqrt(a), 2 * np.pi * b
            return r * np.cos(phi), r * np.sin(phi), size[0]
        if shape == "annulus":
            r, phi = size[0] + (size[1] - size[0]) * (0.03 + 0.95 * a), 2 * np.pi * b
            return r * np.cos(phi), r * np.sin(phi), size[1]
        return 0.95 * size[0] * (a - 0.5), 0.95 * size[1] * (b - 0.5), 0.5 * min(size)

    def gradient(self, x, y, p, h):
        """By central differences of the sixth order."""
        weights = ((1, 45 / 60), (2, -9 / 60), (3, 1 / 60))
        along_x = sum(w * (self.sag(x + k * h, y, p) - self.sag(x - k * h, y, p)) for k, w in weights)
        along_y = sum(w * (self.sag(x, y + k * h, p) - self.sag(x, y - k * h, p)) for k, w in weights)
        return along_x / h, along_y / h

    def make(self, folder):
        x, y, size = self.places()
        true = {**self.values, **self.more}
        turn, origin = np.eye(3), np.zeros(3)
        h = 2e-3 * size
        if self.piece:
            dx, dy, axes = self.piece
            origin = np.array([dx, dy, float(self.sag(np.array([dx]), np.array([dy]), true)[0])])
            if axes == "normal":
                gx, gy = (float(g[0]) for g in self.gradient(np.array([dx]), np.array([dy]), true, h))
                turn = shortest(np.array([-gx, -gy, 1]) / np.sqrt(1 + gx * gx + gy * gy))
            # Scattered on the parent about the origin of the piece.
            x, y = x + dx, y + dy
        z = self.sag(x, y, true)
        gx, gy = self.gradient(x, y, true, h)
        steep = np.sqrt(1 + gx**2 + gy**2)
        n = np.stack([-gx / steep, -gy / steep, 1 / steep], axis=1)
        points = (np.stack([x, y, z], axis=1) - origin) @ turn
        n = n @ turn
        columns = [*n.T, *np.cross(points, n).T]
        for name, value in self.more.items():
            step = 1e-4 * abs(value)
            high, low = ({**true, name: value + s * step} for s in (1, -1))
            columns.append((self.sag(x, y, high) - self.sag(x, y, low)) / (2 * step) / steep)
        places = points[:, :2] / size
        deviation = shaped(places[:, 0], places[:, 1])
        matrix = np.stack([c / max(np.linalg.norm(c), 1e-300) for c in columns if np.linalg.norm(c) > 1e-12], axis=1)
        u, s, _ = np.linalg.svd(matrix, full_matrices=False)
        basis = u[:, s > 1e-9 * s[0]]
        for _ in range(2):
            deviation = deviation - basis @ (basis.T @ deviation)
        pose = {key: POSE[key] if key in self.pose else 0.0 for key in WHOLE}
        for kind, d in (("true", 0 * deviation), ("formed", deviation)):
            moved = move(points + d[:, None] * n, pose)
            (folder / f"{self.name}-{kind}.xyz").write_text(
                "".join(f"{a!r} {b!r} {c!r}\n" for a, b, c in moved.tolist())
            )
        if self.lens:
            (folder / f"{self.name}.zmx").write_text(self.lens)
        else:
            (folder / f"{self.name}.toml").write_text(self.nominal())
        return {
            "name": self.name,
            "lens": bool(self.lens),
            "expected": {**{key: pose[key] for key in self.pose}, **self.more},
            "rms_nm": 1e6 * float(np.sqrt(np.mean(deviation**2))),
            "pv_nm": 1e6 * float(np.ptp(deviation)),
        }

    def nominal(self):
        shape, *size = self.aperture
        if shape == "circle":
            aperture = f'shape = "circle"\nradius_mm = {size[0]}\n'
        elif shape == "annulus":
            aperture = f'shape = "annulus"\ninner_radius_mm = {size[0]}\nouter_radius_mm = {size[1]}\n'
        else:
            aperture = f'shape = "rectangle"\nwidth_mm = {size[0]}\nheight_mm = {size[1]}\n'
        free = ", ".join(f'"{name}"' for name in (*self.pose, *self.more))
        piece = ""
        if self.piece:
            dx, dy, axes = self.piece
            piece = f'[surface.off_axis]\ndx_mm = {dx}\ndy_mm = {dy}\naxes = "{axes}"\n'
        return f"[surface]\n{self.surface}\n{piece}[aperture]\n{aperture}[fit]\nfree = [{free}]\n"


def shortest(normal):
    """The rotation that takes z to the normal by the shortest way (Rodrigues)."""
    axis = np.cross([0, 0, 1], normal)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + cross + cross @ cross / (1 + normal[2])


def shaped(x, y):
    """100 nm of waves and a bump of 300 nm, mm."""
    waves = np.cos(2.1 * x - 0.7 * y + 0.3) * np.sin(3.3 * y + 1.1 * x) + 0.4 * (x * x - y * y)
    bump = np.exp(-((x - 0.31) ** 2 + (y + 0.22) ** 2) / (2 * 0.08**2))
    return 1e-4 * waves + 3e-4 * bump


def move(points, pose):
    """p' = Rz·Ry·Rx·p + t."""
    (sx, cx), (sy, cy), (sz, cz) = ((np.sin(pose[k]), np.cos(pose[k])) for k in ("rx", "ry", "rz"))
    rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return points @ (rz @ ry @ rx).T + [pose["tx"], pose["ty"], pose["tz"]]


def lines(**keys):
    """Keys and values as TOML has them."""
    return "\n".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())


def terms(names, of):
    """One line each."""
    rows = []
    for key, value in of.items():
        key = key if isinstance(key, tuple) else (key,)
        named = ", ".join(f"{name} = {part}" for name, part in zip(names, key))
        rows.append(f"    {{ {named}, mm = {value!r} }},\n")
    return "\nterms = [\n" + "".join(rows) + "]"


def cases(folder):
    disc = ("circle", 10.0)
    flat = lambda x, y, p: 0 * x
    yield Case("plane", lines(kind="plane"), flat, {}, disc, ("tz", "rx", "ry"))
    sphere = even({})
    for radius in (30.0, -12.5):
        yield Case(
            f"sphere{radius}", lines(kind="sphere", radius_mm=radius), sphere, {"radius": radius}, disc,
            ("tx", "ty", "tz"), {"radius": radius * 1.001},
        )
    for k in (-1.0, -2.5, 0.6, -0.4):
        yield Case(
            f"conic{k}", lines(kind="conic", radius_mm=25.0, conic=k), even({}), {"radius": 25.0, "conic": k}, disc,
            ROUND, {"radius": 25.01, "conic": k + 0.01},
        )
    al = {4: 3.69067205091e-5, 6: -1.285461192617e-8, 8: -1.400167659754e-10, 10: -2.51311664812e-13}
    named = {f"A{order}": value for order, value in al.items()}
    yield Case(
        "asphere", lines(kind="asphere", radius_mm=11.65, conic=-1.1, **named), even(al), {"radius": 11.65, "conic": -1.1},
        ("circle", 9.0), ROUND, {"A4": 3.7e-5, "A6": -1.3e-8},
    )
    yield Case(
        "asphere-r2", lines(kind="asphere", radius_mm=60.0, A2=1e-3, A4=2e-6, A22=3e-26), even({2: 1e-3, 4: 2e-6, 22: 3e-26}),
        {"radius": 60.0}, disc, ROUND,
    )
    yield Case("corrector", lines(kind="asphere", base="flat", A2=-2e-4, A4=1e-6), even({2: -2e-4, 4: 1e-6}), {}, disc, ROUND)
    yield Case(
        "odd-asphere", lines(kind="odd-asphere", radius_mm=25.0, conic=-0.5, A3=1.2e-5, A4=-3e-7, A5=2e-8),
        even({3: 1.2e-5, 4: -3e-7, 5: 2e-8}), {"radius": 25.0, "conic": -0.5}, disc, ROUND,
    )
    yield Case(
        "axicon", lines(kind="odd-asphere", base="flat", A1=0.02, A3=1e-6), even({1: 0.02, 3: 1e-6}), {},
        ("annulus", 1.0, 10.0), ROUND,
    )
    a = [-0.08, -0.0323, 0.0105, -0.005, 0.001, -0.0002, 0.00004, 0.00001]
    for kind in ("conic-normal", "sphere-normal", "axis"):
        yield Case(
            f"q-bfs-{kind}",
            lines(kind="q-bfs", radius_mm=17.3729, conic=-0.676, normalisation_radius_mm=12.0, projection=kind, coefficients_mm=a),
            forbes(kind, 12.0, a), {"radius": 17.3729, "conic": -0.676}, ("circle", 11.5), ROUND, {"Q0": -0.081, "Q2": 0.0104},
        )
    steep = [-0.8148370167576, -0.32311, 0.10591, -0.05058, 0.00987, -0.0022]
    yield Case(
        "asl5040",
        lines(
            kind="q-bfs", radius_mm=17.3729, conic=-0.67609120640407927, normalisation_radius_mm=27.0, projection="conic-normal",
            coefficients_mm=steep,
        ),
        forbes("conic-normal", 27.0, steep), {"radius": 17.3729, "conic": -0.67609120640407927}, ("circle", 22.86), ROUND,
    )
    yield Case(
        "q-bfs-flat", lines(kind="q-bfs", base="flat", normalisation_radius_mm=12.0, projection="axis", coefficients_mm=a),
        forbes("axis", 12.0, a), {}, disc, ROUND,
    )
    con = [0.012, -0.0008, 0.0003, 0.0001]
    yield Case(
        "q-con", lines(kind="q-con", radius_mm=-40.0, conic=0.3, normalisation_radius_mm=12.0, coefficients_mm=con),
        forbes("con", 12.0, con), {"radius": -40.0, "conic": 0.3}, ("circle", 11.0), ROUND, {"Q1": -0.00081},
    )
    sheet = ("rectangle", 20.0, 30.0)
    yield Case(
        "cylinder-y", lines(kind="cylinder", straight_along="y", radius_mm=40.0), cylinder("y", {}), {"radius": 40.0}, sheet,
        ("tx", "tz", "rx", "rz"), {"radius": 40.02},
    )
    yield Case(
        "cylinder-x", lines(kind="cylinder", straight_along="x", radius_mm=-40.0), cylinder("x", {}), {"radius": -40.0}, sheet,
        ("ty", "tz", "ry", "rz"), {"radius": -40.02},
    )
    yield Case(
        "acylinder", lines(kind="cylinder", straight_along="y", radius_mm=40.0, conic=-0.8, A4=1e-5),
        cylinder("y", {4: 1e-5}), {"radius": 40.0, "conic": -0.8}, sheet, ("tx", "tz", "rx", "ry", "rz"), {"A4": 1.01e-5},
    )
    two = {"radius_x": 30.0, "conic_x": -0.8, "radius_y": 55.0, "conic_y": 0.4}
    yield Case(
        "biconic", lines(kind="biconic", radius_x_mm=30.0, conic_x=-0.8, radius_y_mm=55.0, conic_y=0.4), biconic, two,
        disc, WHOLE, {"radius_x": 30.01, "conic_y": 0.41},
    )
    yield Case(
        "biconic-flat", lines(kind="biconic", radius_y_mm=-55.0, conic_y=3.0), biconic, {"radius_y": -55.0, "conic_y": 3.0},
        disc, ("ty", "tz", "rx", "ry", "rz"),
    )
    # A turn about the line through (0, 0, R) changes nothing.
    turned = ("tx", "ty", "tz", "rx", "rz")
    yield Case(
        "toroid", lines(kind="toroid", rotation_radius_mm=60.0, radius_mm=35.0, conic=0.2, A4=1e-7), toroid({4: 1e-7}),
        {"rotation_radius": 60.0, "radius": 35.0, "conic": 0.2}, disc, turned, {"rotation_radius": 60.02, "radius": 35.01},
    )
    yield Case(
        "saddle", lines(kind="toroid", rotation_radius_mm=-60.0, radius_mm=35.0, A4=1e-7), toroid({4: 1e-7}),
        {"rotation_radius": -60.0, "radius": 35.0}, disc, turned,
    )
    strip = ("rectangle", 40.0, 10.0)
    inf = float("inf")
    for figure in ("cylindrical", "revolved"):
        for name, p, q in (
            ("elliptic", 400.0, 90.0), ("hyperbolic", -306.0, 115.0), ("hyperbolic-image", 200.0, -300.0),
            ("parabolic", inf, 120.0), ("collimating", 120.0, inf),
        ):
            far = {"p": p, "q": q, "theta": 0.12}
            written = {key: "infinite" if np.isinf(value) else value for key, value in (("source_mm", p), ("image_mm", q))}
            # Along y, or about the line through source and image, there is nothing to feel.
            pose = ("tx", "tz", "rx", "ry", "rz") if figure == "cylindrical" else ("tx", "ty", "tz", "ry", "rz")
            yield Case(
                f"{figure}-{name}", lines(kind="mirror", figure=figure, **written, grazing_rad=0.12), mirror(figure), far,
                strip, pose,
            )
    for count, of in (
        ("fringe", {4: 2e-3, 5: 2e-3, 8: -5e-4, 11: 3e-4, 16: 1e-4, 28: -2e-4, 37: 1e-4}),
        ("noll", {4: 2e-3, 5: 2e-3, 8: -5e-4, 11: 3e-4, 16: 1e-4, 28: -2e-4, 37: 1e-4}),
        ("ansi", {4: 2e-3, 5: 2e-3, 8: -5e-4, 11: 3e-4, 16: 1e-4, 28: -2e-4, 37: 1e-4}),
        ("orders", {(2, 2): 2e-3, (3, -1): -5e-4, (5, 3): 3e-4, (9, -7): -2e-4, (12, 0): 1e-4}),
    ):
        for norm in (False, True):
            word = "unit-rms" if norm else "unit-height"
            free = {"Z(2,2)": 2.1e-3} if count == "orders" else {"Z5": 2.1e-3, "Z11": 3.1e-4}
            yield Case(
                f"zernike-{count}-{word}",
                lines(kind="zernike", indices=count, normalisation=word, normalisation_radius_mm=12.0, radius_mm=50.0, conic=-1.0)
                + terms(("n", "m") if count == "orders" else ("index",), of),
                zernike(count, norm, 12.0, of), {"radius": 50.0, "conic": -1.0}, disc, WHOLE, free,
            )
    strong = {(0, 2): 0.02, (1, -1): -0.004, (2, 3): 0.003, (3, 0): 0.002, (0, -2): 0.01, (4, 1): 1e-3, (5, -4): 5e-4}
    yield Case(
        "q-2d", lines(kind="q-2d", radius_mm=40.0, normalisation_radius_mm=12.0) + terms(("n", "m"), strong),
        q2d(12.0, strong), {"radius": 40.0}, disc,
    )
    yield Case(
        "q-2d-flat", lines(kind="q-2d", base="flat", normalisation_radius_mm=12.0) + terms(("n", "m"), strong),
        q2d(12.0, strong), {}, disc,
    )
    pairs = {(2, 1): 2e-2, (0, 3): -1e-2, (4, 2): 4e-3, (1, 0): 1e-3}
    for family in ("chebyshev", "legendre"):
        yield Case(
            family, lines(kind=family, half_x_mm=20.0, half_y_mm=12.0, radius_mm=150.0) + terms(("x", "y"), pairs),
            product(family, 20.0, 12.0, pairs), {"radius": 150.0}, ("rectangle", 36.0, 22.0),
        )
    yield Case(
        "xy", lines(kind="xy", normalisation_radius_mm=10.0, radius_mm=-60.0, conic=-1.0) + terms(("x", "y"), pairs),
        product("xy", 10.0, 10.0, pairs), {"radius": -60.0, "conic": -1.0}, disc,
    )
    pair = zernike("noll", True, 12.0, {7: 1e-3, 9: 2e-3})
    summed = over_base(lambda x, y, p: powers(np.hypot(x, y), {4: 2e-6, 6: 1e-9}) + pair(x, y, {}))
    yield Case(
        "sum",
        lines(
            kind="zernike", indices="noll", normalisation="unit-rms", normalisation_radius_mm=12.0, radius_mm=80.0, conic=-0.5,
            A4=2e-6, A6=1e-9,
        )
        + terms(("index",), {7: 1e-3, 9: 2e-3}),
        summed, {"radius": 80.0, "conic": -0.5}, disc,
    )
    for axes in ("normal", "parallel"):
        yield Case(
            f"off-axis-{axes}", lines(kind="conic", radius_mm=203.2, conic=-1.0), even({}), {"radius": 203.2, "conic": -1.0},
            ("circle", 12.7), ROUND, None, (20.0, 50.0, axes),
        )
    waves = lambda x, y, p: 3e-3 * np.sin(0.4 * x + 0.2) * np.cos(0.3 * y - 0.5) + 1e-5 * x * y * (x + 2 * y)
    for name, base, values in (
        ("grid", {}, {}), ("grid-on-conic", {"radius_mm": 60.0, "conic": -1.0}, {"radius": 60.0, "conic": -1.0}),
    ):
        grid_sag(folder / f"{name}.DAT", 241, 0.1, waves)
        yield Case(name, lines(kind="grid", file=f"{name}.DAT", **base), over_base(waves), values, disc)


def zemax(kind, curvature=0.0, conic=0.0, radius=10.0, parameters=None, data=None, unit="MM"):
    """A lens file as OpticStudio writes it, with the surface as its number 1: PARM from the parameters' numbers, XDAT from those of the
    extra data."""
    rows = [f"TYPE {kind}", f"CURV {curvature!r} 0 0 0 0 \"\"", f"CONI {conic!r}"]
    rows += [f"PARM {number} {value!r}" for number, value in (parameters or {}).items()]
    rows += ["DISZ 4.0", f"DIAM {radius!r} 1 0 0 1 \"\""]
    rows += [f"XDAT {number} {value!r} 0 0 1.0 0.0 0 \"\"" for number, value in (data or {}).items()]
    body = "".join(f"  {row}\n" for row in rows)
    return (
        f"VERS 140124 258 36214\nMODE SEQ\nNAME part\nUNIT {unit} X W X CM MR CPMM\n"
        f"SURF 0\n  TYPE STANDARD\n  CURV 0.0 0 0 0 0 \"\"\n  DISZ INFINITY\nSURF 1\n{body}SURF 2\n  TYPE STANDARD\n"
    )


def lenses(folder):
    """Surfaces of lens files: what their numbers mean is OpticStudio's help, Sequential Surfaces."""
    disc = ("circle", 10.0)

    def lens(kind, name, sag, values, pose=WHOLE, aperture=disc, **given):
        return Case(name, "", sag, values, aperture, pose, lens=zemax(kind, radius=aperture[1] / given.pop("size", 1.0), **given))

    yield lens(
        "STANDARD", "STANDARD", even({}), {"radius": -25.0, "conic": -1.0}, ROUND, curvature=-0.04, conic=-1.0,
    )
    yield lens(
        "EVENASPH", "EVENASPH", even({2: 1e-3, 4: 2e-6, 6: -1e-9, 16: 1e-22}), {"radius": 62.5, "conic": -0.5}, ROUND,
        curvature=0.016, conic=-0.5, parameters={1: 1e-3, 2: 2e-6, 3: -1e-9, 8: 1e-22},
    )
    yield lens(
        "EVENASPH", "EVENASPH-in", even({4: 1e-2 / 25.4**3, 6: -1e-2 / 25.4**5}), {"radius": 63.5, "conic": -0.5}, ROUND,
        curvature=0.4, conic=-0.5, parameters={2: 1e-2, 3: -1e-2}, unit="IN", size=25.4,
    )
    yield lens(
        "ODDASPHE", "ODDASPHE", even({3: 1.2e-5, 4: -3e-7, 5: 2e-8}), {"radius": 25.0, "conic": -0.5}, ROUND,
        curvature=0.04, conic=-0.5, parameters={3: 1.2e-5, 4: -3e-7, 5: 2e-8},
    )
    extended = dict(enumerate([1e-2, -2e-2, 3e-3, 1e-3, -1e-3], 1))
    yield lens(
        "XASPHERE", "XASPHERE", even({2 * k: value / 10.0 ** (2 * k) for k, value in extended.items()}), {"radius": 50.0, "conic": -0.5},
        ROUND, curvature=0.02, conic=-0.5, data={1: 5, 2: 10.0, **{2 + k: value for k, value in extended.items()}},
    )
    # x, y, x², xy, y², x³ …
    orders = [(n - j, j) for n in range(1, 5) for j in range(n + 1)]
    pairs = {(1, 0): 1e-3, (0, 1): -2e-3, (2, 0): 2e-2, (1, 1): 3e-3, (0, 2): -1e-2, (2, 1): 5e-3, (0, 3): -4e-3, (2, 2): 1e-3}
    yield lens(
        "XPOLYNOM", "XPOLYNOM", product("xy", 10.0, 10.0, pairs), {"radius": -62.5, "conic": -1.0}, curvature=-0.016, conic=-1.0,
        data={1: len(orders), 2: 10.0, **{3 + orders.index(pair): value for pair, value in pairs.items()}},
    )
    of = {4: 2e-3, 5: 2e-3, 8: -5e-4, 11: 3e-4, 16: 1e-4, 28: -2e-4, 37: 1e-4}
    for kind, count, norm in (("FZERNSAG", "fringe", False), ("SZERNSAG", "noll", True)):
        terms_of = zernike(count, norm, 12.0, of)
        yield lens(
            kind, kind, lambda x, y, p, terms_of=terms_of: terms_of(x, y, p) + powers(np.hypot(x, y), {4: 1e-7}),
            {"radius": 50.0, "conic": -1.0}, curvature=0.02, conic=-1.0, parameters={2: 1e-7},
            data={1: 37, 2: 12.0, **{2 + k: value for k, value in of.items()}},
        )
    a = [-0.08, -0.0323, 0.0105, -0.005, 0.001]
    for number, kind in enumerate(("conic-normal", "con")):
        yield lens(
            "QED_TYPE", f"QED_TYPE-{number}", forbes(kind, 12.0, a), {"radius": 20.0, "conic": -0.676}, ROUND, ("circle", 11.0),
            curvature=0.05, conic=-0.676, data={1: number, 2: 5, 3: 12.0, **dict(enumerate(a, 4))},
        )
    yield lens(
        "BICONICX", "BICONICX", biconic, {"radius_x": 30.0, "conic_x": -0.8, "radius_y": 50.0, "conic_y": 0.4},
        curvature=0.02, conic=0.4, parameters={1: 30.0, 2: -0.8},
    )
    yield lens(
        "TOROIDAL", "TOROIDAL", toroid({2: 1e-4, 4: 1e-7}), {"rotation_radius": 60.0, "radius": 40.0, "conic": 0.2},
        ("tx", "ty", "tz", "rx", "rz"), curvature=0.025, conic=0.2, parameters={1: 60.0, 2: 1e-4, 3: 1e-7},
    )
    waves = lambda x, y, p: 3e-3 * np.sin(0.4 * x + 0.2) * np.cos(0.3 * y - 0.5)
    grid_sag(folder / "GRID_SAG.DAT", 241, 0.1, waves)
    yield lens(
        "GRID_SAG", "GRID_SAG", over_base(waves), {"radius": 62.5, "conic": -1.0}, curvature=0.016, conic=-1.0,
    )


def grid_sag(path, count, step, sag):
    """Heights as OpticStudio's help describes a grid sag: from -x and +y towards +x, row after row."""
    places = (np.arange(count) - (count - 1) / 2) * step
    rows = [f"{count} {count} {step} {step} 0 0 0"]
    for y in places[::-1]:
        rows += [f"{z!r} 0 0 0 0" for z in sag(places, y, {}).tolist()]
    path.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    (folder / "cases.json").write_text(json.dumps([case.make(folder) for case in (*cases(folder), *lenses(folder))]))
