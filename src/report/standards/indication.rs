//! Indication of a drawing by ISO 10110-5.

use serde::{Deserialize, Serialize};

use super::StandardFigure;

/// `3/A(B/C)` with its RMS, by ISO 10110-5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IndicationFigures {
    /// Indication of the drawing, if the nominal file has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<String>,
    /// Found values, in the unit of what is asked, else in nm.
    pub found: String,
}

/// Its words stand among the figures.
impl StandardFigure for IndicationFigures {
    fn facts(&self) -> Vec<(&'static str, String)> {
        let asked = self.asked.iter().map(|asked| ("ISO 10110-5, asked", asked.clone()));
        std::iter::once(("ISO 10110-5, found", self.found.clone())).chain(asked).collect()
    }
}
