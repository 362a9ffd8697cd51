//! Alpha complexes by looking at every point, and Betti numbers by elimination: slow, and independent of the crate.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Centre and squared radius of the smallest sphere through corners.
fn sphere(places: &[PointMm]) -> (PointMm, f64) {
    let first = places[0];
    let ways: Vec<PointMm> =
        places[1..].iter().map(|place| [0, 1, 2].map(|axis| place[axis] - first[axis])).collect();
    // The centre is first + Σ λ·way, with way·(Σ λ·way) = way²/2.
    let size = ways.len();
    let mut rows: Vec<Vec<f64>> = ways
        .iter()
        .map(|way| {
            let mut row: Vec<f64> = ways.iter().map(|other| dot(way, other)).collect();
            row.push(dot(way, way) / 2.0);
            row
        })
        .collect();
    for column in 0..size {
        let most = |row: &usize| rows[*row][column].abs();
        let pivot = (column..size).max_by(|a, b| most(a).total_cmp(&most(b))).unwrap();
        rows.swap(column, pivot);
        let pivot = rows[column].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(index, _)| *index != column) {
            let factor = row[column] / pivot[column];
            row.iter_mut().zip(&pivot).for_each(|(value, other)| *value -= factor * other);
        }
    }
    let mut way = [0.0; 3];
    for (index, edge) in ways.iter().enumerate() {
        let share = rows[index][size] / rows[index][index];
        way = [0, 1, 2].map(|axis| way[axis] + share * edge[axis]);
    }
    ([0, 1, 2].map(|axis| first[axis] + way[axis]), dot(&way, &way))
}

/// Simplices of the alpha complex of balls of a diameter, by corners in ascending order: those whose smallest empty sphere is within.
pub(crate) fn alpha_complex(
    points: &[PointMm],
    tetrahedra: &[[u32; 4]],
    diameter: f64,
) -> Vec<Vec<u32>> {
    let mut values: BTreeMap<Vec<u32>, f64> = BTreeMap::new();
    for tetrahedron in tetrahedra {
        for subset in 1_u32..16 {
            let corners =
                (0..4).filter(|slot| subset >> slot & 1 == 1).map(|slot| tetrahedron[slot]);
            values.insert(corners.collect(), f64::INFINITY);
        }
    }
    let mut simplices: Vec<Vec<u32>> = values.keys().cloned().collect();
    simplices.sort_by_key(|simplex| std::cmp::Reverse(simplex.len()));
    for simplex in &simplices {
        let places: Vec<PointMm> = simplex.iter().map(|&at| points[at as usize]).collect();
        let (centre, square) = sphere(&places);
        let is_inside = |at: u32, place: &PointMm| {
            let way = [0, 1, 2].map(|axis| place[axis] - centre[axis]);
            !simplex.contains(&at) && dot(&way, &way) < square * (1.0 - 1e-12)
        };
        if !(0..).zip(points).any(|(at, place)| is_inside(at, place)) {
            values.insert(simplex.clone(), square);
        }
        // A face is there as soon as any simplex that it is of.
        let value = values[simplex];
        for left_out in 0..simplex.len() {
            let mut face = simplex.clone();
            face.remove(left_out);
            if let Some(least) = values.get_mut(&face) {
                *least = least.min(value);
            }
        }
    }
    let limit = diameter * diameter / 4.0;
    values.into_iter().filter(|(_, value)| *value <= limit).map(|(simplex, _)| simplex).collect()
}

/// Betti numbers with coefficients in Z/2, by elimination in the boundary matrices.
pub(crate) fn betti(complex: &[Vec<u32>]) -> [i64; 3] {
    let of_size = |size: usize| -> Vec<&Vec<u32>> {
        complex.iter().filter(|simplex| simplex.len() == size).collect()
    };
    let rank = |size: usize| -> i64 {
        let rows: BTreeMap<&Vec<u32>, usize> = of_size(size - 1).into_iter().zip(0..).collect();
        let mut by_lowest: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for simplex in of_size(size) {
            let mut column: Vec<usize> = (0..size)
                .map(|left_out| {
                    let mut face = simplex.clone();
                    face.remove(left_out);
                    rows[&face]
                })
                .collect();
            column.sort_unstable();
            while let Some(other) = column.last().and_then(|lowest| by_lowest.get(lowest)) {
                let mut sum: Vec<usize> =
                    column.iter().filter(|row| !other.contains(row)).copied().collect();
                sum.extend(other.iter().filter(|row| !column.contains(row)));
                sum.sort_unstable();
                column = sum;
            }
            if let Some(&lowest) = column.last() {
                by_lowest.insert(lowest, column);
            }
        }
        by_lowest.len() as i64
    };
    let count = |size: usize| of_size(size).len() as i64;
    let ranks = [0, rank(2), rank(3), rank(4)];
    [0, 1, 2].map(|dimension| count(dimension + 1) - ranks[dimension] - ranks[dimension + 1])
}
