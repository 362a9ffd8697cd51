//! The HTML file: its parts in order.

use std::fmt::{Result, Write as _};

use asphera_report::standards::Standard;
use asphera_report::words::raised;
use asphera_report::{Chapter, ChapterId, FormFigures, Measured, Report, Status, View};

use super::provenance::Provenance;
use super::words::{css_string, instant, text};
use super::{blocks, charts, map, sections, spectra};

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
    let view = View::of_report(report);
    let title = title(report, provenance);
    let date = date(report, provenance);
    head(out, &title, &date)?;
    writeln!(out, "<header><h1>{}</h1>", text(&title))?;
    if let Some(form) = &report.form {
        writeln!(out, "<p class=\"nominal\">{}</p>", text(&raised(&form.nominal)))?;
    }
    writeln!(out, "<p class=\"when\">Measured {}</p></header>", text(&date))?;
    verdict(out, report.verdict.status, &view)?;
    headline(out, &view)?;
    for chapter in &view.chapters {
        match chapter.id {
            ChapterId::Deviation => {
                part(out, chapter.title, Keep::First, |out| map::figure(out, measurement))?;
                out.push_str("<section>\n");
                blocks::draw(out, &chapter.blocks)?;
                out.push_str("</section>\n");
                report.form.iter().try_for_each(|form| drawings(out, measurement, form))?;
            }
            // The mesh needs no heading of its own beside the points.
            ChapterId::Points => part(out, chapter.title, Keep::RunsOn, |out| {
                blocks::draw(out, &chapter.blocks)?;
                let mesh = view.chapter(ChapterId::Mesh);
                mesh.iter().try_for_each(|mesh| blocks::draw(out, &mesh.blocks))
            })?,
            ChapterId::Mesh => {}
            // They stand among the files and the software that the figures come from.
            ChapterId::Session => {}
            id => {
                let keep = if id == ChapterId::Zernike { Keep::Tall } else { Keep::RunsOn };
                part(out, chapter.title, keep, |out| {
                    picture(out, chapter, report)?;
                    blocks::draw(out, &chapter.blocks)
                })?;
            }
        }
    }
    part(out, "Provenance", Keep::RunsOn, |out| {
        if let Some(session) = view.chapter(ChapterId::Session) {
            blocks::draw(out, &session.blocks)?;
        }
        provenance.draw(out, report)
    })?;
    out.push_str("</body>\n</html>\n");
    Ok(())
}

/// The curve or the bars of a chapter that has some.
fn picture(out: &mut String, chapter: &Chapter, report: &Report) -> Result {
    let Some(form) = &report.form else { return Ok(()) };
    let of = &form.standards;
    match chapter.id {
        ChapterId::Standard(Standard::Psd) => {
            of.psd.iter().try_for_each(|psd| spectra::psd(out, psd))
        }
        ChapterId::Standard(Standard::QSpectrum) => {
            of.q_spectrum.iter().try_for_each(|q| spectra::q_spectrum(out, q))
        }
        ChapterId::Zernike => form.zernike.iter().try_for_each(|of| charts::zernike(out, of)),
        _ => Ok(()),
    }
}

fn drawings(out: &mut String, measurement: &dyn Measured, form: &FormFigures) -> Result {
    let range_nm = [form.deviation.min_nm, form.deviation.max_nm];
    if let Some(histogram) = &form.histogram {
        part(out, "Histogram", Keep::Together, |out| charts::histogram(out, histogram, range_nm))?;
    }
    part(out, "Sections", Keep::RunsOn, |out| sections::figures(out, measurement))?;
    if !form.rings.is_empty() {
        part(out, "Radial profile", Keep::Together, |out| charts::rings(out, &form.rings))?;
    }
    Ok(())
}

/// Where a part of the paper may break.
#[derive(Clone, Copy)]
enum Keep {
    /// Anywhere: kept together, it would leave sheets half empty.
    RunsOn,
    /// Nowhere: a drawing stays with its heading.
    Together,
    /// Nowhere, and it belongs on the first sheet.
    First,
    /// Nowhere, though it is as high as a sheet.
    Tall,
}

/// A part with its heading; nothing at all where there is nothing to show.
fn part(
    out: &mut String,
    heading: &str,
    keep: Keep,
    body: impl FnOnce(&mut String) -> Result,
) -> Result {
    let mut inside = String::new();
    body(&mut inside)?;
    if inside.is_empty() {
        return Ok(());
    }
    let class = match keep {
        Keep::RunsOn => "",
        Keep::Together => " class=\"keep\"",
        Keep::First => " class=\"keep first\"",
        Keep::Tall => " class=\"keep tall\"",
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
    let label = provenance.label_of(report);
    let what = label
        .title()
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

/// The word in large letters, with the lines of a short summary beside it.
fn verdict(out: &mut String, status: Status, view: &View) -> Result {
    let (class, sign) = match status {
        Status::Pass => ("pass", "\u{2713}"),
        Status::Fail => ("fail", "\u{2715}"),
        Status::Undecided => ("undecided", "?"),
        Status::None => ("none", "\u{2013}"),
    };
    writeln!(
        out,
        "<section class=\"verdict {class}\"><p class=\"word\"><span aria-hidden=\"true\">{sign}</span> {}</p>\n<ul>",
        status.word()
    )?;
    let lines = view.chapter(ChapterId::Verdict).map_or(&[][..], |chapter| &chapter.brief);
    // The first of them is the word.
    lines.iter().skip(1).try_for_each(|line| writeln!(out, "<li>{}</li>", text(line)))?;
    out.push_str("</ul></section>\n");
    Ok(())
}

fn headline(out: &mut String, view: &View) -> Result {
    out.push_str("<section class=\"cards\">\n");
    for fact in &view.headline {
        writeln!(
            out,
            "<div><p class=\"name\">{}</p><p class=\"value\">{}</p><p class=\"note\">{}</p></div>",
            text(&fact.name),
            text(&fact.value),
            text(fact.note.as_deref().unwrap_or_default())
        )?;
    }
    out.push_str("</section>\n");
    Ok(())
}
