//! Tests of the details of a fit.

use crate::nominal::parse;
use asphera_form::{FitSettings, Loss, Parameter, fit};

use super::*;

/// A plane with a step of 1 µm and one outlier: what the fit knows, in the words of the report.
#[test]
fn a_fit_is_told_whole() {
    let mut points: Vec<[f64; 3]> = (0..400_u32)
        .map(|i| {
            let (x, y) = (f64::from(i % 20) + 100.0, f64::from(i / 20));
            [x, y, if (i / 20 + i) % 2 == 0 { 1e-3 } else { 0.0 }]
        })
        .collect();
    points[57][2] = 3.0;
    let free = vec![Parameter::Tx, Parameter::Tz, Parameter::Ry];
    let settings = FitSettings { free, loss: Loss::TUKEY, ..FitSettings::default() };
    let part = parse("flat.toml", "[surface]\nkind = \"plane\"\n").unwrap();
    let told = of_fit(&fit(&points, &Nominal::Plane, &settings).unwrap(), None, &part);
    let [lacks] = &told.undetermined[..] else { panic!("{:?}", told.undetermined) };
    assert_eq!((&lacks.parameter[..], lacks.by_shape), ("tx", true));
    assert_eq!(lacks.combination.shares[0].parameter, "tx");
    let covariance = told.covariance.unwrap();
    assert_eq!(covariance.parameters, ["tz", "ry"]);
    assert_eq!(covariance.units, ["mm", "rad"]);
    // The plane is turned about an axis 100 mm away.
    let correlation = covariance.correlation[0][1].unwrap();
    assert!(correlation.abs() > 0.99 && covariance.correlation[1][1] == Some(1.0));
    let [[a, b], [c, d]] = [0, 1].map(|i| [0, 1].map(|j| covariance.covariance[i][j]));
    assert!(b == c && (b / (a * d).sqrt() - correlation).abs() < 1e-12);
    assert_eq!((told.converged, told.cautions.len()), (Some(true), 0));
    assert!(told.weakest.unwrap().text.contains("tz"));
}

#[test]
fn cautions_say_whether_they_forbid_a_verdict() {
    for allowed in [false, true] {
        let found = caution(&Caution::UpsideDown { allowed });
        assert_eq!((&found.kind[..], found.forbids_verdict), ("upside_down", !allowed));
    }
    let mirrored = Caution::Mirrored { rms_mm: 1e-2, mirrored_rms_mm: 1e-6 };
    let beyond = Caution::BeyondDomain { domain_mm: 9.0, beyond: 3, farthest_mm: 9.4 };
    let told = [caution(&mirrored), caution(&beyond)];
    assert_eq!((&told[0].kind[..], told[0].forbids_verdict), ("mirrored", true));
    assert_eq!((&told[1].kind[..], told[1].forbids_verdict), ("beyond_domain", false));
    assert!(told[1].text.contains("3 points"), "{}", told[1].text);
}
