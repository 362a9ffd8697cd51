//! Surfaces end at missing samples: on balls whose zones are known, and with every method.

use std::f64::consts::PI;

use asphera_volume::{
    Ambiguity, BALL_RADIUS, Blend, Gaps, Grey, Majority, Method, Middles, Samples, Surface,
    VolumeBounds, blurred_area, open_area, reconstruct, trilinear_surface, with_missing,
};

use crate::noise::Random;

const SIDE: usize = 51;

/// A ball and its distances, with samples missing where a rule says so.
struct Scanned {
    samples: Samples,
    missing: Samples,
    values: Vec<f32>,
}

impl Scanned {
    fn ball(radius: f64, is_missing: impl Fn([f64; 3]) -> bool) -> Scanned {
        let place =
            |at: usize| [at % SIDE, at / SIDE % SIDE, at / SIDE / SIDE].map(|at| at as f64 - 25.0);
        let height = |at: usize| radius - place(at).iter().map(|x| x * x).sum::<f64>().sqrt();
        let all = 0..SIDE.pow(3);
        let lacks: Vec<bool> = all.clone().map(|at| is_missing(place(at))).collect();
        let values = all.map(|at| if lacks[at] { f32::NAN } else { height(at) as f32 });
        let values: Vec<f32> = values.collect();
        let inside: Vec<bool> = values.iter().map(|value| *value >= 0.0).collect();
        Scanned {
            samples: Samples::from_bools([SIDE; 3], &inside).unwrap(),
            missing: Samples::from_bools([SIDE; 3], &lacks).unwrap(),
            values,
        }
    }

    fn grey(&self) -> Grey<'_> {
        Grey { values: &self.values, size: [SIDE; 3], threshold: 0.0 }
    }

    fn surface(&self, method: &Method) -> Surface {
        reconstruct(&self.samples, method, &self.grey())
            .unwrap()
            .without_gaps(self.missing.size(), Gaps::missing(&self.missing))
    }
}

/// All methods.
pub(crate) const METHODS: [Method; 7] = [
    Method::Marching(Ambiguity::Paired),
    Method::Majority(Majority::Foreground),
    Method::Majority(Majority::Complement),
    Method::Balls { radius: BALL_RADIUS, refine: 2 },
    Method::Trilinear { refine: 2 },
    Method::Smooth { blend: Blend::Infinite, refine: 2 },
    Method::Voxels,
];

/// Two slices without values: caps above and below, each with one border. Their area is Archimedes', 2πR·height.
#[test]
fn a_gap_of_slices_cuts_a_ball_into_two_caps() {
    let scan = Scanned::ball(20.3, |[_, _, z]| z == 4.0 || z == 5.0);
    for method in &METHODS {
        let found = scan.surface(method).figures();
        assert!(!found.is_closed && found.is_oriented, "{method:?}");
        assert_eq!((found.volume, found.borders), (None, 2), "{method:?}");
        // A cap is a disc.
        let euler: Vec<i64> = found.pieces.iter().map(|piece| piece.euler).collect();
        assert_eq!((euler, found.euler()), (vec![1, 1], 2), "{method:?}");
        assert!(found.pieces.iter().all(|piece| piece.genus.is_none() && piece.volume.is_none()));
    }
    let grey = trilinear_surface(&scan.samples, &scan.grey())
        .without_gaps(scan.missing.size(), Gaps::missing(&scan.missing));
    assert_eq!((grey.figures().borders, grey.euler()), (2, 2));
    // Surface is left below slice 3 and above slice 6.
    let truth = 2.0 * PI * 20.3 * (2.0 * 20.3 - 3.0);
    assert!((grey.figures().area / truth - 1.0).abs() < 0.002, "{} {truth}", grey.figures().area);
    let by_marching = scan.surface(&METHODS[0]).area();
    assert!((by_marching / truth - 1.0).abs() < 0.002, "{by_marching} {truth}");
}

