//! Targets in ρ on surfaces whose reach is known.

use std::f64::consts::SQRT_2;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_report::SamplingFigures;

use crate::Part;
use crate::nominal::parse;
use crate::sampling::current::Current;
use crate::sampling::{Along, Wanted, sampling_of_mesh, sampling_of_points};
use crate::{Pipeline, Remembered};

/// A raster of `side` × `side` places `step_mm` apart about the origin.
fn raster(side: u32, step_mm: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..side * side).map(move |index| {
        [index % side, index / side]
            .map(|at| step_mm * (f64::from(at) - 0.5 * (f64::from(side) - 1.0)))
    })
}

fn part(surface: &str, sampling: &str) -> Part {
    parse("part.toml", &format!("{surface}[fit]\nfree = [\"tz\"]\n[sampling]\n{sampling}")).unwrap()
}

/// The sampling of exact points of a part.
fn sampled(part: Part, places: impl Iterator<Item = [f64; 2]>) -> SamplingFigures {
    let nominal = part.nominal.clone();
    let mut pipeline = Pipeline::new(part);
    let heights = places.filter_map(|[x, y]| Some([x, y, nominal.height_mm(x, y)?]));
    heights.for_each(|point| pipeline.take_position(point));
    pipeline.finish().report.sampling
}

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 20\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 4\n";
/// A tube of 20 mm about a circle.
const TORUS: &str = "[surface]\nkind = \"toroid\"\nrotation_radius_mm = 50\nradius_mm = 20\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 4\n";
const CYLINDER: &str = "[surface]\nkind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = 20\n\
    [aperture]\nshape = \"rectangle\"\nwidth_mm = 8\nheight_mm = 8\n";
/// Bends most strongly at its rim, with a radius of (R² - k·r²)^(3/2)/R² = 5.12 mm. The centres of that curvature lie
/// 2.16 mm from the axis, 5.74 mm above the vertex: nearest to the rim, 6.13 mm from the vertex.
const ELLIPSOID: &str = "[surface]\nkind = \"asphere\"\nradius_mm = 10\nconic = 1\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 6\n";

/// Share of a raster of 0.1 mm that lies within 0.04 mm of its points. It falls with the slope.
const DISCS: f64 = std::f64::consts::PI * 0.16;

/// Half the diagonal of the squares of a raster of 0.1 mm is the gap; it grows with the slope.
#[test]
fn rho_is_the_gap_over_the_smallest_local_feature_size() {
    for (surface, reach_mm, steep) in
        [(SPHERE, 20.0, 1.03), (TORUS, 20.0, 1.03), (CYLINDER, 20.0, 1.03)]
    {
        let places = || raster(101, 0.1);
        let found = sampled(part(surface, "rho_limit = 0.0038\n"), places());
        assert!((found.reach_mm.unwrap() / reach_mm - 1.0).abs() < 4e-3, "{found:?}");
        assert_eq!(found.lfs_source.as_deref(), Some("nominal"));
        assert_eq!((found.rho_target, found.epsilon_target), (Some(0.0038), None));
        assert_eq!(found.rho_max, Some(found.gap_max_mm.unwrap() / found.reach_mm.unwrap()));
        let rho = found.rho_max.unwrap() * reach_mm * SQRT_2 / 0.1;
        assert!((0.995..steep).contains(&rho), "{surface}: {rho}");
        assert_eq!((found.coverage, found.next.len()), (Some(1.0), 0), "{surface}: {found:?}");
        assert!(found.unknown.is_empty(), "{found:?}");

        // A limit of 0.04 mm is met within quarters of discs about the points, and the spacing needed says by how much.
        let found = sampled(part(surface, "rho_limit = 0.002\n"), places());
        assert_eq!(found.next.len(), 1, "{surface}: {found:?}");
        let share = found.coverage.unwrap() / DISCS;
        assert!((0.97..1.001).contains(&share), "{surface}: {share}");
        let needed_mm = SQRT_2 * 0.002 * found.reach_mm.unwrap();
        let spacing_mm = found.next[0].spacing_needed_mm.unwrap();
        assert!((spacing_mm / needed_mm - 1.0).abs() < 1e-12, "{spacing_mm}");
    }
}

