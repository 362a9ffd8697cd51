//! Affine maps of the plane, as the attribute `transform` of SVG writes them.

use super::PlaceMm;

/// x' = a·x + c·y + e, y' = b·x + d·y + f.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine(pub(super) [f64; 6]);

impl Affine {
    pub(super) const NONE: Affine = Affine([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);

    pub(super) fn of(self, [x, y]: PlaceMm) -> PlaceMm {
        let [a, b, c, d, e, f] = self.0;
        [a * x + c * y + e, b * x + d * y + f]
    }

    /// This map after another.
    pub(super) fn after(self, other: Affine) -> Affine {
        let [a, b, c, d, e, f] = other.0;
        let linear = |x: f64, y: f64| {
            let ([p, q], [r, s]) = (self.of([x, y]), self.of([0.0, 0.0]));
            [p - r, q - s]
        };
        let ([a, b], [c, d], [e, f]) = (linear(a, b), linear(c, d), self.of([e, f]));
        Affine([a, b, c, d, e, f])
    }

    /// The map of a list of transforms, the last applied first; `None` where it is not understood (SVG 1.1, 7.6).
    pub(super) fn parse(text: &str) -> Option<Affine> {
        let mut all = Affine::NONE;
        let mut rest = text.trim();
        while !rest.is_empty() {
            let (name, after) = rest.split_once('(')?;
            let (inside, after) = after.split_once(')')?;
            let words = inside.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty());
            let values: Vec<f64> =
                words.map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>()?;
            all = all.after(Affine::named(name.trim(), &values)?);
            rest = after.trim_start_matches(|letter: char| letter == ',' || letter.is_whitespace());
        }
        all.0.iter().all(|value| value.is_finite()).then_some(all)
    }

    fn named(name: &str, values: &[f64]) -> Option<Affine> {
        let turned = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Affine([cos, sin, -sin, cos, 0.0, 0.0])
        };
        let moved = |x: f64, y: f64| Affine([1.0, 0.0, 0.0, 1.0, x, y]);
        Some(match (name, values) {
            ("matrix", &[a, b, c, d, e, f]) => Affine([a, b, c, d, e, f]),
            ("translate", &[x]) => moved(x, 0.0),
            ("translate", &[x, y]) => moved(x, y),
            ("scale", &[s]) => Affine([s, 0.0, 0.0, s, 0.0, 0.0]),
            ("scale", &[x, y]) => Affine([x, 0.0, 0.0, y, 0.0, 0.0]),
            ("rotate", &[degrees]) => turned(degrees),
            ("rotate", &[degrees, x, y]) => moved(x, y).after(turned(degrees)).after(moved(-x, -y)),
            ("skewX", &[degrees]) => Affine([1.0, 0.0, degrees.to_radians().tan(), 1.0, 0.0, 0.0]),
            ("skewY", &[degrees]) => Affine([1.0, degrees.to_radians().tan(), 0.0, 1.0, 0.0, 0.0]),
            _ => return None,
        })
    }
}
