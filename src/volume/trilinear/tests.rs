//! Cells against a finer grid of the function itself, and volumes against what a surface must be.

use super::*;
use crate::{Histogram, SurfaceCheck, Topology};

/// Random numbers of Knuth's MMIX generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    /// From −1 to 1.
    fn signed(&mut self) -> f64 {
        self.next() as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

fn code_of(values: &[f64; 8]) -> u8 {
    (0..8).fold(0, |code, corner| code | u8::from(values[corner] >= 0.0) << corner)
}

fn shape_of(values: &[f64; 8]) -> Shape {
    let code = code_of(values);
    Shape::of(code, values, facts()[usize::from(code)].c1_faces)
}

/// Components and tunnels of foreground and background of a cell: corners in the same piece, and the tunnel.
fn betti(values: &[f64; 8]) -> [[u64; 2]; 2] {
    let shape = shape_of(values);
    let pieces = shape.body_pieces();
    let code = code_of(values);
    [1, 0].map(|sign| {
        let mut own: Vec<u8> =
            (0..8).filter(|at| code >> at & 1 == sign).map(|at| pieces[at]).collect();
        own.sort_unstable();
        own.dedup();
        // What the tunnel joins runs through the other sign.
        let is_pierced = shape.joined.is_some_and(|[corner, _]| code >> corner & 1 != sign);
        [own.len() as u64, u64::from(is_pierced)]
    })
}

/// The same by samples of the function, `pieces` a side; `None` where the grid has cavities, which the function has not.
fn sampled(values: &[f64; 8], pieces: usize) -> Option<[[u64; 2]; 2]> {
    let step = 1.0 / pieces as f64;
    let inside = Samples::from_fn([pieces + 1; 3], |x, y, z| {
        value_and_gradient(values, [x, y, z].map(|at| at as f64 * step)).0 >= 0.0
    })
    .unwrap();
    let outside =
        Samples::from_fn([pieces + 1; 3], |x, y, z| !inside.get([x, y, z].map(|at| at as i64)))
            .unwrap();
    let mut found = [[0; 2]; 2];
    for (of, samples) in found.iter_mut().zip([inside, outside]) {
        let topology = Topology::new(&samples, &Histogram::new(&samples));
        if topology.cavities > 0 || topology.tunnels < 0 {
            return None;
        }
        *of = [topology.components, topology.tunnels as u64];
    }
    Some(found)
}

/// Random cells have the components and tunnels that a finer grid of the function shows. 10⁴ of them, 10⁶ with
/// `ASPHERA_LONG`; `ASPHERA_CELLS` asks for another number.
#[test]
fn cells_have_the_topology_of_the_function() {
    let asked = std::env::var("ASPHERA_CELLS").ok();
    let usual = if std::env::var_os("ASPHERA_LONG").is_some() { 1_000_000 } else { 10_000 };
    let count: usize = asked.and_then(|count| count.parse().ok()).unwrap_or(usual);
    let mut random = Random(7);
    let (mut tunnels, mut open) = (0, Vec::new());
    for number in 0..count {
        // Half of them with alternating signs along most edges, where there is much to decide.
        let mut values: [f64; 8] = std::array::from_fn(|_| random.signed());
        if number % 2 == 1 {
            let turned = random.next() % 256;
            for (corner, value) in values.iter_mut().enumerate() {
                let is_even = corner.count_ones().is_multiple_of(2);
                let is_kept = turned >> corner & 1 == 1 && random.next().is_multiple_of(2);
                *value = if is_even != is_kept { value.abs() } else { -value.abs() };
            }
        }
        let expected = betti(&values);
        tunnels += u32::from(shape_of(&values).joined.is_some());
        // Coarse grids lose narrow passages; finer ones are asked only where they disagree.
        if ![15, 45, 96].iter().any(|&pieces| sampled(&values, pieces) == Some(expected)) {
            open.push(values);
        }
    }
    // Passages that 96 pieces do not show are few, and a thousandth of the values decides them.
    assert!(open.len() <= count / 1000, "{} {:?}", open.len(), open.first());
    for values in open {
        assert!(is_near_a_tie(&values), "{values:?}: decided {:?}", betti(&values));
    }
    assert!(tunnels > count as u32 / 500, "{tunnels}");
}

/// Whether moving all values by a thousandth of the largest changes the decision.
fn is_near_a_tie(values: &[f64; 8]) -> bool {
    let own = betti(values);
    [-1e-3, 1e-3].iter().any(|shift| betti(&values.map(|value| value + shift)) != own)
}

/// A tunnel by hand: two corners of 1 in a cell of −0.1, which the slice at 1/2 joins.
#[test]
fn opposite_corners_are_joined_where_the_body_saddle_says_so() {
    let cell = |other: f64| {
        let mut values = [other; 8];
        (values[0], values[7]) = (1.0, 1.0);
        betti(&values)
    };
    // In the middle the function is 2/8 + 6/8·other, a saddle; by symmetry the body saddles lie on the diagonal.
    assert_eq!(cell(-0.1), [[1, 0], [1, 1]]);
    assert_eq!(cell(-1.0), [[2, 0], [1, 0]]);
    // On the diagonal f(t) = (1−t)³ + t³ + 3·t·(1−t)·other, at 1/2 it is 1/4 + 3/4·other: 0 at −1/3.
    assert_eq!(cell(-0.333), [[1, 0], [1, 1]]);
    assert_eq!(cell(-0.334), [[2, 0], [1, 0]]);
}

#[test]
fn ties_follow_the_rule() {
    // A face whose saddle is exactly 0 joins foreground; whole numbers, so that nothing is rounded.
    let face = |values: [f64; 4]| {
        let [a, b, c, d] = values;
        let values = [a, b, d, c, -9.0, -9.0, -9.0, -9.0];
        betti(&values)[0][0]
    };
    assert_eq!(face([2.0, -3.0, 3.0, -2.0]), 1);
    assert_eq!(face([2.0, -3.0, 3.0, -2.000_000_1]), 2);
    assert_eq!(face([0.0, -3.0, 3.0, -2.0]), 2);
    // Products that round alike: 1 − 2⁻⁵⁴ and its square differ from it by less than a rounding.
    let near = 1.0 - f64::EPSILON / 2.0;
    let wide = 1.0 + f64::EPSILON;
    assert_eq!(near * wide, 1.0);
    assert_eq!(face([near, -1.0, wide, -1.0]), 1);
    assert_eq!(face([1.0, -near, 1.0, -wide]), 2);
    // A body saddle of exactly 0 opens no tunnel: 3·1 − 3·1 on the diagonal above, times 3.
    let mut values = [-1.0; 8];
    (values[0], values[7]) = (3.0, 3.0);
    assert_eq!(betti(&values), [[2, 0], [1, 0]]);
}

/// The number of pieces and tunnels does not depend on how the cell is turned, mirrored or scaled by a power of two.
#[test]
fn turned_and_scaled_cells_have_the_same_topology() {
    let mut random = Random(3);
    for _ in 0..3000 {
        let values: [f64; 8] = std::array::from_fn(|_| (random.next() % 511) as f64 - 255.0);
        let expected = betti(&values);
        for symmetry in crate::cell::symmetries() {
            let mut turned = [0.0; 8];
            (0..8).for_each(|corner| turned[symmetry.corner(corner)] = values[corner]);
            assert_eq!(betti(&turned), expected, "{values:?}");
        }
        assert_eq!(betti(&values.map(|value| value * 0.125)), expected);
    }
}

fn checked(values: &[f32], size: [usize; 3], threshold: f32) -> Surface {
    let samples =
        Samples::from_fn(size, |x, y, z| values[(z * size[1] + y) * size[0] + x] >= threshold)
            .unwrap();
    let surface = trilinear_surface(&samples, &Grey { values, size, threshold });
    let whole = SurfaceCheck { is_closed: true, is_oriented: true, is_manifold: true };
    assert_eq!(surface.check(), whole);
    assert!(surface.vertices.iter().flatten().all(|side| side.is_finite()));
    surface
}

#[test]
fn surfaces_of_any_values_are_closed_oriented_manifolds() {
    let mut random = Random(11);
    let mut own_vertices = 0;
    for number in 0..400 {
        let size = [8; 3];
        // Few different values make ties; NaN and infinity are missing.
        let values: Vec<f32> = (0..512)
            .map(|_| match number % 4 {
                0 => (random.signed()) as f32,
                1 => (random.next() % 3) as f32 - 1.0,
                2 => (random.next() % 256) as f32 - 127.5,
                _ if random.next().is_multiple_of(10) => f32::NAN,
                _ if random.next().is_multiple_of(30) => f32::INFINITY,
                _ => (random.next() % 7) as f32 - 3.0,
            })
            .collect();
        let surface = checked(&values, size, 0.0);
        let samples = Samples::from_fn(size, |x, y, z| values[(z * 8 + y) * 8 + x] >= 0.0).unwrap();
        let grid = crate::marching_cubes(&samples, Ambiguity::Apart, &crate::Middles);
        own_vertices += surface.vertices.len() - grid.vertices.len();
    }
    assert!(own_vertices > 0);
    assert!(checked(&[-1.0], [1; 3], 0.0).vertices.is_empty());
    assert_eq!(checked(&[1.0], [1; 3], 0.0).vertices.len(), 6);
}

/// The mesh of one cell has the Euler number of its two sides: a disc for each loop, a tube for the tunnel.
#[test]
fn meshes_of_cells_are_discs_and_tubes() {
    let mut random = Random(5);
    let mut tubes = 0;
    for _ in 0..20_000 {
        let values: [f64; 8] = std::array::from_fn(|corner: usize| {
            let value = random.signed();
            if corner.count_ones().is_multiple_of(2) && !random.next().is_multiple_of(4) {
                value.abs()
            } else {
                value
            }
        });
        let code = code_of(&values);
        let shape = shape_of(&values);
        let mut mesh = CellMesh::default();
        mesh_of(code, &values, facts()[usize::from(code)].c1_faces, &mut mesh);
        let mut vertices: Vec<u8> = mesh.triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut sides: Vec<[u8; 2]> =
            mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let directed = sides.len();
        sides.sort_unstable();
        sides.dedup();
        assert_eq!(sides.len(), directed, "a side runs once in each direction");
        sides.iter_mut().for_each(|side| side.sort_unstable());
        sides.sort_unstable();
        sides.dedup();
        let euler = vertices.len() as i64 - sides.len() as i64 + mesh.triangles.len() as i64;
        let tube = i64::from(shape.joined.is_some());
        assert_eq!(euler, shape.loops.len() as i64 - 2 * tube, "{values:?}");
        tubes += tube;
        let scale = values.iter().fold(0.0_f64, |scale, value| scale.max(value.abs()));
        for vertex in &mesh.vertices {
            assert!(vertex.iter().all(|side| (0.0..=1.0).contains(side)));
            assert!(value_and_gradient(&values, *vertex).0.abs() <= scale);
        }
    }
    assert!(tubes > 50, "{tubes}");
}

#[test]
fn threads_and_parts_left_out_change_nothing() {
    let mut random = Random(2);
    let size = [20, 17, 23];
    let values: Vec<f32> = (0..20 * 17 * 23).map(|_| random.signed() as f32).collect();
    let in_pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| checked(&values, size, 0.25))
    };
    assert_eq!(in_pool(1), in_pool(3));
    // Samples left out are background, whatever their values.
    let some = Samples::from_fn(size, |x, y, z| {
        values[(z * 17 + y) * 20 + x] >= 0.25 && (x + y + z) % 3 > 0
    })
    .unwrap();
    let surface = trilinear_surface(&some, &Grey { values: &values, size, threshold: 0.25 });
    assert!(surface.check().is_manifold);
}
