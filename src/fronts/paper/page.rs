//! The HTML file: its parts in order.

use std::fmt::{Result, Write as _};

use asphera_report::{FormFigures, Measured, Report, Status, Verdict};

use super::provenance::Provenance;
use super::words::{css_string, instant, percent, place, short, text, with_u};
use super::{charts, defects, map, sections, spectra, standards, tables};

/// A measurement as one HTML file: style, drawings and pictures inside, no script, nothing from elsewhere.
///
/// It is well-formed XML too. The same arguments give the same bytes. Takes time in proportion to the nodes
/// of the map and to the triangles two sections meet.
pub fn html(measurement: &dyn Measured, provenance: &Provenance) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = write(&mut out, measurement, provenance);
    out
}

fn write(out: &mut String, measurement: &dyn Measured, provenance: &Provenance) -> Result {
    let report = measurement.report();
    let title = title(report, provenance);
    let date = date(report, provenance);
    head(out, &title, &date)?;
    writeln!(out, "<header><h1>{}</h1>", text(&title))?;
    if let Some(form) = &report.form {
        writeln!(out, "<p class=\"nominal\">{}</p>", text(&form.nominal))?;
    }
    writeln!(out, "<p class=\"when\">Measured {}</p></header>", text(&date))?;
    verdict(out, &report.verdict)?;
    key_figures(out, report)?;
    part(out, "Deviation", |out| map::figure(out, measurement))?;
    if let Some(form) = &report.form {
        drawings(out, measurement, form)?;
        part(out, FIGURES, |out| {
            form.standards.indication.iter().try_for_each(|of| standards::indication(out, of))?;
            tables::figures(out, form)
        })?;
        further(out, form)?;
        part(out, "Fit", |out| {
            tables::fit(out, form)?;
            tables::reference(out, form)
        })?;
        if let Some(zernike) = &form.zernike {
            part(out, "Zernike terms", |out| {
                writeln!(
                    out,
                    "<p class=\"note\">{} order, {}, over a disc of {} mm radius about the origin; fitted \
                     together. They leave an RMS of {} nm.</p>",
                    text(&zernike.scheme),
                    text(&zernike.normalisation),
                    short(zernike.radius_mm),
                    short(zernike.residual_rms_nm)
                )?;
                charts::zernike(out, zernike)?;
                if !zernike.indeterminate.is_empty() {
                    let numbers: Vec<String> =
                        zernike.indeterminate.iter().map(ToString::to_string).collect();
                    writeln!(
                        out,
                        "<p class=\"note\">Not told from lower ones by these places: {}.</p>",
                        numbers.join(", ")
                    )?;
                }
                Ok(())
            })?;
        }
    }
    part(out, "Sampling", |out| tables::sampling(out, &report.sampling))?;
    part(out, "Defects", |out| defects::features(out, &report.features))?;
    part(out, "Points", |out| tables::points(out, report))?;
    if !report.links.is_empty() {
        part(out, "Links and devices", |out| tables::links(out, &report.links))?;
    }
    part(out, "Provenance", |out| tables::provenance(out, report, provenance))?;
    out.push_str("</body>\n</html>\n");
    Ok(())
}

/// Minimum zone, texture and spectra, those there are.
fn further(out: &mut String, form: &FormFigures) -> Result {
    let of = &form.standards;
    if let Some(zone) = &of.minimum_zone {
        part(out, "Minimum zone", |out| standards::minimum_zone(out, zone, &form.fit.pose))?;
    }
    if let Some(texture) = &of.texture {
        part(out, "Surface texture", |out| standards::texture(out, texture))?;
    }
    part(out, "Spectra", |out| {
        of.psd.iter().try_for_each(|psd| spectra::psd(out, psd))?;
        of.q_spectrum.iter().try_for_each(|q| spectra::q_spectrum(out, q))
    })
}

fn drawings(out: &mut String, measurement: &dyn Measured, form: &FormFigures) -> Result {
    let pv_limit_nm = measurement.report().verdict.pv_limit_nm();
    let range_nm = [form.deviation.min_nm, form.deviation.max_nm];
    if let Some(histogram) = &form.histogram {
        part(out, "Histogram", |out| charts::histogram(out, histogram, pv_limit_nm, range_nm))?;
    }
    part(out, "Sections", |out| sections::figures(out, measurement))?;
    if !form.rings.is_empty() {
        part(out, "Radial profile", |out| charts::rings(out, &form.rings))?;
    }
    Ok(())
}

/// A part with its heading; nothing at all where there is nothing to show.
fn part(out: &mut String, heading: &str, body: impl FnOnce(&mut String) -> Result) -> Result {
    let mut inside = String::new();
    body(&mut inside)?;
    if inside.is_empty() {
        return Ok(());
    }
    // The map belongs on the first sheet; a part that is one drawing stays with its heading. All else may run on: kept together, it
    // would leave sheets half empty.
    let class = match heading {
        "Deviation" => " class=\"keep first\"",
        "Zernike terms" => " class=\"keep tall\"",
        "Histogram" | "Radial profile" => " class=\"keep\"",
        _ => "",
    };
    writeln!(out, "<section{class}>\n<h2>{}</h2>\n{inside}</section>", text(heading))
}

