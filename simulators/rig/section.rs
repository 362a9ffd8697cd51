//! The section of an airfoil, by the four digits of the NACA (Jacobs, Ward, Pinkerton: NACA report 460, 1933).

use std::f64::consts::TAU;

/// An airfoil of the four-digit series with a closed trailing edge. The middle of its chord is the origin, x leads to the
/// trailing edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Section {
    /// Length of the chord, mm.
    pub(crate) chord_mm: f64,
    /// Camber in hundredths of the chord, its place in tenths, and the thickness in hundredths, as one number: 2412.
    pub(crate) naca: u32,
}

impl Section {
    /// So many places once round, from the trailing edge along the upper side, equally far apart along the edge.
    pub(crate) fn path_mm(&self, points: u64) -> Vec<[f64; 2]> {
        let count = usize::try_from(points).unwrap_or(usize::MAX);
        let corners = MOST_CORNERS.min(count.saturating_mul(8)).max(FEWEST_CORNERS);
        let corner = |index: usize| self.place_mm(index as f64 / corners as f64);
        let mut length_mm = vec![0.0; corners + 1];
        for index in 0..corners {
            let ([x, y], [x2, y2]) = (corner(index), corner((index + 1) % corners));
            length_mm[index + 1] = length_mm[index] + (x2 - x).hypot(y2 - y);
        }
        let mut side = 0;
        let place = |k: usize| {
            let wanted_mm = length_mm[corners] * (k as f64 + 0.5) / count as f64;
            while side + 1 < corners && length_mm[side + 1] < wanted_mm {
                side += 1;
            }
            let along = (wanted_mm - length_mm[side]) / (length_mm[side + 1] - length_mm[side]);
            self.place_mm((side as f64 + along) / corners as f64)
        };
        (0..count).map(place).collect()
    }

    /// The place at a share of the way round, from the trailing edge along the upper side. Places lie closer together at the edges.
    ///
    /// Thickness: y = 5·t·(0.2969·√x - 0.1260·x - 0.3516·x² + 0.2843·x³ - 0.1036·x⁴), across the mean line.
    pub(crate) fn place_mm(&self, share: f64) -> [f64; 2] {
        let angle = TAU * share;
        let x = 0.5 * (1.0 + angle.cos());
        let side = if share < 0.5 { 1.0 } else { -1.0 };
        let [camber, place, thickness] = self.shares();
        let half = 5.0
            * thickness
            * (0.2969 * x.sqrt() + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1036 * x))));
        let (mean, slope) = if camber == 0.0 || place == 0.0 {
            (0.0, 0.0)
        } else {
            let (over, rest) =
                if x < place { (place, 0.0) } else { (1.0 - place, 1.0 - 2.0 * place) };
            let factor = camber / (over * over);
            (factor * (rest + 2.0 * place * x - x * x), 2.0 * factor * (place - x))
        };
        let (sin, cos) = slope.atan().sin_cos();
        let [x, y] = [x - side * half * sin, mean + side * half * cos];
        [self.chord_mm * (x - 0.5), self.chord_mm * y]
    }

    /// Camber, its place and the thickness, as shares of the chord.
    pub(crate) fn shares(&self) -> [f64; 3] {
        let [camber, place, thickness] =
            [self.naca / 1000, self.naca / 100 % 10, self.naca % 100].map(f64::from);
        [camber / 100.0, place / 10.0, thickness / 100.0]
    }
}

/// Corners of the polygon along which lengths are measured: eight a point, within these bounds.
const FEWEST_CORNERS: usize = 4_000;
const MOST_CORNERS: usize = 400_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_equally_far_apart() {
        let section = Section { chord_mm: 60.0, naca: 2412 };
        let path = section.path_mm(500);
        let next = path.iter().cycle().skip(1);
        let steps: Vec<f64> =
            path.iter().zip(next).map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).collect();
        let mean = steps.iter().sum::<f64>() / 500.0;
        // A chord across the round leading edge is a little shorter, and across the corner behind much.
        assert!(steps[..499].iter().all(|step| (step / mean - 1.0).abs() < 0.02), "{steps:?}");
        assert_eq!(path.len(), 500);
        assert!(section.path_mm(0).is_empty() && section.path_mm(1)[0][0] < -29.0);
    }

    #[test]
    fn a_symmetric_section_has_its_thickness_and_closes() {
        let section = Section { chord_mm: 100.0, naca: 12 };
        let places: Vec<[f64; 2]> =
            (0..2000).map(|k| section.place_mm(f64::from(k) / 2000.0)).collect();
        assert!((places[0][0] - 50.0).abs() < 1e-9 && places[0][1].abs() < 1e-9);
        assert!((places[1000][0] + 50.0).abs() < 1e-9 && places[1000][1].abs() < 1e-9);
        let highest = places.iter().map(|place| place[1]).fold(0.0, f64::max);
        assert!((highest - 6.0).abs() < 0.005, "{highest}");
        // Both sides are alike.
        for k in 1..1000 {
            let [upper, lower] = [places[k], places[2000 - k]];
            assert!((upper[0] - lower[0]).abs() < 1e-9 && (upper[1] + lower[1]).abs() < 1e-9);
        }
    }

    #[test]
    fn a_cambered_section_has_its_mean_line_at_its_place() {
        let section = Section { chord_mm: 1.0, naca: 2412 };
        assert_eq!(section.shares(), [0.02, 0.4, 0.12]);
        // At the highest place of the mean line both sides lie straight above and below it.
        let share = (-0.2_f64).acos() / TAU;
        let [upper, lower] = [section.place_mm(share), section.place_mm(1.0 - share)];
        assert!((upper[0] + 0.1).abs() < 1e-12 && (lower[0] + 0.1).abs() < 1e-12);
        assert!((0.5 * (upper[1] + lower[1]) - 0.02).abs() < 1e-12);
    }
}
