//! Torus knots: closed smooth curves with a known reach.

/// The curve ((R + ρ·cos qt)·cos pt, (R + ρ·cos qt)·sin pt, ρ·sin qt): p and q without a common divisor make one knot.
#[derive(Clone, Debug)]
pub(crate) struct Knot {
    turns: [f64; 2],
    radii: [f64; 2],
    /// Places all along it, evenly in its parameter.
    places: Vec<[f64; 3]>,
    /// No two of them that follow each other are farther apart.
    step: f64,
}

impl Knot {
    pub(crate) fn new(turns: [u32; 2], radii: [f64; 2]) -> Knot {
        let turns = turns.map(f64::from);
        let mut knot = Knot { turns, radii, places: Vec::new(), step: 0.0 };
        knot.places = (0..PLACES).map(|index| knot.jet(parameter(index))[0]).collect();
        for (index, &place) in knot.places.iter().enumerate() {
            let next = knot.places[(index + 1) % PLACES];
            knot.step = knot.step.max(length(minus(next, place)));
        }
        knot
    }

    /// Place, first and second derivative.
    fn jet(&self, t: f64) -> [[f64; 3]; 3] {
        let [p, q] = self.turns;
        let [big, small] = self.radii;
        let ((sp, cp), (sq, cq)) = ((p * t).sin_cos(), (q * t).sin_cos());
        // The distance from the axis with its derivatives.
        let (w, dw, ddw) = (big + small * cq, -small * q * sq, -small * q * q * cq);
        [
            [w * cp, w * sp, small * sq],
            [dw * cp - w * p * sp, dw * sp + w * p * cp, small * q * cq],
            [
                ddw * cp - 2.0 * dw * p * sp - w * p * p * cp,
                ddw * sp + 2.0 * dw * p * cp - w * p * p * sp,
                -small * q * q * sq,
            ],
        ]
    }

    /// The reach, found at the places: the least |a − b|² / (2·distance of b from the tangent at a) (Federer, Curvature measures, 1959,
    /// 4.18). Between places it is less by some ten thousandths.
    pub(crate) fn reach(&self) -> f64 {
        let mut reach = f64::INFINITY;
        for index in 0..PLACES {
            let [place, tangent, second] = self.jet(parameter(index));
            let square = dot(tangent, tangent);
            // Of two places that fall together it is the radius of curvature.
            let across = cross(tangent, second);
            reach = reach.min(square * square.sqrt() / length(across));
            for &other in &self.places {
                let from = minus(other, place);
                let beside = length(cross(from, tangent)) / square.sqrt();
                if beside > 1e-9 {
                    reach = reach.min(dot(from, from) / (2.0 * beside));
                }
            }
        }
        reach
    }

    /// The length: by the trapezium rule, which converges with every order on a closed curve.
    pub(crate) fn length(&self) -> f64 {
        let speed =
            |index| dot(self.jet(parameter(index))[1], self.jet(parameter(index))[1]).sqrt();
        (0..PLACES).map(speed).sum::<f64>() * std::f64::consts::TAU / PLACES as f64
    }

    /// The distance of a point, if it is below `most`.
    pub(crate) fn distance(&self, point: [f64; 3], most: f64) -> Option<f64> {
        let square = |index: usize| {
            let from = minus(self.places[index], point);
            dot(from, from)
        };
        let first = (0, square(0));
        let (nearest, least) = (1..PLACES)
            .map(|index| (index, square(index)))
            .fold(first, |best, one| if one.1 < best.1 { one } else { best });
        if least.sqrt() > most + self.step {
            return None;
        }
        // Newton's steps to where the tangent is at right angles to the way.
        let mut t = parameter(nearest);
        for _ in 0..5 {
            let [place, tangent, second] = self.jet(t);
            let from = minus(place, point);
            t -= dot(from, tangent) / (dot(tangent, tangent) + dot(from, second));
        }
        let found = length(minus(self.jet(t)[0], point));
        Some(found.min(least.sqrt())).filter(|distance| *distance < most)
    }
}

fn parameter(index: usize) -> f64 {
    std::f64::consts::TAU * index as f64 / PLACES as f64
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

const PLACES: usize = 300;

#[test]
fn a_knot_that_is_a_circle_has_the_reach_of_one() {
    let circle = Knot::new([1, 0], [3.0, 0.5]);
    assert!((circle.reach() - 3.5).abs() < 1e-9, "{}", circle.reach());
    let found = circle.distance([0.0, 5.0, 2.0], 10.0).unwrap();
    assert!((found - 1.5_f64.hypot(2.0)).abs() < 1e-9, "{found}");
    assert_eq!(circle.distance([0.0, 0.0, 0.0], 3.0), None);
    // The two strands of a trefoil are less than a diameter of its torus' section apart.
    let trefoil = Knot::new([2, 3], [3.0, 1.0]);
    assert!(trefoil.reach() > 0.3 && trefoil.reach() < 1.0, "{}", trefoil.reach());
}
