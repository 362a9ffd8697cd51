//! Defects of a surface: pits, scratches, dust, steps and single wrong readings, and its partition by
//! curvature.
//!
//! A defect is what stands off from a smooth reference by more than noise explains, over less than a
//! largest width. [`find_defects`]
//!
//! 1. fits a *reference* that is wide against a defect and not moved by it (`reference.rs`, `fit.rs`), less wide where
//!    form that is long and smooth at the scale of the points asks for it (`windows.rs`), or an edge that is alike along
//!    the border (`edges.rs`);
//! 2. looks for *steps* in what is left, and fits the reference again so that it may jump there
//!    (`steps.rs`);
//! 3. *detects* connected sets of vertices whose residuals are too large (`detect.rs`), so that the
//!    number of false ones to be expected on a whole surface is the caller's choice, by the noise of the place
//!    (`noise_field.rs`), as far as its tails were seen to go (`tail.rs`);
//! 4. *measures* and names each (`measure.rs`). Of bumps so wide that the reference bends towards them it does all this twice,
//!    the second time with their heights taken off before the reference is fitted (`bodies.rs`).
//!
//! On a large surface with a nominal [`search_defects`] does so only where a quick look at its deviations hints at
//! something (`screen.rs`), at a tenth of the time. If the part has an axis, form that is alike all round it is taken off first
//! (`ring_profile.rs`).
//!
//! Depths are along the normal, areas and lengths in the plane of projection.
//!
//! **What it does not see.** Form and waviness that the reference does not follow raise the level from which
//! on something is a defect, about where they are (`followed.rs`). What runs along the border, within six rings of
//! neighbours, over more than some 60 spacings is taken for the form of the edge (`rim_zones.rs`). Where the form near a
//! border is alike along it and moves narrower windows, these take over, up to 60 spacings inwards: pits and grooves wider than a
//! third of them are then seen less well, and what is wide and runs along the border may be lost. A groove or ridge that is
//! longer than 36 spacings, and so wide and smooth that a quartic over fifteen spacings follows it, is form; one without ends if a
//! quartic over seven spacings does. So is a groove or ridge all round the axis, or round a place within five spacings of it,
//! however narrow, and within 13 spacings of the axis what is no higher than such rings about it. A step that rises over more than some twenty spacings is form.
//! Defects nearer to each other than two spacings are one. A step that is hardly above the noise of its cells may be
//! found in several pieces.

mod bodies;
mod cells;
mod detect;
mod edges;
mod fit;
mod followed;
mod ground;
mod line;
mod measure;
mod noise_field;
mod partition;
mod placed;
mod profile;
mod reference;
mod residuals;
mod rim;
mod rim_zones;
mod ring_profile;
mod rows;
mod screen;
mod search;
mod settings;
mod shape;
mod steps;
#[cfg(test)]
mod study;
mod surface;
mod tail;
mod tally;
#[cfg(test)]
mod tests;
mod windows;

use std::cmp::Ordering;

use asphera_geometry::{BoundsMm, PointMm, VertexId};

use self::detect::Found;
use self::ground::Ground;
use self::measure::Zone;
pub use self::partition::{
    Bands, BandsError, Class, CurvatureRegion, Partition, PartitionError, partition,
};
use self::reference::Reference;
pub use self::search::{DefectSearch, DeviatingSurface, search_defects};
pub use self::settings::{DefectSettings, DefectSettingsError, DefectsUnknown, Samples};
use self::steps::Step;
use self::surface::Surface;
use crate::noise::{HeightSteps, edges_of, height_steps};

/// Windows of the reference in largest widths.
const WINDOW: f64 = 3.0;

/// Standard deviations that the residuals of a defect's own vertices add up to, at least.
const OWN_LEAST: f64 = 2.0;

/// How near to a step what stands off is the step's own, in spacings.
const OWN_SPACINGS: f64 = 2.0;

/// What a defect is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DefectKind {
    /// Below the surface, less than four times as long as wide.
    Pit,
    /// Above the surface, less than four times as long as wide: dust, for instance.
    Bump,
    /// Below the surface, at least four times as long as wide.
    Scratch,
    /// Above the surface, at least four times as long as wide: a fibre, for instance.
    Ridge,
    /// A line along which the level of the surface jumps.
    Step,
    /// One or two readings that stand off alone.
    Spike,
}

