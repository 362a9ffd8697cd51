//! Distributions that coverage factors come from: normal, Student's, χ², Fisher's.
//!
//! Incomplete gamma and beta functions are those of statrs; what stands here joins them at many degrees of freedom.

use std::f64::consts::FRAC_1_SQRT_2;

use libm::erfc;
use statrs::function::beta::beta_reg;
use statrs::function::gamma::{gamma_lr, ln_gamma};

/// P(X ≤ t) of Student's distribution with `dof` > 0 degrees of freedom, infinite ones being the normal
/// distribution.
pub(crate) fn student_cdf(t: f64, dof: f64) -> f64 {
    if dof > NEARLY_NORMAL {
        return normal_cdf(t);
    }
    // DLMF 8.17.
    let tail = 0.5 * beta_reg(0.5 * dof, 0.5, dof / (dof + t * t));
    if t < 0.0 { tail } else { 1.0 - tail }
}

/// P(X ≤ x) of the standard normal distribution.
pub(crate) fn normal_cdf(x: f64) -> f64 {
    0.5 * erfc(-x * FRAC_1_SQRT_2)
}

/// The t with P(X ≤ t) = p of Student's distribution, p between 0 and 1 exclusive.
pub(crate) fn student_quantile(p: f64, dof: f64) -> f64 {
    let upper = p.max(1.0 - p);
    let mut high = 1.0;
    while student_cdf(high, dof) < upper && high < 1e300 {
        high *= 2.0;
    }
    let t = bisect(0.0, high, |t| student_cdf(t, dof) < upper);
    if p < 0.5 { -t } else { t }
}

/// The x with P(X > x) = `share` of the standard normal distribution, to 1e-6 or better, in few operations: algorithm AS 241,
/// the shorter one (Wichura, Appl. Statist. 37 (1988) 477). ±∞ at 0 and 1.
pub(crate) fn normal_exceeded(share: f64) -> f64 {
    let q = 0.5 - share;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        let above =
            3.387_132_717_9 + r * (50.434_271_938 + r * (159.291_132_02 + r * 59.109_374_72));
        let below = 1.0 + r * (17.895_169_469 + r * (78.757_757_664 + r * 67.187_563_6));
        return q * above / below;
    }
    let tail = share.min(1.0 - share);
    if tail <= 0.0 {
        return if q > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
    }
    let r = (-tail.ln()).sqrt();
    let size = if r <= 5.0 {
        let r = r - 1.6;
        (1.423_437_277_7 + r * (2.756_815_39 + r * (1.306_728_481_6 + r * 0.170_238_211_03)))
            / (1.0 + r * (0.737_001_642_5 + r * 0.120_211_326_75))
    } else {
        let r = r - 5.0;
        (6.657_905_115 + r * (3.081_226_386 + r * (0.428_682_943_37 + r * 0.017_337_203_997)))
            / (1.0 + r * (0.241_978_942_25 + r * 0.012_258_202_635))
    };
    if q > 0.0 { size } else { -size }
}

/// P(X ≤ x) of the χ² distribution with `dof` > 0 degrees of freedom, whole or not.
///
/// Beyond [`NEARLY_NORMAL`] by Wilson & Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684, there to 1e-7: the loops of statrs
/// take time as √dof, and from some 1e15 they never end.
pub(crate) fn chi_square_cdf(x: f64, dof: f64) -> f64 {
    if x <= 0.0 {
        0.0
    } else if dof > NEARLY_NORMAL {
        let variance = 2.0 / (9.0 * dof);
        normal_cdf(((x / dof).cbrt() - 1.0 + variance) / variance.sqrt())
    } else if x > NEVER_EXCEEDED * dof.max(1.0) {
        1.0
    } else {
        gamma_lr(0.5 * dof, 0.5 * x).min(1.0)
    }
}

/// Density of the χ² distribution at x > 0.
pub(crate) fn chi_square_density(x: f64, dof: f64) -> f64 {
    let a = 0.5 * dof;
    0.5 * ((a - 1.0) * (0.5 * x).ln() - 0.5 * x - ln_gamma(a)).exp()
}

/// P(X ≤ f) of Fisher's distribution with that many degrees of freedom over and under the line (DLMF 8.17).
pub(crate) fn fisher_cdf(f: f64, over: f64, under: f64) -> f64 {
    if f <= 0.0 {
        0.0
    } else if under > NEARLY_NORMAL {
        chi_square_cdf(over * f, over)
    } else {
        beta_reg(0.5 * over, 0.5 * under, over * f / (over * f + under))
    }
}

/// The median of the χ² distribution.
pub(crate) fn chi_square_median(dof: f64) -> f64 {
    bisect(0.0, dof + 1.0, |x| chi_square_cdf(x, dof) < 0.5)
}

