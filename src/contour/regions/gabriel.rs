//! The shape hull: the region of the relaxed Gabriel graph.

use std::cmp::Reverse;

use asphera_geometry::predicates::scalar_product;

use super::holders::Holders;
use super::peeling::{Ear, Peeling, Verdict};
use super::radius_mm;
use crate::triangulation::TriangleId;
use crate::{Graph, Region, SampleId, Triangulation};

/// The region of the relaxed Gabriel graph (RGG): border triangles go, those of the largest circumcircle first, as long as the centre of
/// that circle lies outside the region and the removal is regular.
///
/// It is one part that holds all samples. It is right where every concavity is divergent: where its triangles are obtuse with the
/// longest side towards the mouth. With `holes` every acute triangle off the border whose three neighbours are obtuse towards it begins
/// a hole, that of the largest circle first, and the hole grows by the same rule; points at random have many such. J.
/// Peethambaran, R. Muthuganapathy, *A non-parametric approach to shape reconstruction from planar point sets through Delaunay
/// filtering*, Computer-Aided Design 62 (2015) 164-175; as their public program works. Angles are decided exactly, centres and radii are
/// rounded. n·log n time and that of short walks through the mesh to the centres of circles.
pub fn relaxed_gabriel(triangulation: &Triangulation, holes: bool) -> Region {
    peeled(triangulation, holes).region()
}

/// The shape hull graph: the Delaunay edges within the region of [`relaxed_gabriel`] without holes, its border among them.
///
/// J. Peethambaran, R. Muthuganapathy (2015); the text was not at hand.
pub fn shape_hull_graph(triangulation: &Triangulation) -> Graph {
    if triangulation.triangles().is_empty() {
        return crate::graphs::delaunay(triangulation);
    }
    let peeling = peeled(triangulation, false);
    Graph::of_edges(triangulation, |edge| {
        let triangles = triangulation.edges()[edge as usize].triangles();
        triangles.into_iter().flatten().any(|triangle| peeling.holds(triangle))
    })
}

fn peeled(triangulation: &Triangulation, holes: bool) -> Peeling<'_> {
    let key = |triangle: TriangleId| radius_mm(triangulation, triangle).to_bits();
    let holders = Holders::new(triangulation);
    let rule = |peeling: &Peeling, ear: Ear| match holders.holder(ear.triangle) {
        Some(holder) if peeling.holds(holder) => Verdict::StayWith(holder),
        _ => Verdict::Go,
    };
    let mut peeling = Peeling::new(triangulation);
    peeling.peel(peeling.hull(), |_, triangle| key(triangle), rule);
    if holes {
        let count = triangulation.triangles().len() as TriangleId;
        let mut seeds: Vec<TriangleId> =
            (0..count).filter(|&triangle| is_fat(triangulation, triangle)).collect();
        seeds.sort_by_key(|&triangle| (Reverse(key(triangle)), triangle));
        for seed in seeds {
            let corners = triangulation.triangles()[seed as usize];
            if peeling.holds(seed) && !corners.iter().any(|&corner| peeling.is_on_border(corner)) {
                peeling.remove(seed);
                peeling.peel(triangulation.sides(seed), |_, triangle| key(triangle), rule);
            }
        }
    }
    peeling
}

/// Whether a triangle is acute and each of its neighbours obtuse with its longest side towards it.
fn is_fat(triangulation: &Triangulation, triangle: TriangleId) -> bool {
    let corners = triangulation.triangles()[triangle as usize];
    let is_acute = (0..3).all(|corner| angle_is(triangulation, corners, corner).is_gt());
    let faces = |(beyond, side): (Option<TriangleId>, u32)| {
        let corner = beyond.and_then(|beyond| obtuse_corner(triangulation, beyond));
        corner.is_some_and(|corner| !triangulation.ends(side).contains(&corner))
    };
    let beyond = triangulation.across(triangle).into_iter();
    is_acute && beyond.zip(triangulation.sides(triangle)).all(faces)
}

/// The corner of a triangle with an angle of more than 90°.
pub(super) fn obtuse_corner(
    triangulation: &Triangulation,
    triangle: TriangleId,
) -> Option<SampleId> {
    let corners = triangulation.triangles()[triangle as usize];
    let obtuse = (0..3).find(|&corner| angle_is(triangulation, corners, corner).is_lt());
    obtuse.map(|corner| corners[corner])
}

/// Greater for an acute angle at a corner, less for an obtuse one.
fn angle_is(
    triangulation: &Triangulation,
    corners: [SampleId; 3],
    corner: usize,
) -> std::cmp::Ordering {
    let at = |offset: usize| triangulation.place(corners[(corner + offset) % 3]);
    scalar_product(at(0), at(1), at(2))
}
