//! Times and loop counts of the Point Cloud Graph. Sizes and seeds are fixed and printed.
//!
//! `cargo bench -p asphera-graph --bench graph -- THREADS [POINTS] [ROW…]`; `POINTS` is the larger cloud of the row `growth`,
//! 10,000,000. Rows are `neighbours`, `loops`, `disturbed`, `growth`
//! and `running`; without one all are run. `disturbed` holds loops with noise, uneven density and gaps against those without.
//! `ASPHERA_BENCH_OFF` names OFF meshes as PATH=GENUS,PATH=GENUS that are sampled beside the bodies made here.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it found")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
#![expect(clippy::unwrap_used, reason = "a benchmark ends where something is not as it must be")]

#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/it/bodies.rs"]
mod bodies;

use std::time::Instant;

use asphera_graph::functions::{geodesic, height};
use asphera_graph::{Choices, Cloud, RunningGraph, RunningSettings, extract};
use bodies::{Body, Place, Random, norm};

const POINTS: usize = 100_000;
const DIRECTIONS: usize = 20;
/// Directions of each disturbed cloud.
const FEWER: usize = 10;
/// Points of the conveyor that are meshed, too: a mesh keeps them all.
const MESHED: usize = 10_000_000;
const ROWS: [&str; 5] = ["neighbours", "loops", "disturbed", "growth", "running"];

fn main() {
    let numbers: Vec<usize> =
        std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let threads = numbers.first().copied().unwrap_or(1);
    let many = numbers.get(1).copied().unwrap_or(10_000_000);
    let rows: Vec<String> =
        std::env::args().skip(1).filter(|word| ROWS.contains(&&**word)).collect();
    let is_asked = |row: &str| rows.is_empty() || rows.iter().any(|asked| asked == row);
    println!("{threads} threads, best of 5");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        if is_asked("neighbours") {
            neighbours();
        }
        if is_asked("loops") {
            loops();
        }
        if is_asked("disturbed") {
            disturbed();
        }
        if is_asked("growth") {
            growth(many);
        }
        if is_asked("running") {
            running(many);
        }
    });
}

fn neighbours() {
    let points = Body::row(2).sample(POINTS, &mut Random::new(1));
    let flat = points.iter().flatten().flat_map(|value| value.to_le_bytes());
    if let Some(path) = std::env::var_os("ASPHERA_BENCH_POINTS_OUT") {
        std::fs::write(path, flat.collect::<Vec<u8>>()).unwrap();
    }
    let cloud = Cloud::new(&points).unwrap();
    let all = best(|| Cloud::new(&points).unwrap().nearest(10).unwrap().k());
    println!("  tree and 10 neighbours of {POINTS} points: {:.0} ms", 1e3 * all);
    let graph = best(|| {
        let cloud = Cloud::new(&points).unwrap();
        let field = height(&cloud, [1.0, 0.2, 0.1]).unwrap();
        extract(&cloud, &field, &Choices::default()).unwrap().loops.len()
    });
    println!("  graph by height of {POINTS} points, all included: {:.0} ms", 1e3 * graph);
    let nearest = cloud.nearest(12).unwrap();
    let way = best(|| geodesic(&cloud, &nearest, &[0]).unwrap().values.len());
    println!("  geodesic distances of {POINTS} points, neighbours known: {:.0} ms", 1e3 * way);
}

fn loops() {
    let mut random = Random::new(1);
    let mut clouds: Vec<(String, usize, Vec<Place>)> = Vec::new();
    for entry in std::env::var("ASPHERA_BENCH_OFF").unwrap_or_default().split(',') {
        if let Some((path, genus)) = entry.split_once('=') {
            let points = off_samples(path, &mut random);
            clouds.push((path.to_owned(), genus.parse().unwrap(), points));
        }
    }
    let rows = [1, 2, 5, 9].map(Body::row);
    let plates = [2.0, 1.0, 0.5].map(Body::plate);
    for body in [Body::sphere()].into_iter().chain(rows).chain(plates) {
        clouds.push((body.name.clone(), body.genus, body.sample(POINTS, &mut random)));
    }
    println!(
        "  loops = genus of {POINTS} random points, {DIRECTIONS} directions, defaults; of those stable; the most loops = genus; of those stable"
    );
    let mut sum = [0; 4];
    for (name, genus, points) in &clouds {
        let cloud = Cloud::new(points).unwrap();
        let mut directions = Random::new(7);
        // Right by the height itself, and stable; right by the most loops, and stable.
        let mut right = [0; 4];
        let mut wrong = Vec::new();
        for at in 0..DIRECTIONS {
            let field = height(&cloud, directions.direction()).unwrap();
            let choices = Choices::default();
            let found = extract(&cloud, &field, &choices).unwrap();
            let stability = found.stability(&cloud, &field, &choices).unwrap();
            let most = &stability.most;
            let [own, of_all] = [found.loops.len(), most.loops].map(|loops| loops == *genus);
            let is_right = [own, own && stability.is_stable, of_all, of_all && most.is_stable];
            right.iter_mut().zip(is_right).for_each(|(sum, one)| *sum += usize::from(one));
            if !is_right.iter().all(|one| *one) {
                wrong.push(format!(
                    "{at}: {} loops, {} minor, {:?}, most {most:?}",
                    found.loops.len(),
                    found.minor_loops.len(),
                    stability.trials
                ));
            }
        }
        println!("    {name}, genus {genus}: {right:?}; wrong {wrong:#?}");
        sum.iter_mut().zip(right).for_each(|(sum, one)| *sum += one);
    }
    println!("    of {} in all: {sum:?}", DIRECTIONS * clouds.len());
}

