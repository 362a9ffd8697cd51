//! The local feature size of a mesh in space: that of the design where one was fitted, else by medial balls of the points.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_geometry::vector::Vector;
use asphera_surface::curvature::{Adjacency, ShapeSettings, local_shape};
use asphera_surface::lfs::{Accuracy, MeasuredLfs};
use asphera_surface::noise::{Along, Noise};
use rayon::prelude::*;

use super::meshed::Meshed;
use super::patch::{AtVertex, Patch};
use super::shape::{Laid, across};

/// The local feature size everywhere.
pub(super) enum FeatureSize {
    /// One value in mm, infinite of a plane.
    Design(f64),
    Measured(Cubes),
}

/// Values of cubes, each that of one vertex in it: off by no more than its diagonal, for a local feature size changes by no more than
/// the way gone.
pub(super) struct Cubes {
    side_mm: f64,
    /// `None` where it is not known.
    values_mm: BTreeMap<[i64; 3], Option<f64>>,
}

impl Cubes {
    fn at_mm(&self, place_mm: PointMm) -> Option<f64> {
        let own = cube(place_mm, self.side_mm);
        if let Some(value_mm) = self.values_mm.get(&own) {
            return *value_mm;
        }
        // Between vertices a place may lie in a cube without one.
        let beside = (0..27_i64).filter_map(|at| {
            let way = [at % 3, at / 3 % 3, at / 9].map(|step| step - 1);
            let other = [0, 1, 2].map(|axis| own[axis].saturating_add(way[axis]));
            self.values_mm.get(&other).copied().flatten()
        });
        beside.reduce(f64::min)
    }
}

/// The cube of a place. A cast saturates, and places are 1e12 mm at most.
fn cube(place_mm: PointMm, side_mm: f64) -> [i64; 3] {
    place_mm.map(|mm| (mm / side_mm).floor() as i64)
}

impl FeatureSize {
    /// The local feature size of a mesh of this noise and spacing in mm.
    ///
    /// # Errors
    ///
    /// Why it is not known, in words.
    pub(super) fn of(
        meshed: &Meshed,
        normals: &[Option<Vector>],
        laid: Option<&Laid>,
        sigma_mm: Option<f64>,
        spacing_mm: f64,
    ) -> Result<FeatureSize, String> {
        if let Some(laid) = laid {
            return Ok(FeatureSize::Design(laid.shape.radius_mm()));
        }
        let sigma_mm =
            sigma_mm.ok_or("local feature size: the noise of the points is not known")?;
        let cubes = measured(meshed, normals, sigma_mm, spacing_mm)
            .map_err(|why| format!("local feature size: {why}"))?;
        Ok(FeatureSize::Measured(cubes))
    }

    /// At a place, in mm; `None` where it is not known.
    pub(super) fn at_mm(&self, place_mm: PointMm) -> Option<f64> {
        match self {
            FeatureSize::Design(mm) => Some(*mm),
            FeatureSize::Measured(cubes) => cubes.at_mm(place_mm),
        }
    }

    /// Its source, as reports name it.
    pub(super) fn source(&self) -> &'static str {
        match self {
            FeatureSize::Design(_) => "nominal",
            FeatureSize::Measured(_) => "measured",
        }
    }
}

/// Medial balls of a thinned set of vertices, one a cube.
fn measured(
    meshed: &Meshed,
    normals: &[Option<Vector>],
    sigma_mm: f64,
    spacing_mm: f64,
) -> Result<Cubes, String> {
    let wanted = (meshed.points_mm.len() / 2).clamp(1, MOST_CUBES) as f64;
    let side_mm = (meshed.proof.area_mm2 / wanted).sqrt().max(spacing_mm);
    if !side_mm.is_normal() {
        return Err("the points span no area".to_owned());
    }
    let mut first: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    for (vertex, place) in (0..).zip(&meshed.points_mm) {
        if normals[vertex as usize].is_some() {
            first.entry(cube(*place, side_mm)).or_insert(vertex);
        }
    }
    let chosen: Vec<u32> = first.values().copied().collect();
    let noise = Noise::new(sigma_mm, Along::Z).map_err(|why| why.to_string())?;
    let at_vertex = AtVertex::of(meshed);
    let known: Vec<Option<(Vector, f64)>> = chosen
        .par_iter()
        .map(|&vertex| normal(meshed, &at_vertex, (vertex, normals[vertex as usize]?), noise))
        .collect();
    if 2 * known.iter().flatten().count() < known.len() {
        return Err("noise tilts the normals too far, or the points are too few".to_owned());
    }
    let tilt_rad = known.iter().flatten().map(|(_, tilt)| *tilt).fold(0.0, f64::max);
    let gap_mm = std::f64::consts::SQRT_2 * side_mm;
    let accuracy = Accuracy { gap_mm, position_mm: sigma_mm, normal_rad: tilt_rad };
    let mut lfs = MeasuredLfs::new(accuracy).map_err(|why| why.to_string())?;
    let places: Vec<PointMm> =
        chosen.iter().map(|&vertex| meshed.points_mm[vertex as usize]).collect();
    let of_chosen: Vec<Option<Vector>> =
        known.iter().map(|known| known.map(|(normal, _)| normal)).collect();
    lfs.insert(&places, &of_chosen).map_err(|why| why.to_string())?;
    let axis = lfs.refresh();
    let found_mm: Vec<Option<f64>> = places.par_iter().map(|&place| axis.at(place).mm()).collect();
    Ok(Cubes { side_mm, values_mm: first.into_keys().zip(found_mm).collect() })
}

/// The normal at a vertex by a polynomial over its rings, with its tilt by noise in rad; `None` where that is too much.
fn normal(
    meshed: &Meshed,
    at_vertex: &AtVertex,
    (vertex, about): (u32, Vector),
    noise: Noise,
) -> Option<(Vector, f64)> {
    let Patch { places_mm, facets } = at_vertex.patch(meshed, (vertex, about), RINGS, None)?;
    let adjacency = Adjacency::new(&places_mm, &facets, None).ok()?;
    let settings = ShapeSettings::default().with_noise(noise);
    let shape = local_shape(&places_mm, &adjacency, 0, &settings).ok()?;
    let [first, second] = shape.uncertainty?.normal_rad;
    let [u, v] = across(about);
    let [x, y, z] = shape.normal;
    let normal = [0, 1, 2].map(|axis| x * u[axis] + y * v[axis] + z * about[axis]);
    Some((normal, first.max(second))).filter(|(_, tilt)| *tilt <= MOST_TILT_RAD)
}

const MOST_CUBES: usize = 10_000;
const RINGS: usize = 3;
/// A normal that noise tilts farther tells nothing.
const MOST_TILT_RAD: f64 = 0.05;
