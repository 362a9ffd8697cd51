//! The table `figures`.

use std::num::NonZeroU8;

use asphera_figures::texture::{Datum, Gaussian, Order, Robust, Scale};
use asphera_figures::{Definition, FringeCount, SlopeSettings};
use asphera_measure::{FigureSettings, Q_TERMS, TextureSettings};
use asphera_settings::Section;

/// Reads the table `figures`.
pub(super) fn read(table: &Section<'_>) -> FigureSettings {
    let section = table.section("figures");
    let otherwise = FigureSettings::default();
    let settings = FigureSettings {
        of_points: (Definition::OF_POINTS.into_iter())
            .filter(|figure| section.or(figure.id(), false))
            .collect(),
        slope: slope(&section),
        psd: section.or("psd", otherwise.psd),
        zernike: zernike(&section).unwrap_or(otherwise.zernike),
        q_terms: NonZeroU8::new(section.within("q_terms", Q_TERMS, 0..=MOST_Q_TERMS)),
        texture: texture(&section),
    };
    section.finish();
    settings
}

fn slope(section: &Section<'_>) -> Option<SlopeSettings> {
    let over_mm = section.get::<f64>("slope_length_mm");
    let step_mm = section.get::<f64>("slope_step_mm");
    let Some(over_mm) = over_mm else {
        if step_mm.is_some() {
            section.problem("slope_step_mm", "slope_length_mm beside it", "none");
        }
        return None;
    };
    match SlopeSettings::new(over_mm, step_mm.unwrap_or(0.5 * over_mm)) {
        Ok(settings) => Some(settings),
        Err(error) => {
            section.problem("slope_length_mm", "lengths above 0", error);
            None
        }
    }
}

fn zernike(section: &Section<'_>) -> Option<FringeCount> {
    let count = section.get::<u8>("zernike_terms")?;
    let known = [FringeCount::ThirtySix, FringeCount::ThirtySeven];
    let found = known.into_iter().find(|known| known.last() == count);
    if found.is_none() {
        section.problem("zernike_terms", "36 or 37, which Fringe sets have", count);
    }
    found
}

/// Reads `texture = false` or the table `texture`, without which there is none.
fn texture(figures: &Section<'_>) -> Option<TextureSettings> {
    if !figures.has("texture") {
        return None;
    }
    if figures.is_bool("texture") {
        if figures.or("texture", false) {
            figures.problem("texture", "a table that states the scale, or false", "true");
        }
        return None;
    }
    let section = figures.section("texture");
    let removed = [("nothing", Datum::AsGiven), ("mean", Datum::Mean), ("plane", Datum::MeanPlane)];
    let f_operation = section.word("remove", Datum::MeanPlane, &removed);
    let order = match section.or::<u8>("order", 2) {
        0 => Order::Zero,
        2 => Order::Two,
        other => {
            section.problem("order", "0 or 2", other);
            Order::Two
        }
    };
    let filter = |key| match Gaussian::new(section.get(key)?, order) {
        Ok(filter) => Some(filter),
        Err(error) => {
            section.problem(key, "a length above 0", error);
            None
        }
    };
    let (s, l) = (filter("s_mm"), filter("l_mm"));
    // Outliers are what the S-filter is to take out, and what the L-filter must not follow.
    let is_robust = section.or("robust", false);
    if is_robust && l.is_none() {
        section.problem("robust", "l_mm beside it: only the L-filter can be robust", "none");
    }
    let l = l.map(|l| if is_robust { l.robust(Robust::default()) } else { l });
    section.finish();
    match Scale::new(s, l) {
        Ok(scale) => Some(TextureSettings { f_operation, scale }),
        Err(error) => {
            section.problem("s_mm", "a length below l_mm", error);
            None
        }
    }
}

/// More cost more than all else.
const MOST_Q_TERMS: u8 = 60;

#[cfg(test)]
mod tests {
    use super::super::part;
    use super::*;

    fn parse(text: &str) -> Result<FigureSettings, String> {
        let text = format!("[surface]\nkind = \"plane\"\n{text}");
        part::parse("n.toml", &text)
            .map(|part| part.figures)
            .map_err(|problems| problems.to_string())
    }

    #[test]
    fn what_is_not_said_is_what_costs_little() {
        assert_eq!(parse("").unwrap(), FigureSettings::default());
        assert_eq!(parse("[figures]\ntexture = false\n").unwrap(), FigureSettings::default());
    }

    #[test]
    fn all_is_read() {
        let found = parse(
            "[figures]\nminimum_zone = true\nslope_length_mm = 1\npsd = false\nzernike_terms = 37\nq_terms = 0\n\
             [figures.texture]\nremove = \"mean\"\ns_mm = 0.08\nl_mm = 2.5\norder = 0\nrobust = true\n",
        );
        let s = Gaussian::new(0.08, Order::Zero).unwrap();
        let l = Gaussian::new(2.5, Order::Zero).unwrap().robust(Robust::default());
        let expected = FigureSettings {
            of_points: vec![Definition::MinimumZone],
            slope: SlopeSettings::new(1.0, 0.5).ok(),
            psd: false,
            zernike: FringeCount::ThirtySeven,
            q_terms: None,
            texture: Some(TextureSettings {
                f_operation: Datum::Mean,
                scale: Scale::new(Some(s), Some(l)).unwrap(),
            }),
        };
        assert_eq!(found.unwrap(), expected);
    }

    #[test]
    fn every_mistake_is_named() {
        let problems = parse(
            "[figures]\nslope_step_mm = 1\nzernike_terms = 30\nq_terms = 61\npds = true\n\
             [figures.texture]\nremove = \"form\"\ns_mm = 3\nl_mm = 2\norder = 1\n",
        )
        .unwrap_err();
        let keys: Vec<&str> =
            problems.lines().map(|line| line.split(": ").nth(1).unwrap()).collect();
        assert_eq!(
            keys,
            [
                "figures.slope_step_mm",
                "figures.zernike_terms",
                "figures.q_terms",
                "figures.pds",
                "figures.texture.remove",
                "figures.texture.s_mm",
                "figures.texture.order",
            ],
            "{problems}"
        );
        for (rest, key) in [
            ("[figures]\ntexture = true\n", "figures.texture"),
            ("[figures.texture]\ns_mm = -1\n", "figures.texture.s_mm"),
            ("[figures.texture]\nrobust = true\ns_mm = 1\n", "figures.texture.robust"),
            ("[figures]\nslope_length_mm = 0\n", "figures.slope_length_mm"),
        ] {
            let problems = parse(rest).unwrap_err();
            assert!(problems.contains(key) && problems.lines().count() == 1, "{problems}");
        }
    }
}
