//! The pose of an asphere from a million points, here and by SciPy's `least_squares(method="lm")` on the same
//! residual function, vectorised in NumPy.
//!
//! `ASPHERA_PYTHON` names a Python with numpy and scipy; without it nothing is compared. Both sides fit the same
//! points by the same orthogonal distances from the same start to convergence; reading and writing the points
//! is not counted.

use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use asphera_form::{FitSettings, PointMm, Pose, fit};
use part::nominal;

mod part;

const COUNT: usize = 1_000_000;
/// Runs here, of which the median counts.
const RUNS: usize = 5;

#[expect(clippy::print_stdout, reason = "the ratio is what this is for")]
#[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
fn main() {
    let Some(python) = std::env::var_os("ASPHERA_PYTHON") else {
        println!("skipped: ASPHERA_PYTHON is not set");
        return;
    };
    let points = part::points(COUNT, |_, _| 0.0);
    let mut runs: Vec<(Duration, Pose)> = (0..RUNS)
        .map(|_| {
            let begin = Instant::now();
            let fitted = fit(&points, &nominal(), &FitSettings::default()).expect("a fit");
            (begin.elapsed(), fitted.pose)
        })
        .collect();
    runs.sort_by_key(|(elapsed, _)| *elapsed);
    let (ours, pose) = runs[RUNS / 2];
    let Some((theirs_s, found)) = scipy(&python, &points) else {
        println!("skipped: no Python with numpy and scipy at ASPHERA_PYTHON");
        return;
    };
    let ours_s = ours.as_secs_f64();
    let here = [pose.tx_mm, pose.ty_mm, pose.tz_mm, pose.rx_rad, pose.ry_rad];
    let apart = here.iter().zip(&found).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    println!(
        "pose of an asphere, {COUNT} points: {ours_s:.3} s here, {theirs_s:.3} s by SciPy, ratio {:.1}; poses {apart:.1e} mm or rad apart",
        theirs_s / ours_s
    );
}

/// Seconds and tx, ty, tz, rx, ry.
fn scipy(python: &std::ffi::OsStr, points: &[PointMm]) -> Option<(f64, Vec<f64>)> {
    let mut child = Command::new(python)
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .ok()?;
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    child.stdin.take()?.write_all(&bytes).ok()?;
    let mut text = String::new();
    child.stdout.take()?.read_to_string(&mut text).ok()?;
    if !child.wait().ok()?.success() {
        return None;
    }
    let mut numbers = text.split_whitespace().map(|number| number.parse::<f64>().ok());
    Some((numbers.next()??, numbers.collect::<Option<Vec<f64>>>()?))
}

/// The distance by Newton's method on the meridian, all points at once, as many steps as the slowest needs.
const SCRIPT: &str = r#"
import sys, time
import numpy as np
from scipy.optimize import least_squares
points = np.frombuffer(sys.stdin.buffer.read(), dtype="<f8").reshape(-1, 3)
c, k = 1 / 11.65, -1.1
A = [3.69067205091e-5, -1.285461192617e-8, -1.400167659754e-10, -2.51311664812e-13,
     5.01789877647e-16, 5.855871513042e-18, -1.127794407419e-20]
def profile(s):
    u = s * s
    phi = np.sqrt(1 - (1 + k) * c * c * u)
    p = np.zeros_like(u); p1 = np.zeros_like(u); p2 = np.zeros_like(u)
    for a in reversed(A):
        p2 = p2 * u + p1
        p1 = p1 * u + p
        p = p * u + a
    first = u * (2 * p + u * p1)
    second = 2 * p + u * (4 * p1 + u * 2 * p2)
    return (c * u / (1 + phi) + u * u * p, c * s / phi + 2 * s * first,
            c / phi**3 + 2 * first + 4 * u * second)
def residuals(x):
    tx, ty, tz, rx, ry = x
    sx, cx, sy, cy = np.sin(rx), np.cos(rx), np.sin(ry), np.cos(ry)
    R = np.array([[cy, sy * sx, sy * cx], [0, cx, -sx], [-sy, cy * sx, cy * cx]])
    q = (points - [tx, ty, tz]) @ R
    rho, zeta = np.hypot(q[:, 0], q[:, 1]), q[:, 2]
    s = rho.copy()
    for _ in range(50):
        z, slope, second = profile(s)
        above = z - zeta
        step = ((s - rho) + above * slope) / (1 + slope * slope + above * second)
        s -= step
        if np.max(np.abs(step)) < 1e-14:
            break
    z, slope, _ = profile(s)
    return (slope * (s - rho) - (z - zeta)) / np.sqrt(1 + slope * slope)
residuals(np.zeros(5))
begin = time.perf_counter()
found = least_squares(residuals, np.zeros(5), method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12)
print(time.perf_counter() - begin, *found.x)
"#;
