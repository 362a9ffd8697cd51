//! Descriptors of shapes: bodies of one kind are nearer to each other than to others.

use asphera_graph::compare::{Size, evaluation, graph_features, shape_descriptor};
use asphera_graph::functions::FunctionError;
use asphera_graph::{Choices, Cloud, StripChoice, extract, functions};

use crate::bodies::{Body, Place, Random};

/// Two bodies of each of four kinds, in other sizes and poses.
fn bodies() -> Vec<(usize, Cloud<3>)> {
    let mut random = Random::new(21);
    let kinds = [Body::sphere(), Body::torus(), Body::row(3), Body::plate(0.5)];
    let mut all = Vec::new();
    for (class, body) in kinds.iter().enumerate() {
        for size in [1.0, 3.0] {
            let points = body.sample(4_000, &mut random);
            let turned: Vec<Place> =
                points.iter().map(|&[x, y, z]| [5.0 - size * y, size * x, size * z]).collect();
            all.push((class, Cloud::new(&turned).unwrap()));
        }
    }
    all
}

#[test]
fn shapes_of_one_kind_find_each_other_in_any_size() {
    let bodies = bodies();
    let classes: Vec<usize> = bodies.iter().map(|(class, _)| *class).collect();
    let of = |size: Size| {
        let all = bodies.iter().map(|(_, cloud)| shape_descriptor(cloud, size).unwrap());
        let all: Vec<_> = all.collect();
        evaluation(&classes, |a, b| all[a].distance(&all[b])).unwrap()
    };
    let free = of(Size::Free);
    assert_eq!((free.nearest_neighbour, free.mean_average_precision), (1.0, 1.0), "{free:?}");
    // Where sizes count, a body of three times the size is another one.
    assert!(of(Size::Counts).nearest_neighbour < 0.5);
}

#[test]
fn descriptors_do_not_hang_on_the_order_of_points_or_on_units() {
    let points = Body::torus().sample(2_000, &mut Random::new(22));
    let of = |points: &[Place], size| shape_descriptor(&Cloud::new(points).unwrap(), size).unwrap();
    let own = of(&points, Size::Free);
    let mut reversed = points.clone();
    reversed.reverse();
    assert_eq!(own, of(&reversed, Size::Free));
    let larger: Vec<Place> = points.iter().map(|point| point.map(|mm| 64.0 * mm)).collect();
    assert_eq!(own, of(&larger, Size::Free));
    assert_eq!(own.distance(&own), 0.0);
    let other = of(&Body::sphere().sample(2_000, &mut Random::new(23)), Size::Free);
    assert_eq!(own.distance(&other), other.distance(&own));
    assert!(own.distance(&other) > 0.1);
    let few = Cloud::new(&points[..7]).unwrap();
    assert_eq!(shape_descriptor(&few, Size::Free), Err(FunctionError::NoPoints));
    // A cloud in pieces is compared by its distances alone.
    let mut parted = points.clone();
    parted.extend(points.iter().map(|&[x, y, z]| [x, y, z + 90.0]));
    assert!(of(&parted, Size::Counts).distance(&of(&parted, Size::Counts)) == 0.0);
}

/// The distance of the paper keeps the laws of a pseudo-metric and does not see another sample of the same body.
#[test]
fn the_distance_of_the_paper_keeps_its_laws() {
    let mut random = Random::new(24);
    let mut features = |body: &Body| {
        let cloud = Cloud::new(&body.sample(20_000, &mut random)).unwrap();
        let height = functions::height(&cloud, [1.0, 0.2, 0.1]).unwrap();
        let choices = Choices { strips: StripChoice::Uniform(20), ..Choices::default() };
        graph_features(&extract(&cloud, &height, &choices).unwrap().graph)
    };
    let [torus, again] = [features(&Body::torus()), features(&Body::torus())];
    let (sphere, row) = (features(&Body::sphere()), features(&Body::row(3)));
    assert_eq!(sphere.nodes, 20);
    assert!(torus.distance(&again) < 0.2 * torus.distance(&sphere), "{torus:?} {again:?}");
    for (a, b, c) in [(torus, sphere, row), (sphere, row, torus)] {
        assert_eq!(a.distance(&b), b.distance(&a));
        assert!(a.distance(&c) <= a.distance(&b) + b.distance(&c) + 1e-12);
        assert_eq!(a.distance(&a), 0.0);
    }
}
