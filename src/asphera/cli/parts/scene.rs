//! The parts of a scene: those that lie apart, and those that touch where a library tells them apart.

use std::collections::HashMap;

use asphera_geometry::PointMm;
use asphera_graph::compare::Size;
use asphera_graph::library::{Recognition, recognise_any_size, recognise_touching};
use asphera_graph::{Choices, Cloud, extract, functions};

use super::super::graph::figures::{PartFigures, parts_of};
use super::super::output::Failure;
use super::library::Library;

/// A part of a scene.
pub(super) struct ScenePart {
    pub(super) figures: PartFigures,
    /// Its points by their numbers in the file, ascending.
    pub(super) rows: Vec<usize>,
    /// Its places in mm, each once.
    pub(super) places: Vec<PointMm>,
    /// Which entry of the library it is, where there is one.
    pub(super) recognition: Option<Recognition>,
}

/// All parts, the one of most points first, and what is no part.
pub(super) struct Scene {
    pub(super) parts: Vec<ScenePart>,
    /// Pieces of too few points to be parts, and the points in them.
    pub(super) islands: usize,
    pub(super) island_points: u64,
    /// Points left over where touching parts were taken apart.
    pub(super) crumbs: u64,
}

impl Scene {
    /// The parts of a cloud, whose points nearer than `tau_mm` belong together. With a library touching parts are taken apart where
    /// sizes count; `within_mm` is the largest difference that fits, or as the points allow.
    pub(super) fn new(
        cloud: &Cloud<3>,
        tau_mm: f64,
        library: Option<&Library>,
        (size, within_mm): (Size, Option<f64>),
    ) -> Result<Scene, Failure> {
        let found = parts_of(cloud, tau_mm)?;
        // The part of each place; none of what is left over.
        let mut part_of_place: Vec<Option<usize>> = vec![None; cloud.len()];
        let mut parts: Vec<ScenePart> = Vec::new();
        for part in &found.parts {
            let places: Vec<PointMm> =
                part.places.iter().map(|&place| cloud.places()[place as usize]).collect();
            let pieces: Vec<(Vec<PointMm>, Option<Recognition>)> = match library {
                None => vec![(places, None)],
                Some(library) if size == Size::Free => {
                    let found = recognise_any_size(&places, &library.entries, within_mm);
                    vec![(places, Some(found))]
                }
                Some(library) => recognise_touching(&places, &library.entries, within_mm)
                    .into_iter()
                    .map(|piece| (piece.points, Some(piece.recognition)))
                    .collect(),
            };
            // Asked by place alone, so its order reaches nothing.
            let ids: HashMap<[u64; 3], u32> =
                part.places.iter().map(|&id| (bits(&cloud.places()[id as usize]), id)).collect();
            for (places, recognition) in pieces {
                let own = places.iter().filter_map(|place| ids.get(&bits(place)));
                own.for_each(|&id| part_of_place[id as usize] = Some(parts.len()));
                let figures = figures(&places, tau_mm)?;
                parts.push(ScenePart { figures, rows: Vec::new(), places, recognition });
            }
        }
        for (row, &place) in cloud.places_of_rows().iter().enumerate() {
            if let Some(part) = part_of_place[place as usize] {
                parts[part].rows.push(row);
            }
        }
        for part in &mut parts {
            part.figures.points = part.rows.len() as u64;
        }
        // Of equal counts those that were found first stay first.
        parts.sort_by_key(|part| std::cmp::Reverse(part.rows.len()));
        let island_points = found.islands.iter().map(|island| island.points).sum();
        let in_parts: u64 = parts.iter().map(|part| part.rows.len() as u64).sum();
        let crumbs = cloud.places_of_rows().len() as u64 - in_parts - island_points;
        Ok(Scene { parts, islands: found.islands.len(), island_points, crumbs })
    }
}

/// The figures of the places of a part, but for its points. Its holes are those that the graph along its longest axis shows.
fn figures(places: &[PointMm], tau_mm: f64) -> Result<PartFigures, Failure> {
    let own = Cloud::new(places)?;
    let height = functions::principal_height(&own, 1)?;
    let choices = Choices { tau_mm: Some(tau_mm), ..Choices::default() };
    let loops = extract(&own, &height, &choices)?.loops.len();
    let box_mm = own.bounds_mm().unwrap_or_default();
    let mean = |axis: usize| places.iter().map(|at| at[axis]).sum::<f64>() / places.len() as f64;
    Ok(PartFigures { points: 0, box_mm, centre_mm: [0, 1, 2].map(mean), loops })
}

fn bits(place: &PointMm) -> [u64; 3] {
    place.map(f64::to_bits)
}