/// The reach is that of all the aperture, also of what was not measured: the middle is farther from the medial axis,
/// and bends less.
#[test]
fn what_was_not_measured_counts_for_the_reach_of_a_nominal() {
    let near = |found: Option<f64>, expected: f64| (found.unwrap() / expected - 1.0).abs() < 6e-3;
    let places = || raster(123, 0.1);
    let whole = sampled(part(ELLIPSOID, "rho_limit = 0.05\n"), places());
    assert!(near(whole.reach_mm, 5.12) && near(whole.lfs_min_mm, 5.12), "{whole:?}");
    let middle = places().filter(|[x, y]| x.hypot(*y) < 3.0);
    let middle = sampled(part(ELLIPSOID, "rho_limit = 0.05\n"), middle);
    assert!(near(middle.reach_mm, 5.12), "{middle:?}");
    let border_mm = (3.0_f64 - 2.16).hypot(5.741 - 0.472);
    assert!((middle.lfs_min_mm.unwrap() / border_mm - 1.0).abs() < 0.02, "{middle:?}");
    assert!((middle.coverage.unwrap() - 0.25).abs() < 0.02, "{middle:?}");
    // Without an aperture it is that of what was measured.
    let anywhere = ELLIPSOID.split("[aperture]").next().unwrap();
    let places = places().filter(|[x, y]| x.hypot(*y) < 3.0);
    let found = sampled(part(anywhere, "rho_limit = 0.05\n"), places);
    assert!(near(found.reach_mm, 91.0_f64.powf(1.5) / 100.0), "{found:?}");
}

/// Of two targets the stricter counts at each place. On the ellipsoid either is met in the middle and not at the rim,
/// where gaps are larger; that of ε the sooner, as the local feature size falls besides.
#[test]
fn of_two_targets_the_stricter_counts() {
    let found = |limits: &str| sampled(part(ELLIPSOID, limits), raster(123, 0.1));
    let by_epsilon = found("epsilon_limit = 0.009\n");
    let share = by_epsilon.coverage.unwrap();
    assert!((0.2..0.9).contains(&share), "{by_epsilon:?}");
    // So large a ρ changes nothing.
    let both = found("epsilon_limit = 0.009\nrho_limit = 0.5\n");
    assert_eq!((both.epsilon_target, both.rho_target), (Some(0.009), Some(0.5)));
    assert_eq!((both.coverage, &both.next), (by_epsilon.coverage, &by_epsilon.next));
    // A gap is 0.071 mm at most where the surface is flat: 0.0138 of the reach.
    let by_rho = found("rho_limit = 0.0105\n");
    let both = found("epsilon_limit = 0.5\nrho_limit = 0.0105\n");
    assert!((0.01..0.99).contains(&by_rho.coverage.unwrap()), "{by_rho:?}");
    assert_eq!((both.coverage, &both.next), (by_rho.coverage, &by_rho.next));
    // One tighter than either.
    let both = found("epsilon_limit = 0.009\nrho_limit = 0.0105\n").coverage.unwrap();
    assert!(both <= share && both <= by_rho.coverage.unwrap(), "{both}");
    // The gap's own limit counts beside them.
    let share = found("rho_limit = 0.5\ngap_limit_mm = 0.04\n").coverage.unwrap();
    assert!((0.8..1.0).contains(&(share / DISCS)), "{share}");
}

#[test]
fn a_plane_has_no_reach_and_a_rho_of_nothing() {
    let plane = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 4\n";
    let mut pipeline = Pipeline::new(part(plane, "rho_limit = 1e-6\n"));
    // An exact tilt: heights that are all one number would hide their noise.
    raster(101, 0.125)
        .for_each(|[x, y]| pipeline.take_position([x, y, (4.0 * x + 5.0 * y) / 4096.0]));
    let found = pipeline.finish().report.sampling;
    assert_eq!((found.reach_mm, found.rho_max), (None, Some(0.0)));
    assert_eq!((found.coverage, found.unknown.len()), (Some(1.0), 0), "{found:?}");
}

