//! What the report of the sampling costs, against the mesh it is made of.
//!
//! `cargo bench -p asphera --bench report` meshes 1,044,336 points of a spiral, once as they arrive from an
//! instrument, by batches of 1,024, and once as from a file, by large batches that threads share. Then it says all
//! that a report says of their sampling and of its defects, and prints the medians of the times and their ratios.
//! `ASPHERA_BENCH_POINTS` sets another number of points, `RAYON_NUM_THREADS` the threads. What depends on the
//! nominal alone is made once a part, long before its last point, and printed by itself.

use std::f64::consts::TAU;

use asphera::clock::Clock;
use asphera_form::{Pose, deviations};
use asphera_geometry::PointMm;
use asphera_measure::Part;
use asphera_measure::{Remembered, features_of_mesh, sampling_of_mesh};
use asphera_mesh::Mesh;
use asphera_surface::Plane;

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let count = std::env::var("ASPHERA_BENCH_POINTS").map_or(1_044_336, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    });
    let threads = rayon::current_num_threads();
    println!(
        "{count} points of a spiral, {PITCH_MM} mm apart, on a sphere R {RADIUS_MM} mm, 30 nm noise, {threads} threads"
    );
    let rim_mm = PITCH_MM * (count as f64 / (TAU / 2.0)).sqrt();
    for (name, keep) in [
        ("all covered", Keep { share: 1.0 }),
        ("a stripe at a tenth of the density", Keep { share: 0.1 }),
    ] {
        let points: Vec<PointMm> =
            spiral(count).filter(|point| keep.keeps(point, rim_mm)).collect();
        let part = part(0.95 * rim_mm);
        let mut remembered = Remembered::default();
        let mut times: Vec<[f64; 4]> = Vec::new();
        for round in 0..=ROUNDS {
            let clock = Clock::start();
            let mut mesh = Mesh::new();
            points.iter().for_each(|&point| mesh.push(point));
            mesh.flush();
            let arriving = clock.now();
            drop(mesh);
            let clock = Clock::start();
            let mut mesh = Mesh::new();
            mesh.extend(points.iter().copied());
            mesh.flush();
            let meshed = clock.now();
            let figures =
                sampling_of_mesh(&mesh, &part, &Pose::default(), &Plane::XY, &mut remembered);
            let done = clock.now();
            let deviations_mm = deviations(mesh.points(), &part.nominal, &Pose::default());
            let begun = clock.now();
            let features = features_of_mesh(
                &mesh,
                &part,
                &deviations_mm,
                (&Plane::XY, &Pose::default()),
                &figures,
            );
            let searched_s = clock.now().since(begun).as_secs_f64();
            let report_s = done.since(meshed).as_secs_f64();
            let time = [arriving.as_secs_f64(), meshed.as_secs_f64(), report_s, searched_s];
            if round > 0 {
                times.push(time);
                continue;
            }
            println!("{name}: {} points, coverage {:?}", points.len(), figures.coverage);
            println!("  defects {:?}", features.defects.as_ref().map(Vec::len));
            println!(
                "  first report, with the nominal's local feature size: {:.1} ms",
                1e3 * time[2]
            );
        }
        let [arriving_s, mesh_s, report_s, defects_s] = [0, 1, 2, 3].map(|which| {
            let mut of: Vec<f64> = times.iter().map(|time| time[which]).collect();
            of.sort_by(f64::total_cmp);
            of[of.len() / 2]
        });
        for (what, seconds) in [
            ("mesh as points arrive", arriving_s),
            ("mesh by large batches", mesh_s),
            ("report", report_s),
            ("triangles listed, defects and partition", defects_s),
        ] {
            println!(
                "  {what}: {:.1} ms ({:.0} ns a point), of the meshes {:.2} and {:.2}",
                1e3 * seconds,
                1e9 * seconds / points.len() as f64,
                seconds / arriving_s,
                seconds / mesh_s
            );
        }
    }
}

/// Which points of a stripe along y are kept: a share of them.
struct Keep {
    share: f64,
}

impl Keep {
    fn keeps(&self, &[x, _, z]: &PointMm, rim_mm: f64) -> bool {
        // The last digits of the noise are as good as a draw.
        let draw = (1e9 * z).fract().abs();
        !(0.2..0.3).contains(&(x / rim_mm)) || draw < self.share
    }
}

/// Points along an Archimedean spiral from the centre, one pitch apart along it and across.
fn spiral(count: usize) -> impl Iterator<Item = PointMm> {
    let mut state = 42_u64;
    (0..count).map(move |i| {
        // The arc up to the angle t is about pitch·t²/(2·2π) long.
        let turn = (2.0 * TAU * i as f64).sqrt();
        let radius = PITCH_MM * turn / TAU;
        let (x, y) = (radius * turn.cos(), radius * turn.sin());
        let noise = (0..4).map(|_| unit(&mut state) - 0.5).sum::<f64>() * (12.0_f64 / 4.0).sqrt();
        let squared = x * x + y * y;
        let sag = squared / (RADIUS_MM + (RADIUS_MM * RADIUS_MM - squared).sqrt());
        [x, y, sag + SIGMA_MM * noise]
    })
}

/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), from 0 to below 1.
fn unit(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut draw = *state;
    draw = (draw ^ (draw >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    draw = (draw ^ (draw >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (((draw ^ (draw >> 31)) >> 11) as f64) / (1_u64 << 53) as f64
}

fn part(aperture_mm: f64) -> Part {
    let text = format!(
        "[surface]\nkind = \"asphere\"\nradius_mm = {RADIUS_MM}\n\
         [aperture]\nshape = \"circle\"\nradius_mm = {aperture_mm}\n\
         [sampling]\ngap_limit_mm = {}\n",
        1.5 * PITCH_MM
    );
    asphera_nominal::parse("part.toml", &text).expect("the part is sound")
}

const PITCH_MM: f64 = 0.01;
const RADIUS_MM: f64 = 20.0;
const SIGMA_MM: f64 = 30e-6;
const ROUNDS: usize = 7;
