//! What is formed along a profile: its sampling, the slopes of its deviation, and how that bends.

use asphera_figures::SlopeSettings;
use asphera_geometry::{PointMm, VertexId};
use asphera_surface::noise::{HeightSteps, height_steps};

/// One point of a profile, in the order of `s_mm`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    /// Position along the line, mm.
    pub(super) s_mm: f64,
    /// Deviation, mm; NaN where the point does not count.
    pub(super) deviation_mm: f64,
    /// Measured slope less that of the nominal, where slopes were measured.
    pub(super) slope: Option<f64>,
}

/// How densely points lie along the part of a line that counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Coverage {
    /// Length of the line in the aperture, mm.
    pub(super) length_mm: f64,
    /// Length of it that is sampled densely enough, mm.
    pub(super) covered_mm: f64,
    /// Largest distance of a place to its nearest point, mm.
    pub(super) gap_max_mm: f64,
    /// The same of what is sampled densely enough.
    pub(super) gap_covered_mm: f64,
    /// Largest share of a gap in the bound of the local feature size.
    pub(super) epsilon_max: f64,
}

/// The coverage of `pieces` of s by points at ascending `s_mm`. A piece between two points is sampled densely enough if half
/// its length is no more than `limit_mm` at its middle; beyond the outermost points half of `spacing_mm` is.
pub(super) fn coverage(
    pieces: &[[f64; 2]],
    s_mm: &[f64],
    spacing_mm: f64,
    limits: impl Fn(f64) -> (f64, f64),
) -> Coverage {
    let mut found = Coverage::default();
    let (Some(&first), Some(&last)) = (s_mm.first(), s_mm.last()) else { return found };
    let mut take = |from: f64, to: f64, gap_mm: f64, dense: bool| {
        for [low, high] in pieces {
            let length_mm = (to.min(*high) - from.max(*low)).max(0.0);
            if length_mm > 0.0 {
                found.gap_max_mm = found.gap_max_mm.max(gap_mm);
                if dense {
                    found.covered_mm += length_mm;
                    found.gap_covered_mm = found.gap_covered_mm.max(gap_mm);
                }
                found.epsilon_max = found.epsilon_max.max(gap_mm / limits(0.5 * (from + to)).1);
            }
        }
    };
    for pair in s_mm.windows(2) {
        let gap_mm = 0.5 * (pair[1] - pair[0]);
        take(pair[0], pair[1], gap_mm, gap_mm <= limits(0.5 * (pair[0] + pair[1])).0);
    }
    let [low, high] = [
        pieces.first().map_or(first, |piece| piece[0]),
        pieces.last().map_or(last, |piece| piece[1]),
    ];
    let rim_mm = 0.5 * spacing_mm;
    take((first - rim_mm).max(low), first, rim_mm.min((first - low).max(0.0)), true);
    take(last, (last + rim_mm).min(high), rim_mm.min((high - last).max(0.0)), true);
    take(low, first - rim_mm, first - low, false);
    take(last + rim_mm, high, high - last, false);
    found.length_mm = pieces.iter().map(|[low, high]| high - low).sum();
    found
}

