//! Memory of our mesh: the peak of a process that meshes, less that of one that only generates.
//!
//! Each is a child process of its own, so that what was measured before leaves no trace. A scan is
//! generated batch by batch in both and stored in neither. The peak is the line `VmHWM` of
//! `/proc/self/status` (proc_pid_status(5)), which begins anew with each program, unlike the peak
//! of getrusage(2), which a child inherits. Elsewhere than on Linux there is no figure.

use std::fs;
use std::hint::black_box;
use std::num::NonZeroUsize;
use std::process::{Command, ExitCode, Stdio};

use asphera_mesh::Mesh;
use clap::ValueEnum;

use crate::orders::Scan;

/// Work of a child process before it says its peak.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Peak {
    /// Generates the points and meshes them.
    Mesh,
    /// Generates the points.
    Generate,
}

/// Bytes of memory our mesh takes for each point of a scan, at its peak; `None` where the system
/// does not say.
pub(crate) fn bytes_per_point(scan: Scan, batch: NonZeroUsize) -> Option<f64> {
    let with = peak_bytes(Peak::Mesh, scan, batch)?;
    let without = peak_bytes(Peak::Generate, scan, batch)?;
    Some((with - without) / scan.count as f64)
}

fn peak_bytes(peak: Peak, scan: Scan, batch: NonZeroUsize) -> Option<f64> {
    // Without the file no child needs to be asked.
    vm_hwm_bytes()?;
    let program = std::env::current_exe().expect("a process on Linux finds its own program");
    let work = peak.to_possible_value().expect("no work is hidden from the options");
    let output = Command::new(program)
        .args(["--peak", work.get_name(), "--order", &scan.order.name()])
        .args(["--points", &scan.count.to_string(), "--seed", &scan.seed.to_string()])
        .args(["--batch", &batch.to_string()])
        .stderr(Stdio::inherit())
        .output()
        .expect("the program that runs can be started once more");
    assert!(output.status.success(), "the child that measures memory ended: {}", output.status);
    let answer = String::from_utf8_lossy(&output.stdout);
    Some(answer.trim().parse().expect("the child prints a number of bytes"))
}

/// Does the work of a child process and prints its peak in bytes.
pub(crate) fn child(peak: Peak, scan: Scan, batch: NonZeroUsize) -> ExitCode {
    let mut mesh = Mesh::new();
    scan.for_each_batch(batch.get(), |points| match peak {
        Peak::Mesh => mesh.insert(points),
        Peak::Generate => {
            black_box(points);
        }
    });
    let Some(bytes) = vm_hwm_bytes() else { return ExitCode::FAILURE };
    black_box(mesh.counts());
    print_bytes(bytes);
    ExitCode::SUCCESS
}

#[expect(clippy::print_stdout, reason = "the parent process reads it")]
fn print_bytes(bytes: u64) {
    println!("{bytes}");
}

/// The most memory this process ever had resident.
pub(crate) fn vm_hwm_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
