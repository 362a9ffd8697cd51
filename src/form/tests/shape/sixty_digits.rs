//! Heights and all derivatives against tables.py, which computes them in 60 decimal digits.

use std::sync::Arc;

use asphera_form::shape::{
    Biconic, ConicSection, Cylinder, EvenAsphere, Mirror, OddAsphere, OffAxis, Projection,
    QAsphere, Shape, Toroid,
};

fn shape(kind: &str, numbers: &[f64]) -> Arc<dyn Shape> {
    let base = |at: usize| ConicSection::new(numbers[at], numbers[at + 1]).unwrap();
    let even = |n: &[f64]| {
        let terms = [(2, n[2]), (4, n[3]), (10, n[4])];
        Arc::new(EvenAsphere::new(base(0), &terms).unwrap())
    };
    // Of a Q asphere the last number is ρmax.
    let (a, rho_max) = (&numbers[2..numbers.len() - 1], numbers[numbers.len() - 1]);
    let bfs = |projection| QAsphere::bfs(base(0), rho_max, projection, a).unwrap();
    let n = numbers;
    match kind {
        "even" => even(n),
        "odd" => {
            let terms = [(1, n[2]), (3, n[3]), (4, n[4])];
            Arc::new(OddAsphere::new(base(0), &terms).unwrap())
        }
        "acylinder" => Arc::new(Cylinder::acylinder(base(0), &[(4, n[2])]).unwrap()),
        "biconic" => Arc::new(Biconic::new(base(0), base(2))),
        "toroid" => Arc::new(Toroid::new(n[0], base(1), &[(2, n[3]), (6, n[4])]).unwrap()),
        "q_bfs_axis" => Arc::new(bfs(Projection::Axis)),
        "q_bfs_sphere" => Arc::new(bfs(Projection::SphereNormal)),
        "q_bfs_conic" => Arc::new(bfs(Projection::ConicNormal)),
        "q_con" => Arc::new(QAsphere::con(base(0), rho_max, a).unwrap()),
        "cylindrical" => Arc::new(Mirror::cylindrical(n[0], n[1], n[2]).unwrap()),
        "revolved" => Arc::new(Mirror::revolved(n[0], n[1], n[2]).unwrap()),
        "off_axis" => Arc::new(OffAxis::tilted(even(n), n[5], n[6]).unwrap()),
        other => unreachable!("tables.py writes no {other}"),
    }
}

/// Each to a few roundings: of its own, of what the height over the distance (or its square) makes of a
/// slope (or bend), and off the axis of the parent's coordinates.
#[test]
fn heights_and_derivatives() {
    let mut lines = 0;
    for line in include_str!("tables.txt").lines() {
        let mut fields = line.split("; ");
        let kind = fields.next().unwrap();
        let mut numbers = || -> Vec<f64> {
            fields.next().unwrap().split(' ').map(|number| number.parse().unwrap()).collect()
        };
        let shape = shape(kind, &numbers());
        let [place, z, gradient, hessian, by] = std::array::from_fn(|_| numbers());
        let (tolerance, origin_mm) = if kind == "off_axis" { (1e-13, 10.0) } else { (4e-15, 0.0) };
        let hold = |what: &str, ours: &[f64], expected: &[f64], floor: f64| {
            let largest = expected.iter().fold(floor, |largest, value| largest.max(value.abs()));
            for (own, value) in ours.iter().zip(expected) {
                let error = (own - value).abs();
                assert!(error <= tolerance * largest, "{line}: {what} {own}, off by {error:e}");
            }
        };
        let (x, y) = (place[0], place[1]);
        let r = x.hypot(y);
        let jet = shape.jet(x, y).unwrap();
        hold("height", &[jet.z_mm, shape.sag_mm(x, y).unwrap()], &[z[0], z[0]], origin_mm);
        hold("slope", &jet.gradient, &gradient, z[0].abs() / r);
        hold("bend", &jet.hessian_per_mm, &hessian, z[0].abs() / (r * r));
        let mut ours = vec![f64::NAN; by.len()];
        shape.by_parameters(x, y, &mut ours).unwrap();
        for (own, value) in ours.iter().zip(&by) {
            hold("by a parameter", &[*own], &[*value], 0.0);
        }
        lines += 1;
    }
    assert_eq!(lines, 104);
}
