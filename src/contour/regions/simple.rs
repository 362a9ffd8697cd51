//! The simple shape.

use super::peeling::{Peeling, Verdict};
use crate::{Region, SampleId, Triangulation};

/// The simple shape: from the convex hull the longest side ag of the border is replaced by ae and eg, e the third corner of its
/// triangle.
///
/// It is, if both are shorter than ag, ag is longer than twice the distance from a and from g to their nearest samples, and the removal of
/// the triangle is regular. The region is one part that holds all samples. A. Gheibi, M. Davoodi, A. Javad, S. Panahi, M. M. Aghdam,
/// M. Asgaripour, A. Mohades, *Polygonal shape reconstruction in the plane*, IET Computer Vision 5 (2011) 97-106; the text was not at
/// hand. Their comparison of angles is among samples within the circle of the triangle, where a Delaunay triangulation has none. Decided
/// exactly but for the factor of two. n·log n time.
pub fn simple_shape(triangulation: &Triangulation) -> Region {
    let nearest_mm = |sample: SampleId| {
        let nearest = triangulation.nearest(sample);
        nearest.map_or(f64::INFINITY, |spoke| triangulation.length_mm(spoke.edge))
    };
    let mut peeling = Peeling::new(triangulation);
    peeling.peel(
        peeling.hull(),
        |side, _| triangulation.length_class(side),
        |_, ear| {
            let own = triangulation.length_class(ear.side);
            let sides = triangulation.sides(ear.triangle).into_iter();
            let is_longest = sides
                .filter(|&side| side != ear.side)
                .all(|side| triangulation.length_class(side) < own);
            let length_mm = triangulation.length_mm(ear.side);
            let is_long = |end| length_mm > 2.0 * nearest_mm(end);
            match is_longest && triangulation.ends(ear.side).into_iter().all(is_long) {
                true => Verdict::Go,
                false => Verdict::Stay,
            }
        },
    );
    peeling.region()
}