/// The median distance of neighbours, mm.
pub(super) fn median_spacing_mm(s_mm: &[f64]) -> f64 {
    let mut steps: Vec<f64> = s_mm.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Slopes of the deviation, each with the length it stands for in mm: those measured, or else of the line between neighbours.
pub(super) fn slopes(stations: &[Station]) -> Vec<(f64, f64)> {
    if stations.iter().all(|station| station.slope.is_some()) {
        let own = stations.iter().filter(|station| station.deviation_mm.is_finite());
        return own.filter_map(|station| Some((station.slope?, 1.0))).collect();
    }
    let pairs = stations.windows(2).map(|pair| {
        let length_mm = pair[1].s_mm - pair[0].s_mm;
        ((pair[1].deviation_mm - pair[0].deviation_mm) / length_mm, length_mm)
    });
    pairs.filter(|(slope, length_mm)| slope.is_finite() && *length_mm > 0.0).collect()
}

/// Mean, RMS and largest magnitude of slopes by their lengths.
pub(super) fn summed(slopes: &[(f64, f64)]) -> Option<[f64; 3]> {
    let length: f64 = slopes.iter().map(|(_, length)| length).sum();
    if slopes.is_empty() || length.is_nan() || length <= 0.0 {
        return None;
    }
    let mean = slopes.iter().map(|(slope, own)| slope * own).sum::<f64>() / length;
    let square = slopes.iter().map(|(slope, own)| slope * slope * own).sum::<f64>() / length;
    let most = slopes.iter().map(|(slope, _)| slope.abs()).fold(0.0, f64::max);
    Some([mean, square.sqrt(), most])
}

/// Standard deviation in mm that deviations vary by from point to point, from third divided differences: smooth form
/// leaves next to none. 1.4826 times the median of their sizes, as of a normal distribution; `None` of fewer than
/// [`NOISE_LEAST`].
pub(super) fn noise_mm(stations: &[Station]) -> Option<f64> {
    let own: Vec<&Station> = stations.iter().filter(|of| of.deviation_mm.is_finite()).collect();
    let mut sizes: Vec<f64> = own
        .windows(4)
        .filter_map(|window| {
            let weight = |i: usize| -> f64 {
                let others = (0..4).filter(|&j| j != i);
                others.map(|j| 1.0 / (window[i].s_mm - window[j].s_mm)).product()
            };
            let weights: [f64; 4] = std::array::from_fn(weight);
            let sum = |of: &dyn Fn(usize) -> f64| (0..4).map(of).sum::<f64>();
            let difference = sum(&|i| weights[i] * window[i].deviation_mm);
            let size = difference.abs() / sum(&|i| weights[i] * weights[i]).sqrt();
            size.is_finite().then_some(size)
        })
        .collect();
    if sizes.len() < NOISE_LEAST {
        return None;
    }
    let middle = sizes.len() / 2;
    Some(OF_MEDIAN * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// How the heights of points come, of which `s_mm` is the place along the line.
pub(super) fn steps(points: &[PointMm], s_mm: impl Fn(&PointMm) -> f64) -> HeightSteps {
    let mut order: Vec<VertexId> = (0..points.len() as VertexId).collect();
    let at = |vertex: VertexId| s_mm(&points[vertex as usize]);
    order.sort_by(|&one, &other| at(one).total_cmp(&at(other)));
    let edges: Vec<[VertexId; 2]> = order.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    height_steps(points, &edges)
}

/// RMS that noise of a standard deviation in mm gives the slopes of [`slopes`] between neighbours.
pub(super) fn slope_of_noise(stations: &[Station], noise_mm: f64) -> Option<f64> {
    let pairs = stations.windows(2).filter(|pair| {
        pair.iter().all(|station| station.deviation_mm.is_finite()) && pair[1].s_mm > pair[0].s_mm
    });
    let (length, squares) = pairs.fold((0.0, 0.0), |(length, squares), pair| {
        let own = pair[1].s_mm - pair[0].s_mm;
        (length + own, squares + 2.0 * noise_mm * noise_mm / own)
    });
    (length > 0.0).then(|| (squares / length).sqrt())
}

/// Slopes of best lines over the integration length, at stations a sampling step apart (ISO 10110-5, of a profile). A window
/// counts if it lies on the profile and holds three points.
pub(super) fn slopes_over(stations: &[Station], settings: &SlopeSettings) -> Vec<(f64, f64)> {
    let own: Vec<&Station> = stations.iter().filter(|of| of.deviation_mm.is_finite()).collect();
    let (Some(first), Some(last)) = (own.first(), own.last()) else { return Vec::new() };
    let half_mm = 0.5 * settings.integration_mm();
    let (from, to) = (first.s_mm + half_mm, last.s_mm - half_mm);
    let steps = ((to - from) / settings.step_mm()).floor();
    if !(0.0..=MOST_STATIONS).contains(&steps) {
        return Vec::new();
    }
    let at = (0..=steps as usize).map(|step| from + step as f64 * settings.step_mm());
    at.filter_map(|s_mm| {
        let low = own.partition_point(|of| of.s_mm < s_mm - half_mm - ROUNDING * half_mm);
        let high = own.partition_point(|of| of.s_mm <= s_mm + half_mm + ROUNDING * half_mm);
        let window = own.get(low..high).filter(|window| window.len() >= 3)?;
        let of = window.iter().map(|of| (of.s_mm - s_mm, of.deviation_mm));
        Some((parabola(of, false)?[1], 1.0))
    })
    .collect()
}

/// The largest second derivative of the deviation, 1/mm, of best parabolas over [`BENT`] points; `None` of fewer points.
pub(super) fn largest_bend_per_mm(stations: &[Station]) -> Option<f64> {
    let own: Vec<&Station> = stations.iter().filter(|of| of.deviation_mm.is_finite()).collect();
    let bends = own.windows(BENT).filter_map(|window| {
        let middle_mm = window[BENT / 2].s_mm;
        let of = window.iter().map(|of| (of.s_mm - middle_mm, of.deviation_mm));
        Some(2.0 * parabola(of, true)?[2].abs())
    });
    bends.reduce(f64::max)
}

/// Coefficients of the best line, or parabola if it is `bent`, by orthogonal polynomials.
fn parabola(points: impl Iterator<Item = (f64, f64)> + Clone, bent: bool) -> Option<[f64; 3]> {
    let n = points.clone().count() as f64;
    let mean =
        |of: &dyn Fn(f64, f64) -> f64| points.clone().map(|(x, z)| of(x, z)).sum::<f64>() / n;
    let (x0, z0) = (mean(&|x, _| x), mean(&|_, z| z));
    let square = mean(&|x, _| (x - x0).powi(2));
    if square.is_nan() || square <= 0.0 {
        return None;
    }
    let slope = mean(&|x, z| (x - x0) * (z - z0)) / square;
    if !bent {
        return Some([z0 - slope * x0, slope, 0.0]);
    }
    let skew = mean(&|x, _| (x - x0).powi(3)) / square;
    let second = |x: f64| (x - x0).powi(2) - skew * (x - x0) - square;
    let norm = mean(&|x, _| second(x).powi(2));
    (norm > 0.0).then(|| [z0, slope, mean(&|x, z| second(x) * (z - z0)) / norm])
}

/// Points of a window that tells how the deviation bends.
const BENT: usize = 9;
/// Fewer third differences tell no noise.
const NOISE_LEAST: usize = 16;
/// Standard deviation over the median of the sizes of a normal distribution.
const OF_MEDIAN: f64 = 1.482_602_218_505_602;
/// More stations than this tell nothing more.
const MOST_STATIONS: f64 = 1e6;
/// Share of a window by which a point at its end may lie beyond it.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    fn stations(z: impl Fn(f64) -> f64) -> Vec<Station> {
        (0..=100)
            .map(|i| {
                let s_mm = 0.1 * f64::from(i);
                Station { s_mm, deviation_mm: z(s_mm), slope: None }
            })
            .collect()
    }

    #[test]
    fn slopes_and_bends_of_polynomials_are_theirs() {
        let line = stations(|s| 1.0 + 2e-6 * s);
        let [mean, rms, most] = summed(&slopes(&line)).unwrap();
        for slope in [mean, rms, most] {
            assert!((slope - 2e-6).abs() < 1e-13, "{slope}");
        }
        let bent = stations(|s| 3e-6 * s * s - 1e-6 * s);
        assert!((largest_bend_per_mm(&bent).unwrap() - 6e-6).abs() < 1e-13);
        let settings = SlopeSettings::new(1.0, 0.5).unwrap();
        let found = slopes_over(&bent, &settings);
        assert_eq!(found.len(), 19);
        // The best line over a window of a parabola has the slope of its middle.
        assert!((found[0].0 - (6e-6 * 0.5 - 1e-6)).abs() < 1e-13, "{found:?}");
    }

    /// Alternating deviations of 2 nm on a parabola: third differences of size 16 nm over the root of 20.
    #[test]
    fn noise_is_what_third_differences_say_and_form_is_none() {
        let form = |s: f64| 1e-6 * s * s + 2e-5 * s;
        assert!(noise_mm(&stations(form)).unwrap() < 1e-14);
        let mut noisy = stations(form);
        for (at, station) in noisy.iter_mut().enumerate() {
            station.deviation_mm += if at % 2 == 0 { 2e-6 } else { -2e-6 };
        }
        let truth = OF_MEDIAN * 16e-6 / 20.0_f64.sqrt();
        let found = noise_mm(&noisy).unwrap();
        assert!((found - truth).abs() < 1e-11, "{found} {truth}");
        // Differences of two such over 0.1 mm.
        let slope = slope_of_noise(&noisy, 3e-6).unwrap();
        assert!((slope - 3e-6 * 2.0_f64.sqrt() / 0.1).abs() < 1e-12, "{slope}");
        assert_eq!(noise_mm(&noisy[..10]), None);
        assert_eq!(slope_of_noise(&noisy[..1], 1.0), None);
    }

    #[test]
    fn coverage_counts_lengths_by_place() {
        let s: Vec<f64> = [0.0, 1.0, 2.0, 6.0, 7.0].to_vec();
        let limits = |_| (1.0, 10.0);
        let found = coverage(&[[-0.25, 8.0]], &s, 1.0, limits);
        assert_eq!(found.length_mm, 8.25);
        assert_eq!(found.covered_mm, 0.25 + 2.0 + 1.0 + 0.5);
        assert_eq!((found.gap_max_mm, found.gap_covered_mm), (2.0, 0.5));
        assert_eq!(found.epsilon_max, 0.2);
        let ring = coverage(&[[0.0, 1.0], [6.5, 7.0]], &s, 1.0, limits);
        assert_eq!((ring.length_mm, ring.covered_mm), (1.5, 1.5));
    }
}
