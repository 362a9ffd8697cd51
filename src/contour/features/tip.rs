//! The ends of an airfoil's section: a round edge, or a corner of its two sides.

use super::circle::{Fitted, solved};
use super::course::Noise;
use super::polynomial::Polynomial;
use super::profile::Estimate;
use super::section::Section;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// An end of a section.
pub(super) struct Tip {
    /// Its place along and across the chord, mm.
    pub(super) at: PlaceMm,
    /// Standard uncertainty along the chord, mm.
    pub(super) u_mm: f64,
    /// Whether the sides meet there in a corner.
    pub(super) is_corner: bool,
}

impl Tip {
    /// An end of a section: a corner where the sides, going on, fit its last points better by half than a circle does; else round.
    pub(super) fn new(
        section: &Section,
        end: usize,
        thickness_mm: f64,
        noise: &Noise,
    ) -> Result<Tip, String> {
        let at = section.words(end);
        let zone_mm = thickness_mm / ZONE;
        let near = section.near(end, zone_mm);
        if near.len() < LEAST_OF_TIP {
            return Err(format!(
                "airfoil: {} points lie within {zone_mm:.4} mm of the end of the chord near {at}, {LEAST_OF_TIP} or more are needed; measure more points there",
                near.len()
            ));
        }
        let places: Vec<PlaceMm> = near.iter().map(|&index| section.places[index]).collect();
        let circle_mm2 = Fitted::circle(&places).map_or(f64::INFINITY, |circle| {
            let off = |&place: &PlaceMm| distance_mm(place, circle.centre_mm()) - circle.radius_mm;
            places.iter().map(|place| off(place).powi(2)).sum()
        });
        // Finer than this the polynomials are not.
        let fine_mm = noise.sigma_mm.max(FINE * thickness_mm);
        let noise_mm2 = near.len() as f64 * fine_mm * fine_mm;
        let corner = Corner::new(section, end, noise);
        let corner_mm2 = corner.as_ref().map_or(f64::INFINITY, |it| it.squares_mm2(&places));
        if corner_mm2 < 0.5 * circle_mm2
            && corner_mm2 <= FIT * noise_mm2
            && let Some(corner) = corner
        {
            return Ok(corner.tip);
        }
        let round_mm2 = near.len() as f64 * (ROUND * zone_mm).powi(2);
        if circle_mm2 > FIT * noise_mm2 + round_mm2 {
            return Err(format!(
                "airfoil: the end of the chord near {at} is neither round nor a corner"
            ));
        }
        vertex(section, end, thickness_mm, noise)
            .ok_or_else(|| format!("airfoil: the end of the chord near {at} has no vertex"))
    }

    /// The radius of the circle of least squares of a round end, as deep as a [`ZONE`]th of the thickness.
    ///
    /// Every length of the curve counts by how much of that depth is left at its place. So neither the density of the points nor where they
    /// lie moves the radius.
    pub(super) fn radius(
        &self,
        section: &Section,
        end: usize,
        thickness_mm: f64,
        noise: &Noise,
    ) -> Result<Estimate, String> {
        if self.is_corner {
            return Err("the edge is a corner".to_owned());
        }
        let zone_mm = thickness_mm / ZONE;
        let near = section.near(end, 2.0 * zone_mm);
        let radius = |section: &Section| {
            let tip_mm = vertex(section, end, thickness_mm, noise)?.at[0];
            let depth_mm = |place: PlaceMm| Section::outward(end) * (tip_mm - place[0]);
            let places: Vec<PlaceMm> = near.iter().map(|&index| section.places[index]).collect();
            weighted_circle(&places, zone_mm, depth_mm)
        };
        let missing = || "the points of the edge lie on no circle".to_owned();
        let value = radius(section).ok_or_else(missing)?;
        // Each point moves the circle and the end of the chord, from which the depth counts.
        let mut variance_mm2 = 0.0;
        for &index in &near {
            let moved = section.moved(index, noise.sigma_mm);
            variance_mm2 += (radius(&moved).ok_or_else(missing)? - value).powi(2);
        }
        Ok(Estimate { value, u: variance_mm2.sqrt() })
    }
}

/// The radius of the circle of least squares of places with their [`weights`].
fn weighted_circle(
    places: &[PlaceMm],
    zone_mm: f64,
    depth_mm: impl Fn(PlaceMm) -> f64,
) -> Option<f64> {
    let is_inner = |place: &PlaceMm| depth_mm(*place) <= zone_mm;
    let inner: Vec<PlaceMm> = places.iter().copied().filter(is_inner).collect();
    let fitted = Fitted::circle(&inner)?;
    let (mut centre, mut radius) = (fitted.centre_mm(), fitted.radius_mm);
    let weights = weights(places, zone_mm, &depth_mm);
    for _ in 0..STEPS {
        let (normal, right) = sums(places, &weights, centre, radius);
        let [da, db, dr] = solved(normal, right)?;
        centre = [centre[0] + da, centre[1] + db];
        radius += dr;
    }
    (radius.is_finite() && radius > 0.0).then_some(radius)
}

