//! The openings of a mesh: loops of its border, with their place, their area and the way a probe comes from.

use asphera_geometry::PointMm;
use asphera_geometry::vector::{Vector, cross, dot, length, minus, plus, unit};

use super::meshed::Meshed;
use super::sampled::solid_angle;
use super::shape::{Laid, Shape, across};

/// A loop of the border.
#[derive(Clone, Debug)]
pub(super) struct Opening {
    pub(super) edges: usize,
    pub(super) length_mm: f64,
    /// The middle of its corners, on the shape where there is one.
    pub(super) at_mm: PointMm,
    /// Out of the material.
    pub(super) approach: Option<Vector>,
    /// Area: on the shape of a sphere or cylinder, else as seen along that.
    pub(super) area_mm2: Option<f64>,
    /// Largest distance of a corner from the middle.
    pub(super) radius_mm: f64,
    /// The part of the mesh it belongs to.
    part: u32,
    /// Whether it goes round the axis of a cylinder.
    winds: bool,
    /// Whether the surface should go on there.
    pub(super) is_gap: bool,
}

/// The loops of the border, the longest first. Of a mesh without two sides they are those that its proof lists.
pub(super) fn openings(meshed: &Meshed, laid: Option<&Laid>) -> Vec<Opening> {
    let walked = meshed.proof.is_oriented.then(|| Borders::of(meshed).loops()).flatten();
    let mut found: Vec<Opening> = match walked {
        Some(loops) => {
            let normals = meshed.normals();
            loops
                .iter()
                .map(|(corners, part)| of_loop(meshed, &normals, laid, corners, *part))
                .collect()
        }
        None => meshed.proof.border_loops.iter().map(|border| unsided(meshed, border)).collect(),
    };
    tell_rims(&mut found, laid.map(|laid| laid.shape));
    found.sort_by(|a: &Opening, b: &Opening| {
        let by_place = || a.at_mm.iter().zip(&b.at_mm).map(|(a, b)| a.total_cmp(b));
        let by_length = b.length_mm.total_cmp(&a.length_mm);
        by_place().fold(by_length, std::cmp::Ordering::then)
    });
    found
}

/// Says which loops are the rim of a part that ends. A sphere has none. A tube has those that go round its axis, any other piece
/// its widest.
fn tell_rims(openings: &mut [Opening], shape: Option<Shape>) {
    if matches!(shape, Some(Shape::Sphere { .. })) {
        return;
    }
    let mut parts: Vec<u32> = openings.iter().map(|opening| opening.part).collect();
    parts.sort_unstable();
    parts.dedup();
    for part in parts {
        let of_part = || openings.iter().enumerate().filter(|(_, opening)| opening.part == part);
        let size = |opening: &Opening| opening.area_mm2.unwrap_or(opening.length_mm);
        let rims: Vec<usize> = if of_part().any(|(_, opening)| opening.winds) {
            of_part().filter(|(_, opening)| opening.winds).map(|(at, _)| at).collect()
        } else {
            let widest = of_part().max_by(|(_, a), (_, b)| size(a).total_cmp(&size(b)));
            widest.map(|(at, _)| at).into_iter().collect()
        };
        rims.into_iter().for_each(|at| openings[at].is_gap = false);
    }
}

fn unsided(meshed: &Meshed, border: &asphera_reconstruct::prove::BorderLoop) -> Opening {
    Opening {
        edges: border.edges,
        length_mm: border.length_mm,
        at_mm: meshed.points_mm[border.vertex as usize],
        approach: None,
        area_mm2: None,
        radius_mm: border.length_mm / std::f64::consts::TAU,
        part: 0,
        winds: false,
        is_gap: true,
    }
}

