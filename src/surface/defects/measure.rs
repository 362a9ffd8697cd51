//! What a set of vertices is: its kind, place, size and depth.
//!
//! **Size.** What is seen of a defect depends on the noise. So area, length and width are those of the
//! part deeper than half of its depth, cut out of the triangles by linear interpolation: of a flat
//! bottom with steep flanks the whole of it, of a Gaussian dimple the full width at half maximum.
//! Where the depth is below eight standard deviations of the noise, means over the first ring take
//! the place of single readings.
//!
//! **Depth.** Of a pit or bump the extreme of a cubic through the residuals within two rings of the
//! deepest place; where that does not follow them to 5 % of the depth, the deepest reading. Of a
//! scratch that of the profile across it, folded along its length.
//!
//! **Kind.** One or two single readings beyond the threshold are a spike. What is at least four times
//! as long as wide is a scratch or ridge, else it is a pit or bump. Lengths are those of the uniform
//! ellipse, or of a scratch the uniform line, with the same second moments. If these hold less than
//! half of the area their ellipse would have, it is bent, and half its perimeter is its length; of a
//! scratch of few samples across the perimeter is rough, and the length up to a fifth too large.

use asphera_geometry::{BoundsMm, VertexId};

use super::detect::Found;
use super::profile;
use super::shape::{Above, above, principal};
use super::{Defect, DefectKind, Samples};
use crate::curvature::{CUBIC, Local, QUADRIC, Rings, System, derivatives, terms_at};

/// Length over width from which on a defect is a scratch.
pub(super) const ELONGATED: f64 = 4.0;
/// Standard deviations below which single readings are averaged.
const WEAK: f64 = 8.0;
/// How much of the depth a cubic may miss.
const FOLLOWED: f64 = 0.05;
/// Standard deviation of an area that is counted out in samples, over the root of the number of
/// samples along its perimeter, in areas of one: a boundary anywhere between two samples.
const COUNTED: f64 = 0.29;
/// How near a vertex of a defect is to a place on it, in spacings.
const ON_IT: f64 = 1.5;
/// Largest condition of a fit that is used.
const CONDITION: f64 = 1e3;

/// Residuals along the normal, and what is known of them.
pub(super) struct Field<'a> {
    pub(super) samples: Samples<'a>,
    /// By vertex in mm; NaN where not known.
    pub(super) residuals_mm: &'a [f64],
    /// Projected area of each vertex in mm².
    pub(super) areas_mm2: &'a [f64],
    pub(super) sigma_mm: f64,
    pub(super) spacing_mm: f64,
    pub(super) threshold: f64,
}

/// What of the field belongs to a defect.
pub(super) struct Zone<'a> {
    pub(super) found: &'a Found,
    /// Its vertices and those within two rings, ascending.
    pub(super) vertices: Vec<VertexId>,
    /// Triangles about them.
    pub(super) triangles: Vec<[VertexId; 3]>,
    /// Area over projected area.
    pub(super) secant: f64,
    /// Standard uncertainty of the reference in mm.
    pub(super) reference_mm: f64,
}

