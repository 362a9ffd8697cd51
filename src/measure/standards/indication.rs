//! What was found, as a drawing would state it by ISO 10110-5.

use asphera_figures::{Indication, Irregularity, LengthUnit};
use asphera_report::standards::IndicationFigures;

/// In the unit of what is asked, else in nm.
pub(crate) fn found(parts: &Irregularity, asked: Option<&Indication>) -> IndicationFigures {
    let unit = asked.map_or(LengthUnit::Nanometres, |asked| asked.unit);
    let number = |nm: f64| match unit {
        LengthUnit::Nanometres => format!("{} nm", four_digits(nm)),
        LengthUnit::Fringes { .. } => four_digits(nm / unit.nm()),
    };
    let mut found =
        format!("3/{}({}/{})", number(parts.a_nm), number(parts.b_nm), number(parts.c_nm));
    for (name, nm) in [
        ("RMSt", parts.rms_total_nm),
        ("RMSi", parts.rms_irregularity_nm),
        ("RMSa", parts.rms_variant_nm),
    ] {
        found.push_str(&format!("; {name} {}", number(nm)));
    }
    if let LengthUnit::Fringes { wavelength_nm } = unit {
        found.push_str(&format!("; λ={wavelength_nm} nm"));
    }
    IndicationFigures { asked: asked.map(ToString::to_string), found }
}

fn four_digits(value: f64) -> String {
    // Through the shortest form: no noughts behind the last digit.
    format!("{value:.3e}").parse::<f64>().unwrap_or(value).to_string()
}

#[cfg(test)]
mod tests {
    use asphera_figures::{Approximation, Sample, decompose};
    use asphera_form::Aperture;

    use super::*;

    #[test]
    fn it_is_told_in_the_unit_that_is_asked() {
        let places: Vec<[f64; 2]> = (0..4000)
            .map(|i| (f64::from(i), 2.4 * f64::from(i)))
            .map(|(i, phi)| {
                [5.0 * (i / 4000.0).sqrt() * phi.cos(), 5.0 * (i / 4000.0).sqrt() * phi.sin()]
            })
            .collect();
        let nm = |[x, y]: [f64; 2]| 300.0 * (x * x + y * y) / 25.0;
        let deviations_mm: Vec<f64> = places.iter().map(|&place| nm(place) * 1e-6).collect();
        let aperture = Aperture::Circle { radius_mm: 5.0 };
        let sample = Sample::new(&places, &deviations_mm, None, &aperture).unwrap();
        let parts = decompose(&sample, Approximation::Quadratic, None).unwrap();
        let plain = found(&parts, None);
        assert!(plain.asked.is_none() && plain.found.starts_with("3/300 nm("), "{}", plain.found);
        let asked: Indication = "3/2(0.5); λ=600".parse().unwrap();
        let fringes = found(&parts, Some(&asked));
        assert_eq!(fringes.asked.as_deref(), Some("3/2(0.5); λ=600 nm"));
        assert!(fringes.found.starts_with("3/1(") && fringes.found.ends_with("; λ=600 nm"));
    }
}