/// Loops by height in the first directions of [`loops`], and the most loops there.
fn counts(points: &[Place]) -> Vec<[usize; 2]> {
    let cloud = Cloud::new(points).unwrap();
    let mut directions = Random::new(7);
    let count = |_| {
        let field = height(&cloud, directions.direction()).unwrap();
        let choices = Choices::default();
        let found = extract(&cloud, &field, &choices).unwrap();
        [found.loops.len(), found.stability(&cloud, &field, &choices).unwrap().most.loops]
    };
    (0..FEWER).map(count).collect()
}

/// Loops of clouds with noise, uneven density and gaps, against those of the same body without.
fn disturbed() {
    println!("  loops unchanged in {FEWER} directions, {POINTS} points");
    // Unchanged and as many as the genus, of the height itself and of the most loops.
    let mut sums: Vec<(String, [[usize; 2]; 2])> = Vec::new();
    // Each with the radius of its smallest hole.
    let rows = [1, 2, 5, 9].map(|genus| (Body::row(genus), 0.6));
    let plates = [2.0, 1.0, 0.5].map(|thickness| (Body::plate(thickness), 0.8));
    let mut all = 0;
    for (body, radius) in rows.into_iter().chain(plates) {
        let points = body.sample(POINTS, &mut Random::new(1));
        let expected = counts(&points);
        all += FEWER;
        for (name, points) in disturbances(&body, radius, &points) {
            let found = counts(&points);
            let right: [[usize; 2]; 2] = std::array::from_fn(|most| {
                let pairs = found.iter().zip(&expected);
                let same = pairs.filter(|(a, b)| a[most] == b[most]).count();
                [same, found.iter().filter(|loops| loops[most] == body.genus).count()]
            });
            println!("    {}, {name}: unchanged and the genus {right:?}", body.name);
            if right.iter().any(|[same, _]| *same < FEWER) {
                println!("        {found:?} of {expected:?}");
            }
            if !sums.iter().any(|(known, _)| *known == name) {
                sums.push((name.clone(), [[0; 2]; 2]));
            }
            for (_, sum) in sums.iter_mut().filter(|(known, _)| *known == name) {
                let right = right.as_flattened();
                sum.as_flattened_mut().iter_mut().zip(right).for_each(|(sum, one)| *sum += one);
            }
        }
    }
    println!("    of {all}: unchanged and the genus, by the height and by the most loops");
    for (name, sum) in &sums {
        println!("    {name}: {sum:?}");
    }
}

fn disturbances(body: &Body, radius: f64, points: &[Place]) -> Vec<(String, Vec<Place>)> {
    let mut random = Random::new(2);
    let mut found = Vec::new();
    for share in [0.02, 0.05, 0.10, 0.15] {
        let mut noisy = |point: &Place| point.map(|mm| mm + radius * share * random.normal());
        let name = format!("noise of {:.0} %", 100.0 * share);
        found.push((name, points.iter().map(&mut noisy).collect()));
    }
    // Ten times as dense at one end along x as at the other.
    let wide = points.iter().map(|[x, ..]| x.abs()).fold(0.0, f64::max);
    let mut uneven = Vec::new();
    while uneven.len() < POINTS {
        let more = body.sample(POINTS, &mut random);
        let stays = |[x, ..]: &Place| random.unit() < 0.55 + 0.45 * x / wide;
        uneven.extend(more.into_iter().filter(stays));
    }
    uneven.truncate(POINTS);
    found.push(("density 1:10".to_owned(), uneven));
    let fewer = points.iter().copied().filter(|_| random.unit() >= 0.3).collect();
    found.push(("30 % cut away at random".to_owned(), fewer));
    // Discs of two spacings each, until 30 % are gone.
    let cloud = Cloud::new(points).unwrap();
    let within = cloud.within(2.0 * cloud.spacing_mm().unwrap()).unwrap();
    let mut is_gone = vec![false; cloud.len()];
    let mut gone = 0;
    while gone < 3 * cloud.len() / 10 {
        let middle = random.below(cloud.len()) as u32;
        for &place in within.neighbours(middle).iter().chain([&middle]) {
            gone += usize::from(!is_gone[place as usize]);
            is_gone[place as usize] = true;
        }
    }
    let places = cloud.places().iter().zip(&is_gone);
    let left = places.filter(|(_, is_gone)| !**is_gone).map(|(place, _)| *place).collect();
    found.push(("30 % cut away in discs of 2 spacings".to_owned(), left));
    found
}

