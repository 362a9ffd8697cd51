//! What to measure next: regions as reports write them, and places to go to.

use std::fmt::Write as _;

use asphera_geometry::PointMm;
use asphera_report::{NextFigures, PolygonFigures, Waypoints};
use asphera_surface::coverage::{Coverage, Patch, PlanError, Polygon, Ring, waypoints};

use super::places::Lifted;

/// The regions that are not covered, with all that is needed to go there.
#[derive(Clone, Debug)]
pub struct Next {
    patches: Vec<Patch>,
    /// The spacing in the plane for regions that name none, in mm.
    otherwise_mm: Option<f64>,
    lifted: Lifted<'static>,
}

impl Next {
    pub(super) fn new(
        patches: Vec<Patch>,
        otherwise_mm: Option<f64>,
        lifted: Lifted<'static>,
    ) -> Next {
        Next { patches, otherwise_mm, lifted }
    }

    /// Places to measure in each region, the first region first.
    pub fn waypoints(&self) -> Waypoints {
        places_to_go(&self.patches, self.otherwise_mm, &self.lifted)
    }
}

/// Places to measure in each region, region by region in their order, as far as [`MOST_PLACES`] reach.
pub(super) fn places_to_go(
    patches: &[Patch],
    otherwise_mm: Option<f64>,
    lifted: &Lifted<'_>,
) -> Waypoints {
    let mut found =
        Waypoints { csv: "region,x_mm,y_mm,z_mm\n".to_owned(), places: 0, regions: 0, left_out: 0 };
    for (index, patch) in patches.iter().enumerate() {
        let limit = MOST_PLACES - found.places;
        match waypoints(std::slice::from_ref(patch), otherwise_mm, limit) {
            Ok(places) => {
                found.regions += 1;
                found.places += places.len();
                for place in places {
                    let [x, y, z] = lifted.at(place.at_mm);
                    // Writing into a String cannot fail.
                    let _ = writeln!(found.csv, "{},{x:.6},{y:.6},{z:.6}", index + 1);
                }
            }
            Err(
                PlanError::Spacing { .. } | PlanError::TooMany { .. } | PlanError::Figure { .. },
            ) => {
                found.left_out += 1;
            }
        }
    }
    found
}

/// The first regions as reports write them.
pub(super) fn figures(coverage: &Coverage, lifted: &Lifted<'_>) -> Vec<NextFigures> {
    let aperture_mm2 = coverage.areas.map(|areas| areas.aperture_mm2);
    let figures = |patch: &Patch| {
        let (polygons, simplified_mm) = drawn(patch, lifted);
        NextFigures {
            area_mm2: patch.area_mm2,
            undersampled_mm2: patch.undersampled_mm2,
            uncovered_mm2: patch.uncovered_mm2,
            adds_coverage: aperture_mm2
                .filter(|aperture_mm2| *aperture_mm2 > 0.0)
                .map(|aperture_mm2| (patch.missing_mm2() / aperture_mm2).min(1.0)),
            epsilon_max: patch.epsilon_max.filter(|epsilon| epsilon.is_finite()),
            gap_max_mm: patch.gap_max_mm,
            spacing_needed_mm: patch.spacing.mm(),
            points_needed: patch.samples_needed().map(|count| count as u64),
            at_mm: rounded(lifted.at(patch.inside_mm)),
            approach: None,
            polygons,
            simplified_mm: (1e9 * simplified_mm).ceil() / 1e9,
        }
    };
    coverage.patches.iter().take(MOST_REGIONS).map(figures).collect()
}

/// The polygons of a region with few enough places, and how far their lines were moved for it in mm.
fn drawn(patch: &Patch, lifted: &Lifted<'_>) -> (Vec<PolygonFigures>, f64) {
    let places =
        |polygon: &Polygon| polygon.rings().map(|ring| ring.places_mm.len()).sum::<usize>();
    let mut tolerance_mm = 0.0;
    let mut most = 0.01 * patch.area_mm2.sqrt();
    let count: usize = patch.polygons.iter().map(places).sum();
    let thinned = |tolerance_mm: f64| -> Vec<[Vec<Vec<[f64; 2]>>; 1]> {
        let rings = |polygon: &Polygon| {
            [polygon.rings().map(|ring| simplified(ring, tolerance_mm)).collect()]
        };
        patch.polygons.iter().map(rings).collect()
    };
    let mut found = thinned(0.0);
    if count > MOST_CORNERS {
        // The finest that is coarse enough, to a factor of two.
        most *= 2.0_f64.powi(-8);
        loop {
            tolerance_mm = most;
            found = thinned(tolerance_mm);
            let left: usize = found.iter().flatten().flatten().map(Vec::len).sum();
            let least: usize = 4 * found.iter().flatten().map(Vec::len).sum::<usize>();
            if left <= MOST_CORNERS.max(least) {
                break;
            }
            most *= 2.0;
        }
    }
    let lift = |ring: &Vec<[f64; 2]>| -> Vec<PointMm> {
        ring.iter().map(|&place| rounded(lifted.at(place))).collect()
    };
    let polygons = found.iter().flatten().filter_map(|rings| {
        let (outline, holes) = rings.split_first()?;
        let holes_mm = holes.iter().filter(|hole| hole.len() > 2).map(lift).collect();
        Some(PolygonFigures { outline_mm: lift(outline), holes_mm })
    });
    (polygons.collect(), tolerance_mm)
}

