//! A region without parameters, with its border moved to where the area is expected to end.

use asphera_geometry::Sets;
use asphera_geometry::predicates::compare_with_right_angle;

use super::alpha::within;
use crate::inside::Inside;
use crate::triangulation::TriangleId;
use crate::{Region, Triangulation};

/// The α-shape of twice the median edge, its ragged border smoothed and moved out.
///
/// Samples at random leave bays in the border of an α-shape that the area does not have. So triangles up to a wider α are taken in as
/// well: up to F median edges, F = 6·(n / 8000)^¼ for n samples, within 3 and 8. Of these, what is truly empty stays out: connected
/// triangles of which one holds the centre of its circumcircle. A bay of the border drains outwards: its centres lie beyond it. That is
/// the flow of H. Edelsbrunner, M. Facello and J. Liang, Discrete Applied Mathematics 88 (1998) 83-102, in the plane.
///
/// Samples within an area end before its border does: by 0.20 + 0.36/F of the median edge. Holes shrink as the outline grows. The rule
/// and its figures are ours, from areas of 500 to 8,000 points at random and on rasters. The gap is for borders that do not run along
/// the rows of a raster: there it is anything from 0 to a row. A concave corner is rounded by the wider α.
///
/// Where the border itself was sampled, nothing is smoothed or moved: where the middle length of border edges is below 0.9 of the
/// median edge and the spread of the middle half of them is below a quarter of it. n·log n time.
pub fn auto_shape(triangulation: &Triangulation) -> Region {
    let by_length = triangulation.by_length();
    let median_mm = by_length.get(by_length.len() / 2).map(|&edge| triangulation.length_mm(edge));
    let Some(median_mm) = median_mm.filter(|_| !triangulation.triangles().is_empty()) else {
        return Region::default();
    };
    let narrow_mm = 2.0 * median_mm;
    let dense = within(triangulation, narrow_mm);
    let region = Region::of(triangulation, &Inside::of(dense.clone()));
    if is_border_sampled(triangulation, &region, median_mm) {
        return region;
    }
    let factor = (6.0 * (triangulation.len() as f64 / 8000.0).sqrt().sqrt()).clamp(3.0, 8.0);
    let wide = within(triangulation, factor * median_mm);
    let smooth = Region::of(triangulation, &Inside::of(smoothed(triangulation, &dense, wide)));
    smooth.moved(median_mm * (0.20 + 0.36 / factor))
}

/// Triangles of a wide α without those that are empty by a narrow one and do not drain outwards.
fn smoothed(triangulation: &Triangulation, dense: &[bool], mut wide: Vec<bool>) -> Vec<bool> {
    let is_between: Vec<bool> =
        dense.iter().zip(&wide).map(|(dense, wide)| *wide && !dense).collect();
    let between = || (0..dense.len() as TriangleId).filter(|&at| is_between[at as usize]);
    let mut sets = Sets::new(dense.len());
    for triangle in between() {
        for beyond in triangulation.across(triangle).into_iter().flatten() {
            if is_between[beyond as usize] {
                sets.join(triangle as usize, beyond as usize);
            }
        }
    }
    let mut is_empty = vec![false; dense.len()];
    for triangle in between().filter(|&triangle| holds_its_centre(triangulation, triangle)) {
        is_empty[sets.root(triangle as usize)] = true;
    }
    for triangle in between() {
        wide[triangle as usize] = !is_empty[sets.root(triangle as usize)];
    }
    wide
}

/// Whether no angle of a triangle is above 90°, exactly: then the centre of its circumcircle lies in it.
fn holds_its_centre(triangulation: &Triangulation, triangle: TriangleId) -> bool {
    let corners = triangulation.triangles()[triangle as usize];
    let [a, b, c] = corners.map(|corner| triangulation.place(corner));
    let angles = [[a, b, c], [b, c, a], [c, a, b]];
    angles.iter().all(|&[at, p, q]| compare_with_right_angle(at, p, q).is_ge())
}

/// Whether the edges of the border are shorter than those within, and alike.
fn is_border_sampled(triangulation: &Triangulation, region: &Region, median_mm: f64) -> bool {
    let edges = region.border().edges().iter();
    let mut ranks: Vec<(u32, u32)> = edges
        .filter_map(|&[p, q]| triangulation.edge_between(p, q))
        .map(|edge| (triangulation.length_class(edge), edge))
        .collect();
    ranks.sort_unstable();
    let at = |quarters: usize| {
        let rank = ranks.get(quarters * ranks.len() / 4);
        rank.map_or(f64::INFINITY, |&(_, edge)| triangulation.length_mm(edge))
    };
    at(2) < 0.9 * median_mm && at(3) - at(1) < 0.25 * at(2)
}
