//! The outline of a mesh and the gaps along it, found by walking along the hull.
//!
//! What a list of triangles tells only by looking through all of it, a mesh tells in proportion to its hull.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use asphera_geometry::{Gap, PointMm, VertexId, from_smallest};
use asphera_mesh::{About, Mesh};

use super::{Outline, Sides, Unseen, flat, gaps_along, hull, refine};

/// What lies along the outline of the triangles of a mesh.
pub(crate) struct Rim {
    /// The vertices of the outline counter-clockwise, from the smallest number on. `None` without triangles, or
    /// where their outline is not one closed line that passes no vertex twice.
    pub(crate) hull: Option<Vec<VertexId>>,
    /// The triangles, by ascending index, whose circumcentre lies beyond the hull, and upper bounds of their gaps.
    pub(crate) refined: Vec<(usize, Gap)>,
}

impl Rim {
    /// That of a list of triangles. Takes some passes over it.
    pub(crate) fn of_triangles(points: &[PointMm], triangles: &[[VertexId; 3]]) -> Rim {
        let outline = Outline::new(points.len(), triangles);
        let refined = gaps_along(points, triangles, &outline);
        Rim { hull: hull(triangles, &outline), refined }
    }

    /// That of a mesh, whose triangles these are. Takes a look at each point, and else time in proportion to the
    /// hull.
    pub(crate) fn of_mesh(mesh: &Mesh, triangles: &[[VertexId; 3]]) -> Rim {
        let points = mesh.points();
        let mut walk = Walk { mesh, known: HashMap::new() };
        let Some(mut hull) = walk.hull() else { return Rim { hull: None, refined: Vec::new() } };
        let mut refined = Vec::new();
        for (&from, &to) in hull.iter().zip(hull.iter().cycle().skip(1)) {
            let Ok(Some(corners)) = walk.across([to, from]) else { continue };
            let root = flat(points, corners);
            if root.is_obtuse() && root.longest_side() == [from, to] {
                let done = refine(points, &mut walk, (corners, root), &mut refined);
                done.expect("all triangles are seen");
            }
        }
        let index = |corners| triangles.binary_search(&corners).ok();
        let mut refined: Vec<(usize, Gap)> =
            refined.into_iter().filter_map(|(corners, gap)| Some((index(corners)?, gap))).collect();
        refined.sort_unstable_by_key(|&(index, _)| index);
        let smallest = (0..hull.len()).min_by_key(|&at| hull[at]).unwrap_or(0);
        hull.rotate_left(smallest);
        Rim { hull: Some(hull), refined }
    }
}

/// A way along the hull and the triangles beneath it.
struct Walk<'a> {
    mesh: &'a Mesh,
    /// What is about the vertices met.
    known: HashMap<VertexId, About>,
}

impl Walk<'_> {
    /// The vertices of the hull counter-clockwise; `None` if there are no triangles.
    fn hull(&mut self) -> Option<Vec<VertexId>> {
        let place = |vertex: &VertexId| self.mesh.points()[*vertex as usize];
        // No other vertex lies before it along x.
        let first = self.mesh.vertices().min_by(|p, q| {
            let ([x, y, _], [u, v, _]) = (place(p), place(q));
            x.total_cmp(&u).then(y.total_cmp(&v))
        })?;
        let mut about = self.mesh.about(first)?;
        if about.on_line() {
            return None;
        }
        let mut hull = Vec::new();
        let mut at = first;
        loop {
            let next = *about.vertices.first()?;
            hull.push(at);
            let after = self.mesh.about_next(next, &about);
            self.known.insert(at, about);
            if next == first {
                return Some(hull);
            }
            (at, about) = (next, after);
        }
    }
}

impl Sides for Walk<'_> {
    type Name = [VertexId; 3];

    fn corners(&self, triangle: [VertexId; 3]) -> [VertexId; 3] {
        triangle
    }

    fn across(&mut self, [from, to]: [VertexId; 2]) -> Result<Option<[VertexId; 3]>, Unseen> {
        let About { vertices, on_hull, .. } = match self.known.entry(to) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(unknown) => unknown.insert(self.mesh.about(to).ok_or(Unseen)?),
        };
        let at = vertices.iter().position(|&other| other == from).ok_or(Unseen)?;
        let last = at + 1 == vertices.len();
        let third = vertices[if last { 0 } else { at + 1 }];
        // Beyond the last neighbour of a vertex of the hull there is nothing.
        Ok(Some(from_smallest([to, from, third])).filter(|_| !(last && *on_hull)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both ways tell the same.
    fn assert_agrees(mesh: &Mesh) -> usize {
        let (points, triangles) = (mesh.points(), mesh.triangles());
        let by_list = Rim::of_triangles(points, &triangles);
        let found = Rim::of_mesh(mesh, &triangles);
        assert_eq!(found.hull, by_list.hull);
        assert_eq!(found.refined, by_list.refined);
        found.refined.len()
    }

    #[test]
    fn a_mesh_and_its_triangles_have_the_same_rim() {
        let rough = |i: u32, j: u32| 1e-3 * f64::from((i * 7_919 + j * 104_729) % 101) / 101.0;
        for count in [2, 3, 7, 30] {
            let nodes = (0..count).flat_map(|j| (0..count).map(move |i| (i, j)));
            let rows = nodes.clone().map(|(i, j)| [f64::from(i) + rough(i, j), f64::from(j), 0.0]);
            let slanted = nodes.map(|(i, j)| {
                [f64::from(i) + rough(i, j), f64::from(j) + rough(j, i + 50), rough(i, 2 * j)]
            });
            for (place, points) in
                [rows.collect::<Vec<PointMm>>(), slanted.collect()].iter().enumerate()
            {
                let mut mesh = Mesh::new();
                mesh.insert(points);
                let refined = assert_agrees(&mesh);
                assert!(refined > 20 || place == 0 || count < 30, "{refined}");
                // A dent in the outline.
                mesh.remove(0).unwrap();
                assert_agrees(&mesh);
            }
        }
    }

    #[test]
    fn without_triangles_there_is_no_hull() {
        let mut mesh = Mesh::new();
        for point in [[0.0; 3], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]] {
            assert!(Rim::of_mesh(&mesh, &[]).hull.is_none());
            mesh.insert(&[point]);
        }
        assert!(Rim::of_mesh(&mesh, &[]).hull.is_none());
        mesh.insert(&[[0.0, 2.0, 0.0]]);
        assert_agrees(&mesh);
    }
}
