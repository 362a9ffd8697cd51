//! How far apart the largest and the least of many random numbers lie.

/// The quantile of the range of `count` independent standard normal numbers: with probability `share` the largest less the least is at
/// most this.
///
/// P(range ≤ r) = n·∫ φ(x)·(Φ(x + r) - Φ(x))ⁿ⁻¹ dx, on a grid of 0.005. 0 of fewer than two numbers.
pub fn noise_range(count: usize, share: f64) -> f64 {
    if count < 2 {
        return 0.0;
    }
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let at = |index: usize| STEP * index as f64 - WIDEST;
    // Φ at the places of the grid, summed up by Simpson's rule from below.
    let mut below = vec![0.0; PLACES];
    for index in 1..PLACES {
        let (from, to) = (at(index - 1), at(index));
        let part = density(from) + 4.0 * density(0.5 * (from + to)) + density(to);
        below[index] = below[index - 1] + STEP / 6.0 * part;
    }
    let power = (count - 1) as f64;
    let probability = |steps: usize| -> f64 {
        let within = |index: usize| below[(index + steps).min(PLACES - 1)] - below[index];
        let values = (0..PLACES).map(|index| density(at(index)) * within(index).powf(power));
        count as f64 * STEP * values.sum::<f64>()
    };
    let (mut low, mut high) = (0, PLACES - 1);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if probability(middle) < share { low = middle } else { high = middle }
    }
    let [before, after] = [probability(low), probability(high)];
    STEP * (low as f64 + ((share - before) / (after - before)).clamp(0.0, 1.0))
}

/// The grid: from -9 to 9.
const WIDEST: f64 = 9.0;
const STEP: f64 = 0.005;
const PLACES: usize = 3601;
