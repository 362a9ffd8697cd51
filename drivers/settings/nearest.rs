//! The known key that a mistyped one may mean.

/// The known word nearest to `word`, if it is near enough to be a typing error or a unit left out.
pub(crate) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    if word.len() > LONGEST_MISTYPED {
        return None;
    }
    let without_unit =
        |known: &&&str| known.strip_prefix(word).is_some_and(|rest| rest.starts_with('_'));
    if let Some(known) = known.iter().find(without_unit) {
        return Some(known);
    }
    let (distance, nearest) = known.iter().map(|known| (edits(word, known), *known)).min()?;
    (distance <= 1 + word.len() / 4).then_some(nearest)
}

/// Bytes of a word that may be a known one mistyped; the known ones have some 20.
const LONGEST_MISTYPED: usize = 64;

/// Levenshtein's distance.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, a) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_words_are_not_suggested() {
        assert_eq!(nearest("radius", &["radius_mm", "conic"]), Some("radius_mm"));
        assert_eq!(nearest("height", &["radius_mm", "conic"]), None);
        assert_eq!(nearest("radius_m", &["radius_mm", "conic"]), Some("radius_mm"));
        assert_eq!(nearest("x", &["conic"]), None);
        assert_eq!(nearest(&"conic".repeat(20), &["conic"]), None);
    }
}
