//! The keys `loss`, `threshold_nm` and `weights` of the table `[fit]`.

use asphera_form::Loss;
use asphera_measure::{Criterion, Weights};
use asphera_settings::{OrAuto, Section};

/// Reads the keys `loss`, `threshold_nm` and `weights`.
pub(super) fn criterion(fit: &Section<'_>) -> Criterion {
    let losses = [("squares", Loss::Squares), ("huber", Loss::HUBER), ("tukey", Loss::TUKEY)];
    let loss = fit.word("loss", Loss::Squares, &losses);
    let weights = [("none", Weights::None), ("uncertainty", Weights::Uncertainty)];
    let weights = fit.word("weights", Weights::None, &weights);
    let threshold = fit.or("threshold_nm", OrAuto::Auto);
    let loss_scale_mm = match (threshold, loss) {
        (OrAuto::Auto, _) => None,
        (OrAuto::Number(_), Loss::Squares) => {
            let expected = "no such key where loss is \"squares\"; \"huber\" or \"tukey\" have one";
            fit.problem("threshold_nm", expected, "one");
            None
        }
        (OrAuto::Number(threshold_nm), Loss::Huber { k } | Loss::Tukey { k }) => {
            if threshold_nm <= 0.0 {
                fit.problem("threshold_nm", "a length above 0 in nm, or \"auto\"", threshold_nm);
            }
            Some(threshold_nm * 1e-6 / k)
        }
    };
    Criterion { loss, loss_scale_mm, weights }
}

#[cfg(test)]
mod tests {
    use asphera_measure::Part;

    use super::super::part;
    use super::*;

    fn parse(fit: &str) -> Result<Part, String> {
        let text = format!("[surface]\nkind = \"sphere\"\nradius_mm = 20\n[fit]\n{fit}");
        part::parse("n.toml", &text).map_err(|problems| problems.to_string())
    }

    #[test]
    fn losses_and_weights_are_read() {
        assert!(parse("").unwrap().criterion.is_plain());
        assert!(parse("loss = \"squares\"\nweights = \"none\"\n").unwrap().criterion.is_plain());
        let auto = parse("loss = \"huber\"\nthreshold_nm = \"auto\"\n").unwrap().criterion;
        assert_eq!((auto.loss, auto.loss_scale_mm), (Loss::HUBER, None));
        let given = parse("loss = \"tukey\"\nthreshold_nm = 46.85\nweights = \"uncertainty\"\n");
        let given = given.unwrap().criterion;
        assert_eq!((given.loss, given.weights), (Loss::TUKEY, Weights::Uncertainty));
        assert!((given.loss_scale_mm.unwrap() - 1e-5).abs() < 1e-19);
        // Robust fits have uncertainties too.
        assert!(parse("loss = \"huber\"\n[tolerance]\npvr_nm = 5\n").is_ok());
    }

    #[test]
    fn what_makes_no_sense_is_named() {
        for (fit, key) in [
            ("loss = \"absolute\"\n", "fit.loss: expected \"squares\" or \"huber\" or \"tukey\""),
            ("threshold_nm = 5\n", "fit.threshold_nm: expected no such key"),
            ("loss = \"huber\"\nthreshold_nm = 0\n", "fit.threshold_nm: expected a length above 0"),
            ("loss = \"huber\"\nthreshold_nm = \"wide\"\n", "or \"auto\""),
            ("weights = \"1/u\"\n", "fit.weights: expected \"none\" or \"uncertainty\""),
            ("side = \"back\"\n", "fit.side: expected \"given\" or \"either\""),
            ("free = [\"tz\"]\nside = \"either\"\n", "only a fit with rx and ry free"),
        ] {
            let problems = parse(fit).unwrap_err();
            assert!(problems.contains(key), "{problems}");
        }
    }
}