/// A defect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Defect {
    /// What it is.
    pub kind: DefectKind,
    /// Its middle, weighted by the residuals, or its highest vertex where that middle does not lie on it, as that of a
    /// bent scratch; of a step the middle of its line, at the height of the nearest vertex.
    pub centre_mm: PointMm,
    /// The smallest rectangle about its vertices; of a step about its line.
    pub bounds_mm: BoundsMm,
    /// Projected area in mm² of the part that is deeper than half of the depth; `None` of steps and
    /// spikes, which have none.
    pub area_mm2: Option<f64>,
    /// Standard uncertainty of the area in mm².
    pub area_uncertainty_mm2: Option<f64>,
    /// Length in mm of the same part. `None` of spikes and where too few samples lie in it.
    pub length_mm: Option<f64>,
    /// Width in mm, at most the length. `None` of steps too.
    pub width_mm: Option<f64>,
    /// Unit vector in the plane of projection along the length, in either sense; of a step such that
    /// the higher side lies to its left. `None` of spikes and of what is bent.
    pub direction: Option<[f64; 2]>,
    /// Height in mm along the normal, or depth as a negative number; of a step how much higher its
    /// higher side is. Of a bump wider than a fifth of a window, on form that is no quartic over two windows, it is a lower
    /// bound.
    pub height_mm: f64,
    /// Standard uncertainty of the height in mm.
    pub height_uncertainty_mm: f64,
    /// Volume in mm³ between surface and reference, negative below it; `None` of steps and spikes.
    pub volume_mm3: Option<f64>,
    /// Vertices that stand off; of a step those its height was measured from.
    pub vertices: u64,
    /// Whether it reaches the border of the surface: what is seen of it is then perhaps not all.
    pub on_border: bool,
    /// The sum of its residuals, of a step its height, over the standard deviation that noise gives
    /// that.
    pub significance: f64,
}

/// The defects of a surface, and by what they were found.
#[derive(Clone, Debug)]
pub struct Defects {
    /// The most significant first.
    pub defects: Vec<Defect>,
    /// Standard deviation in mm of the residuals along the normal that counts as noise: that of the
    /// noise, or of half of all residuals if they tell of more. Where noise differs by place it is that of half of the
    /// surface.
    pub sigma_mm: f64,
    /// Standard deviations from which on a single residual is a defect; of the mean of some it is as many, or fewer
    /// where the tails of the noise are long.
    pub threshold: f64,
    /// Largest width of a defect in mm.
    pub largest_mm: f64,
    /// Width in mm of the windows of the reference.
    pub window_mm: f64,
    /// Root of the mean projected area of a vertex, in mm.
    pub spacing_mm: f64,
    /// Vertices of the surface where there is no reference: it is not known whether they are defects.
    pub unreferenced: u64,
    residuals_mm: Vec<f64>,
}

impl Defects {
    /// Residual of a vertex from the reference in mm, along the normal; `None` where there is no such
    /// vertex or no reference.
    pub fn residual_mm(&self, vertex: VertexId) -> Option<f64> {
        self.residuals_mm.get(vertex as usize).copied().filter(|residual| residual.is_finite())
    }
}

