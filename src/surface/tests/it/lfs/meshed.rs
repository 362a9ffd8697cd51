//! Reach of meshes of bodies whose medial axis is known: never above the truth, and not far below.

use asphera_surface::lfs::{NoReach, mesh_reach};

type Mesh = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A closed grid of places: `columns` run round, `rows` too.
fn ring(columns: u32, rows: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let turn = std::f64::consts::TAU;
    let points = (0..rows * columns).map(|at| {
        place(
            turn * f64::from(at % columns) / f64::from(columns),
            turn * f64::from(at / columns) / f64::from(rows),
        )
    });
    let number = |column: u32, row: u32| row % rows * columns + column % columns;
    let triangles = (0..rows * columns).flat_map(|at| {
        let (column, row) = (at % columns, at / columns);
        let [a, b] = [column, column + 1].map(|column| number(column, row));
        let [c, d] = [column, column + 1].map(|column| number(column, row + 1));
        [[a, b, d], [a, d, c]]
    });
    (points.collect(), triangles.collect())
}

fn torus(large: f64, small: f64) -> Mesh {
    ring(112, 40, |u, v| {
        let wide = large + small * v.cos();
        [wide * u.cos(), wide * u.sin(), small * v.sin()]
    })
}

/// An octahedron whose facets are cut in four, its vertices moved out onto a sphere and stretched.
fn ball(cuts: u32, semi: [f64; 3], inwards: bool) -> Mesh {
    let mut points = vec![
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, -1.0],
    ];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    for _ in 0..cuts {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = [0, 1, 2].map(|axis| points[a as usize][axis] + points[b as usize][axis]);
                let length = sum.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
                points.push(sum.map(|x| x / length));
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let points = points.into_iter().map(|p| [0, 1, 2].map(|axis| semi[axis] * p[axis]));
    if inwards {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    (points.collect(), triangles)
}

fn joined((mut points, mut triangles): Mesh, (more, others): Mesh) -> Mesh {
    let first = points.len() as u32;
    points.extend(more);
    triangles.extend(others.into_iter().map(|corners| corners.map(|corner| corner + first)));
    (points, triangles)
}

/// Balls, tori, an ellipsoid whose end bends by b²/a, a wall of 1, a gap of 0.8.
#[test]
fn reaches_are_those_of_the_bodies() {
    let moved = |(points, triangles): Mesh, by: f64| -> Mesh {
        (points.into_iter().map(|[x, y, z]| [x + by, y, z]).collect(), triangles)
    };
    let wall = joined(ball(4, [2.5; 3], false), ball(4, [1.5; 3], true));
    let gap = joined(ball(4, [1.5; 3], false), moved(ball(4, [1.5; 3], false), 3.8));
    for ((points, triangles), truth, share, name) in [
        (ball(4, [2.0; 3], false), 2.0, 0.6, "ball"),
        (torus(3.0, 1.0), 1.0, 0.6, "torus"),
        (torus(3.0, 2.0), 1.0, 0.6, "torus with a narrow hole"),
        (ball(4, [2.0, 2.0, 4.0], false), 1.0, 0.6, "ellipsoid"),
        (wall, 0.5, 0.5, "wall"),
        (gap, 0.4, 0.4, "gap"),
    ] {
        let found = mesh_reach(&points, &triangles).unwrap_or_else(|why| panic!("{name}: {why}"));
        eprintln!("{name}: {found:?} of {truth}");
        assert!(found.lower_mm <= truth * 1.001, "{name}: {found:?} {truth}");
        assert!(found.lower_mm >= share * truth, "{name}: {found:?} {truth}");
        assert!((found.mm / truth - 1.0).abs() < 0.1, "{name}: {found:?} {truth}");
    }
}

/// A long capsule of few facets along its cylinder: places between vertices count.
#[test]
fn long_facets_are_sampled() {
    let (points, triangles) = ball(4, [1.0; 3], false);
    let stretch = |[x, y, z]: [f64; 3]| [x, y, z + if z > 1e-9 { 8.0 } else { 0.0 }];
    let points: Vec<[f64; 3]> = points.into_iter().map(stretch).collect();
    let found = mesh_reach(&points, &triangles).unwrap();
    eprintln!("capsule: {found:?}");
    assert!(found.lower_mm <= 1.001 && found.lower_mm > 0.6, "{found:?}");
}

#[test]
fn no_reach_is_proved_of_edges_and_open_meshes() {
    let sharp = ball(0, [1.0; 3], false);
    let why = mesh_reach(&sharp.0, &sharp.1).unwrap_err();
    assert!(
        matches!(why, NoReach::Sharp { angle_rad, .. } if (angle_rad - 1.231).abs() < 1e-3),
        "{why}"
    );
    assert!(why.to_string().contains("an edge of 70.5° at"), "{why}");
    let (points, mut triangles) = ball(4, [1.0; 3], false);
    triangles.pop();
    let why = mesh_reach(&points, &triangles).unwrap_err();
    assert!(matches!(why, NoReach::NotClosed { triangles: 1, .. }), "{why}");
    assert!(mesh_reach(&[], &[]).is_err());
}