impl Field<'_> {
    pub(super) fn place_mm(&self, vertex: VertexId) -> [f64; 2] {
        let [x, y, _] = self.samples.points[vertex as usize];
        [x, y]
    }

    /// Residual of a vertex in mm, or its mean over the first ring.
    fn value_mm(&self, vertex: VertexId, averaged: bool) -> f64 {
        let own = self.residuals_mm[vertex as usize];
        if !averaged || !own.is_finite() {
            return own;
        }
        let (mut sum, mut count) = (own, 1.0);
        for &other in self.samples.adjacency.neighbours(vertex) {
            let value = self.residuals_mm[other as usize];
            if value.is_finite() {
                sum += value;
                count += 1.0;
            }
        }
        sum / count
    }

    /// Measures a defect.
    pub(super) fn measure(&self, zone: &Zone<'_>) -> Defect {
        let sign = if zone.found.raised { 1.0 } else { -1.0 };
        let vertices = &zone.found.vertices;
        let deepest = |averaged: bool| {
            vertices
                .iter()
                .map(|&vertex| (sign * self.value_mm(vertex, averaged), vertex))
                .reduce(|best, other| if self.deeper(other, best) { other } else { best })
        };
        let single = deepest(false).expect("a defect has a vertex");
        let averaged = single.0 < WEAK * self.sigma_mm
            || deepest(true).is_some_and(|best| best.0 < 0.5 * WEAK * self.sigma_mm);
        let spike = vertices.len() <= 2 && single.0 >= self.threshold * self.sigma_mm;
        let (peak, rest) = if spike {
            ((single.0, self.sigma_mm), false)
        } else {
            let start = deepest(averaged).unwrap_or(single);
            (self.extreme(self.middle(vertices, start, sign, averaged), sign), averaged)
        };
        let mut measured = self.extent(zone, sign, rest, peak.0);
        let (mut height, mut width) = (peak, None);
        let long = measured.axes.is_some_and(|axes| axes.length_mm >= ELONGATED * axes.width_mm);
        let kind = match (spike, long, zone.found.raised) {
            (true, ..) => DefectKind::Spike,
            (_, true, false) => DefectKind::Scratch,
            (_, true, true) => DefectKind::Ridge,
            (_, false, false) => DefectKind::Pit,
            (_, false, true) => DefectKind::Bump,
        };
        if long && let Some(axes) = measured.axes.filter(|axes| !axes.bent) {
            let samples = zone
                .vertices
                .iter()
                .map(|&vertex| (self.place_mm(vertex), sign * self.residuals_mm[vertex as usize]));
            if let Some(profile) =
                profile::across(samples, &measured.core, &axes, self.spacing_mm, self.sigma_mm)
            {
                height = (profile.depth_mm, profile.uncertainty_mm);
                width = Some(profile.width_mm);
                measured = self.extent(zone, sign, false, profile.depth_mm);
            }
        }
        let uncertainty_mm = height.1.hypot(zone.reference_mm);
        let along = (measured.above.contour_mm / self.spacing_mm).max(1.0);
        // Along the contour every sample errs by itself, of means over a ring every third.
        let single_mm = self.sigma_mm / along.sqrt();
        let shift_mm = single_mm.hypot(0.5 * uncertainty_mm);
        let level =
            |shift_mm: f64| self.above(zone, sign, rest, 0.5 * height.0 + shift_mm).area_mm2;
        let by_level = 0.5 * (level(-shift_mm) - level(shift_mm)).abs();
        let counted = COUNTED * along.sqrt() * self.spacing_mm.powi(2);
        let axes = measured.axes;
        let centre = self.centre(vertices, deepest(averaged).unwrap_or(single).1);
        Defect {
            kind,
            centre_mm: centre,
            bounds_mm: self.bounds(vertices),
            area_mm2: (!spike).then_some(measured.above.area_mm2),
            area_uncertainty_mm2: (!spike).then_some(by_level.hypot(counted)),
            length_mm: axes.filter(|_| !spike).map(|axes| axes.length_mm),
            width_mm: axes.filter(|_| !spike).map(|axes| width.unwrap_or(axes.width_mm)),
            direction: axes.filter(|axes| !spike && !axes.bent).map(|axes| axes.direction),
            height_mm: sign * height.0,
            height_uncertainty_mm: uncertainty_mm,
            volume_mm3: (!spike).then(|| self.volume(zone)),
            vertices: vertices.len() as u64,
            on_border: vertices.iter().any(|&vertex| self.samples.adjacency.on_border(vertex)),
            significance: zone.found.significance,
        }
    }

    /// Whether one value and vertex come before another: ties by place.
    fn deeper(&self, (value, vertex): (f64, VertexId), (other, of): (f64, VertexId)) -> bool {
        let [p, q] = [vertex, of].map(|vertex| self.place_mm(vertex));
        value.total_cmp(&other).then(p[0].total_cmp(&q[0])).then(p[1].total_cmp(&q[1])).is_gt()
    }

    /// The vertex in the middle of those at least half as deep as the deepest, if it is one of them.
    ///
    /// The deepest is so by noise too; a fit about it would make that depth.
    fn middle(
        &self,
        vertices: &[VertexId],
        deepest: (f64, VertexId),
        sign: f64,
        averaged: bool,
    ) -> (f64, VertexId) {
        let deep: Vec<(f64, VertexId)> = vertices
            .iter()
            .map(|&vertex| (sign * self.value_mm(vertex, averaged), vertex))
            .filter(|&(value, _)| value >= 0.5 * deepest.0)
            .collect();
        let total: f64 = deep.iter().map(|(value, _)| value).sum();
        let origin = self.place_mm(deepest.1);
        let place = [0, 1].map(|axis| {
            let parts =
                deep.iter().map(|&(value, of)| value * (self.place_mm(of)[axis] - origin[axis]));
            origin[axis] + parts.sum::<f64>() / total
        });
        let away = |vertex: VertexId| {
            let at = self.place_mm(vertex);
            (at[0] - place[0]).hypot(at[1] - place[1])
        };
        let nearest = deep
            .into_iter()
            .min_by(|p, q| away(p.1).total_cmp(&away(q.1)))
            .filter(|&(_, vertex)| away(vertex) <= 1.5 * self.spacing_mm);
        nearest.map_or(deepest, |(_, vertex)| (deepest.0, vertex))
    }

    /// Depth in mm about a vertex and its standard uncertainty.
    fn extreme(&self, (value, vertex): (f64, VertexId), sign: f64) -> (f64, f64) {
        let alone = (value, self.sigma_mm);
        let mut rings = Rings::default();
        rings.gather(self.samples.adjacency, vertex, 2);
        let samples: Vec<VertexId> = rings
            .samples()
            .iter()
            .copied()
            .filter(|&sample| self.residuals_mm[sample as usize].is_finite())
            .collect();
        let mut places = Vec::new();
        let Ok(local) = Local::of(self.samples.points, &samples, &mut places) else { return alone };
        for (place, &sample) in places.iter_mut().zip(&samples) {
            place[2] = sign * self.residuals_mm[sample as usize];
        }
        let found = polynomial::<CUBIC>(&places).or_else(|| polynomial::<QUADRIC>(&places));
        let Some(Polynomial { terms, variance, deviation_mm }) = found else { return alone };
        let [height, gx, gy, xx, xy, yy] = local.in_mm(terms);
        let determinant = xx * yy - xy * xy;
        let mut depth = height;
        if determinant > 0.0 && xx < 0.0 {
            let step = [(xy * gy - yy * gx) / determinant, (xy * gx - xx * gy) / determinant];
            if step[0].hypot(step[1]) <= 1.5 * self.spacing_mm {
                depth += 0.5 * (gx * step[0] + gy * step[1]);
            }
        }
        if deviation_mm <= (1.5 * self.sigma_mm).max(FOLLOWED * depth) {
            // What the polynomial misses beyond the noise it may miss at the extreme too.
            let missed_mm = (deviation_mm.powi(2) - self.sigma_mm.powi(2)).max(0.0).sqrt();
            (depth, missed_mm.hypot(variance.sqrt() * deviation_mm.max(self.sigma_mm)))
        } else if value > WEAK * self.sigma_mm {
            // How deep it is between the samples is not known to better than the samples differ.
            (alone.0, self.sigma_mm.hypot(FOLLOWED * alone.0))
        } else {
            (depth, variance.sqrt() * deviation_mm)
        }
    }

    fn above(&self, zone: &Zone<'_>, sign: f64, averaged: bool, level: f64) -> Above {
        let mut sum = Above::default();
        for corners in &zone.triangles {
            let corners = corners
                .map(|corner| (self.place_mm(corner), sign * self.value_mm(corner, averaged)));
            if corners.iter().any(|corner| !corner.1.is_finite()) {
                continue;
            }
            let part = above(corners, level);
            sum.area_mm2 += part.area_mm2;
            sum.contour_mm += part.contour_mm;
        }
        sum
    }

    fn extent(&self, zone: &Zone<'_>, sign: f64, averaged: bool, depth_mm: f64) -> Extent {
        let level = 0.5 * depth_mm;
        let above = self.above(zone, sign, averaged, level);
        let core: Vec<([f64; 2], f64)> = zone
            .vertices
            .iter()
            .filter(|&&vertex| sign * self.value_mm(vertex, averaged) >= level)
            .map(|&vertex| (self.place_mm(vertex), self.areas_mm2[vertex as usize]))
            .collect();
        let axes = principal(core.iter().copied())
            .filter(|_| core.len() > 2 && above.area_mm2 > 0.0)
            .map(|found| {
                // Every sample stands for a square of one spacing.
                let spread = self.spacing_mm.powi(2) / 12.0;
                let [long, short] = found.variances.map(|variance| (variance + spread).sqrt());
                let ellipse_mm2 = 4.0 * std::f64::consts::PI * long * short;
                let bent = above.area_mm2 < 0.5 * ellipse_mm2;
                let (length_mm, width_mm) = if bent {
                    (0.5 * above.contour_mm, 2.0 * above.area_mm2 / above.contour_mm)
                } else if long >= ELONGATED * short {
                    let length_mm = 12.0_f64.sqrt() * long;
                    (length_mm, above.area_mm2 / length_mm)
                } else {
                    (4.0 * long, 4.0 * short)
                };
                Axes { direction: found.direction, length_mm, width_mm, bent }
            });
        Extent { above, core, axes }
    }

    /// The middle of the residuals, or the deepest place if that middle does not lie on the defect.
    fn centre(&self, vertices: &[VertexId], deepest: VertexId) -> [f64; 3] {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        let origin = self.samples.points[vertices[0] as usize];
        for &vertex in vertices {
            let point = self.samples.points[vertex as usize];
            let index = vertex as usize;
            let weight = self.residuals_mm[index].abs() * self.areas_mm2[index];
            (0..3).for_each(|axis| sum[axis] += weight * (point[axis] - origin[axis]));
            total += weight;
        }
        let middle =
            [0, 1, 2].map(|axis| origin[axis] + if total > 0.0 { sum[axis] / total } else { 0.0 });
        let on_it = vertices.iter().any(|&vertex| {
            let [x, y] = self.place_mm(vertex);
            (x - middle[0]).hypot(y - middle[1]) <= ON_IT * self.spacing_mm
        });
        if on_it { middle } else { self.samples.points[deepest as usize] }
    }

    fn bounds(&self, vertices: &[VertexId]) -> BoundsMm {
        BoundsMm::about(vertices.iter().map(|&vertex| self.place_mm(vertex)))
    }

    /// A residual along the normal over an area in space is as much as one along z over its projection.
    fn volume(&self, zone: &Zone<'_>) -> f64 {
        let parts = zone.vertices.iter().map(|&vertex| vertex as usize);
        let known = parts.filter(|&index| self.residuals_mm[index].is_finite());
        zone.secant
            * known.map(|index| self.residuals_mm[index] * self.areas_mm2[index]).sum::<f64>()
    }
}