/// Finds the defects of a surface.
///
/// Noise without correlation is expected to make no more than [`DefectSettings::with_false_expected`] defects of its own
/// on the whole surface, also where it differs from place to place or has tails up to those of Laplace's distribution. The vertices are shared out to rayon's
/// threads; the bits do not depend on how many there are, and on the order of the vertices by
/// rounding alone if the noise is given, else by the choice of neighbourhoods that
/// [`estimate_noise`](crate::noise::estimate_noise) looks at.
///
/// ```
/// use asphera_surface::curvature::Adjacency;
/// use asphera_surface::defects::{DefectKind, DefectSettings, Samples, find_defects};
/// use asphera_surface::noise::{Along, Noise};
/// use asphera_mesh::Mesh;
///
/// // z = x²/40 with a pit of 1 µm at (0.5, 0.5).
/// let places = (0..10_000_u32).map(|i| [i % 100, i / 100].map(|i| 0.02 * (f64::from(i) - 49.5)));
/// let pit = |x: f64, y: f64| -1e-3 * (-((x - 0.5).powi(2) + (y - 0.5).powi(2)) / 3.2e-3).exp();
/// let mut mesh = Mesh::new();
/// mesh.extend(places.map(|[x, y]| [x, y, x * x / 40.0 + pit(x, y)]));
/// mesh.flush();
/// let triangles = mesh.triangles();
/// let adjacency = Adjacency::new(mesh.points(), &triangles, Some(0.1))?;
///
/// let samples = Samples {
///     points: mesh.points(),
///     triangles: &triangles,
///     adjacency: &adjacency,
///     deviations_mm: None,
/// };
/// let settings = DefectSettings::default().with_noise(Noise::new(1e-5, Along::Z)?);
/// let found = find_defects(&samples, &settings)?;
/// assert_eq!(found.defects.len(), 1);
/// assert_eq!(found.defects[0].kind, DefectKind::Pit);
/// assert!((found.defects[0].height_mm + 1e-3).abs() < 5e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn find_defects(
    samples: &Samples<'_>,
    settings: &DefectSettings,
) -> Result<Defects, DefectsUnknown> {
    needs_noise(settings, samples.points, samples.triangles)?;
    find(samples, settings, None)
}

/// Refuses heights of which neither the noise nor the step is known: one step of them would stand off for ever.
fn needs_noise(
    settings: &DefectSettings,
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
) -> Result<(), DefectsUnknown> {
    let hidden = || height_steps(points, &edges_of(triangles)) == HeightSteps::Hidden;
    if settings.noise.is_none() && hidden() { Err(DefectsUnknown::HiddenSteps) } else { Ok(()) }
}

/// The same over a ground that is known, as where these samples are a part of a surface.
fn find(
    samples: &Samples<'_>,
    settings: &DefectSettings,
    ground: Option<&Ground>,
) -> Result<Defects, DefectsUnknown> {
    let surface = Surface::new(samples, settings, ground)?;
    let found = surface.defects(&[])?;
    if !found.defects.iter().any(|defect| bodies::is_wide(defect, surface.window_mm)) {
        return Ok(found);
    }
    let cells = surface.cells(samples)?;
    match &bodies::bodies(samples, &cells, &found.defects, surface.window_mm)[..] {
        [] => Ok(found),
        // A reference that may not follow what is wide bends towards it, which then looks lower than it is.
        bodies => surface.defects(bodies),
    }
}

/// For each vertex whether it is of the surface, at a place and a height that are known.
fn used(samples: &Samples<'_>, areas_mm2: &[f64]) -> Vec<bool> {
    (0..samples.points.len() as VertexId)
        .map(|vertex| {
            areas_mm2[vertex as usize] > 0.0
                && samples.points[vertex as usize].iter().all(|coordinate| coordinate.is_finite())
                && cells::height_mm(samples, vertex).is_finite()
        })
        .collect()
}

/// The most significant first, of equal ones the one farther left.
fn by_significance(p: &Defect, q: &Defect) -> Ordering {
    let [a, b] = [p.centre_mm, q.centre_mm];
    q.significance
        .total_cmp(&p.significance)
        .then(a[0].total_cmp(&b[0]))
        .then(a[1].total_cmp(&b[1]))
}

/// A third of the projected area of every triangle for each of its corners.
fn areas_mm2(samples: &Samples<'_>) -> Result<Vec<f64>, DefectsUnknown> {
    let points = samples.points;
    let deviations = samples.deviations_mm.map_or(points.len(), <[f64]>::len);
    if samples.adjacency.len() != points.len() || deviations != points.len() {
        let adjacency = samples.adjacency.len();
        return Err(DefectsUnknown::Numbers { points: points.len(), adjacency, deviations });
    }
    let mut areas_mm2 = vec![0.0; points.len()];
    for (triangle, corners) in samples.triangles.iter().enumerate() {
        if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= points.len()) {
            return Err(DefectsUnknown::Corner { triangle, corner, points: points.len() });
        }
        if joined(samples, *corners) {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            if area.is_finite() {
                for &corner in corners {
                    areas_mm2[corner as usize] += area.abs() / 6.0;
                }
            }
        }
    }
    Ok(areas_mm2)
}

