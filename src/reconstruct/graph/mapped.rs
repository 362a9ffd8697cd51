//! The map of landmarks, its faces and triangles, made of where cells touch.

use asphera_geometry::{PointMm, Sets};

use super::contacts::Contact;
use super::{Cell, GraphMap, NoSurface, Stage, faces, triangles};

/// The last steps of the method. Landmarks go by their ranks.
pub(super) struct Mapped {
    contacts: Vec<Contact>,
    edges: Vec<[u32; 2]>,
    faces: Vec<Vec<u32>>,
    /// Faces cut into triangles, not turned.
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Mapped {
    /// Joins cells that touch at more than `threshold` points. `meetings` are asked for when faces are.
    pub(super) fn of(
        landmarks_mm: &[PointMm],
        contacts: Vec<Contact>,
        threshold: u32,
        meetings: impl FnOnce() -> Option<Vec<[u32; 2]>>,
        enters: &mut dyn FnMut(Stage),
    ) -> Mapped {
        let joined = contacts.iter().filter(|contact| contact.points > threshold);
        let edges: Vec<[u32; 2]> = joined.map(|contact| contact.landmarks).collect();
        enters(Stage::Faces);
        let faces = faces::faces(landmarks_mm.len(), &edges, meetings().as_deref(), LONGEST);
        enters(Stage::Triangles);
        let triangles = triangles::triangles(landmarks_mm, &edges, &faces);
        Mapped { contacts, edges, faces, triangles }
    }

    /// The map by the numbers of points: `ids` are those of the landmarks.
    pub(super) fn map(self, ids: Vec<u32>, cells: Vec<Option<Cell>>) -> GraphMap {
        let (vertices, components) = parts(ids.len(), &self.edges);
        let id = |rank: u32| ids[rank as usize];
        let named = |contact: Contact| Contact { landmarks: contact.landmarks.map(id), ..contact };
        let face = |face: Vec<u32>| face.into_iter().map(id).collect();
        GraphMap {
            contacts: self.contacts.into_iter().map(named).collect(),
            edges: self.edges.len(),
            vertices,
            components,
            faces: self.faces.into_iter().map(face).collect(),
            cells,
            landmarks: ids,
        }
    }
}

impl NoSurface {
    /// Why so many places with such landmarks have no facets.
    pub(super) fn of(places: usize, landmarks: usize) -> NoSurface {
        match () {
            () if places < 4 => NoSurface::FewPoints,
            () if landmarks < 4 => NoSurface::FewLandmarks,
            () => NoSurface::NoFaces,
        }
    }
}

/// How many vertices have an edge, and how many parts they make.
fn parts(landmarks: usize, edges: &[[u32; 2]]) -> (usize, usize) {
    let mut has_edge = vec![false; landmarks];
    let mut sets = Sets::new(landmarks);
    let mut vertices = 0;
    let mut components = 0;
    for &[one, other] in edges {
        for end in [one, other] {
            if !std::mem::replace(&mut has_edge[end as usize], true) {
                vertices += 1;
                components += 1;
            }
        }
        components -= usize::from(sets.join(one as usize, other as usize));
    }
    (vertices, components)
}

/// Cycles of more edges are no faces. The paper says that faces have fewer than 5 edges in practice.
const LONGEST: usize = 10;