/// A closed line with only those of its places that keep it within a tolerance of what it was: D. H. Douglas,
/// T. K. Peucker, Cartographica 10 (1973) 112-122, doi:10.3138/FM57-6770-U75U-7727, of its two halves.
fn simplified(ring: &Ring, tolerance_mm: f64) -> Vec<[f64; 2]> {
    let places = &ring.places_mm;
    if tolerance_mm <= 0.0 || places.len() < 4 {
        return places.clone();
    }
    let [x, y] = places[0];
    let far_mm = |place: &[f64; 2]| (place[0] - x).hypot(place[1] - y);
    let opposite = (0..places.len())
        .max_by(|&i, &j| far_mm(&places[i]).total_cmp(&far_mm(&places[j])))
        .unwrap_or(0);
    let at = |index: usize| places[index % places.len()];
    let mut keep = vec![false; places.len()];
    keep[0] = true;
    keep[opposite] = true;
    let mut open = vec![(0, opposite), (opposite, places.len())];
    while let Some((from, to)) = open.pop() {
        let farthest = (from + 1..to)
            .map(|index| (distance_mm(at(index), at(from), at(to)), index))
            .max_by(|left, right| left.0.total_cmp(&right.0));
        if let Some((mm, index)) = farthest.filter(|&(mm, _)| mm > tolerance_mm) {
            debug_assert!(mm.is_finite());
            keep[index] = true;
            open.push((from, index));
            open.push((index, to));
        }
    }
    places.iter().zip(keep).filter_map(|(&place, keep)| keep.then_some(place)).collect()
}

/// To a nanometre: a report with up to 5,000 corners is long enough.
fn rounded(place_mm: PointMm) -> PointMm {
    // Adding zero makes negative zero positive.
    place_mm.map(|mm| (1e6 * mm).round() / 1e6 + 0.0)
}

/// From a place to the line between two others.
fn distance_mm(at: [f64; 2], p: [f64; 2], q: [f64; 2]) -> f64 {
    let way = [q[0] - p[0], q[1] - p[1]];
    let from = [at[0] - p[0], at[1] - p[1]];
    let squared = way[0] * way[0] + way[1] * way[1];
    let along = from[0] * way[0] + from[1] * way[1];
    let share = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    (from[0] - share * way[0]).hypot(from[1] - share * way[1])
}

/// Regions in a report.
pub(super) const MOST_REGIONS: usize = 20;
/// Corners of the polygons of a region in a report.
const MOST_CORNERS: usize = 256;
/// Places to go to, of all regions.
pub const MOST_PLACES: usize = 200_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_keeps_its_shape_within_the_tolerance() {
        let circle = |count: usize| -> Vec<[f64; 2]> {
            (0..count)
                .map(|i| (i as f64 / count as f64 * std::f64::consts::TAU).sin_cos())
                .map(|(sin, cos)| [10.0 * cos, 10.0 * sin])
                .collect()
        };
        let ring = Ring { places_mm: circle(5000), open: vec![false; 5000] };
        assert_eq!(simplified(&ring, 0.0), ring.places_mm);
        let found = simplified(&ring, 0.01);
        // A chord of half angle a lies 10·(1 - cos a) inside: 0.01 mm at 2.6°.
        assert!((60..200).contains(&found.len()), "{}", found.len());
        for place in &ring.places_mm {
            let sides = found.iter().zip(found.iter().cycle().skip(1));
            let near =
                sides.map(|(&p, &q)| distance_mm(*place, p, q)).fold(f64::INFINITY, f64::min);
            assert!(near <= 0.01, "{near}");
        }
    }
}