fn growth(many: usize) {
    let time = |count: usize| {
        let points = Body::row(2).sample(count, &mut Random::new(3));
        let begun = Instant::now();
        let cloud = Cloud::new(&points).unwrap();
        let field = height(&cloud, [1.0, 0.2, 0.1]).unwrap();
        let found = extract(&cloud, &field, &Choices::default()).unwrap();
        (begun.elapsed().as_secs_f64(), found.loops.len())
    };
    let few = (0..3).map(|_| time(many / 10).0).fold(f64::INFINITY, f64::min);
    let (all, loops) = time(many);
    println!(
        "  {many} points by height: {all:.2} s, over 10 × {few:.3} s = {:.2}; {loops} loops",
        all / (10.0 * few)
    );
}

/// Profiles of 1,000 points over parts of 20 mm, 30 mm apart, on a conveyor that never ends.
fn running(many: usize) {
    const PROFILE: usize = 1000;
    let settings = RunningSettings {
        axis: 1,
        is_reversed: false,
        tau_mm: 0.6,
        strip_mm: 0.9,
        keeps_points: false,
    };
    let mut graph = RunningGraph::new(settings).unwrap();
    // The mesh of the first of these points, as a station makes it beside the graph.
    let mut mesh = Some(asphera_mesh::Mesh::new());
    let (mut meshing, mut beside) = (0.0, 0.0);
    let (mut parts, mut most, mut spent) = (0, 0, 0.0);
    let mut resident_mb = [0.0; 2];
    let mut profile: Vec<Place> = Vec::with_capacity(PROFILE);
    let rows = many / PROFILE;
    for row in 0..rows {
        let y = 0.1 * row as f64;
        profile.clear();
        profile.extend((0..PROFILE).map(|at| {
            let x = 0.1 * at as f64;
            [x + 10.0 * (x / 20.0).floor(), y + 10.0 * (y / 20.0).floor(), (0.3 * x).sin()]
        }));
        let begun = Instant::now();
        graph.take(&profile).unwrap();
        spent += begun.elapsed().as_secs_f64();
        if row * PROFILE == MESHED {
            mesh = None;
        }
        if let Some(mesh) = &mut mesh {
            let begun = Instant::now();
            mesh.insert(&profile);
            meshing += begun.elapsed().as_secs_f64();
            beside = spent;
        }
        if row == rows / 10 || row + 1 == rows {
            resident_mb = [resident_mb[1], resident()];
        }
        graph.take_closed();
        graph.take_events();
        parts += graph.take_ended().len();
        most = most.max(graph.waiting());
    }
    let begun = Instant::now();
    graph.finish();
    spent += begun.elapsed().as_secs_f64();
    parts += graph.take_ended().len();
    let meshed = many.min(MESHED);
    println!(
        "  running graph of {many} points of a conveyor: {:.0} ns a point, {parts} parts, at most {most} points wait",
        1e9 * spent / many as f64
    );
    println!(
        "    of the first {meshed}: mesh {:.0} ns a point, ratio {:.2}",
        1e9 * meshing / meshed as f64,
        beside / meshing
    );
    if many > MESHED {
        let [early, late] = resident_mb;
        println!("    memory of the process: {early:.1} MB after a tenth, {late:.1} MB at the end");
    }
}

/// Memory of this process, MB; 0 where the system does not say.
fn resident() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kb = line.and_then(|line| line.trim().strip_suffix(" kB")).and_then(|kb| kb.parse().ok());
    kb.map_or(0.0, |kb: f64| kb * 1.024e-3)
}

fn best(work: impl Fn() -> usize) -> f64 {
    let run = |_| {
        let begun = Instant::now();
        std::hint::black_box(work());
        begun.elapsed().as_secs_f64()
    };
    (0..5).map(run).fold(f64::INFINITY, f64::min)
}

/// Points at random, evenly on the triangles of an OFF file.
fn off_samples(path: &str, random: &mut Random) -> Vec<Place> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut numbers = text.split_whitespace().skip(1).map(|word| word.parse::<f64>().unwrap());
    let mut number = || numbers.next().unwrap();
    let (vertices, faces) = (number() as usize, number() as usize);
    number();
    let corners: Vec<Place> = (0..vertices).map(|_| [number(), number(), number()]).collect();
    let mut sides = Vec::new();
    let mut ends = Vec::new();
    let mut sum = 0.0;
    for _ in 0..faces {
        assert_eq!(number(), 3.0, "triangles only");
        let [a, b, c] = [number(), number(), number()].map(|index| corners[index as usize]);
        let [u, v]: [Place; 2] = [b, c].map(|to| std::array::from_fn(|axis| to[axis] - a[axis]));
        let turned = |i: usize| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
        sum += norm([turned(0), turned(1), turned(2)]);
        sides.push((a, u, v));
        ends.push(sum);
    }
    let draw = |_| {
        let at = sum * random.unit();
        let (a, u, v) = sides[ends.partition_point(|end| *end <= at).min(faces - 1)];
        let (mut s, mut t) = (random.unit(), random.unit());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        std::array::from_fn(|axis| a[axis] + s * u[axis] + t * v[axis])
    };
    (0..POINTS).map(draw).collect()
}
