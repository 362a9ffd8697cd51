//! The triangles that hold the centres of others' circles.

use std::cell::OnceCell;

use asphera_geometry::Sets;
use asphera_geometry::predicates::left_of;
use rayon::prelude::*;

use super::gabriel::obtuse_corner;
use crate::triangulation::{EdgeId, TriangleId, distance_mm};
use crate::{PlaceMm, Triangulation};

/// Triangles that hold the centres of circles. Most lie near, and a walk of few steps finds them.
///
/// Samples of a curve have triangles as thin as the samples are dense, and a walk meets many. Once one does, all are found together.
pub(super) struct Holders<'a> {
    triangulation: &'a Triangulation,
    all: OnceCell<Vec<Option<TriangleId>>>,
}

/// Where a walk ended.
enum End {
    /// In a triangle that holds the place, its border included.
    Within(TriangleId),
    /// At the last triangle before the hull.
    Beyond(TriangleId),
    /// On the way.
    Open,
}

impl<'a> Holders<'a> {
    pub(super) fn new(triangulation: &'a Triangulation) -> Holders<'a> {
        Holders { triangulation, all: OnceCell::new() }
    }

    /// The triangle that holds the centre of a triangle's circle; none if that lies beyond the hull.
    pub(super) fn holder(&self, triangle: TriangleId) -> Option<TriangleId> {
        if obtuse_corner(self.triangulation, triangle).is_none() {
            return Some(triangle);
        }
        let centre = self.centre_mm(triangle)?;
        match self.walked(triangle, centre, MOST_STEPS) {
            End::Within(at) => Some(at),
            End::Beyond(_) => None,
            End::Open => self.all.get_or_init(|| self.found())[triangle as usize],
        }
    }

    /// The centre of a triangle's circle in mm; none where rounding makes it a line.
    fn centre_mm(&self, triangle: TriangleId) -> Option<PlaceMm> {
        let centre = self.triangulation.centres_mm()[triangle as usize];
        centre.iter().all(|value| value.is_finite()).then_some(centre)
    }

    /// Walks from a triangle to a place.
    ///
    /// In a Delaunay triangulation every triangle on the way is nearer to the place than the one before, so no walk goes in circles (H.
    /// Edelsbrunner, Combinatorica 10 (1990) 251-260).
    fn walked(&self, from: TriangleId, place: PlaceMm, most_steps: usize) -> End {
        let mut at = from;
        for _ in 0..most_steps {
            let corners = self.corners(at);
            let leaves = |side: &usize| left_of(corners[(side + 1) % 3], corners[*side], place);
            let Some(side) = (0..3).find(leaves) else { return End::Within(at) };
            match self.triangulation.across(at)[side] {
                Some(beyond) => at = beyond,
                None => return End::Beyond(at),
            }
        }
        End::Open
    }

    /// The holders of all triangles: each walk begins where that of a neighbour ended.
    ///
    /// The neighbours are those of the shortest tree of Voronoi edges. Along a curve it runs along the medial axis, so from one centre to
    /// the next few triangles lie between.
    fn found(&self) -> Vec<Option<TriangleId>> {
        let is_way = self.shortest_ways();
        let count = self.triangulation.triangles().len();
        let mut found = vec![None; count];
        let mut is_found = vec![false; count];
        let mut open = Vec::new();
        for root in 0..count as TriangleId {
            if !is_found[root as usize] {
                open.push((root, root));
            }
            while let Some((triangle, start)) = open.pop() {
                is_found[triangle as usize] = true;
                let (holder, last) = self.found_from(triangle, start);
                found[triangle as usize] = holder;
                let sides = self.triangulation.sides(triangle).into_iter();
                for (side, beyond) in sides.zip(self.triangulation.across(triangle)) {
                    let beyond =
                        beyond.filter(|&it| is_way[side as usize] && !is_found[it as usize]);
                    open.extend(beyond.map(|beyond| (beyond, last)));
                }
            }
        }
        found
    }

    /// The holder of a triangle, sought from another on, and where the walk ended.
    fn found_from(
        &self,
        triangle: TriangleId,
        start: TriangleId,
    ) -> (Option<TriangleId>, TriangleId) {
        if obtuse_corner(self.triangulation, triangle).is_none() {
            return (Some(triangle), triangle);
        }
        let Some(centre) = self.centre_mm(triangle) else { return (None, start) };
        match self.walked(start, centre, usize::MAX) {
            End::Within(at) if self.lies_within(centre, at) => (Some(at), at),
            // On a side two triangles hold it, and the walk from the triangle itself decides which.
            End::Within(at) => match self.walked(triangle, centre, usize::MAX) {
                End::Within(holder) => (Some(holder), at),
                End::Beyond(_) | End::Open => (None, at),
            },
            End::Beyond(at) => (None, at),
            End::Open => (None, start),
        }
    }

    /// Whether each edge belongs to the tree of the triangles with the shortest Voronoi edges (J. B. Kruskal, Proceedings of the AMS 7
    /// (1956) 48-50).
    fn shortest_ways(&self) -> Vec<bool> {
        let centres = self.triangulation.centres_mm();
        let edges = self.triangulation.edges();
        let mut ways: Vec<(f64, EdgeId)> = (0..)
            .zip(edges)
            .filter_map(|(id, edge)| {
                let [left, right] = edge.triangles().map(|it| it.map(|it| centres[it as usize]));
                Some((distance_mm(left?, right?), id))
            })
            .collect();
        ways.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut sets = Sets::new(self.triangulation.triangles().len());
        let mut is_way = vec![false; edges.len()];
        for (_, id) in ways {
            if let [Some(left), Some(right)] = edges[id as usize].triangles() {
                is_way[id as usize] = sets.join(left as usize, right as usize);
            }
        }
        is_way
    }

    /// Whether a place lies in a triangle and on none of its sides.
    fn lies_within(&self, place: PlaceMm, triangle: TriangleId) -> bool {
        let corners = self.corners(triangle);
        (0..3).all(|side| left_of(corners[side], corners[(side + 1) % 3], place))
    }

    fn corners(&self, triangle: TriangleId) -> [PlaceMm; 3] {
        self.triangulation.triangles()[triangle as usize]
            .map(|corner| self.triangulation.place(corner))
    }
}

/// Longer walks are rare where samples lie all over an area.
const MOST_STEPS: usize = 64;

#[cfg(test)]
mod tests;
