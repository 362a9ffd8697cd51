//! Which figure a limit is of.

use serde::{Deserialize, Serialize};

/// The figure of a limit, and of what it is formed: what a check and an outlook share. Every output shows it by these words.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FigureName {
    /// Identity of the limit, with unit and scope: `pv_nm`, `rms_nm 0-4.5 mm`.
    pub name: String,
    /// Identity of the figure: `pv`, `rmsi`.
    #[serde(default)]
    pub id: String,
    /// Short sign of the figure: `PV`, `RMSi`.
    #[serde(default)]
    pub symbol: String,
    /// Unit of values and limit.
    #[serde(default)]
    pub unit: String,
    /// The part of the aperture or the terms removed, and where the fit may change the shape what the deviation is from:
    /// `from 0-4.5 mm`, `about the fitted shape`; absent of the whole deviation from the design.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scope: Option<String>,
}

impl FigureName {
    /// Sign and scope: `PV`, `RMS from 0-4.5 mm`.
    pub fn words(&self) -> String {
        match &self.scope {
            Some(scope) => format!("{} {scope}", self.symbol),
            None => self.symbol.clone(),
        }
    }
}
