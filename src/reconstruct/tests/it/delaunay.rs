//! The Delaunay triangulation: by its own exact check, by brute force, by counts that are known, and by Qhull.

use std::process::{Command, Stdio};

use asphera_geometry::PointMm;
use asphera_geometry::predicates::{orientation_in_space, sphere_encloses};
use asphera_reconstruct::{Delaunay, LeftOut, NoDelaunay, Unsound, check_delaunay};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, torus, uniform};

fn lattice(side: u32) -> Vec<PointMm> {
    let steps = || (0..side).map(f64::from);
    steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z]))).collect()
}

fn random(count: usize, seed: u64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(seed);
    (0..count).map(|_| [0; 3].map(|_| uniform(&mut random))).collect()
}

fn sound(points: &[PointMm]) -> Vec<[u32; 4]> {
    let found = Delaunay::new(points).unwrap().tetrahedra();
    assert_eq!(check_delaunay(points, &found), Ok(()));
    found
}

/// Tetrahedra by their places, whatever the numbers of the points.
fn by_places(points: &[PointMm]) -> Vec<[[u64; 3]; 4]> {
    let mut all: Vec<_> = Delaunay::new(points)
        .unwrap()
        .tetrahedra()
        .iter()
        .map(|corners| {
            let mut places = corners.map(|corner| points[corner as usize].map(f64::to_bits));
            places.sort_unstable();
            places
        })
        .collect();
    all.sort_unstable();
    all
}

/// All tetrahedra whose spheres enclose no point.
fn by_brute_force(points: &[PointMm]) -> Vec<[u32; 4]> {
    let at = |corner: usize| points[corner];
    let n = points.len();
    let mut found = Vec::new();
    for (a, b, c, d) in (0..n).flat_map(|a| {
        (a + 1..n)
            .flat_map(move |b| (b + 1..n).flat_map(move |c| (c + 1..n).map(move |d| (a, b, c, d))))
    }) {
        let side = orientation_in_space(at(a), at(b), at(c), at(d));
        if side.is_eq() {
            continue;
        }
        let [p, q] = if side.is_gt() { [a, b] } else { [b, a] };
        let mut others = (0..n).filter(|e| ![a, b, c, d].contains(e));
        if !others.any(|e| sphere_encloses(at(p), at(q), at(c), at(d), at(e))) {
            found.push([a, b, c, d].map(|corner| corner as u32));
        }
    }
    found.sort_unstable();
    found
}

#[test]
fn scans_random_points_and_exact_lattices_are_sound() {
    sound(&random(20_000, 1));
    sound(&ball(5_000, 0.0, 2));
    sound(&ball(5_000, 5e-6, 3));
    sound(&torus(100, 40).0);
    let cube = sound(&lattice(9));
    // Every unit cube has five or six tetrahedra; the rule for ties cuts all alike, into six.
    assert_eq!(cube.len(), 6 * 8 * 8 * 8);
    // Two planes: all others of their places are cospherical and coplanar many times over.
    let far: Vec<PointMm> =
        lattice(8).into_iter().map(|[x, y, z]| [1e9 + x, y - 1e9, 1e11 + 8.0 * z]).collect();
    assert_eq!(sound(&far).len(), 6 * 7 * 7 * 7);
    let decimal: Vec<PointMm> =
        lattice(7).iter().map(|p| p.map(|value| 0.1 * value - 3.3)).collect();
    sound(&decimal);
}

#[test]
fn the_order_of_points_changes_nothing() {
    for mut points in [random(2_000, 4), lattice(7), ball(2_000, 0.0, 5), torus(40, 30).0] {
        let expected = by_places(&points);
        let mut numbers = Pcg64::seed_from_u64(6);
        for last in (1..points.len()).rev() {
            points.swap(last, (numbers.next_u64() % (last as u64 + 1)) as usize);
        }
        assert_eq!(by_places(&points), expected);
    }
}

#[test]
fn two_skew_lines_have_a_tetrahedron_for_every_pair_of_gaps() {
    let mut points: Vec<PointMm> = (0..60).map(|at| [f64::from(at), 0.0, 0.0]).collect();
    points.extend((0..40).map(|at| [3.0, f64::from(at * at) - 100.0, 1.0]));
    assert_eq!(sound(&points).len(), 59 * 39);
}

