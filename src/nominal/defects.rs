//! The tables `defects` and `partition`.

use asphera_measure::{DefectLimits, FLAT_BELOW_PER_MM, LISTED};
use asphera_settings::Section;

/// Reads `defects = false` or the table `defects`.
pub(super) fn limits(table: &Section<'_>) -> Option<DefectLimits> {
    if table.is_bool("defects") {
        return table.or("defects", true).then(DefectLimits::default);
    }
    let section = table.section("defects");
    let otherwise = DefectLimits::default();
    let limits = DefectLimits {
        largest_mm: section
            .has("largest_mm")
            .then(|| section.within("largest_mm", 1.0, 1e-6..=1e6)),
        false_expected: section.within("false_expected", otherwise.false_expected, 1e-9..=10.0),
        min_height_nm: section.within("min_height_nm", otherwise.min_height_nm, 0.0..=1e12),
        listed: section.within("listed", LISTED as u64, 0..=MOST_LISTED) as usize,
    };
    section.finish();
    Some(limits)
}

/// Reads the table `partition`.
pub(super) fn flat_below_per_mm(table: &Section<'_>) -> f64 {
    let section = table.section("partition");
    let flat_below_per_mm = section.within("flat_below_per_mm", FLAT_BELOW_PER_MM, 0.0..=1e6);
    section.finish();
    flat_below_per_mm
}

/// Most that may be: every snapshot carries them.
const MOST_LISTED: u64 = 1000;

#[cfg(test)]
mod tests {
    use asphera_measure::Part;

    use super::super::part::parse;
    use super::*;

    fn part(text: &str) -> Part {
        parse("part.toml", &format!("{text}\n[surface]\nkind = \"plane\"\n")).unwrap()
    }

    #[test]
    fn defects_are_looked_for_unless_not_wanted() {
        assert_eq!(part("").defects, Some(DefectLimits::default()));
        assert_eq!(part("defects = true").defects, Some(DefectLimits::default()));
        assert_eq!(part("defects = false").defects, None);
        let wanted = part("[defects]\nlargest_mm = 0.5\nmin_height_nm = 20\nlisted = 3").defects;
        let expected = DefectLimits {
            largest_mm: Some(0.5),
            min_height_nm: 20.0,
            listed: 3,
            ..DefectLimits::default()
        };
        assert_eq!(wanted, Some(expected));
        assert_eq!(part("[partition]\nflat_below_per_mm = 0.01").flat_below_per_mm, 0.01);
    }

    #[test]
    fn limits_that_cannot_be_are_named() {
        let text = "defects = \"no\"\n[surface]\nkind = \"plane\"\n";
        assert_eq!(parse("n.toml", text).unwrap_err().0[0].key, "defects");
        let text = "[surface]\nkind = \"plane\"\n[defects]\nlargest_mm = 0\nfalse_expected = 11\nwide = 1\n\
                    [partition]\nflat_below_per_mm = -1\n";
        let problems = parse("n.toml", text).unwrap_err();
        let keys: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
        assert_eq!(
            keys,
            [
                "defects.largest_mm",
                "defects.false_expected",
                "defects.wide",
                "partition.flat_below_per_mm"
            ]
        );
    }
}
