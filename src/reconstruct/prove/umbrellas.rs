//! The fans and rings of triangles about the vertices, and the parts of a mesh.

use asphera_geometry::Sets;

use super::edges::Edges;

/// The umbrellas of a mesh.
pub(super) struct Umbrellas {
    /// For every corner of a triangle (3·facet + corner) the smallest such number in its fan.
    pub(super) fan: Vec<u32>,
    /// How many points are corners.
    pub(super) vertices: usize,
    /// Vertices of more than one fan.
    pub(super) singular: Vec<u32>,
    /// Parts that share no vertex.
    pub(super) components: usize,
}

impl Umbrellas {
    pub(super) fn of(facets: &[[u32; 3]], edges: &Edges) -> Umbrellas {
        let mut corners = Sets::new(3 * facets.len());
        for [one, other] in &edges.inner {
            for (a, b) in one.corners().into_iter().zip(other.corners()) {
                corners.join(a as usize, b as usize);
            }
        }
        let fan: Vec<u32> = (0..3 * facets.len()).map(|slot| corners.root(slot) as u32).collect();
        let points = facets.as_flattened().iter().max().map_or(0, |&last| last as usize + 1);
        let mut first_fan = vec![NONE; points];
        let mut is_singular = vec![false; points];
        for (&vertex, &fan) in facets.as_flattened().iter().zip(&fan) {
            let first = &mut first_fan[vertex as usize];
            if *first == NONE {
                *first = fan;
            }
            is_singular[vertex as usize] |= *first != fan;
        }
        let mut parts = Sets::new(points);
        let vertices = first_fan.iter().filter(|&&fan| fan != NONE).count();
        let mut components = vertices;
        for facet in facets {
            let [a, b, c] = facet.map(|corner| corner as usize);
            components -= usize::from(parts.join(a, b)) + usize::from(parts.join(b, c));
        }
        let singular = (0..points as u32).filter(|&vertex| is_singular[vertex as usize]).collect();
        Umbrellas { fan, vertices, singular, components }
    }
}

const NONE: u32 = u32::MAX;