#[test]
fn points_that_do_not_span_space_are_refused() {
    let of = |points: &[PointMm]| Delaunay::new(points).unwrap_err();
    assert_eq!(of(&[]), NoDelaunay::TooFew { found: 0 });
    assert_eq!(of(&[[f64::NAN; 3], [0.0; 3], [0.0; 3], [1.0; 3]]), NoDelaunay::TooFew { found: 2 });
    let line: Vec<PointMm> = (0..50).map(|at| [0.5 * f64::from(at), f64::from(at), 7.0]).collect();
    assert_eq!(of(&line), NoDelaunay::OnALine { places: 50 });
    let plane: Vec<PointMm> =
        lattice(6).into_iter().map(|[x, y, _]| [x + 1e9, y, x - 3.0]).collect();
    assert_eq!(of(&plane), NoDelaunay::InAPlane { places: 36 });
    assert!(of(&plane).to_string().contains("--method local"));
    // One place a last bit off the plane.
    let mut off = plane[..0].to_vec();
    off.extend((0..36).map(|at| [f64::from(at % 6), f64::from(at / 6), 1.0]));
    off[17][2] = 1.0_f64.next_up();
    off.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(Delaunay::new(&off).unwrap().tetrahedra(), by_brute_force(&off));
    let mut points = lattice(3);
    points.insert(5, [f64::INFINITY, 0.0, 0.0]);
    points.push([2.0; 3]);
    let found = Delaunay::new(&points).unwrap();
    assert_eq!(found.left_out(), [(5, LeftOut::NoPlace), (28, LeftOut::Duplicate)]);
    assert_eq!((found.vertices(), found.tetrahedra().len()), (27, 48));
}

#[test]
fn the_check_finds_what_is_wrong() {
    let points = lattice(3);
    let right = sound(&points);
    let check = |change: &dyn Fn(&mut Vec<[u32; 4]>)| {
        let mut wrong = right.clone();
        change(&mut wrong);
        check_delaunay(&points, &wrong).unwrap_err()
    };
    assert!(matches!(check(&|all| all.push(all[0])), Unsound::SameSide { .. }));
    assert!(matches!(check(&|all| all[3][2] = 27), Unsound::NoSuchPoint { .. }));
    assert!(matches!(check(&|all| all[3] = [0, 1, 2, 3]), Unsound::Flat { .. }));
    let cell = right.len() / 2;
    assert!(matches!(
        check(&|all| {
            all.remove(cell);
        }),
        Unsound::NotConvex { .. } | Unsound::HullOpen { .. }
    ));
    assert_eq!(check(&|all| all.clear()), Unsound::Empty);
    // Another way to cut the cubes has empty spheres too, but not by the rule.
    let mirrored: Vec<[u32; 4]> =
        right.iter().map(|corners| corners.map(|at| (2 - at / 9) * 9 + at % 9)).collect();
    assert!(matches!(check_delaunay(&points, &mirrored), Err(Unsound::SphereNotEmpty { .. })));
    // Two bodies over one another: each is sound, both together wind twice.
    let mut twice = lattice(2);
    twice.extend(lattice(2).iter().map(|p| p.map(|value| 0.25 + 0.5 * value)));
    let half = sound(&lattice(2));
    let mut both = half.clone();
    both.extend(half.iter().map(|corners| corners.map(|corner| corner + 8)));
    assert!(matches!(
        check_delaunay(&twice, &both),
        Err(Unsound::Overlap { .. } | Unsound::NotConvex { .. })
    ));
}

#[test]
fn qhull_finds_the_same_tetrahedra() {
    let Some(python) = std::env::var_os("ASPHERA_PYTHON") else {
        eprintln!("skipped: ASPHERA_PYTHON not set");
        return;
    };
    let has = Command::new(&python).args(["-c", "import scipy.spatial"]).output();
    if !has.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: python package scipy not found");
        return;
    }
    const SCRIPT: &str = "
import sys, numpy
from scipy.spatial import Delaunay
points = numpy.loadtxt(sys.stdin)
cells = numpy.sort(Delaunay(points).simplices, axis=1)
for cell in sorted(map(tuple, cells)): print(*cell)";
    for points in [random(3_000, 7), ball(3_000, 1e-3, 8)] {
        let mut child = Command::new(&python)
            .args(["-c", SCRIPT])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let text: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
        std::io::Write::write_all(&mut child.stdin.take().unwrap(), text.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success());
        let expected: Vec<[u32; 4]> = String::from_utf8(output.stdout)
            .unwrap()
            .lines()
            .map(|line| {
                let mut fields = line.split(' ').map(|field| field.parse().unwrap());
                std::array::from_fn(|_| fields.next().unwrap())
            })
            .collect();
        assert_eq!(Delaunay::new(&points).unwrap().tetrahedra(), expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn few_points_of_a_lattice_agree_with_brute_force(
        places in prop::collection::btree_set(prop::array::uniform3(0_i32..4), 4..14),
        tilt in 0_i32..3,
    ) {
        let points: Vec<PointMm> = places
            .iter()
            .map(|&[x, y, z]| [x, y, z + tilt * x].map(f64::from))
            .collect();
        match Delaunay::new(&points) {
            Ok(found) => {
                let found = found.tetrahedra();
                prop_assert_eq!(check_delaunay(&points, &found), Ok(()));
                prop_assert_eq!(found, by_brute_force(&points));
            }
            Err(_) => prop_assert_eq!(by_brute_force(&points), Vec::<[u32; 4]>::new()),
        }
    }
}
