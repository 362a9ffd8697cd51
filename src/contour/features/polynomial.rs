//! Polynomials of least squares with the covariance of their values.

/// A polynomial fitted to heights over places.
pub(super) struct Polynomial {
    middle: f64,
    half: f64,
    coefficients: Vec<f64>,
    /// (XᵀWX)⁻¹ of the coefficients.
    unit: Vec<Vec<f64>>,
    /// Weighted sum of squares that is left.
    pub(super) squares: f64,
}

impl Polynomial {
    /// The polynomial of a degree through (place, height). Noise is across the curve: a height counts by 1 / (1 + slope²), the slope that of a first
    /// fit in which all count alike. None of fewer heights than the degree and four.
    pub(super) fn fit(degree: usize, rows: &[[f64; 2]]) -> Option<Polynomial> {
        let alike = Polynomial::weighted(degree, rows, |_| 1.0)?;
        Polynomial::weighted(degree, rows, |place| 1.0 / (1.0 + alike.slope(place).powi(2)))
    }

    fn weighted(
        degree: usize,
        rows: &[[f64; 2]],
        weight: impl Fn(f64) -> f64,
    ) -> Option<Polynomial> {
        if rows.len() < degree + 4 {
            return None;
        }
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) =
            rows.iter().fold(ends, |(low, high), row| (low.min(row[0]), high.max(row[0])));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let count = degree + 1;
        let mut normal = vec![vec![0.0; 2 * count + 1]; count];
        for &[place, height] in rows {
            let powers = powers((place - middle) / half, count);
            let weight = weight(place);
            for i in 0..count {
                for j in 0..count {
                    normal[i][j] += weight * powers[i] * powers[j];
                }
                normal[i][2 * count] += weight * powers[i] * height;
            }
        }
        for (index, row) in normal.iter_mut().enumerate() {
            row[count + index] = 1.0;
        }
        eliminate(&mut normal)?;
        let coefficients: Vec<f64> = normal.iter().map(|row| row[2 * count]).collect();
        let unit = normal.iter().map(|row| row[count..2 * count].to_vec()).collect();
        let mut polynomial = Polynomial { middle, half, coefficients, unit, squares: 0.0 };
        polynomial.squares = rows
            .iter()
            .map(|&[place, height]| weight(place) * (height - polynomial.value(place)).powi(2))
            .sum();
        Some(polynomial)
    }

    /// The value at a place.
    pub(super) fn value(&self, place: f64) -> f64 {
        let t = (place - self.middle) / self.half;
        self.coefficients.iter().rev().fold(0.0, |sum, it| sum * t + it)
    }

    /// The slope at a place.
    pub(super) fn slope(&self, place: f64) -> f64 {
        let t = (place - self.middle) / self.half;
        let terms = self.coefficients.iter().enumerate().skip(1).rev();
        terms.fold(0.0, |sum, (power, it)| sum * t + power as f64 * it) / self.half
    }

    /// The variance of the value at a place where heights of weight 1 have variance 1.
    pub(super) fn variance(&self, place: f64) -> f64 {
        let powers = powers((place - self.middle) / self.half, self.coefficients.len());
        let row = |row: &Vec<f64>| -> f64 { row.iter().zip(&powers).map(|(a, b)| a * b).sum() };
        self.unit.iter().zip(&powers).map(|(it, power)| power * row(it)).sum()
    }

    /// The range of the places it was fitted to.
    pub(super) fn range(&self) -> [f64; 2] {
        [self.middle - self.half, self.middle + self.half]
    }
}

fn powers(t: f64, count: usize) -> Vec<f64> {
    std::iter::successors(Some(1.0), |power| Some(power * t)).take(count).collect()
}

/// Gauss and Jordan's elimination of rows; none where they depend on each other.
fn eliminate(rows: &mut [Vec<f64>]) -> Option<()> {
    for column in 0..rows.len() {
        let largest = (column..rows.len())
            .reduce(|p, q| if rows[q][column].abs() > rows[p][column].abs() { q } else { p })?;
        rows.swap(column, largest);
        let lead = rows[column][column];
        if lead.is_nan() || lead.abs() <= 1e-12 {
            return None;
        }
        rows[column].iter_mut().for_each(|value| *value /= lead);
        let lead = rows[column].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(index, _)| *index != column) {
            let share = row[column];
            row.iter_mut().zip(&lead).for_each(|(value, lead)| *value -= share * lead);
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_itself() {
        let of = |x: f64| 2.0 - x + 0.5 * x * x * x;
        let rows: Vec<[f64; 2]> =
            (0..20).map(|x| 3.0 + 0.1 * f64::from(x)).map(|x| [x, of(x)]).collect();
        let found = Polynomial::fit(3, &rows).expect("rows enough");
        assert!((found.value(3.5) - of(3.5)).abs() < 1e-11 && found.squares < 1e-20);
        assert!((found.slope(3.5) - (1.5 * 3.5 * 3.5 - 1.0)).abs() < 1e-10);
        assert!(Polynomial::fit(3, &rows[..6]).is_none());
    }

    #[test]
    fn the_variance_of_a_mean_and_of_the_end_of_a_line() {
        let rows: Vec<[f64; 2]> = (0..101).map(|x| [f64::from(x), 1.0]).collect();
        let mean = Polynomial::fit(0, &rows).expect("rows enough");
        assert!((mean.variance(7.0) - 1.0 / 101.0).abs() < 1e-12);
        let line = Polynomial::fit(1, &rows).expect("rows enough");
        // 1/n + (x - mean)²/Σ(x - mean)².
        let sum = 101.0 * (101.0 * 101.0 - 1.0) / 12.0;
        assert!((line.variance(100.0) - 1.0 / 101.0 - 2500.0 / sum).abs() < 1e-12);
    }
}
