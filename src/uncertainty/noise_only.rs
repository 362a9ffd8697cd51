//! The uncertainty of PV and RMS where only the noise of a point is known: closed forms, at the cost of nothing.
//!
//! With residuals r = e + z, e the form and z independent noise of standard deviation σ, the mean square of n
//! points grows by σ², and var|r|² = 4·σ²·|e|² + 2·n·σ⁴ (Searle & Gruber, Linear Models, 2nd ed., 2.4). The range of
//! the residuals changes by no more than √2 times the length of the noise, so its standard deviation is at most √2·σ
//! (the Gaussian Poincaré inequality: Boucheron, Lugosi & Massart, Concentration Inequalities, theorem 3.20), and
//! noise lifts either end by no more than σ·√(2·ln n) on the average (the same, theorem 2.5).
//!
//! What the places do, [`super::places()`] says. What is correlated, and what the machine does, is not in it: for that there
//! is [`super::uncertainty`].

use super::distribution::student_quantile;
use super::places::Places;

/// Effect of noise alone on PV and RMS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseOnly {
    /// Standard deviation of the noise of a point in nm.
    pub noise_nm: f64,
    /// RMS of the form without the noise in nm, 0 where noise makes all of it.
    pub form_nm: f64,
    /// Standard uncertainty of that in nm.
    pub u_rms_nm: f64,
    /// The standard uncertainty of the PV is at most this, in nm.
    pub u_pv_at_most_nm: f64,
    /// What noise has added to the PV on the average is at most this, in nm.
    pub pv_bias_at_most_nm: f64,
    mean_square_nm2: f64,
    spread_nm2: f64,
    u_noise_nm: f64,
}

impl NoiseOnly {
    /// For `count` points of an RMS about the nominal and a noise, both in nm; `None` without a point, or unless
    /// both are finite and not negative. What the parameters of the fit take off the noise is neglected.
    pub fn new(rms_nm: f64, noise_nm: f64, count: usize) -> Option<NoiseOnly> {
        let usable = |value: f64| value.is_finite() && value >= 0.0;
        if count == 0 || !usable(rms_nm) || !usable(noise_nm) {
            return None;
        }
        let (n, noise_nm2) = (count as f64, noise_nm * noise_nm);
        let mean_square_nm2 = (rms_nm * rms_nm - noise_nm2).max(0.0);
        // Standard deviation of the mean square.
        let spread_nm2 =
            ((4.0 * noise_nm2 * mean_square_nm2 + 2.0 * noise_nm2 * noise_nm2) / n).sqrt();
        let found = NoiseOnly {
            noise_nm,
            form_nm: mean_square_nm2.sqrt(),
            u_rms_nm: 0.0,
            u_pv_at_most_nm: std::f64::consts::SQRT_2 * noise_nm,
            pv_bias_at_most_nm: 2.0 * noise_nm * (2.0 * n.ln()).sqrt(),
            mean_square_nm2,
            spread_nm2,
            u_noise_nm: 0.0,
        };
        Some(found.told())
    }

    /// The same of a noise that is known to a standard uncertainty in nm: as one measured from the points, which is taken off with its
    /// error.
    #[must_use]
    pub fn known_to(self, u_noise_nm: f64) -> NoiseOnly {
        NoiseOnly { u_noise_nm, ..self }.told()
    }

    /// The same with the RMS over the area about its own best fit, and what the places do to it.
    pub fn over(self, places: &Places) -> NoiseOnly {
        let noise_nm2 = self.noise_nm * self.noise_nm;
        let mean_square_nm2 = (places.mean_square_nm2(self.noise_nm) - noise_nm2).max(0.0);
        let by_noise = (4.0 * noise_nm2 * mean_square_nm2 + 2.0 * noise_nm2 * noise_nm2)
            * places.crowding
            / places.count as f64;
        NoiseOnly {
            form_nm: mean_square_nm2.sqrt(),
            mean_square_nm2,
            spread_nm2: (by_noise + places.variance_nm4(self.noise_nm)).sqrt(),
            ..self
        }
        .told()
    }

    fn told(self) -> NoiseOnly {
        let [low, high] = self.within(1.0);
        NoiseOnly { u_rms_nm: 0.5 * (high - low), ..self }
    }

    /// An interval in nm that holds the RMS of the form with probability `confidence`, above 0 and below 1, the
    /// mean square taken for normal.
    pub fn rms_interval_nm(&self, confidence: f64) -> [f64; 2] {
        self.within(student_quantile(0.5 + 0.5 * confidence, f64::INFINITY))
    }