/// A sample amid the material and one far outside end no surface; one on the surface opens it.
#[test]
fn samples_away_from_the_surface_leave_it_closed() {
    let of = |gap: [f64; 3]| {
        let found = Scanned::ball(10.0, |at| at == gap);
        let open = found.surface(&METHODS[0]);
        (open.figures(), marching(&found.samples))
    };
    // Background amid the material is a cavity of its own, which is no surface of the part.
    let (found, closed) = of([1.0, 0.0, 0.0]);
    assert_eq!((found.is_closed, found.pieces.len(), closed.pieces().len()), (true, 1, 2));
    let (found, closed) = of([20.0, 0.0, 0.0]);
    assert_eq!((found.is_closed, found.triangles), (true, closed.triangles.len() as u64));
    let (found, _) = of([10.0, 0.0, 0.0]);
    assert_eq!((found.is_closed, found.borders, found.euler()), (false, 1, 1));
}

fn marching(samples: &Samples) -> Surface {
    reconstruct(samples, &METHODS[0], &Middles).unwrap()
}

/// Nothing missing changes nothing; all missing leaves nothing.
#[test]
fn none_and_all_missing() {
    let samples = Random::new(3).volume([12, 9, 7], 0.4);
    let none = Samples::background([12, 9, 7]).unwrap();
    let surface = marching(&samples);
    assert_eq!(surface.clone().without_gaps(none.size(), Gaps::missing(&none)), surface);
    assert_eq!(open_area(&samples, Gaps::missing(&none)), blurred_area(&samples));
    let all = none.complement();
    assert_eq!(surface.without_gaps(all.size(), Gaps::missing(&all)), Surface::default());
    assert_eq!(with_missing(&none, &all), all);
    let bounds = VolumeBounds::with_missing(&none, Some(&all), None);
    assert!(bounds.low == 0.0 && bounds.high >= 12.0 * 9.0 * 7.0, "{bounds:?}");
}

/// Slices, a wedge and single samples missing from a ball of binary samples: the area that is left is known, by Archimedes or by
/// the share of the wedge.
#[test]
fn the_area_beside_gaps_is_that_of_the_zones() {
    let radius = 20.3;
    let all = 4.0 * PI * radius * radius;
    let slices = Scanned::ball(radius, |[_, _, z]| (4.0..=9.0).contains(&z));
    let wedge = Scanned::ball(radius, |[x, y, _]| x > 0.0 && y > 0.0);
    // The cells beside the wedge are no surface either: it begins at the planes x = 0 and y = 0.
    for (scan, truth, name) in [
        (&slices, 2.0 * PI * radius * (2.0 * radius - 7.0), "slices"),
        (&wedge, 0.75 * all, "wedge"),
    ] {
        let found = open_area(&scan.samples, Gaps::missing(&scan.missing));
        let error = found.area / truth - 1.0;
        assert!(error.abs() < 0.01, "{name}: {error} {found:?}");
        assert!((found.area - truth).abs() < 2.0 * found.u, "{name}: {found:?} {truth}");
        // With background in the gap, walls of it count as surface.
        assert!(blurred_area(&scan.samples).area / truth - 1.0 > 0.05, "{name}");
    }
}

/// Certain bounds hold whatever the missing samples hide: a slab through the middle, and a corner of the background.
#[test]
fn bounds_hold_what_missing_samples_hide() {
    let radius = 15.2;
    let truth = 4.0 / 3.0 * PI * f64::powi(radius, 3);
    for is_missing in
        [|[_, _, z]: [f64; 3]| z.abs() < 2.0, |[x, y, z]: [f64; 3]| x + y + z > 20.0, |_| false]
    {
        let scan = Scanned::ball(radius, is_missing);
        for regular in [None, Some(radius)] {
            let found = VolumeBounds::with_missing(&scan.samples, Some(&scan.missing), regular);
            assert!(found.low < truth && truth < found.high, "{found:?} {truth}");
            let plain = VolumeBounds::new(&scan.samples, regular);
            assert!(found.low <= plain.low + 1e-9 && found.high >= plain.high - 1e-9);
        }
    }
}