fn of_loop(
    meshed: &Meshed,
    normals: &[Option<Vector>],
    laid: Option<&Laid>,
    corners: &[u32],
    part: u32,
) -> Opening {
    let places: Vec<PointMm> =
        corners.iter().map(|&corner| meshed.points_mm[corner as usize]).collect();
    let first = places[0];
    let ways: Vec<Vector> = places.iter().map(|place| minus(*place, first)).collect();
    let sum = ways.iter().fold([0.0; 3], |sum, way| plus(sum, 1.0, *way));
    let middle = plus(first, 1.0 / places.len() as f64, sum);
    let pairs = || (0..ways.len()).map(|at| (ways[at], ways[(at + 1) % ways.len()]));
    let length_mm = pairs().map(|(from, to)| length(minus(to, from))).sum();
    // The border runs with the material on its left, so its area looks into the material.
    let double_area = pairs().fold([0.0; 3], |sum, (from, to)| plus(sum, -1.0, cross(from, to)));
    let out = corners.iter().filter_map(|&corner| normals[corner as usize]);
    let mean = unit(out.fold([0.0; 3], |sum, normal| plus(sum, 1.0, normal)));
    let (at_mm, approach) = match laid {
        // The middle of a wide loop lies near the centre of the sphere, where nothing is out.
        Some(Laid { shape: Shape::Sphere { radius_mm }, centre_mm, .. }) => {
            let out = unit(double_area).or(mean);
            (out.map_or(middle, |out| plus(*centre_mm, *radius_mm, out)), out)
        }
        Some(laid) => (laid.foot_mm(middle), Some(laid.off(middle).1)),
        None => (middle, unit(double_area).or(mean)),
    };
    let around = laid.filter(|laid| matches!(laid.shape, Shape::Cylinder { .. }));
    let unrolled = around.map(|laid| unrolled(laid, &places));
    let winds = unrolled.is_some_and(|(turns, _)| turns != 0);
    let area_mm2 = match (laid, unrolled) {
        (Some(Laid { shape: Shape::Sphere { radius_mm }, centre_mm, .. }), _) => {
            let apex = minus(at_mm, *centre_mm);
            let corner = |at: usize| minus(places[at % places.len()], *centre_mm);
            let seen = (0..places.len()).map(|at| solid_angle([apex, corner(at + 1), corner(at)]));
            radius_mm * radius_mm * seen.sum::<f64>().abs()
        }
        (_, Some((0, area_mm2))) => area_mm2,
        _ => 0.5 * length(double_area),
    };
    let radius_mm = places.iter().map(|place| length(minus(*place, middle))).fold(0.0, f64::max);
    Opening {
        edges: corners.len(),
        length_mm,
        at_mm,
        approach,
        area_mm2: Some(area_mm2),
        radius_mm,
        part,
        winds,
        is_gap: true,
    }
}

/// How often a loop goes round the axis of a cylinder, and the area inside on the unrolled surface.
fn unrolled(laid: &Laid, places: &[PointMm]) -> (i32, f64) {
    let [u, v] = across(laid.axis);
    let flat: Vec<[f64; 2]> = places
        .iter()
        .map(|place| {
            let way = minus(*place, laid.centre_mm);
            [dot(way, v).atan2(dot(way, u)), dot(way, laid.axis)]
        })
        .collect();
    let (mut turned, mut double_area) = (0.0, 0.0);
    for at in 0..flat.len() {
        let ([from, low], [to, high]) = (flat[at], flat[(at + 1) % flat.len()]);
        let step = (to - from + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
            - std::f64::consts::PI;
        double_area += step * (low + high);
        turned += step;
    }
    let turns = (turned / std::f64::consts::TAU).round() as i32;
    (turns, 0.5 * double_area.abs() * laid.shape.radius_mm())
}

/// Directed edges of the facets, sorted: from, to, facet.
struct Borders<'a> {
    meshed: &'a Meshed,
    edges: Vec<[u32; 3]>,
}

impl Borders<'_> {
    fn of(meshed: &Meshed) -> Borders<'_> {
        let numbered = meshed.facets.iter().zip(0_u32..);
        let mut edges: Vec<[u32; 3]> = numbered
            .flat_map(|(&[a, b, c], facet)| [[a, b, facet], [b, c, facet], [c, a, facet]])
            .collect();
        edges.sort_unstable();
        Borders { meshed, edges }
    }

    fn facet(&self, from: u32, to: u32) -> Option<u32> {
        let at = self.edges.partition_point(|edge| [edge[0], edge[1]] < [from, to]);
        self.edges.get(at).filter(|edge| [edge[0], edge[1]] == [from, to]).map(|edge| edge[2])
    }

    /// The loops of border edges by their corners, each with the part it belongs to; `None` where a walk does not come back, as
    /// at edges of three facets.
    fn loops(&self) -> Option<Vec<(Vec<u32>, u32)>> {
        let is_border = |edge: &[u32; 3]| self.facet(edge[1], edge[0]).is_none();
        let border: Vec<[u32; 3]> = self.edges.iter().copied().filter(is_border).collect();
        let mut is_walked = vec![false; border.len()];
        let mut loops = Vec::new();
        for first in 0..border.len() {
            if is_walked[first] {
                continue;
            }
            let mut corners = Vec::new();
            let mut at = first;
            loop {
                if std::mem::replace(&mut is_walked[at], true) {
                    return None;
                }
                let [from, to, facet] = border[at];
                corners.push(from);
                let next = self.next(to, facet)?;
                at = border.binary_search_by(|edge| [edge[0], edge[1]].cmp(&[to, next])).ok()?;
                if at == first {
                    break;
                }
            }
            loops.push((corners, self.meshed.part_of[border[first][2] as usize]));
        }
        Some(loops)
    }

    /// Where the border goes on at a corner: round the fan of facets from the one before.
    fn next(&self, corner: u32, facet: u32) -> Option<u32> {
        let mut facet = facet;
        for _ in 0..=self.meshed.facets.len() {
            let corners = self.meshed.facets[facet as usize];
            let at = corners.iter().position(|&other| other == corner)?;
            let end = corners[(at + 1) % 3];
            match self.facet(end, corner) {
                Some(beyond) => facet = beyond,
                None => return Some(end),
            }
        }
        None
    }
}
