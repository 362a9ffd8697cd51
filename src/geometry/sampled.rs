//! Places on a triangle mesh, as many on a mm² as on any other.

use crate::numbers::Numbers;
use crate::sum::Sum;
use crate::vector::{cross, length, minus, plus, unit};
use crate::{PointMm, VertexId};

/// A place on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePlace {
    /// The place in mm.
    pub at_mm: PointMm,
    /// The unit normal of its triangle: from its front, where its corners run counter-clockwise.
    pub normal: [f64; 3],
}

/// Draws `count` places on the triangles of `points`, mm, as likely on a mm² as on any other; none where no triangle has an area.
///
/// The range of areas is cut into `count` equal steps with a place in each, so none is bare by chance. A place in its triangle is
/// drawn by R. Osada and others, "Shape distributions", ACM Transactions on Graphics 21 (2002), equation 1. The same arguments
/// give the same bits. `O(triangles + count)`.
///
/// # Panics
///
/// If a triangle names a point that there is not.
pub fn sampled_surface(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    count: usize,
    seed: u64,
) -> Vec<SurfacePlace> {
    let normal = |corners: &[VertexId; 3]| {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        cross(minus(b, a), minus(c, a))
    };
    let mut whole = Sum::default();
    triangles.iter().for_each(|corners| whole.add(length(normal(corners))));
    let step = whole.total() / count as f64;
    let [along, first, second] = [0, 1, 2].map(|stream| Numbers::new(seed, 0, stream));
    let (mut places, mut passed) = (Vec::new(), Sum::default());
    let has_area = |corners: &&[VertexId; 3]| unit(normal(corners)).is_some();
    let mut left = triangles.iter().filter(has_area).peekable();
    while let Some(corners) = left.next() {
        let across = normal(corners);
        passed.add(length(across));
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let is_last = left.peek().is_none();
        // Rounding may leave the last places behind the last triangle.
        while places.len() < count
            && (is_last
                || (places.len() as f64 + along.uniform(places.len())) * step < passed.total())
        {
            let index = places.len();
            let (root, share) = (first.uniform(index).sqrt(), second.uniform(index));
            let at_mm = plus(plus(a, root * (1.0 - share), minus(b, a)), root * share, minus(c, a));
            let normal = unit(across).unwrap_or_default();
            places.push(SurfacePlace { at_mm, normal });
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Two triangles of areas 1 and 3 in the planes z = 0 and x = 0.
    const POINTS: [PointMm; 5] =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, -3.0]];
    const TRIANGLES: [[VertexId; 3]; 3] = [[0, 1, 2], [0, 0, 1], [0, 3, 4]];

    #[test]
    fn triangles_get_places_by_their_areas_and_places_lie_on_them() {
        let places = sampled_surface(&POINTS, &TRIANGLES, 4000, 7);
        assert_eq!(places.len(), 4000);
        let (flat, steep): (Vec<&SurfacePlace>, Vec<&SurfacePlace>) =
            places.iter().partition(|place| place.normal == [0.0, 0.0, 1.0]);
        assert!((flat.len() as i64 - 1000).abs() <= 1, "{}", flat.len());
        for place in &flat {
            let [x, y, z] = place.at_mm;
            assert!(x >= 0.0 && y >= 0.0 && x / 2.0 + y <= 1.0 + 1e-12 && z == 0.0);
        }
        for place in &steep {
            let [x, y, z] = place.at_mm;
            assert_eq!((place.normal, x), ([1.0, 0.0, 0.0], 0.0));
            assert!(y <= 0.0 && z <= 0.0 && -y / 2.0 - z / 3.0 <= 1.0 + 1e-12);
        }
    }

    /// Over a triangle with corners a, b, c the mean is (a + b + c)/3; x over the right one of the legs 2 and 1 has the variance
    /// 2²/18 about it.
    #[test]
    fn places_have_the_moments_of_the_uniform_distribution() {
        let places = sampled_surface(&POINTS, &TRIANGLES[..1], 100_000, 3);
        let count = places.len() as f64;
        let mean = |value: &dyn Fn(&PointMm) -> f64| {
            places.iter().map(|place| value(&place.at_mm)).sum::<f64>() / count
        };
        let (x, y) = (mean(&|at| at[0]), mean(&|at| at[1]));
        let variance = mean(&|at| (at[0] - 2.0 / 3.0).powi(2));
        // Five standard errors; of the variance those of a distribution of bounded kurtosis 2.4.
        let error = |variance: f64| 5.0 * (variance / count).sqrt();
        assert!((x - 2.0 / 3.0).abs() < error(4.0 / 18.0), "{x}");
        assert!((y - 1.0 / 3.0).abs() < error(1.0 / 18.0), "{y}");
        assert!(
            (variance - 4.0 / 18.0).abs() < error(1.4 * (4.0_f64 / 18.0).powi(2)),
            "{variance}"
        );
    }

    #[test]
    fn without_an_area_there_is_no_place() {
        assert!(sampled_surface(&[], &[], 10, 1).is_empty());
        assert!(sampled_surface(&POINTS, &TRIANGLES[1..2], 10, 1).is_empty());
        assert!(sampled_surface(&POINTS, &TRIANGLES, 0, 1).is_empty());
        assert_eq!(sampled_surface(&POINTS, &TRIANGLES[..2], 10, 1).len(), 10);
    }

    proptest! {
        #[test]
        fn there_are_as_many_places_as_asked_for_and_the_same_again(
            points in prop::collection::vec(prop::array::uniform3(-1e3..1e3), 3..20),
            picks in prop::collection::vec(prop::array::uniform3(0_usize..20), 1..40),
            count in 1_usize..300,
            seed in any::<u64>(),
        ) {
            let triangles: Vec<[VertexId; 3]> =
                picks.iter().map(|corners| corners.map(|at| (at % points.len()) as VertexId)).collect();
            let places = sampled_surface(&points, &triangles, count, seed);
            prop_assert!(places.len() == count || places.is_empty());
            for place in &places {
                prop_assert!((length(place.normal) - 1.0).abs() < 1e-12);
                prop_assert!(place.at_mm.iter().all(|side| side.abs() <= 1e3 + 1e-9));
            }
            prop_assert_eq!(sampled_surface(&points, &triangles, count, seed), places);
        }
    }
}