/// Where `below` turns from true to false.
pub(crate) fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Degrees of freedom from which distributions are normal, or nearly so, to 1e-7.
const NEARLY_NORMAL: f64 = 1e6;
/// χ² over its degrees of freedom, or over 1 where these are fewer, that is exceeded with a probability below 1e-300.
const NEVER_EXCEEDED: f64 = 2000.0;
/// All bits of an answer above 2⁻¹⁵⁰ of the first interval.
const HALVINGS: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy 1.17.1: `stats.t.ppf`, `stats.chi2.cdf`, `stats.chi2.pdf`, `stats.chi2.median`, `stats.norm.ppf` and `isf`,
    /// `stats.f.cdf`.
    #[test]
    fn values_of_scipy() {
        let close = |found: f64, truth: f64, relative: f64| {
            assert!((found / truth - 1.0).abs() < relative, "{found} {truth}");
        };
        close(student_quantile(0.975, 1.0), 12.706204736174694, 1e-12);
        close(student_quantile(0.975, 2.5), 3.5746548420036817, 1e-12);
        close(student_quantile(0.95, 7.0), 1.8945786050900062, 1e-12);
        close(student_quantile(0.995, 30.0), 2.7499956535672254, 1e-12);
        close(student_quantile(0.9, 1000.0), 1.2823987214609247, 1e-11);
        close(student_quantile(0.025, 12.0), -2.1788128296672293, 1e-12);
        close(student_quantile(0.975, f64::INFINITY), 1.959963984540054, 1e-12);
        close(student_quantile(0.95, f64::INFINITY), 1.6448536269514722, 1e-12);
        for (share, truth) in [
            (0.3, 0.5244005127080409),
            (0.025, 1.9599639845400545),
            (0.001, 3.090232306167813),
            (1e-15, 7.941345326170998),
            (1e-40, 13.31092137142517),
            (0.99, -2.3263478740408408),
        ] {
            close(normal_exceeded(share), truth, 4e-7);
        }
        assert_eq!([1.0, 0.5, 0.0].map(normal_exceeded), [f64::NEG_INFINITY, 0.0, f64::INFINITY]);
        close(chi_square_cdf(3.0, 4.5), 0.36723054820997547, 1e-12);
        close(chi_square_cdf(0.01, 1.0), 0.07965567455405799, 1e-12);
        close(chi_square_cdf(120.0, 100.0), 0.9155933189063082, 1e-12);
        close(chi_square_cdf(60.0, 100.0), 0.0005188914625480344, 1e-12);
        close(chi_square_cdf(50000.0, 50123.7), 0.34867261941950095, 1e-9);
        close(chi_square_cdf(200020.0, 200000.0), 0.5130334414362707, 1e-9);
        close(chi_square_cdf(20030000.0, 20000000.0), 0.9999989374692083, 1e-6);
        close(chi_square_cdf(1000500.0, 1000001.0), 0.6380527923342237, 1e-7);
        close(chi_square_density(3.0, 4.5), 0.16345991117210337, 1e-12);
        close(chi_square_density(10.0, 11.0), 0.0899509693388397, 1e-12);
        close(chi_square_median(1.0), 0.454936423119572, 1e-12);
        close(chi_square_median(6.0), 5.348120627447118, 1e-12);
        close(chi_square_median(17.0), 16.338182377392467, 1e-12);
        close(fisher_cdf(1.5, 58.0, 236.0), 0.9808804689460059, 1e-11);
        close(fisher_cdf(0.7, 5.0, 12.5), 0.3664446955527185, 1e-11);
        close(fisher_cdf(1.3, 249.0, 999744.0), 0.9989991663581763, 1e-7);
        close(fisher_cdf(1.0, 20000.0, 100000.0), 0.5009711568759853, 1e-9);
        close(fisher_cdf(1.01, 100000.0, 900000.0), 0.982778277446743, 1e-9);
        close(fisher_cdf(1.3, 58.0, 2e6), 0.937970812112013, 1e-5);
    }

    /// Noise of 1e-6 nm on a form of 20 nm has 1e15 degrees of freedom: the series of the incomplete gamma function did not end.
    #[test]
    fn chi_square_answers_for_any_degrees_of_freedom() {
        for power in -30..=300 {
            let dof = 10.0_f64.powi(power);
            for ratio in [1e-300, 1e-9, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 2.0, 1e9, 1e300] {
                let share = chi_square_cdf(ratio * dof, dof);
                assert!((0.0..=1.0).contains(&share), "{dof} {ratio}: {share}");
            }
        }
        for dof in [1.0, 30.0, 1e4, 1e6, 2e6, 1e18] {
            let shares =
                (0..400).map(|k| chi_square_cdf(dof * (1.0 + f64::from(k - 200) * 0.005), dof));
            assert!(shares.collect::<Vec<_>>().is_sorted(), "{dof}");
        }
    }
}
