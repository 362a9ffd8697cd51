//! Solids whose r is known, digitized at 0.57 r in any pose: nothing forbidden occurs, and every method has their topology.

use asphera_volume::{
    Ambiguity, BALL_RADIUS, Blend, GridCheck, Histogram, LEAST_BALL_RADIUS, Majority, Method,
    Middles, Topology, Verdict, reconstruct,
};

use crate::bodies::Body;
use crate::meshes::assert_manifold;
use crate::noise::Random;

/// h = 0.57 r < r / √3.
const SPACING: f64 = 0.57;

#[test]
fn digitized_regular_bodies_keep_their_topology() {
    let mut random = Random::new(20);
    let mut pairs = 0;
    let rounds = if std::env::var_os("ASPHERA_LONG").is_some() { 10_000 } else { 300 };
    for round in 0..rounds {
        let body = match round % 50 {
            // Knots take a hundred times as long as others.
            49 => Body::knot(
                [[2, 3], [3, 2], [2, 5]][(random.word() % 3) as usize],
                [random.between(2.5, 4.0), random.between(0.9, 1.3)],
            ),
            _ => Body::random(&mut random),
        };
        let samples = body.digitized(SPACING * body.regular, &mut random);
        let what = format!("{round}: {}", body.name);
        let histogram = Histogram::new(&samples);
        let check = GridCheck::new(&samples, &histogram);
        assert_eq!((check.forbidden, check.case8_unpaired, check.c2), (0, 0, 0), "{what}");
        assert_eq!(check.places, []);
        assert_eq!(2 * check.c1, check.case8, "{what}");
        pairs += check.c1;
        let spacing_mm = [SPACING * body.regular; 3];
        assert_eq!(check.verdict(spacing_mm, Some(body.regular)).0, Verdict::Proved);
        assert_eq!(check.verdict(spacing_mm, None).0, Verdict::Unknown);
        let topology = Topology::new(&samples, &histogram);
        assert!(topology.is_determined());
        assert_eq!(2 * topology.euler_6, body.surface_euler, "{what}");
        assert_eq!((topology.components, topology.cavities), (body.components, 0), "{what}");
        for method in methods(round) {
            let surface = reconstruct(&samples, &method, &Middles).unwrap();
            let what = format!("{what}: {method:?}");
            assert_manifold(&surface, &what);
            assert_eq!(surface.euler(), body.surface_euler, "{what}");
            assert_eq!(surface.pieces().len() as u64, body.components, "{what}");
        }
    }
    // Or the rule for pairs was never tried.
    assert!(pairs > 50, "{pairs}");
}

/// All methods that keep the topology. Those that need a finer grid are seen in every third round, with refinements that change.
fn methods(round: usize) -> Vec<Method> {
    let mut methods = vec![
        Method::Marching(Ambiguity::Paired),
        Method::Marching(Ambiguity::Apart),
        Method::Marching(Ambiguity::Joined),
        Method::Majority(Majority::Foreground),
        Method::Majority(Majority::Complement),
    ];
    if round.is_multiple_of(3) {
        let turn = round / 3;
        let refine = 1 + turn % 4;
        let blend = [Blend::Linear, Blend::Cubic, Blend::Infinite][turn % 3];
        let radius = [LEAST_BALL_RADIUS, BALL_RADIUS, 0.999][turn % 3];
        methods.push(Method::Trilinear { refine });
        methods.push(Method::Smooth { blend, refine });
        methods.push(Method::Balls { radius, refine: 4 + turn % 3 });
    }
    methods
}