/// The length of the curve that is nearer to each place than to the others, times what is left of the depth of the zone. Noise lengthens the
/// way from place to place, everywhere alike.
fn weights(places: &[PlaceMm], zone_mm: f64, depth_mm: impl Fn(PlaceMm) -> f64) -> Vec<f64> {
    let half = |p: Option<&PlaceMm>, q: &PlaceMm| p.map_or(0.0, |p| 0.5 * distance_mm(*p, *q));
    let weight = |index: usize| {
        let own = &places[index];
        let before = half(index.checked_sub(1).and_then(|it| places.get(it)), own);
        let length_mm = before + half(places.get(index + 1), own);
        length_mm * (1.0 - depth_mm(*own) / zone_mm).max(0.0)
    };
    (0..places.len()).map(weight).collect()
}

/// Sums of a step of Gauss and Newton's iteration with weights: JᵀWJ and the right side.
fn sums(
    places: &[PlaceMm],
    weights: &[f64],
    centre: PlaceMm,
    radius: f64,
) -> ([[f64; 3]; 3], [f64; 3]) {
    let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (&place, &weight) in places.iter().zip(weights) {
        let distance = distance_mm(place, centre);
        let row = [(place[0] - centre[0]) / distance, (place[1] - centre[1]) / distance, 1.0];
        for i in 0..3 {
            for j in 0..3 {
                normal[i][j] += weight * row[i] * row[j];
            }
            right[i] += weight * row[i] * (distance - radius);
        }
    }
    (normal, right)
}

/// The vertex of a round end: the largest value along the chord of the polynomial of degree 4 across it.
fn vertex(section: &Section, end: usize, thickness_mm: f64, noise: &Noise) -> Option<Tip> {
    let outward = Section::outward(end);
    let mut depth_mm = 0.25 * thickness_mm / ZONE;
    let near = loop {
        let near = section.near(end, depth_mm);
        if near.len() >= LEAST_OF_VERTEX {
            break near;
        }
        depth_mm *= 1.5;
    };
    let rows: Vec<[f64; 2]> =
        near.iter().map(|&index| section.places[index]).map(|[u, v]| [v, outward * u]).collect();
    let polynomial = Polynomial::fit(4, &rows)?;
    let [mut low, mut high] = polynomial.range();
    for _ in 0..SEARCHES {
        let [p, q] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if polynomial.value(p) < polynomial.value(q) { low = p } else { high = q }
    }
    let v = 0.5 * (low + high);
    let [from, to] = polynomial.range();
    let is_inner = v - from > 0.02 * (to - from) && to - v > 0.02 * (to - from);
    is_inner.then(|| Tip {
        at: [outward * polynomial.value(v), v],
        u_mm: noise.sigma_mm * polynomial.variance(v).sqrt(),
        is_corner: false,
    })
}

/// Where both sides meet at an end.
struct Corner {
    sides: [Polynomial; 2],
    tip: Tip,
}

impl Corner {
    /// The sides as polynomials of degree 3 over a share of the chord, but for points so near to the end that noise may have mixed them up.
    fn new(section: &Section, end: usize, noise: &Noise) -> Option<Corner> {
        let outward = Section::outward(end);
        let tip = section.places[section.ends[end]][0];
        let [near, far] = [MIXED * noise.sigma_mm, SHARE * section.length_mm()];
        let ends = [tip - outward * near, tip - outward * far];
        let range = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let [first, second] = [0, 1].map(|side| Polynomial::fit(3, &section.side(side, range)));
        let sides = [first?, second?];
        let slope = |u: f64| sides[0].slope(u) - sides[1].slope(u);
        let mut u = tip;
        for _ in 0..20 {
            u -= (sides[0].value(u) - sides[1].value(u)) / slope(u);
        }
        let variance = (sides[0].variance(u) + sides[1].variance(u)) / slope(u).powi(2);
        let is_there = (u - tip).abs() <= 0.1 * far && variance.is_finite();
        let tip = Tip {
            at: [u, 0.5 * (sides[0].value(u) + sides[1].value(u))],
            u_mm: noise.sigma_mm * variance.sqrt(),
            is_corner: true,
        };
        is_there.then_some(Corner { sides, tip })
    }

    /// Sum of squared distances of places to the nearer side, mm².
    fn squares_mm2(&self, places: &[PlaceMm]) -> f64 {
        let off = |side: &Polynomial, [u, v]: PlaceMm| {
            (v - side.value(u)).powi(2) / (1.0 + side.slope(u).powi(2))
        };
        let nearer = |&place: &PlaceMm| off(&self.sides[0], place).min(off(&self.sides[1], place));
        places.iter().map(nearer).sum()
    }
}

/// The thickness over the depth of an edge.
const ZONE: f64 = 20.0;
/// Least points of an edge.
const LEAST_OF_TIP: usize = 10;
/// Least points of the polynomial of a vertex.
const LEAST_OF_VERTEX: usize = 14;
/// Mean square of what a fit leaves, over the noise's, up to which it fits.
const FIT: f64 = 4.0;
/// Share of the thickness that fits are good for.
const FINE: f64 = 1e-4;
/// Deviation of a round end from its circle (root mean square) over the depth of it, at most.
const ROUND: f64 = 0.04;
/// Distance to a corner, in σ, within which points may be of either side.
const MIXED: f64 = 20.0;
/// Share of the chord over which the sides of a corner are fitted.
const SHARE: f64 = 0.05;
/// Steps of the weighted circle; it takes four to eight.
const STEPS: usize = 20;
/// Steps of the search; each leaves two thirds.
const SEARCHES: usize = 80;
