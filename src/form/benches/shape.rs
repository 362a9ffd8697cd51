//! Height, slopes and bend of shapes at random places. The number of places is the argument, the seed fixed.

use std::sync::Arc;

use asphera_form::shape::{
    Biconic, Conic, ConicSection, EvenAsphere, Mirror, OffAxis, Projection, QAsphere, Shape, Toroid,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SEED: u64 = 2012;
const RADIUS_MM: f64 = 9.0;
const PLACES: usize = 10_000;

#[expect(clippy::print_stderr, reason = "whoever reads the rates must see what they are for")]
fn main() {
    eprintln!("{PLACES} places over a disc of {RADIUS_MM} mm, seed {SEED}");
    divan::main();
}

fn places() -> Vec<[f64; 2]> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let place = |_| {
        let (r, phi) = (RADIUS_MM * uniform().sqrt(), std::f64::consts::TAU * uniform());
        [r * phi.cos(), r * phi.sin()]
    };
    (0..PLACES).map(place).collect()
}

/// The shapes by name.
fn shape(name: &str) -> Arc<dyn Shape> {
    let base = ConicSection::new(17.3729, -0.676).expect("a valid base");
    let q = [-0.8148370167576, -0.32311, 0.10591, -0.05058, 0.00987, -0.0022];
    let even = EvenAsphere::new(base, &[(4, 1e-5), (6, 1e-8), (8, 1e-10), (16, 1e-20)]);
    let even = Arc::new(even.expect("a valid prescription"));
    match name {
        "conic" => Arc::new(Conic::new(base)),
        "even asphere to r^16" => even,
        "Q-bfs, 6 terms" => Arc::new(
            QAsphere::bfs(base, 27.0, Projection::ConicNormal, &q).expect("a valid prescription"),
        ),
        "Q-con, 6 terms" => Arc::new(QAsphere::con(base, 27.0, &q).expect("a valid prescription")),
        "biconic" => {
            let other = ConicSection::new(-30.0, 0.5).expect("a valid section");
            Arc::new(Biconic::new(base, other))
        }
        "toroid" => Arc::new(Toroid::new(80.0, base, &[(4, 1e-6)]).expect("a valid toroid")),
        "ellipsoid" => Arc::new(Mirror::revolved(3e4, 500.0, 0.02).expect("a valid mirror")),
        _ => Arc::new(OffAxis::tilted(even, 3.0, 2.0).expect("a valid section")),
    }
}

const NAMES: [&str; 8] = [
    "conic",
    "even asphere to r^16",
    "Q-bfs, 6 terms",
    "Q-con, 6 terms",
    "biconic",
    "toroid",
    "ellipsoid",
    "off-axis even asphere",
];

#[divan::bench(args = NAMES)]
fn jet(bencher: Bencher, name: &str) {
    let (shape, places) = (shape(name), places());
    bencher.counter(ItemsCount::new(PLACES)).bench(|| {
        places.iter().filter_map(|&[x, y]| shape.jet(x, y)).fold(0.0, |sum, jet| sum + jet.z_mm)
    });
}

#[divan::bench(args = NAMES)]
fn sag(bencher: Bencher, name: &str) {
    let (shape, places) = (shape(name), places());
    bencher
        .counter(ItemsCount::new(PLACES))
        .bench(|| places.iter().filter_map(|&[x, y]| shape.sag_mm(x, y)).sum::<f64>());
}
