//! Polygons with holes, as regions are drawn.

use asphera_geometry::outline::ring_contains;
use asphera_geometry::predicates::Place;

use super::draw::Line;

/// A closed line of a region.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Its places x, y in mm, in order, the region on the left. The first is not repeated.
    pub places_mm: Vec<[f64; 2]>,
    /// For each place whether the side from there to the next one faces nothing that is covered: it
    /// lies on the border of the aperture, or cuts through what is not covered either. The other
    /// sides join samples.
    pub open: Vec<bool>,
}

/// A polygon with holes: a region in one piece as it is seen in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Its outline, counter-clockwise.
    pub outline: Ring,
    /// Its holes, clockwise.
    pub holes: Vec<Ring>,
    /// Its area in mm²: that of its lines, which is less than that of the region where the border of
    /// the aperture is a circle.
    pub area_mm2: f64,
}

impl Polygon {
    /// Its closed lines, the outline first.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        std::iter::once(&self.outline).chain(&self.holes)
    }

    /// Its sides: beginning, end, and whether it is open.
    pub(super) fn sides(&self) -> impl Iterator<Item = (Place, Place, bool)> + '_ {
        self.rings().flat_map(Ring::sides)
    }
}

impl Ring {
    pub(super) fn sides(&self) -> impl Iterator<Item = (Place, Place, bool)> + '_ {
        let ends = self.places_mm.iter().cycle().skip(1);
        let sides = self.places_mm.iter().zip(ends).zip(&self.open);
        sides.map(|((&from, &to), &open)| (from, to, open))
    }
}

/// Puts each hole into the outline about it. The largest polygon comes first.
pub(super) fn polygons(mut lines: Vec<Line>) -> Vec<Polygon> {
    lines.sort_by(|left, right| right.signed_area_mm2.total_cmp(&left.signed_area_mm2));
    let ring = |line: Line| Ring { places_mm: line.places_mm, open: line.open };
    let mut found: Vec<Polygon> = Vec::new();
    for line in lines {
        let area_mm2 = line.signed_area_mm2;
        if area_mm2 > 0.0 {
            found.push(Polygon { outline: ring(line), holes: Vec::new(), area_mm2 });
            continue;
        }
        // A hole may touch the outline at a corner, hardly with its middle.
        let within = |polygon: &Polygon| {
            let middle = middle_of_first_side(&line.places_mm);
            ring_contains(&polygon.outline.places_mm, middle)
        };
        // Of outlines inside each other the smallest, which is the last, is the one about the hole.
        let about = if found.len() < 2 {
            found.first_mut()
        } else {
            let at = found.iter().rposition(within);
            at.map(|at| &mut found[at])
        };
        if let Some(polygon) = about {
            polygon.area_mm2 += area_mm2;
            polygon.holes.push(ring(line));
        }
    }
    found
}

fn middle_of_first_side(places: &[Place]) -> Place {
    let next = places[1 % places.len()];
    [0.5 * (places[0][0] + next[0]), 0.5 * (places[0][1] + next[1])]
}

/// A place inside, away from the lines: of the middles of where 17 levels cross the polygons, the one
/// farthest from all sides. None if the polygons have no area.
pub(super) fn place_inside(polygons: &[Polygon]) -> Option<Place> {
    let sides: Vec<(Place, Place)> =
        polygons.iter().flat_map(Polygon::sides).map(|(p, q, _)| (p, q)).collect();
    let heights = || sides.iter().map(|(p, _)| p[1]);
    let (low, high) =
        (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let mut best: Option<(f64, Place)> = None;
    let mut crossings = Vec::new();
    for level in 0..LEVELS {
        let y = low + (level as f64 + 0.5) / LEVELS as f64 * (high - low);
        crossings.clear();
        for &(p, q) in &sides {
            if (p[1] > y) != (q[1] > y) {
                crossings.push(p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]));
            }
        }
        crossings.sort_by(f64::total_cmp);
        // The widest crossing of a level stands for it.
        let widest = crossings
            .chunks_exact(2)
            .max_by(|left, right| (left[1] - left[0]).total_cmp(&(right[1] - right[0])));
        let Some(&[from, to]) = widest else { continue };
        let at = [0.5 * (from + to), y];
        let clear = sides.iter().map(|&(p, q)| distance_mm(at, p, q)).fold(f64::INFINITY, f64::min);
        if to > from && best.is_none_or(|(distance, _)| clear > distance) {
            best = Some((clear, at));
        }
    }
    best.map(|(_, at)| at)
}

fn distance_mm(at: Place, p: Place, q: Place) -> f64 {
    let way = [q[0] - p[0], q[1] - p[1]];
    let from = [at[0] - p[0], at[1] - p[1]];
    let squared = way[0] * way[0] + way[1] * way[1];
    let along = from[0] * way[0] + from[1] * way[1];
    let share = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    (from[0] - share * way[0]).hypot(from[1] - share * way[1])
}

const LEVELS: usize = 17;

#[cfg(test)]
mod tests {
    use super::*;

    fn line(places: &[Place], signed_area_mm2: f64) -> Line {
        Line { places_mm: places.to_vec(), open: vec![false; places.len()], signed_area_mm2 }
    }

    fn square(low: f64, high: f64) -> Line {
        let size = high - low;
        line(&[[low, low], [high, low], [high, high], [low, high]], size * size)
    }

    fn hole(low: f64, high: f64) -> Line {
        let mut line = square(low, high);
        line.places_mm.reverse();
        line.signed_area_mm2 *= -1.0;
        line
    }

    #[test]
    fn holes_go_to_their_outlines() {
        let found = polygons(vec![
            square(20.0, 24.0),
            hole(2.0, 8.0),
            square(0.0, 10.0),
            hole(21.0, 22.0),
            square(3.0, 7.0),
            hole(4.0, 5.0),
        ]);
        let seen: Vec<(f64, usize)> =
            found.iter().map(|polygon| (polygon.area_mm2, polygon.holes.len())).collect();
        assert_eq!(seen, [(64.0, 1), (15.0, 1), (15.0, 1)]);
        let inside = place_inside(&found[..1]).unwrap();
        let clear = |low: f64, high: f64| inside.iter().all(|mm| (low..=high).contains(mm));
        assert!(clear(0.0, 10.0) && !clear(2.0, 8.0), "{inside:?}");
        assert_eq!(place_inside(&[]), None);
    }
}
