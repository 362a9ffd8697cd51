//! The face of a volume in words.

use super::{Chapter, ChapterId, Fact};
use crate::words::{count, percent, short, with_u};
use crate::{FaceFigures, FacesFigures, ParameterFigures, SecondFigures};

pub(super) fn chapter(face: &FaceFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Volume, "Volume");
    let [x, y, z] = face.size.map(count);
    let size = format!("{x} × {y} × {z} samples");
    let [a, b, c] = face.spacing_mm.map(|mm| short(1e3 * mm));
    let spacing =
        if a == b && b == c { format!("{a} µm") } else { format!("{a} × {b} × {c} µm") };
    let levels = format!("{} and {}", short(face.background), short(face.material));
    let source = match face.threshold_source.as_str() {
        "halfway" => format!("halfway between {levels}"),
        _ => format!("stated, between {levels}"),
    };
    let threshold = format!("{}, {source}", short(face.threshold));
    let blur = format!("{} µm", short(face.blur_um));
    chapter.brief.push(format!("{size}, {spacing} apart; threshold {threshold}; blur {blur}"));
    chapter.brief.push(format!(
        "u of a point: {} nm by noise over {} mm, {} nm by uneven levels, {} nm of the whole face by the threshold",
        short(face.u_noise_nm),
        short(face.noise_length_mm),
        short(face.u_uneven_nm),
        short(face.u_shift_nm)
    ));
    let mut facts = vec![
        Fact::new("Samples", size),
        Fact::new("Spacing", spacing),
        Fact::new("Threshold", threshold),
        Fact::new("Points of the face", count(face.points)),
        Fact::new("Aperture filled", percent(face.filled)),
        Fact::new("Blur of the edge", blur).noted("standard deviation, smoothing included"),
        Fact::new("Smoothed by", format!("{} µm", short(1e3 * face.smoothing_mm))),
    ];
    facts.extend(errors(face));
    for (number, what) in [
        (face.apart, "apart from it"),
        (face.steep, "steeper than 30°"),
        (face.on_border, "on the border of the aperture"),
    ] {
        if number > 0 {
            facts.push(Fact::new(format!("Points {what}, left out"), count(number)));
        }
    }
    chapter.facts(facts);
    chapter.note(
        "Neighbouring points share errors: blur and smoothing spread the noise of a sample over its correlation length. Errors of the \
         spacing are not included; [uncertainty] scale_x_ppm and so on add them.",
    );
    // Seen on the simulated lens: docs/volumes.md.
    chapter.note(
        "The interval of the RMS covers these errors alone. Blur flattens form, which is taken back; of waves shorter than some 15 \
         spacings part of it stays, and no u counts that.",
    );
    for reason in &face.reasons {
        chapter.brief.push(reason.clone());
        chapter.note(format!("{reason}."));
    }
    if let Some(second) = &face.second {
        add_second(&mut chapter, second);
    }
    chapter
}

/// Errors of the points.
fn errors(face: &FaceFigures) -> [Fact; 4] {
    let nm = |value: f64| format!("{} nm", short(value));
    [
        Fact::new("u by the threshold", nm(face.u_shift_nm)).noted(format!(
            "moves the whole face; u of the threshold {}, {}",
            short(face.u_threshold),
            face.u_threshold_source
        )),
        Fact::new("u by uneven levels", nm(face.u_uneven_nm))
            .noted(format!("correlated over {} mm", short(face.uneven_length_mm))),
        Fact::new("u by noise", nm(face.u_noise_nm))
            .noted(format!("of each point, correlated over {} mm", short(face.noise_length_mm))),
        Fact::new("Corrected for curvature", nm(face.curvature_correction_nm))
            .noted("at most; blur moves the edge of a curved face towards its centre of curvature"),
    ]
}

fn add_second(chapter: &mut Chapter, second: &SecondFigures) {
    let form = match &second.report.form {
        Some(form) => {
            let deviation = &form.deviation;
            let u_nm = deviation.uncertainty.as_ref().map(|known| known.u_rms_nm);
            let rms = u_nm.map_or_else(
                || short(deviation.rms_nm),
                |u_nm| with_u(deviation.rms_nm, Some(u_nm)),
            );
            format!("PV {} nm, RMS {rms} nm", short(deviation.pv_nm))
        }
        None => "no form".to_owned(),
    };
    let told = format!("{form}; {}", second.report.verdict.status.word());
    chapter.brief.push(format!("second face: {told}"));
    chapter.facts(vec![Fact::new("Second face", told)]);
    match &second.lies {
        Some(lies) => add_faces(chapter, lies),
        None => chapter.note("Thickness is unknown: one of the two faces has no fit."),
    }
}

fn add_faces(chapter: &mut Chapter, lies: &FacesFigures) {
    let told = |of: &ParameterFigures| format!("{} {}", with_u(of.value, of.u), of.unit);
    let figures = [
        ("Centre thickness", Some(&lies.centre_thickness)),
        ("Wedge", lies.wedge.as_ref()),
        ("Tilt of the axes", lies.tilt.as_ref()),
        ("Decentre", lies.decentre.as_ref()),
    ];
    let known = figures.into_iter().filter_map(|(name, of)| Some((name, told(of?))));
    let known: Vec<(&str, String)> = known.collect();
    let line: Vec<String> =
        known.iter().map(|(name, told)| format!("{} {told}", name.to_lowercase())).collect();
    chapter.brief.push(line.join(", "));
    let mut facts: Vec<Fact> =
        known.into_iter().map(|(name, told)| Fact::new(name, told)).collect();
    if let Some(first) = facts.first_mut() {
        *first = first.clone().noted(format!("along the {}", lies.along));
    }
    chapter.facts(facts);
    for why in &lies.unknown {
        chapter.note(format!("Unknown: {why}."));
    }
}
