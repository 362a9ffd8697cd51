//! The parts of a scene: those that lie apart, and those that touch where a library tells them apart.

use std::collections::HashMap;

use asphera_geometry::PointMm;
use asphera_graph::compare::Size;
use asphera_graph::library::{Recognition, recognise_any_size, recognise_touching};
use asphera_graph::{
    Choices, Cloud, GraphError, Parts, PlaceId, auto_min_points, extract, functions, parts,
};
use asphera_report::parts::PartFigures;

use super::Library;

/// A part of a scene.
pub(crate) struct ScenePart {
    pub(crate) figures: PartFigures,
    /// Its points by their numbers in the file, ascending.
    pub(crate) rows: Vec<usize>,
    /// Its places in mm, each once.
    pub(crate) places: Vec<PointMm>,
    /// Which entry of the library it is, where there is one.
    pub(crate) recognition: Option<Recognition>,
}

/// All parts, the one of most points first, and what is no part.
pub(crate) struct Scene {
    pub(crate) parts: Vec<ScenePart>,
    /// Pieces of too few points to be parts, and the points in them.
    pub(crate) islands: usize,
    pub(crate) island_points: u64,
    /// Points left over where touching parts were taken apart.
    pub(crate) crumbs: u64,
}

impl Scene {
    /// The parts of a cloud, whose points nearer than `tau_mm` belong together. With a library touching parts are taken apart where
    /// sizes count; `within_mm` is the largest difference that fits, or as the points allow.
    pub(crate) fn new(
        cloud: &Cloud<3>,
        tau_mm: f64,
        library: Option<&Library>,
        (size, within_mm): (Size, Option<f64>),
    ) -> Result<Scene, Box<dyn std::error::Error + Send + Sync>> {
        let found = parts_of(cloud, tau_mm)?;
        // The part of each place; none of what is left over.
        let mut part_of_place: Vec<Option<usize>> = vec![None; cloud.len()];
        let mut parts: Vec<ScenePart> = Vec::new();
        for part in &found.parts {
            let (pieces, of_places) = pieces(cloud, &part.places, library, (size, within_mm));
            for (place, piece) in of_places {
                part_of_place[place as usize] = Some(parts.len() + piece);
            }
            for (places, recognition) in pieces {
                let figures = figures_of(&places, tau_mm)?;
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

/// The parts of a cloud; pieces of fewer points than [`auto_min_points`] are islands.
pub(crate) fn parts_of(cloud: &Cloud<3>, tau_mm: f64) -> Result<Parts<3>, GraphError> {
    parts(cloud, tau_mm, auto_min_points(cloud, tau_mm)?)
}

/// The places of a part, and which entry of a library it is.
pub(crate) type Piece = (Vec<PointMm>, Option<Recognition>);

/// The parts that some places of a cloud are, and the part of each place, but for what is left over. With a library touching parts
/// are taken apart where sizes count.
pub(crate) fn pieces(
    cloud: &Cloud<3>,
    of_cloud: &[PlaceId],
    library: Option<&Library>,
    (size, within_mm): (Size, Option<f64>),
) -> (Vec<Piece>, Vec<(PlaceId, usize)>) {
    let places: Vec<PointMm> =
        of_cloud.iter().map(|&place| cloud.places()[place as usize]).collect();
    // Asked by place alone, so its order reaches nothing.
    let ids: HashMap<[u64; 3], PlaceId> =
        places.iter().map(bits).zip(of_cloud.iter().copied()).collect();
    let pieces: Vec<Piece> = match library {
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
    let of_places = (0..).zip(&pieces).flat_map(|(number, (places, _))| {
        places.iter().filter_map(|place| ids.get(&bits(place))).map(move |&place| (place, number))
    });
    let of_places = of_places.collect();
    (pieces, of_places)
}

/// The figures of the places of a part, but for its points. Its holes are those that the graph along its longest axis shows.
pub(crate) fn figures_of(
    places: &[PointMm],
    tau_mm: f64,
) -> Result<PartFigures, Box<dyn std::error::Error + Send + Sync>> {
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
