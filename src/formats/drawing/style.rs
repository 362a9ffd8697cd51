//! Properties `display` and `visibility` of SVG elements, which say whether they are shown.
//!
//! Sources: SVG 2, 6.6 "Presentation attributes"; CSS 2, 6.4 "The cascade" and 11.2. Rules count whose selectors are names, classes and ids
//! of the element itself. Others that set these properties are refused.

use super::svg::Tag;
use crate::error::quoted;
use crate::{Format, Place, ReadError};

/// Whether elements are shown: those within one that is not displayed never are, those within one that is not visible may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    is_displayed: bool,
    is_visible: bool,
}

impl Shown {
    pub(super) const ALL: Shown = Shown { is_displayed: true, is_visible: true };

    /// Whether lines are shown.
    pub(super) fn are_lines(self) -> bool {
        self.is_displayed && self.is_visible
    }

    /// What holds of an element within one.
    pub(super) fn within(self, tag: &Tag, sheet: &StyleSheet) -> Shown {
        let is_none = sheet.value_of("display", tag).is_some_and(|value| value == "none");
        let is_visible = match sheet.value_of("visibility", tag).as_deref() {
            Some("hidden" | "collapse") => false,
            Some("visible") => true,
            _ => self.is_visible,
        };
        Shown { is_displayed: self.is_displayed && !is_none, is_visible }
    }
}

/// The rules of a drawing that set one of the two properties.
#[derive(Default)]
pub(super) struct StyleSheet {
    rules: Vec<(Selector, Vec<Declaration>)>,
}

/// The name, the id and the classes that an element must have; an empty name is any.
#[derive(Default)]
struct Selector {
    name: String,
    ids: Vec<String>,
    classes: Vec<String>,
}

#[derive(Clone)]
struct Declaration {
    property: String,
    value: String,
    is_important: bool,
}

/// Rank of a declaration in the cascade: importance, origin, specificity.
type Rank = (bool, u8, [usize; 3]);

impl StyleSheet {
    /// Reads the text of all elements `style`.
    pub(super) fn parse(text: &str) -> Result<StyleSheet, ReadError> {
        let text = without_comments(text);
        let mut sheet = StyleSheet::default();
        let mut rest = &text[..];
        while let Some((before, after)) = rest.split_once('{') {
            let (block, after) = after.split_at(end_of_block(after));
            rest = after.trim_start_matches('}');
            // Statements without a block, as `@import`, end with a semicolon.
            let selectors = before.rsplit(';').next().unwrap_or_default().trim();
            let declarations = declarations(block);
            let sets = |part: &str| PROPERTIES.iter().any(|property| part.contains(property));
            let matters = match selectors.starts_with('@') {
                true => sets(&block.to_lowercase()),
                false => declarations.iter().any(|it| sets(&it.property)),
            };
            if !matters {
                continue;
            }
            for selector in selectors.split(',').map(str::trim) {
                let parsed = Selector::parse(selector).ok_or_else(|| ReadError::Unsupported {
                    format: Format::Svg,
                    place: Place::Element("style".to_owned()),
                    expected: "a name, a class or an id that sets display or visibility".to_owned(),
                    found: quoted(selector.as_bytes()),
                })?;
                sheet.rules.push((parsed, declarations.clone()));
            }
        }
        Ok(sheet)
    }

    /// The value of a property that an element has by itself.
    fn value_of(&self, property: &str, tag: &Tag) -> Option<String> {
        let mut found: Vec<(Rank, String)> = Vec::new();
        if let Some(value) = tag.get(property) {
            found.push(((false, 0, [0; 3]), value.trim().to_lowercase()));
        }
        let mut take = |declarations: &[Declaration], origin: u8, weight: [usize; 3]| {
            for it in declarations.iter().filter(|it| it.property == property) {
                found.push(((it.is_important, origin, weight), it.value.clone()));
            }
        };
        for (selector, declarations) in self.rules.iter().filter(|(it, _)| it.holds_of(tag)) {
            take(declarations, 1, selector.weight());
        }
        take(&declarations(tag.get("style").unwrap_or_default()), 2, [0; 3]);
        // Of equal ranks the last one holds.
        found.into_iter().max_by_key(|(rank, _)| *rank).map(|(_, value)| value)
    }
}

const PROPERTIES: [&str; 2] = ["display", "visibility"];

impl Selector {
    /// A selector of one element by its own name, classes and ids; `None` of any other.
    fn parse(text: &str) -> Option<Selector> {
        let is_word = |letter: char| letter.is_alphanumeric() || letter == '-' || letter == '_';
        let start = text.find(['.', '#']).unwrap_or(text.len());
        let (name, mut rest) = text.split_at(start);
        let mut selector = Selector::default();
        if name != "*" {
            selector.name = name.to_owned();
        }
        while let Some(sign) = rest.chars().next() {
            let end = rest[1..].find(['.', '#']).map_or(rest.len(), |end| 1 + end);
            let (word, after) = (rest[1..end].to_owned(), &rest[end..]);
            if word.is_empty() || !word.chars().all(is_word) {
                return None;
            }
            match sign {
                '.' => selector.classes.push(word),
                _ => selector.ids.push(word),
            }
            rest = after;
        }
        (!text.is_empty() && selector.name.chars().all(is_word)).then_some(selector)
    }

    fn holds_of(&self, tag: &Tag) -> bool {
        let is_class = |class: &String| {
            tag.get("class").is_some_and(|all| all.split_whitespace().any(|it| it == class))
        };
        (self.name.is_empty() || self.name == tag.name)
            && self.ids.iter().all(|id| tag.get("id") == Some(id))
            && self.classes.iter().all(is_class)
    }

    fn weight(&self) -> [usize; 3] {
        [self.ids.len(), self.classes.len(), usize::from(!self.name.is_empty())]
    }
}

/// Declarations `property: value` with semicolons between.
fn declarations(text: &str) -> Vec<Declaration> {
    let parts = text.split(';').filter_map(|part| part.split_once(':'));
    parts
        .map(|(property, value)| {
            let value = value.trim().to_lowercase();
            let plain = value.strip_suffix("important").and_then(|it| it.trim().strip_suffix('!'));
            Declaration {
                property: property.trim().to_lowercase(),
                is_important: plain.is_some(),
                value: plain.unwrap_or(&value).trim().to_owned(),
            }
        })
        .collect()
}

/// Where the brace stands that closes a block, blocks within it passed over.
fn end_of_block(text: &str) -> usize {
    let mut depth = 1_usize;
    for (at, letter) in text.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

fn without_comments(text: &str) -> String {
    let mut parts = text.split("/*");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        kept.push_str(part.split_once("*/").map_or("", |(_, after)| after));
    }
    kept
}