/// The part deeper than half of the depth.
struct Extent {
    above: Above,
    /// Its vertices and their areas in mm².
    core: Vec<([f64; 2], f64)>,
    /// `None` where too few samples lie in it.
    axes: Option<Axes>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    pub(super) direction: [f64; 2],
    pub(super) length_mm: f64,
    pub(super) width_mm: f64,
    bent: bool,
}

struct Polynomial {
    /// Height, slopes and second derivatives at the vertex.
    terms: [f64; 6],
    /// Variance of the height at the vertex for heights of variance 1.
    variance: f64,
    /// Standard deviation of the heights from the polynomial.
    deviation_mm: f64,
}

fn polynomial<const N: usize>(places: &[[f64; 3]]) -> Option<Polynomial> {
    if places.len() < N + 3 {
        return None;
    }
    let system = System::<N>::of(places, CONDITION)?;
    let (terms, _) = system.solve(places);
    let squares: f64 = places
        .iter()
        .map(|place| {
            let fitted: f64 = terms_at::<N>(place).iter().zip(&terms).map(|(p, q)| p * q).sum();
            (place[2] - fitted).powi(2)
        })
        .sum();
    let at_vertex = system.forward(terms_at::<N>(&[0.0; 3]));
    Some(Polynomial {
        terms: derivatives(&terms),
        variance: at_vertex.iter().map(|part| part * part).sum(),
        deviation_mm: (squares / (places.len() - N) as f64).sqrt(),
    })
}