#[test]
fn the_points_alone_tell_the_reach_of_a_cylinder() {
    // Noise of some 10 nm, from the last digits of a product.
    let noise = |x: f64, y: f64| 3e-5 * ((1e4 * (x + 0.01).sin() * (y + 7.7)).fract().abs() - 0.5);
    let points: Vec<PointMm> = raster(101, 0.1)
        .map(|[x, y]| [x, y, 20.0 - (400.0 - x * x).sqrt() + noise(x, y)])
        .collect();
    let wanted = Wanted::new(None, Some(0.0042), None);
    let found = sampling_of_points(points, Along::Z, wanted).figures;
    assert_eq!(found.lfs_source.as_deref(), Some("measured"), "{found:?}");
    // Too large is the dangerous side: no more than a tenth.
    assert!((0.85..1.1).contains(&(found.reach_mm.unwrap() / 20.0)), "{found:?}");
    assert_eq!(found.reach_mm, found.lfs_min_mm);
    assert_eq!(found.rho_max, Some(found.gap_max_mm.unwrap() / found.reach_mm.unwrap()));
    assert!(found.coverage.is_some(), "{found:?}");
}

/// Nine points tell neither their noise nor a local feature size: nothing is said of limits that hold of it.
#[test]
fn with_a_reach_that_is_not_known_no_coverage_is() {
    for wanted in [Wanted::new(None, Some(0.1), None), Wanted::default()] {
        let points: Vec<PointMm> = raster(3, 1.0).map(|[x, y]| [x, y, 0.01 * x * x]).collect();
        let found = sampling_of_points(points, Along::Z, wanted).figures;
        assert_eq!((found.reach_mm, found.rho_max, found.lfs_source), (None, None, None));
        let decided = [found.coverage, found.undersampled_area_mm2, found.uncovered_area_mm2];
        assert_eq!((decided, found.islands), ([None; 3], None), "{:?}", found.unknown);
        assert_eq!(found.spacing_recommended_mm, None);
        assert!(found.next.iter().all(|next| next.spacing_needed_mm.is_none()));
        let said = |what: &str| found.unknown.iter().any(|why| why.contains(what));
        assert!(said("the local feature size is not known"), "{:?}", found.unknown);
        assert_eq!(
            said("without the reach there is no ρ"),
            wanted.rho.is_some(),
            "{:?}",
            found.unknown
        );
    }
}

/// What is kept up while points arrive knows of ρ as well.
#[test]
fn the_running_figures_follow_a_target_in_rho() {
    for (limit, dense) in [(0.0038, 1.0), (0.002, DISCS)] {
        let part = part(SPHERE, &format!("rho_limit = {limit}\n"));
        let points: Vec<PointMm> =
            raster(101, 0.1).map(|[x, y]| [x, y, part.nominal.height_mm(x, y).unwrap()]).collect();
        let mut mesh = Mesh::new();
        mesh.insert(&points[..6000]);
        let (mut current, mut remembered) = (Current::default(), Remembered::default());
        let (pose, plane) = (Default::default(), asphera_surface::Plane::XY);
        let seen = sampling_of_mesh(&mesh, &part, &pose, &plane, &mut remembered);
        current.begin(&mesh, &part, &pose, &seen, &remembered);
        mesh.insert(&points[6000..]);
        current.keep_up(&mesh, &part, &remembered);
        let found = current.figures().unwrap();
        assert_eq!(found.as_of_points, 101 * 101);
        let share = found.dense_fraction.unwrap() / dense;
        assert!((0.97..1.001).contains(&share), "{found:?}");
        assert_eq!(found.rho_max, Some(found.gap_max_mm.unwrap() / seen.reach_mm.unwrap()));
    }
}
