//! Few points, points on a line, in one place, on one circle, on a raster, far off, and none that are numbers.

use asphera_contour::{Kind, Method, MethodError, Parameters, PlaceMm, Samples, SamplesError};

use crate::places::{by_row, closed, thins, triangulation};

fn each(points: &[PlaceMm], check: impl Fn(Method, Vec<[u32; 2]>)) {
    let set = triangulation(points);
    for method in Method::ALL.into_iter().filter(|method| method.kind() != Kind::Region) {
        // lee and optimal-transport leave samples out.
        // fit-connect, and so stretch-denoise, needs samples on both sides of one.
        if thins(&method) || matches!(method, Method::FitConnect | Method::StretchDenoise) {
            continue;
        }
        check(method, by_row(&method.run(&set, &Parameters::new()).unwrap(), &set));
    }
}

#[test]
fn none_one_and_two() {
    each(&[], |_, edges| assert!(edges.is_empty()));
    each(&[[3.0, 4.0]], |_, edges| assert!(edges.is_empty()));
    each(&[[3.0, 4.0], [3.0, 4.0]], |_, edges| assert!(edges.is_empty()));
    each(&[[3.0, 4.0], [5.0, 4.0], [3.0, 4.0]], |method, edges| {
        assert_eq!(edges, [[0, 1]], "{}", method.name());
    });
}

#[test]
fn points_on_a_line_are_a_path() {
    for direction in [[1.0, 0.0], [0.0, 1.0], [1.0, 3.0], [-0.25, 0.125]] {
        let points: Vec<PlaceMm> = (0..20)
            .map(|step| direction.map(|along: f64| along * f64::from(step * step)))
            .collect();
        let path: Vec<[u32; 2]> = (0..19).map(|row| [row, row + 1]).collect();
        each(&points, |method, edges| {
            // Distances of a line that grow: a sphere of influence reaches farther than one sample.
            if !matches!(method, Method::Sig) {
                let found: Vec<_> = edges.iter().filter(|edge| path.contains(edge)).collect();
                assert!(found.len() == edges.len(), "{}: {edges:?}", method.name());
            }
            if matches!(
                method,
                Method::Emst | Method::Rng | Method::Gabriel | Method::Crust | Method::Delaunay
            ) {
                assert_eq!(edges, path, "{}", method.name());
            }
        });
    }
}

#[test]
fn four_on_one_circle_and_lattices() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    each(&square, |method, edges| {
        // The diagonal is a Gabriel edge, as its circle is empty but for its rim.
        // NN-Crust asks for more than the 90° of its corners.
        let bounds = ["crust", "hnn-crust", "crawl", "connect2d", "sig-connect2d", "peel", "rng"];
        if bounds.contains(&method.name()) {
            assert_eq!(edges, closed(4), "{}", method.name());
        }
    });
    let raster: Vec<PlaceMm> =
        (0..400).map(|index| [f64::from(index % 20), f64::from(index / 20)]).collect();
    each(&raster, |method, edges| {
        let is_step = |&[p, q]: &[u32; 2]| {
            let [p, q] = [p, q].map(|row| raster[row as usize]);
            (p[0] - q[0]).abs() + (p[1] - q[1]).abs() == 1.0
        };
        match method.name() {
            "rng" => assert_eq!(edges.len(), 2 * 20 * 19),
            "emst" => assert_eq!(edges.len(), 399),
            _ => {}
        }
        if matches!(
            method,
            Method::Rng | Method::Emst | Method::Peel | Method::NnCrust | Method::Cocone
        ) {
            assert!(edges.iter().all(is_step), "{}", method.name());
        }
    });
}

#[test]
fn far_offsets_lose_nothing() {
    let near: Vec<PlaceMm> = crate::places::circle(50)
        .into_iter()
        .map(|place| place.map(|value| (value * 1024.0).round() / 1024.0))
        .collect();
    let far: Vec<PlaceMm> = near.iter().map(|[x, y]| [x + 3e11, y - 2e11]).collect();
    let of_curves = |method: &Method| method.kind() == Kind::Curve && !thins(method);
    for method in Method::ALL.into_iter().filter(of_curves) {
        let edges = [&near, &far].map(|points| {
            let set = triangulation(points);
            by_row(&method.run(&set, &Parameters::new()).unwrap(), &set)
        });
        assert_eq!(edges[0], edges[1], "{}", method.name());
        assert_eq!(edges[0], closed(50), "{}", method.name());
    }
}

#[test]
fn what_cannot_be_used_is_refused_with_its_place() {
    let refused = Samples::new(&[[0.0, 0.0], [1.0, f64::NAN]]).unwrap_err();
    assert!(refused.to_string().starts_with("point 2 is (1, NaN): expected finite"), "{refused}");
    let refused = Samples::new(&[[0.0, -2e12]]).unwrap_err();
    assert_eq!(refused, SamplesError::OutOfRange { row: 0, x_mm: 0.0, y_mm: -2e12 });
    let set = triangulation(&crate::places::circle(2001));
    let beta = Parameters::parse("beta=0.5").unwrap();
    let refused = Method::Beta.run(&set, &beta).unwrap_err();
    assert_eq!(refused, MethodError::TooMany { method: "beta", most: 2000, found: 2001 });
    let refused = Method::Peel.run(&set, &Parameters::parse("delta=-1").unwrap()).unwrap_err();
    assert_eq!(refused.to_string(), "peel: expected delta from 0 to 1000000, found -1");
    let refused = Method::Crust.run(&set, &beta).unwrap_err();
    assert_eq!(refused.to_string(), "crust has no parameter `beta`: expected none");
    assert!(Method::from_name("krust").unwrap_err().to_string().contains("hnn-crust"));
    assert!(Parameters::parse("beta").is_err() && Parameters::parse("beta=x").is_err());
}
