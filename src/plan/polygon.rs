//! Polygons with holes: which places lie in them.

/// A region with its holes, corners (x, y) in mm. The sense of its rings does not matter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygon {
    /// The outline.
    pub outline_mm: Vec<[f64; 2]>,
    /// Its holes.
    pub holes_mm: Vec<Vec<[f64; 2]>>,
}

impl Polygon {
    /// Whether a place lies inside, or no farther from a line than `slack_mm`.
    pub fn contains(&self, place: [f64; 2], slack_mm: f64) -> bool {
        let mut inside = false;
        for [[ax, ay], [bx, by]] in self.sides() {
            let [x, y] = place;
            if (ay > y) != (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax) {
                inside = !inside;
            }
        }
        inside || self.sides().any(|side| to_side_mm(place, side) <= slack_mm)
    }

    /// Lowest and highest x and y; `None` without corners.
    pub fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let first = *self.outline_mm.first()?;
        let mut bounds = [first, first];
        for corner in &self.outline_mm {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(corner[axis]);
                bounds[1][axis] = bounds[1][axis].max(corner[axis]);
            }
        }
        Some(bounds)
    }

    fn sides(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        [&self.outline_mm].into_iter().chain(&self.holes_mm).flat_map(|ring| {
            ring.iter().copied().zip(ring.iter().copied().cycle().skip(1)).map(|(p, q)| [p, q])
        })
    }
}

/// The distance of a place from a side in mm.
fn to_side_mm(at: [f64; 2], [p, q]: [[f64; 2]; 2]) -> f64 {
    let way = [q[0] - p[0], q[1] - p[1]];
    let from = [at[0] - p[0], at[1] - p[1]];
    let squared = way[0] * way[0] + way[1] * way[1];
    let along = from[0] * way[0] + from[1] * way[1];
    let share = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    (from[0] - share * way[0]).hypot(from[1] - share * way[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_outside_and_lines_have_a_width() {
        let square = |half: f64| vec![[-half, -half], [half, -half], [half, half], [-half, half]];
        let ring = Polygon { outline_mm: square(2.0), holes_mm: vec![square(1.0)] };
        assert!(ring.contains([1.5, 0.3], 0.0) && !ring.contains([0.2, 0.3], 0.0));
        assert!(!ring.contains([2.2, 0.0], 0.1) && ring.contains([2.2, 0.0], 0.25));
        assert!(ring.contains([0.9, 0.0], 0.15));
        assert_eq!(ring.bounds(), Some([[-2.0, -2.0], [2.0, 2.0]]));
        assert!(!Polygon::default().contains([0.0, 0.0], 1.0));
        assert_eq!(Polygon::default().bounds(), None);
    }
}
