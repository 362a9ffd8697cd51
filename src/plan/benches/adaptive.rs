//! The study of five parts, and an asphere as most are: uniform against adaptive scans to the same ε, coverage and uncertainty.
//!
//! `cargo bench -p asphera-plan --bench adaptive` prints the table of docs/plan.md, with the seeds.

#![expect(clippy::print_stdout, reason = "a benchmark prints")]
#![expect(clippy::unwrap_used, reason = "a study ends where something is not as it must be")]

#[path = "../tests/study/mod.rs"]
#[expect(unreachable_pub, reason = "shared with a test")]
mod study;

use study::{Compared, Scanned};

fn main() {
    for part in study::all() {
        let Compared { planned, hindsight, adaptive } = study::compare(&part);
        println!("{}, seed {}, noise {} nm", part.name, part.seed, part.noise_nm);
        show("planned", &planned, &adaptive);
        show("hindsight", &hindsight, &adaptive);
        show("adaptive", &adaptive, &adaptive);
    }
}

/// A line of the table; shares are against the adaptive scan.
fn show(name: &str, scan: &Scanned, adaptive: &Scanned) {
    let number =
        |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.4}"));
    println!(
        "  {name:10} {:6} points {:5.2}×  lines {:7.1} s {:5.2}×  stops {:7.1} s {:5.2}×  looks {}  coverage {}  ε p99 {}  u {} nm  {:?} {}",
        scan.points,
        scan.points as f64 / adaptive.points as f64,
        scan.time_s,
        scan.time_s / adaptive.time_s,
        scan.stopping_s,
        scan.stopping_s / adaptive.stopping_s,
        scan.looks,
        number(scan.findings.coverage),
        number(scan.findings.epsilon_p99),
        number(scan.findings.u_nm),
        scan.findings.verdict,
        scan.ending.map_or_else(String::new, |ending| format!("{ending:?}")),
    );
}