/// Whether the sides of a triangle join neighbours.
fn joined(samples: &Samples<'_>, [a, b, c]: [VertexId; 3]) -> bool {
    let neighbours = samples.adjacency.neighbours(a);
    neighbours.contains(&b)
        && neighbours.contains(&c)
        && samples.adjacency.neighbours(b).contains(&c)
}

/// The surroundings of each defect. A vertex that belongs to several is that of the most significant.
fn zones<'a>(
    samples: &Samples<'_>,
    found: &'a [Found],
    cell: &[u32],
    reference: &Reference,
    cell_mm: &[f64],
) -> Vec<Zone<'a>> {
    if found.is_empty() {
        return Vec::new();
    }
    let mut owner = vec![cells::NONE; samples.points.len()];
    for (index, found) in found.iter().enumerate() {
        for &vertex in &found.vertices {
            let owner = &mut owner[vertex as usize];
            if *owner == cells::NONE {
                *owner = index as u32;
            }
        }
    }
    let mut zones: Vec<Zone<'a>> = found
        .iter()
        .map(|found| {
            let cell = cell[found.vertices[0] as usize] as usize;
            Zone {
                found,
                vertices: found.vertices.clone(),
                triangles: Vec::new(),
                secant: reference.secants[cell],
                reference_mm: cell_mm[cell] * reference.uncertainties[cell],
            }
        })
        .collect();
    let mut from = vec![0; zones.len()];
    for _ in 0..2 {
        for (index, zone) in zones.iter_mut().enumerate() {
            let until = zone.vertices.len();
            for place in from[index]..until {
                for &other in samples.adjacency.neighbours(zone.vertices[place]) {
                    if owner[other as usize] == cells::NONE {
                        owner[other as usize] = index as u32;
                        zone.vertices.push(other);
                    }
                }
            }
            from[index] = until;
        }
    }
    for &corners in samples.triangles {
        let [a, b, c] = corners.map(|corner| owner[corner as usize]);
        for (index, again) in [(a, false), (b, b == a), (c, c == a || c == b)] {
            if index != cells::NONE && !again && joined(samples, corners) {
                zones[index as usize].triangles.push(corners);
            }
        }
    }
    zones.iter_mut().for_each(|zone| zone.vertices.sort_unstable());
    zones
}

fn of_step(samples: &Samples<'_>, used: &[bool], step: &Step) -> Defect {
    let knots = &step.line.knots_mm[1..step.line.knots_mm.len() - 1];
    let middle = knots[knots.len() / 2];
    let [x, y] = step.line.place_mm(middle);
    let away = |point: &PointMm| (point[0] - x).hypot(point[1] - y);
    let nearest = samples
        .points
        .iter()
        .zip(used)
        .filter(|&(_, &used)| used)
        .map(|(point, _)| point)
        .min_by(|p, q| away(p).total_cmp(&away(q)))
        .expect("a step is made of points");
    let half = 0.5 * step.length_mm;
    let ends = [[-half, knots[0][1]], [half, knots[knots.len() - 1][1]]];
    let places = knots.iter().copied().chain(ends).map(|knot| step.line.place_mm(knot));
    let bounds_mm = BoundsMm::about(places);
    Defect {
        kind: DefectKind::Step,
        centre_mm: [x, y, nearest[2]],
        bounds_mm,
        area_mm2: None,
        area_uncertainty_mm2: None,
        length_mm: Some(step.length_mm),
        width_mm: None,
        direction: Some(step.line.along),
        height_mm: step.height_mm,
        height_uncertainty_mm: step.uncertainty_mm,
        volume_mm3: None,
        vertices: step.samples,
        on_border: step.on_border,
        significance: step.height_mm / step.uncertainty_mm,
    }
}
