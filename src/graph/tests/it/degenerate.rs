//! Inputs that are no surface: nothing panics, and what cannot be is said.

use asphera_graph::{
    Choices, Cloud, CloudError, ExtractError, GraphError, StripChoice, auto_tau_mm, extract,
    functions, parts,
};

fn graph(points: &[[f64; 3]], choices: &Choices) -> Result<(usize, usize, usize), ExtractError> {
    let cloud = Cloud::new(points).unwrap();
    let field = functions::height(&cloud, [0.0, 0.0, 1.0]).unwrap();
    let found = extract(&cloud, &field, choices)?;
    found.stability(&cloud, &field, choices).unwrap();
    let nearest = cloud.nearest(10).unwrap();
    functions::geodesic_from_ends(&cloud, &nearest).unwrap();
    functions::principal_height(&cloud, 2).unwrap();
    let components = found.graph.components().1 as usize;
    Ok((found.graph.nodes().len(), components, found.loops.len()))
}

#[test]
fn few_points_and_points_in_one_place_line_or_plane() {
    let auto = Choices::default();
    assert_eq!(graph(&[], &auto), Err(ExtractError::NoPoints));
    assert_eq!(graph(&[[1.0, 2.0, 3.0]], &auto), Ok((1, 1, 0)));
    assert_eq!(graph(&[[1.0, 2.0, 3.0]; 1_000_000], &auto), Ok((1, 1, 0)));
    assert_eq!(graph(&[[0.0; 3], [1.0; 3]], &auto).unwrap().2, 0);
    let line: Vec<_> = (0..5000).map(|at| [0.0, 0.0, f64::from(at / 3)]).collect();
    let (_, components, loops) = graph(&line, &auto).unwrap();
    assert_eq!((components, loops), (1, 0));
    let plane: Vec<_> =
        (0..10_000).map(|at| [f64::from(at % 100), f64::from(at / 100), 1e9]).collect();
    assert_eq!(graph(&plane, &auto), Ok((1, 1, 0)));
    let tiny: Vec<_> = plane.iter().map(|point| point.map(|value| value * 1e-300)).collect();
    assert_eq!(graph(&tiny, &auto), Ok((1, 1, 0)));
    let far: Vec<_> =
        plane.iter().map(|point| [point[0] + 1e9, point[1] - 1e9, point[0]]).collect();
    let (_, components, loops) = graph(&far, &auto).unwrap();
    assert_eq!((components, loops), (1, 0));
}

#[test]
fn choices_that_do_not_fit_are_told() {
    let points: Vec<_> =
        (0..1000).map(|at| [f64::from(at % 10), f64::from(at / 10), f64::from(at)]).collect();
    let with = |tau_mm, strips| {
        graph(&points, &Choices { tau_mm: Some(tau_mm), strips, ..Choices::default() })
    };
    for tau_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            with(tau_mm, StripChoice::Uniform(3)),
            Err(ExtractError::Graph(GraphError::Tau { .. }))
        ));
    }
    assert!(matches!(
        with(1e-30, StripChoice::Uniform(3)),
        Err(ExtractError::Graph(GraphError::FineTau { .. }))
    ));
    // Below the spacing everything is apart.
    assert_eq!(with(0.5, StripChoice::Uniform(3)), Ok((1000, 1000, 0)));
    // Above the part everything is one.
    assert_eq!(with(1e300, StripChoice::Uniform(3)), Ok((3, 1, 0)));
    assert_eq!(with(1e300, StripChoice::Uniform(5000)).unwrap().0, 1000);
    assert!(with(1.0, StripChoice::Uniform(0)).is_err());
    let refused = |point| Cloud::new(&[point]).map(|_| ());
    assert!(matches!(refused([0.0, f64::NAN, 0.0]), Err(CloudError::OutOfRange { axis: 1, .. })));
    assert!(matches!(refused([1e308, 0.0, 0.0]), Err(CloudError::OutOfRange { axis: 0, .. })));
    let cloud = Cloud::new(&points).unwrap();
    let given = functions::Field::given(vec![f64::NAN; 1000]);
    assert!(matches!(
        extract(&cloud, &given, &Choices::default()),
        Err(ExtractError::Graph(GraphError::NotFinite { place: 0, .. }))
    ));
    let constant = functions::Field::given(vec![7.0; 1000]);
    assert_eq!(extract(&cloud, &constant, &Choices::default()).unwrap().graph.strips().count(), 1);
}

#[test]
fn a_scene_has_its_parts_and_its_dust_apart() {
    let mut points = Vec::new();
    for part in 0..3 {
        points.extend(
            (0..900)
                .map(|at| [f64::from(at % 30) + 50.0 * f64::from(part), f64::from(at / 30), 0.0]),
        );
    }
    points.push([20.0, 80.0, 3.0]);
    let cloud = Cloud::new(&points).unwrap();
    let tau_mm = auto_tau_mm(&cloud).unwrap();
    let min_points = asphera_graph::auto_min_points(&cloud, tau_mm).unwrap();
    let found = parts(&cloud, tau_mm, min_points).unwrap();
    assert_eq!((found.parts.len(), found.islands.len()), (3, 1));
    assert_eq!(found.parts[1].box_mm, [[50.0, 0.0, 0.0], [79.0, 29.0, 0.0]]);
    assert_eq!(found.parts.iter().map(|part| part.points).collect::<Vec<_>>(), [900; 3]);
}
