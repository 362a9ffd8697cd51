//! Correlation of residuals from point to point.

/// Factor by which variances of means grow because residuals follow one another alike: 1 + 2·Σρ(k), at least 1.
///
/// Autocorrelations are those within the sequences. The sum ends where two of them that follow one another are no
/// longer positive together (C. Geyer, Practical Markov Chain Monte Carlo, Stat. Sci. 7 (1992) 473-483, 3.3).
/// `O(n·k)` for k terms of the sum.
pub(crate) fn inflation(sequences: &[Vec<f64>]) -> f64 {
    let square: f64 = sequences.iter().flatten().map(|value| value * value).sum();
    if square <= 0.0 {
        return 1.0;
    }
    let correlation = |lag: usize| {
        let products = |values: &Vec<f64>| -> f64 {
            values.iter().zip(values.iter().skip(lag)).map(|(a, b)| a * b).sum()
        };
        sequences.iter().map(products).sum::<f64>() / square
    };
    let longest = sequences.iter().map(Vec::len).max().unwrap_or(0) / 4;
    let mut sum = 0.0;
    let mut lag = 1;
    while lag < longest.min(LONGEST_LAG) {
        let pair = correlation(lag) + correlation(lag + 1);
        if pair <= 0.0 {
            break;
        }
        sum += pair;
        lag += 2;
    }
    (1.0 + 2.0 * sum).max(1.0)
}

/// Longer correlations are no noise: they are form that no term describes.
const LONGEST_LAG: usize = 4000;

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_geometry::Numbers;

    #[test]
    fn white_noise_is_not_inflated_and_a_moving_mean_is_by_its_width() {
        let numbers = Numbers::new(7, 0, 0);
        let white: Vec<f64> = (0..40_000).map(|index| numbers.normal(index)).collect();
        assert!(inflation(std::slice::from_ref(&white)) < 1.1);
        // Means of w independent numbers: a variance of the mean w times as large as of independent ones.
        let smooth: Vec<f64> =
            white.windows(10).map(|window| window.iter().sum::<f64>() / 10.0).collect();
        let found = inflation(&[smooth]);
        assert!((found - 10.0).abs() < 1.0, "{found}");
        assert_eq!(inflation(&[]), 1.0);
        assert_eq!(inflation(&[vec![0.0; 9]]), 1.0);
    }
}
