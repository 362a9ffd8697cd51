//! Areal surface texture.

use serde::{Deserialize, Serialize};

use super::{Standard, StandardFigure};
use crate::view::{Chapter, Layout, Table, definition, known_of, of_draws};
use crate::words::{DASH, count, percent, quantity, short};
use crate::{FormFigure, FormFigures};

/// Parameters of ISO 25178-2 of a surface between two scales.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextureFigures {
    /// Which surface: `S-F`, `S-L`, or `all wavelengths measured`.
    pub surface: String,
    /// Meaning of the heights: the deviation from the fitted nominal, less this.
    pub f_operation: String,
    /// Nesting index of the S-filter, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub s_mm: Option<f64>,
    /// Nesting index of the L-filter, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub l_mm: Option<f64>,
    /// The filters in words, with what they had to do without.
    pub filters: Vec<String>,
    /// Points that count.
    pub points: u64,
    /// Share of the area of the mesh in the aperture that is measured densely enough and counts.
    pub measured: f64,
    /// The parameters.
    pub figures: Vec<FormFigure>,
}

impl StandardFigure for TextureFigures {
    /// The scale, then the parameters.
    fn chapter(&self, _: &FormFigures) -> Option<Chapter> {
        let mut chapter = Chapter::of_standard(Standard::Texture, "Surface texture");
        let surface = match self.surface.as_str() {
            kind @ ("S-F" | "S-L") => format!("{kind} surface"),
            kind => format!("Surface of {kind}"),
        };
        let first = self.figures.iter().take(BRIEF).map(|figure| {
            format!(
                "{} {}{}",
                figure.name,
                quantity(Some(figure.value), &figure.unit),
                known_of(figure)
            )
        });
        chapter.brief.push(format!("{surface}: {}", first.collect::<Vec<_>>().join(", ")));
        chapter.note(format!(
            "{surface} of the deviation from the fitted nominal, less {}. {} points; {} of the area that is sampled densely \
             enough.",
            self.f_operation,
            count(self.points),
            percent(self.measured)
        ));
        for filter in &self.filters {
            chapter.note(format!("{filter}."));
        }
        let simulated = self.figures.iter().find_map(|figure| figure.simulated.as_ref());
        let mut columns = vec![("parameter", Layout::Head), ("value", Layout::Number)];
        if simulated.is_some() {
            columns.push(("without noise ± u (k = 1); 95 %", Layout::Number));
        }
        columns.push(("definition", Layout::Fine));
        let mut table = Table::new(&columns);
        table.rows.extend(self.figures.iter().map(|figure| {
            let mut row = vec![figure.name.clone(), quantity(Some(figure.value), &figure.unit)];
            if simulated.is_some() {
                row.push(uncertainty(figure));
            }
            row.push(definition(figure));
            row
        }));
        chapter.table(table);
        chapter.note(match simulated {
            Some(simulated) => format!(
                "Intervals cover 95 % of {}. They are of the surface without the share of noise. Those of extremes (Sp, Sv, Sz, \
                 minimum zone) include a defect of a single point that noise may hide. {}",
                simulated.covers,
                of_draws(simulated)
            ),
            None => "No uncertainty was evaluated for these.".to_owned(),
        });
        Some(chapter)
    }

    fn figures(&self) -> &[FormFigure] {
        &self.figures
    }

    fn facts(&self) -> Vec<(&'static str, String)> {
        let surface = ("texture, surface", self.surface.clone());
        let filters = self.filters.iter().map(|filter| ("texture, filter", filter.clone()));
        std::iter::once(surface).chain(filters).collect()
    }
}

fn uncertainty(figure: &FormFigure) -> String {
    match (figure.u, &figure.simulated) {
        (Some(u), Some(simulated)) => format!(
            "{} ± {}; {} to {}",
            short(simulated.without_noise),
            short(u),
            short(simulated.low),
            short(simulated.high)
        ),
        _ => DASH.to_owned(),
    }
}

/// Parameters of texture that a summary has: the first of the list, Sa, Sq and what follows.
const BRIEF: usize = 3;
