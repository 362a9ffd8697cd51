//! The minimum zone.

use serde::{Deserialize, Serialize};

use super::{Standard, StandardFigure};
use crate::view::{Chapter, Layout, Table, definition, known_of, of_draws};
use crate::words::{count, minus, percent, place, short};
use crate::{FormFigure, FormFigures};

/// A minimum zone with what shows that no place near by has a narrower one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MinimumZoneFigures {
    /// Its width, with its definition.
    pub width: FormFigure,
    /// The criterion in words.
    pub method: String,
    /// Why the search ended.
    pub termination: String,
    /// Whether the width exceeds its lower bound by no more than the tolerance of the search.
    pub settled: bool,
    /// No zone near by is narrower than this, nm: a bound by the multipliers of the contacts, to first order.
    pub lower_nm: f64,
    /// Width less that bound, nm.
    pub gap_nm: f64,
    /// Middle of the zone above the nominal, nm. It is large where the zone makes up for a wrong radius.
    pub offset_nm: f64,
    /// Points that were all held against the zone in the end.
    pub points: u64,
    /// How often that was done.
    pub passes: u64,
    /// PV of the same points at the least-squares fit, nm.
    pub least_squares_pv_nm: f64,
    /// Points that hold the zone, the largest share first.
    pub contacts: Vec<ContactFigures>,
}

/// A point that touches the border of a zone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactFigures {
    /// Where, in the part frame of the least-squares fit, mm.
    pub at_mm: [f64; 3],
    /// Which border: `high`, on the +z side, or `low`.
    pub side: String,
    /// Its share in holding the zone, 0 to 1; all of them add up to 1.
    pub share: f64,
}

impl StandardFigure for MinimumZoneFigures {
    /// The zone, what it is beside the fit, and what shows that none near by is narrower.
    fn chapter(&self, form: &FormFigures) -> Option<Chapter> {
        let mut chapter = Chapter::of_standard(Standard::MinimumZone, "Minimum zone");
        chapter.brief.push(format!(
            "{} nm{}; none near by is narrower than {} nm",
            short(self.width.value),
            known_of(&self.width),
            short(self.lower_nm)
        ));
        chapter.note(format!(
            "Every point lies within {} nm between two parallels of the nominal; at the least-squares fit the same points \
             span {} nm. The middle of the zone lies {} nm above the nominal.",
            short(self.width.value),
            short(self.least_squares_pv_nm),
            short(self.offset_nm)
        ));
        if let (Some(u), Some(simulated)) = (self.width.u, &self.width.simulated) {
            chapter.note(format!(
                "u = {} nm (k = 1); {} to {} nm, 95 % of {}; noise adds about {} nm. {}",
                short(u),
                short(simulated.low),
                short(simulated.high),
                simulated.covers,
                short(simulated.bias),
                of_draws(simulated)
            ));
        }
        chapter.note(format!(
            "{}, {}. Certificate: no zone near by is narrower than {} nm, which is {} nm less; all {} points were held \
             against it {} times, and these hold it:",
            self.method,
            self.termination,
            short(self.lower_nm),
            minus(format!("{:.0e}", self.gap_nm)),
            count(self.points),
            count(self.passes)
        ));
        let mut table = Table::new(&[
            ("border", Layout::Head),
            ("at, measured frame", Layout::Text),
            ("share in holding it", Layout::Number),
        ]);
        table.rows.extend(self.contacts.iter().map(|contact| {
            vec![
                contact.side.clone(),
                place(&form.fit.pose.to_measured(contact.at_mm)),
                percent(contact.share),
            ]
        }));
        chapter.table(table);
        chapter.note(definition(&self.width));
        Some(chapter)
    }

    fn figures(&self) -> &[FormFigure] {
        std::slice::from_ref(&self.width)
    }

    fn facts(&self) -> Vec<(&'static str, String)> {
        vec![("minimum zone, lower bound / nm", self.lower_nm.to_string())]
    }
}
