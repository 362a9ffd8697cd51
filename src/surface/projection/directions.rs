//! Directions spread evenly over the half sphere.

use std::collections::BTreeMap;

/// The 81 directions of an icosahedron subdivided twice that do not differ by sign, as unit
/// vectors: no direction in space is farther than 12° from one of them or its opposite.
pub(crate) fn over_half_sphere() -> Vec<[f64; 3]> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    for (long, short) in [(golden, 1.0), (golden, -1.0), (-golden, 1.0), (-golden, -1.0)] {
        vertices.extend([[0.0, short, long], [short, long, 0.0], [long, 0.0, short]].map(unit));
    }
    // Neighbours on the icosahedron are those at an angle of 63.4°, the others at 116.6° or 180°.
    let near = |i: usize, j: usize| dot(vertices[i], vertices[j]) > 0.0;
    let mut faces: Vec<[usize; 3]> = Vec::new();
    for i in 0..vertices.len() {
        for j in (0..i).filter(|&j| near(i, j)) {
            faces.extend((0..j).filter(|&k| near(i, k) && near(j, k)).map(|k| [i, j, k]));
        }
    }
    for _ in 0..2 {
        let mut middles: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        let mut middle = |i: usize, j: usize| {
            *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                let sum = std::array::from_fn(|axis| vertices[i][axis] + vertices[j][axis]);
                vertices.push(unit(sum));
                vertices.len() - 1
            })
        };
        faces = faces
            .into_iter()
            .flat_map(|[i, j, k]| {
                let [ij, jk, ki] = [middle(i, j), middle(j, k), middle(k, i)];
                [[i, ij, ki], [j, jk, ij], [k, ki, jk], [ij, jk, ki]]
            })
            .collect();
    }
    vertices.retain(|&direction| upwards(direction) == direction);
    vertices
}

/// The direction or its opposite: the one whose last coordinate that is not zero is positive.
pub(crate) fn upwards(direction: [f64; 3]) -> [f64; 3] {
    let last = direction.into_iter().rev().find(|&coordinate| coordinate != 0.0);
    if last.is_some_and(|coordinate| coordinate < 0.0) {
        direction.map(|x| 0.0 - x)
    } else {
        direction
    }
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = dot(vector, vector).sqrt();
    vector.map(|coordinate| coordinate / length)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_162_vertices_and_none_twice() {
        let directions = over_half_sphere();
        assert_eq!(directions.len(), 81);
        for (i, &a) in directions.iter().enumerate() {
            assert!((dot(a, a) - 1.0).abs() < 1e-15);
            assert!(directions[..i].iter().all(|&b| dot(a, b).abs() < 0.99));
        }
    }

    #[test]
    fn no_direction_is_far_from_all() {
        let directions = over_half_sphere();
        // A spiral over the sphere: z in equal steps, the angle by the golden section.
        for i in 0..20_000 {
            let z = 1.0 - (f64::from(i) + 0.5) / 10_000.0;
            let (sine, cosine) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            let seen = [radius * cosine, radius * sine, z];
            let nearest = directions.iter().map(|&d| dot(d, seen).abs()).fold(0.0, f64::max);
            assert!(nearest.acos().to_degrees() < 12.0, "{seen:?}");
        }
    }
}
