//! Centres of the spheres of tetrahedra: the vertices of the Voronoi diagram.
//!
//! Tetrahedra of four points nearly on a circle are all but flat, and doubles lose their centres. There the forms are computed
//! in pairs of doubles (T. J. Dekker 1971), some 106 bits.

use asphera_geometry::PointMm;
use rayon::prelude::*;

use crate::delaunay::Delaunay;
use crate::geometry::{cross, dot, minus, scaled};

/// The centre of the sphere of each tetrahedron.
pub(crate) fn of(delaunay: &Delaunay) -> Vec<PointMm> {
    (0..delaunay.tetrahedra as u32)
        .into_par_iter()
        .map(|cell| centre(delaunay.places(cell)))
        .collect()
}

/// The centre of the sphere through four places.
pub(crate) fn centre([a, b, c, d]: [PointMm; 4]) -> PointMm {
    let [u, v, w] = [minus(a, d), minus(b, d), minus(c, d)];
    let normal = cross(v, w);
    let det = dot(u, normal);
    let size = dot(u, u).sqrt() * dot(v, v).sqrt() * dot(w, w).sqrt();
    let way = if det.abs() > CERTAIN * size {
        let terms = [(u, normal), (v, cross(w, u)), (w, cross(u, v))];
        [0, 1, 2].map(|axis| {
            terms.iter().map(|(p, minor)| dot(*p, *p) * minor[axis]).sum::<f64>() / (2.0 * det)
        })
    } else {
        precise_way([a, b, c], d)
    };
    let centre = [0, 1, 2].map(|axis| d[axis] + way[axis]);
    if centre.iter().all(|value| value.is_finite()) {
        return centre;
    }
    // Flat beyond the pairs: the middle of the corners stands for it.
    let sum = [0, 1, 2].map(|axis| a[axis] + b[axis] + c[axis] + d[axis]);
    scaled(sum, 0.25)
}

/// The way from `d` to the centre, by pairs of doubles.
fn precise_way(corners: [PointMm; 3], d: PointMm) -> PointMm {
    let [u, v, w] = corners.map(|p| [0, 1, 2].map(|axis| Pair::sum(p[axis], -d[axis])));
    let minor = |p: [Pair; 3], q: [Pair; 3]| {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| p[i].times(q[j]).plus(p[j].times(q[i]).minus()))
    };
    let product =
        |p: [Pair; 3], q: [Pair; 3]| p[0].times(q[0]).plus(p[1].times(q[1])).plus(p[2].times(q[2]));
    let normal = minor(v, w);
    let det = product(u, normal).value();
    let terms = [(u, normal), (v, minor(w, u)), (w, minor(u, v))];
    [0, 1, 2].map(|axis| {
        let sum = terms
            .iter()
            .map(|&(p, minor)| product(p, p).times(minor[axis]))
            .fold(Pair(0.0, 0.0), Pair::plus);
        sum.value() / (2.0 * det)
    })
}

/// A number as the sum of two doubles.
#[derive(Clone, Copy)]
struct Pair(f64, f64);

impl Pair {
    /// The sum of two doubles, without rounding.
    fn sum(a: f64, b: f64) -> Pair {
        let sum = a + b;
        let part = sum - a;
        Pair(sum, (a - (sum - part)) + (b - part))
    }

    fn plus(self, other: Pair) -> Pair {
        let Pair(high, low) = Pair::sum(self.0, other.0);
        Pair::sum(high, low + self.1 + other.1)
    }

    fn minus(self) -> Pair {
        Pair(-self.0, -self.1)
    }

    fn times(self, other: Pair) -> Pair {
        let high = self.0 * other.0;
        let low = self.0.mul_add(other.0, -high) + (self.0 * other.1 + self.1 * other.0);
        Pair::sum(high, low)
    }

    fn value(self) -> f64 {
        self.0 + self.1
    }
}

/// Determinants above this share of their greatest size are good to 1e-10 in doubles.
const CERTAIN: f64 = 1e-5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_tetrahedra_have_their_centres() {
        for height in [1.0_f64, 1e-6, 1e-12] {
            // Four corners on a sphere about (1, 2, 3) of radius 5, the last a little above the plane of the others.
            let at = |x: f64, y: f64, z: f64| [1.0 + x, 2.0 + y, 3.0 + z];
            let places = [
                at(5.0, 0.0, 0.0),
                at(0.0, 5.0, 0.0),
                at(-5.0, 0.0, 0.0),
                at(0.0, -(25.0 - height * height).sqrt(), height),
            ];
            let found = centre(places);
            // Places are rounded to 1e-15, which the height divides.
            let allowed = 1e-14 + 2e-14 / height;
            assert!((found[0] - 1.0).abs() < 1e-12 && (found[1] - 2.0).abs() < 1e-12);
            assert!((found[2] - 3.0).abs() < allowed, "{height}: {found:?}");
        }
    }
}
