//! Samples a second of the histogram, the Euler number, marching cubes and its parts. Sizes and seeds are printed.
//!
//! Rates are by CPU time of all threads where the system tells it, and by the clock. `peers.py` gives those of other programs.
//!
//! Run with `cargo bench -p asphera-volume --bench volumes -- SIDE THREADS`.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it found")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
#![expect(clippy::unwrap_used, reason = "a benchmark ends where something is not as it must be")]

use std::time::Instant;

use asphera_volume::{
    Ambiguity, Grey, Histogram, Middles, Samples, euler_6, euler_26, marching_cubes,
    trilinear_surface,
};

fn main() {
    let numbers: Vec<usize> =
        std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let side = numbers.first().copied().unwrap_or(256);
    let threads = numbers.get(1).copied().unwrap_or(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    // A gyroid of 8 periods: much surface, no randomness.
    let wave = 16.0 * std::f64::consts::PI / side as f64;
    let bytes: Vec<u8> = (0..side * side * side)
        .map(|index| {
            let [x, y, z] =
                [index % side, index / side % side, index / side / side].map(|at| at as f64 * wave);
            let value = x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
            if value > 0.9 { 200 } else { 10 }
        })
        .collect();
    println!("gyroid, {side}³ bytes, {threads} threads, best of 5, samples a second");
    pool.install(|| {
        let size = [side; 3];
        let samples = Samples::from_bytes(size, &bytes, 100).unwrap();
        let histogram = Histogram::new(&samples);
        println!("  {} mixed cells, {} foreground", histogram.mixed(), samples.foreground());
        rate("threshold", bytes.len(), || {
            Samples::from_bytes(size, &bytes, 100).unwrap().foreground()
        });
        rate("threshold and histogram", bytes.len(), || {
            Histogram::new(&Samples::from_bytes(size, &bytes, 100).unwrap()).mixed()
        });
        rate("threshold and Euler numbers", bytes.len(), || {
            let histogram = Histogram::new(&Samples::from_bytes(size, &bytes, 100).unwrap());
            (euler_6(&histogram) + euler_26(&histogram)).unsigned_abs()
        });
        rate("threshold and marching cubes", bytes.len(), || {
            let samples = Samples::from_bytes(size, &bytes, 100).unwrap();
            marching_cubes(&samples, Ambiguity::Paired, &Middles).triangles.len() as u64
        });
        let values: Vec<f32> = bytes.iter().copied().map(f32::from).collect();
        let grey = Grey { values: &values, size, threshold: 100.0 };
        rate("trilinear of grey values", bytes.len(), || {
            trilinear_surface(&samples, &grey).triangles.len() as u64
        });
    });
}

fn rate(name: &str, samples: usize, work: impl Fn() -> u64) {
    let (mut best, mut least) = (f64::INFINITY, f64::INFINITY);
    let mut figure = 0;
    for _ in 0..5 {
        let (start, busy) = (Instant::now(), cpu_seconds());
        figure = work();
        best = best.min(start.elapsed().as_secs_f64());
        if let (Some(before), Some(after)) = (busy, cpu_seconds()) {
            least = least.min(after - before);
        }
    }
    let per_second = |seconds: f64| samples as f64 / seconds / 1e6;
    println!(
        "  {name}: {:.0} M/s by CPU, {:.0} M/s by the clock ({figure})",
        per_second(least),
        per_second(best)
    );
}

/// Seconds that the threads of this process have run; Linux tells them.
fn cpu_seconds() -> Option<f64> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let mut nanoseconds = 0.0;
    for task in tasks {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        nanoseconds += text.split_whitespace().next()?.parse::<f64>().ok()?;
    }
    Some(nanoseconds / 1e9)
}
