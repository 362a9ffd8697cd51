//! What is on the machine: as an operator or a factory system says it when a session starts.

use serde::{Deserialize, Serialize};

/// Which part is measured, and who measures it; what is not told is absent.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Label {
    /// Name or drawing number of the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Serial number of this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Who measures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
}

/// The longest entry, in characters: what still fits the head of a sheet.
const LONGEST: usize = 120;

impl Label {
    /// The label with spaces around entries taken off, and empty entries as absent.
    ///
    /// # Errors
    ///
    /// Which entry is too long or holds a control character, in words.
    pub fn tidied(self) -> Result<Label, String> {
        let tidy = |name: &str, entry: Option<String>| {
            let Some(entry) = entry else { return Ok(None) };
            let entry = entry.trim();
            let count = entry.chars().count();
            if count > LONGEST {
                return Err(format!(
                    "{name}: expected at most {LONGEST} characters, found {count}"
                ));
            }
            if entry.chars().any(char::is_control) {
                return Err(format!("{name}: expected printable characters, found {entry:?}"));
            }
            Ok((!entry.is_empty()).then(|| entry.to_owned()))
        };
        Ok(Label {
            part: tidy("part", self.part)?,
            serial: tidy("serial", self.serial)?,
            operator: tidy("operator", self.operator)?,
        })
    }

    /// Entries that are given, with their names.
    pub fn entries(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let entries =
            [("part", &self.part), ("serial number", &self.serial), ("operator", &self.operator)];
        entries.into_iter().filter_map(|(name, entry)| Some((name, entry.as_deref()?)))
    }

    /// Part and serial number, as a sheet has them in its head; `None` where neither is told.
    pub fn title(&self) -> Option<String> {
        match (&self.part, &self.serial) {
            (Some(part), Some(serial)) => Some(format!("{part}, no. {serial}")),
            (Some(part), None) => Some(part.clone()),
            (None, Some(serial)) => Some(format!("no. {serial}")),
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_tidied_or_refused() {
        let label = Label {
            part: Some("  lens 7 ".to_owned()),
            serial: Some("   ".to_owned()),
            operator: None,
        };
        let tidied = label.tidied().unwrap();
        assert_eq!((tidied.part.as_deref(), tidied.serial.as_deref()), (Some("lens 7"), None));
        assert_eq!(tidied.title().as_deref(), Some("lens 7"));
        let long = Label { serial: Some("x".repeat(121)), ..Label::default() };
        assert_eq!(
            long.tidied().unwrap_err(),
            "serial: expected at most 120 characters, found 121"
        );
        let control = Label { operator: Some("a\nb".to_owned()), ..Label::default() };
        assert!(control.tidied().unwrap_err().starts_with("operator: expected printable"));
        assert!(serde_json::from_str::<Label>(r#"{"prat": "x"}"#).is_err(), "a slip is no entry");
    }
}