fn head(out: &mut String, title: &str, date: &str) -> Result {
    out.push_str(
        "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n\
         <meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n",
    );
    writeln!(out, "<title>{}</title>", text(title))?;
    writeln!(out, "<meta name=\"generator\" content=\"{}\"/>", text(&Provenance::software()))?;
    writeln!(out, "<style>\n{}", include_str!("style.css"))?;
    // What stands on every printed sheet (CSS Paged Media 3, margin boxes).
    writeln!(
        out,
        "@page {{ @top-left {{ content: {} }} @top-right {{ content: {} }} @bottom-left {{ content: {} }} }}",
        css_string(title),
        css_string(date),
        css_string(&Provenance::software())
    )?;
    out.push_str("</style>\n</head>\n<body>\n");
    Ok(())
}

/// Part, as whoever asks for the paper or who started the session named it; station or file.
fn title(report: &Report, provenance: &Provenance) -> String {
    let what = provenance
        .part
        .clone()
        .or_else(|| report.session.as_ref().and_then(|session| session.label.title()))
        .or_else(|| report.session.as_ref().map(|session| session.station.clone()))
        .or_else(|| provenance.files.first().map(|file| file.name.clone()));
    match what {
        Some(what) => format!("Form deviation: {what}"),
        None => "Form deviation".to_owned(),
    }
}

/// When it was measured: never today's date.
fn date(report: &Report, provenance: &Provenance) -> String {
    let started = report.session.as_ref().map(|session| session.started.as_str());
    let stated = started.or(provenance.date.as_deref());
    stated.map_or_else(|| "at a date not stated".to_owned(), instant)
}

fn verdict(out: &mut String, verdict: &Verdict) -> Result {
    let (class, sign, word) = match verdict.status {
        Status::Pass => ("pass", "\u{2713}", "PASS"),
        Status::Fail => ("fail", "\u{2715}", "FAIL"),
        Status::Undecided => ("undecided", "?", "UNDECIDED"),
        Status::None => ("none", "\u{2013}", "NO LIMITS"),
    };
    writeln!(
        out,
        "<section class=\"verdict {class}\"><p class=\"word\"><span aria-hidden=\"true\">{sign}</span> {word}</p>\n<ul>"
    )?;
    for check in &verdict.checks {
        let (name, unit) = (text(&check.figure.words()), text(&check.figure.unit));
        let u = check.u.map_or(String::new(), |u| format!(" (u {} {unit})", short(u)));
        let doubt = match &check.doubt {
            Some(doubt) => format!(", not proven: {}", text(doubt)),
            None => String::new(),
        };
        writeln!(
            out,
            "<li>{name} {} {unit} {} {} {unit} allowed{u}{doubt}</li>",
            short(check.value),
            if check.value <= check.limit { "\u{2264}" } else { "&gt;" },
            short(check.limit),
        )?;
    }
    for reason in &verdict.reasons {
        writeln!(out, "<li>{}</li>", text(reason))?;
    }
    out.push_str("</ul></section>\n");
    Ok(())
}

fn key_figures(out: &mut String, report: &Report) -> Result {
    let mut cards: Vec<(&str, String, String)> = Vec::new();
    if let Some(form) = &report.form {
        let deviation = &form.deviation;
        let known = deviation.uncertainty.as_ref();
        let about = |nm: f64, u_nm: Option<f64>| match u_nm.filter(|u_nm| *u_nm > 1e-9) {
            Some(u_nm) => format!("{} nm", with_u(nm, Some(2.0 * u_nm))),
            None => format!("{} nm", short(nm)),
        };
        let model = known.map_or(String::new(), |known| {
            let bound = if known.pv_at_most { ", of PV an upper bound" } else { "" };
            format!("; \u{b1} k = 2, {}{bound}", known.model)
        });
        cards.push((
            "PV",
            about(deviation.pv_nm, known.map(|known| known.u_pv_nm)),
            format!(
                "{} nm at {} to {} nm at {}",
                short(deviation.min_nm),
                place(&form.fit.pose.to_measured(deviation.at_min_mm)),
                short(deviation.max_nm),
                place(&form.fit.pose.to_measured(deviation.at_max_mm))
            ),
        ));
        cards.push((
            "RMS",
            about(deviation.rms_nm, known.map(|known| known.u_rms_nm)),
            format!("about the nominal, over the points used{model}"),
        ));
    }
    let coverage = report.sampling.coverage.map_or_else(|| "not known".to_owned(), percent);
    cards.push(("Coverage", coverage, "of the aperture sampled densely enough".to_owned()));
    out.push_str("<section class=\"cards\">\n");
    for (name, value, note) in cards {
        writeln!(
            out,
            "<div><p class=\"name\">{name}</p><p class=\"value\">{}</p><p class=\"note\">{}</p></div>",
            text(&value),
            text(&note)
        )?;
    }
    out.push_str("</section>\n");
    Ok(())
}

const FIGURES: &str = "Figures";