    /// An interval in nm that holds the PV of the form with probability `confidence` at least, for a measured one:
    /// below by what noise adds and by its deviation, above by the deviation alone (the concentration of a function
    /// of Lipschitz constant √2: Boucheron, Lugosi & Massart, theorem 5.6).
    pub fn pv_interval_nm(&self, pv_nm: f64, confidence: f64) -> [f64; 2] {
        let off_nm = 2.0 * self.noise_nm * (2.0 / (1.0 - confidence)).ln().sqrt();
        [(pv_nm - self.pv_bias_at_most_nm - off_nm).max(0.0), pv_nm + off_nm]
    }

    fn within(&self, k: f64) -> [f64; 2] {
        // σ² is known to 2·σ·u(σ).
        let spread_nm2 = self.spread_nm2.hypot(2.0 * self.noise_nm * self.u_noise_nm);
        [-k, k].map(|k| (self.mean_square_nm2 + k * spread_nm2).max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_geometry::Numbers;

    /// 4000 measurements of a form of 10 nm RMS: the scatter of RMS and PV is that of the formulae, a scatter
    /// being known to 1.1 % from so many.
    #[test]
    fn the_scatter_of_simulated_measurements_is_that_told() {
        const COUNT: usize = 200;
        let (rms_nm, noise_nm) = (10.0, 4.0);
        let form: Vec<f64> = (0..COUNT)
            .map(|i| rms_nm * 2.0_f64.sqrt() * (0.1 * std::f64::consts::TAU * i as f64).sin())
            .collect();
        let figures: Vec<(f64, f64)> = (0..4000)
            .map(|draw| {
                let numbers = Numbers::new(3, draw, 0);
                let values: Vec<f64> = form
                    .iter()
                    .enumerate()
                    .map(|(i, e)| e + noise_nm * numbers.normal(i))
                    .collect();
                let square = values.iter().map(|v| v * v).sum::<f64>() / COUNT as f64;
                let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                ((square - noise_nm * noise_nm).max(0.0).sqrt(), high - low)
            })
            .collect();
        let scatter = |of: fn(&(f64, f64)) -> f64| {
            let mean = figures.iter().map(of).sum::<f64>() / 4000.0;
            let square = figures.iter().map(|one| (of(one) - mean).powi(2)).sum::<f64>();
            (mean, (square / 3999.0).sqrt())
        };
        let measured_nm = (rms_nm * rms_nm + noise_nm * noise_nm).sqrt();
        let told = NoiseOnly::new(measured_nm, noise_nm, COUNT).unwrap();
        let (mean, u) = scatter(|one| one.0);
        assert!(
            (mean - told.form_nm).abs() < 0.02 && (u / told.u_rms_nm - 1.0).abs() < 0.04,
            "{mean} {u} {told:?}"
        );
        let (pv_nm, u) = scatter(|one| one.1);
        let form_pv_nm =
            form.iter().copied().fold(0.0, f64::max) - form.iter().copied().fold(0.0, f64::min);
        assert!(
            u < told.u_pv_at_most_nm && pv_nm - form_pv_nm < told.pv_bias_at_most_nm,
            "{pv_nm} {u} {told:?}"
        );
        let missed = figures.iter().filter(|(_, pv_nm)| {
            let [low, high] = told.pv_interval_nm(*pv_nm, 0.95);
            !(low..=high).contains(&form_pv_nm)
        });
        assert!(missed.count() < 200);
    }

    #[test]
    fn noise_alone_no_noise_and_nonsense() {
        // Of noise alone the RMS of the form lies between 0 and σ·(2/n)^¼.
        let told = NoiseOnly::new(4.0, 4.0, 800).unwrap();
        assert_eq!((told.form_nm, told.rms_interval_nm(0.95)[0]), (0.0, 0.0));
        assert!((told.u_rms_nm - 0.5 * 4.0 * (2.0 / 800.0_f64).powf(0.25)).abs() < 1e-12);
        // Where the noise is known to 1 %, and all there is, the form is known to 20 % of it: √(2 · 0.01 · 1.96).
        let measured = NoiseOnly::new(4.0, 4.0, 100_000_000).unwrap().known_to(0.04);
        assert!((measured.rms_interval_nm(0.95)[1] - 0.198 * 4.0).abs() < 1e-3, "{measured:?}");
        let quiet = NoiseOnly::new(5.0, 0.0, 3).unwrap();
        assert_eq!((quiet.form_nm, quiet.u_rms_nm, quiet.u_pv_at_most_nm), (5.0, 0.0, 0.0));
        for (rms_nm, noise_nm, count) in [(1.0, 1.0, 0), (f64::NAN, 1.0, 5), (1.0, -1.0, 5)] {
            assert_eq!(NoiseOnly::new(rms_nm, noise_nm, count), None);
        }
    }
}
