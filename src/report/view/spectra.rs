//! Spectra in words; fronts draw their curves.

use super::{Chapter, ChapterId};
use crate::words::{percent, short};
use crate::{PsdFigures, QFigures, StandardFigures};

/// The chapters of the spectra that there are.
pub(super) fn chapters(of: &StandardFigures) -> Vec<Chapter> {
    of.psd.iter().map(psd).chain(of.q_spectrum.iter().map(q_spectrum)).collect()
}

fn psd(psd: &PsdFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Psd, "Power spectral density");
    let noise = psd.noise_nm2_mm2.map_or(String::new(), |noise| {
        format!(
            " Of the density, {} nm²·mm² at every frequency are noise of the points.",
            short(noise)
        )
    });
    chapter.note(format!(
        "Power spectral density: {}; {}. Taken out before: {}. {} window; {} of the rectangle of the map is measured, nodes \
         {} × {} mm apart. Given up to {} cycles per mm. RMS {} nm.{noise}",
        psd.definition,
        psd.source,
        psd.removed,
        psd.window,
        percent(psd.measured),
        short(psd.spacing_mm[0]),
        short(psd.spacing_mm[1]),
        short(psd.up_to_per_mm),
        short(psd.rms_nm),
    ));
    chapter
}

fn q_spectrum(q: &QFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::QSpectrum, "Slope spectrum");
    let note = q.note.as_ref().map_or(String::new(), |note| format!(" {note}."));
    let end = if q.ends {
        ""
    } else {
        " The series does not end here: the deviation has more waves along the radius than these terms can follow, and \
         that changes all of them. Set a larger q_terms in the table [figures] of the nominal."
    };
    chapter.note(format!(
        "Q spectrum: {}. Radius {} mm, power {} nm. {}{note}{end}",
        q.definition,
        short(q.radius_mm),
        short(q.power_nm),
        slope(q),
    ));
    chapter
}

/// The RMS slope with what noise does to it, and whence the noise is.
fn slope(q: &QFigures) -> String {
    let by = if q.noise_of_residuals { "what the series leaves" } else { "noise of the points" };
    let taken = format!("Lines: standard uncertainties by {by}, {} nm.", short(q.noise_nm));
    match (q.slope_rms_urad, q.slope_95_urad) {
        (Some(slope), Some([low, high])) => format!(
            "RMS slope of the series {} µrad (95 %: {} to {} µrad), {} µrad of noise taken off. {taken}",
            short(slope),
            short(low),
            short(high),
            short(q.slope_noise_urad)
        ),
        _ => format!("RMS slope of the series not known: noise makes terms too uncertain. {taken}"),
    }
}
