//! The middle of places: the centre of the smallest circle about them.
//!
//! It turns, shifts and grows with the places, does not depend on how densely they lie or in which order, and its circle is the
//! smallest unit disc a Zernike fit can have. For a rectangle and a disc, whole or cut in half, it is the centre.

/// The centre of the smallest circle that holds all finite places, mm; `None` without one. A few passes over the places.
///
/// Basis exchange: the place farthest outside joins the two or three that hold the circle, and the smallest circle of
/// these is the next one (Gärtner, ESA 1999, LNCS 1643, 325). Each is larger than the last.
pub fn middle_mm(places_mm: &[[f64; 2]]) -> Option<[f64; 2]> {
    let finite = || places_mm.iter().copied().filter(|place| place.iter().all(|mm| mm.is_finite()));
    let first = finite().next()?;
    // Relative to one of them, so that places far away lose no digits.
    let from_first = |[x, y]: [f64; 2]| [x - first[0], y - first[1]];
    let mut circle = Circle { centre: [0.0; 2], square: 0.0 };
    let mut holding = vec![[0.0; 2]];
    for _ in 0..MOST_ROUNDS {
        let farthest = finite()
            .map(from_first)
            .max_by(|a, b| circle.square_to(*a).total_cmp(&circle.square_to(*b)))?;
        if circle.holds(farthest) {
            break;
        }
        holding.push(farthest);
        (circle, holding) = smallest(&holding)?;
    }
    Some([circle.centre[0] + first[0], circle.centre[1] + first[1]])
}

#[derive(Clone, Copy)]
struct Circle {
    centre: [f64; 2],
    /// The square of its radius.
    square: f64,
}

impl Circle {
    fn square_to(&self, [x, y]: [f64; 2]) -> f64 {
        let (dx, dy) = (x - self.centre[0], y - self.centre[1]);
        dx * dx + dy * dy
    }

    fn holds(&self, place: [f64; 2]) -> bool {
        self.square_to(place) <= self.square * (1.0 + ROUNDING)
    }

    fn about_two([a, b]: [[f64; 2]; 2]) -> Circle {
        let centre = [0, 1].map(|axis| a[axis].midpoint(b[axis]));
        let half = [0, 1].map(|axis| 0.5 * (a[axis] - b[axis]));
        Circle { centre, square: half[0] * half[0] + half[1] * half[1] }
    }

    /// Through three places; `None` where they lie on a line.
    fn through_three([a, b, c]: [[f64; 2]; 3]) -> Option<Circle> {
        let [b, c] = [b, c].map(|place| [place[0] - a[0], place[1] - a[1]]);
        let [square_b, square_c] = [b, c].map(|place| place[0] * place[0] + place[1] * place[1]);
        let doubled = 2.0 * (b[0] * c[1] - b[1] * c[0]);
        let x = (c[1] * square_b - b[1] * square_c) / doubled;
        let y = (b[0] * square_c - c[0] * square_b) / doubled;
        let circle = Circle { centre: [a[0] + x, a[1] + y], square: x * x + y * y };
        circle.square.is_finite().then_some(circle)
    }
}

/// The smallest circle about at most four places, and the two or three of them that hold it.
fn smallest(places: &[[f64; 2]]) -> Option<(Circle, Vec<[f64; 2]>)> {
    let count = places.len();
    let about = |Circle { centre, .. }: Circle| {
        let square = places.iter().map(|at| Circle { centre, square: 0.0 }.square_to(*at));
        Circle { centre, square: square.fold(0.0, f64::max) }
    };
    let mut found: Vec<(Circle, Vec<[f64; 2]>)> = Vec::new();
    for i in 0..count {
        for j in i + 1..count {
            let two = [places[i], places[j]];
            found.push((about(Circle::about_two(two)), two.to_vec()));
            for &third in &places[j + 1..] {
                let three = [places[i], places[j], third];
                let circle = Circle::through_three(three).map(about);
                found.extend(circle.map(|circle| (circle, three.to_vec())));
            }
        }
    }
    found.into_iter().min_by(|(a, _), (b, _)| a.square.total_cmp(&b.square))
}

/// Rounds are 5 to 10 in practice.
const MOST_ROUNDS: usize = 100;
/// A place that lies outside by less of the square of the radius lies on the circle.
const ROUNDING: f64 = 1e-13;

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Option<[f64; 2]>, x: f64, y: f64) {
        let [a, b] = found.unwrap();
        assert!((a - x).hypot(b - y) < 1e-9, "({a}, {b}), not ({x}, {y})");
    }

    #[test]
    fn the_middle_of_known_outlines_is_their_centre() {
        assert_eq!(middle_mm(&[]), None);
        assert_eq!(middle_mm(&[[f64::NAN, 0.0]]), None);
        near(middle_mm(&[[3.0, 4.0], [f64::INFINITY, 0.0]]), 3.0, 4.0);
        near(middle_mm(&[[1.0, 2.0], [1.0, 2.0], [5.0, 2.0], [3.0, 2.0]]), 3.0, 2.0);
        let raster = (0..64_u32).flat_map(|i| (0..48_u32).map(move |j| [i, j].map(f64::from)));
        near(middle_mm(&raster.collect::<Vec<_>>()), 31.5, 23.5);
        // Half a disc, ten thousand kilometres away, has the centre of the whole one.
        let half: Vec<[f64; 2]> = (0..=500)
            .map(|i| f64::from(i) / 500.0 * std::f64::consts::PI)
            .map(|phi| [1e4 + 5.0 * phi.cos(), -1e4 + 5.0 * phi.sin()])
            .collect();
        near(middle_mm(&half), 1e4, -1e4);
        // An obtuse triangle hangs on its longest side, an acute one on all three corners.
        near(middle_mm(&[[0.0, 0.0], [10.0, 0.0], [4.0, 1.0]]), 5.0, 0.0);
        near(middle_mm(&[[0.0, 0.0], [6.0, 0.0], [3.0, 6.0]]), 3.0, 2.25);
    }

    #[test]
    fn no_order_and_no_density_moves_it() {
        let mut places: Vec<[f64; 2]> = (0..2000)
            .map(|i| (f64::from(i) * 0.618, f64::from(i % 97)))
            .map(|(phi, r)| [r * phi.cos(), 0.6 * r * phi.sin()])
            .collect();
        let [x, y] = middle_mm(&places).unwrap();
        places.reverse();
        places.extend(vec![[1.0, 1.0]; 5000]);
        near(middle_mm(&places), x, y);
        let moved: Vec<[f64; 2]> = places.iter().map(|[x, y]| [x + 37.3, y - 112.9]).collect();
        near(middle_mm(&moved), x + 37.3, y - 112.9);
    }
}
