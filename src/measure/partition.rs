//! Which way a part bends: shares of its area by the signs of its curvatures.
//!
//! At the distance of its points noise would hide the curvature of nearly every surface. So heights are averaged over
//! up to 4096 squares first; the mean places are meshed, and the curvatures at them parted as
//! `asphera_surface::defects` does. A mean over a square is off by its curvature times the spread within, the same
//! for all whole squares, so that the curvatures are not.

use std::collections::BTreeMap;

use asphera_geometry::{BoundsMm, PointMm, place};
use asphera_mesh::Mesh;
use asphera_report::{FeatureFigures, PartitionFigures};
use asphera_surface::curvature::{Adjacency, ShapeSettings, local_shapes};
use asphera_surface::defects::{Bands, Class, Partition, partition};
use asphera_surface::noise::Noise;

/// Mean places of a surface by squares.
pub(super) struct Patches {
    means_mm: Vec<PointMm>,
    side_mm: f64,
    /// How many points half of the squares have at least.
    points: usize,
}

/// Sums over the points of a square, over its corner.
#[derive(Clone, Copy, Default)]
struct Sum {
    count: usize,
    mm: PointMm,
}

impl Patches {
    /// The squares of those points that count, by their numbers; `None` if they have no extent.
    pub(super) fn new(points: &[PointMm], counts: impl Fn(usize) -> bool) -> Option<Patches> {
        // A few dozen points a square are as good as all.
        let step = (points.len() / (MOST * POINTS)).max(1);
        let chosen = || (0..points.len()).step_by(step).filter(|&vertex| counts(vertex));
        let bounds = BoundsMm::about(chosen().map(|vertex| place(points[vertex])));
        let squares = (chosen().count() / FEWEST_POINTS).clamp(1, MOST) as f64;
        let extent = bounds.size_mm();
        let side_mm = (extent[0] * extent[1] / squares).sqrt();
        if !(side_mm > 0.0 && side_mm.is_finite()) {
            return None;
        }
        let size = extent.map(|extent| (extent / side_mm) as usize + 1);
        // Squares lie about the middle of the points: a part that is turned or mirrored has the same ones.
        let corner = [0, 1]
            .map(|axis| bounds.low[axis] + 0.5 * (extent[axis] - size[axis] as f64 * side_mm));
        let mut sums = vec![Sum::default(); size[0] * size[1]];
        // Heights over the first one, so that a far origin costs no digits.
        let datum_mm = points[chosen().next()?][2];
        for vertex in chosen() {
            let [x, y, z] = points[vertex];
            let way = [x - corner[0], y - corner[1]];
            let [column, row] =
                [0, 1].map(|axis| ((way[axis] / side_mm) as usize).min(size[axis] - 1));
            let sum = &mut sums[row * size[0] + column];
            sum.count += 1;
            sum.mm = [sum.mm[0] + way[0], sum.mm[1] + way[1], sum.mm[2] + (z - datum_mm)];
        }
        sums.retain(|sum| sum.count > 0);
        let mut filled: Vec<usize> = sums.iter().map(|sum| sum.count).collect();
        filled.sort_unstable();
        let means_mm = sums
            .iter()
            .map(|sum| {
                let [x, y, z] = sum.mm.map(|mm| mm / sum.count as f64);
                [corner[0] + x, corner[1] + y, datum_mm + z]
            })
            .collect();
        Some(Patches { means_mm, side_mm, points: filled[filled.len() / 2] })
    }
}

/// Which way the surface bends, or why that is not known.
pub(super) fn figures(
    patches: Option<Patches>,
    noise: Option<Noise>,
    flat_below_per_mm: f64,
) -> FeatureFigures {
    match shares(patches, noise, flat_below_per_mm) {
        Ok(partition) => FeatureFigures { partition: Some(partition), ..FeatureFigures::default() },
        Err(why) => FeatureFigures { partition_unknown: Some(why), ..FeatureFigures::default() },
    }
}

fn shares(
    patches: Option<Patches>,
    noise: Option<Noise>,
    flat_below_per_mm: f64,
) -> Result<PartitionFigures, String> {
    let Patches { means_mm, side_mm, points } = patches.ok_or("the points span no area")?;
    if means_mm.len() < FEWEST {
        return Err(format!(
            "{} squares of {FEWEST_POINTS} points or more are too few, {FEWEST} are needed",
            means_mm.len()
        ));
    }
    let noise = noise.ok_or("the noise is not known")?;
    let noise = Noise::new(noise.sigma_mm() / (points as f64).sqrt(), noise.along())
        .map_err(|error| error.to_string())?;
    let mut mesh = Mesh::new();
    mesh.insert(&means_mm);
    let triangles = mesh.triangles();
    let adjacency = Adjacency::new(mesh.points(), &triangles, Some(REACH * side_mm))
        .map_err(|error| error.to_string())?;
    let settings = ShapeSettings::default().with_noise(noise);
    let all = 0..mesh.points().len() as u32;
    let shapes = local_shapes(mesh.points(), &adjacency, all, &settings);
    let bands = Bands::Signs { uncertainties: SIGMAS, least_per_mm: flat_below_per_mm };
    let found = partition(mesh.points(), &triangles, &adjacency, &shapes, &bands)
        .map_err(|error| error.to_string())?;
    Ok(PartitionFigures {
        shares: area_shares(&found),
        regions: region_counts(&found),
        flat_below_per_mm,
        flat_below_sigmas: SIGMAS,
        patch_mm: side_mm,
    })
}

fn area_shares(found: &Partition) -> BTreeMap<String, f64> {
    let whole_mm2: f64 = found.classes.iter().map(|&(_, area_mm2, _)| area_mm2).sum();
    occurring(found)
        .map(|(class, area_mm2)| (word(class).to_owned(), area_mm2 / whole_mm2))
        .collect()
}

fn region_counts(found: &Partition) -> BTreeMap<String, u64> {
    let regions = |class| found.regions.iter().filter(|region| region.class == class).count();
    occurring(found).map(|(class, _)| (word(class).to_owned(), regions(class) as u64)).collect()
}

/// The classes that have an area, and that in mm².
fn occurring(found: &Partition) -> impl Iterator<Item = (Class, f64)> + '_ {
    let classes = found.classes.iter().map(|&(class, area_mm2, _)| (class, area_mm2));
    classes.filter(|&(_, area_mm2)| area_mm2 > 0.0)
}

fn word(class: Class) -> &'static str {
    match class {
        Class::Concave => "concave",
        Class::Convex => "convex",
        Class::Saddle => "saddle",
        Class::Trough => "trough",
        Class::Ridge => "ridge",
        Class::Flat => "flat",
        Class::Band(_) | Class::Undetermined => "unknown",
    }
}

/// Most squares: features of a sixtieth of the extent.
const MOST: usize = 4096;
/// Points of a square that are averaged at least where there are many.
const POINTS: usize = 48;
/// Points of a square where there are few.
const FEWEST_POINTS: usize = 4;
/// Fewest squares.
const FEWEST: usize = 30;
/// The length of an edge that bridges a gap, in sides of a square.
const REACH: f64 = 3.0;
/// Standard uncertainties up to which a curvature counts as none.
const SIGMAS: f64 = 3.0;
