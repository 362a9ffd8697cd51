//! The tables: figures, fit, sampling, points, links, provenance.

use std::collections::BTreeMap;
use std::fmt::{Result, Write as _};

use asphera_report::{FitFigures, FormFigure, FormFigures, LinkFigures, Report, SamplingFigures};

use super::errors;
use super::provenance::Provenance;
use super::words::{count, minus, percent, place, short, short_or_dash, text, with_u};

/// The figures of standards and optical shops, those with terms removed in a table of their own.
pub(super) fn figures(out: &mut String, form: &FormFigures) -> Result {
    let (removed, whole): (Vec<&FormFigure>, Vec<&FormFigure>) =
        form.figures.iter().partition(|figure| !figure.removed.is_empty());
    let evaluated = whole.iter().any(|figure| {
        figure.u.is_some() || figure.expanded.is_some() || figure.noise_adds.is_some()
    });
    writeln!(
        out,
        "<table class=\"wide\"><thead><tr><th>figure</th><th>of</th><th class=\"n\">value</th>{}\
         <th>definition</th></tr></thead><tbody>",
        if evaluated { "<th class=\"n\">uncertainty</th>" } else { "" }
    )?;
    for figure in whole {
        writeln!(
            out,
            "<tr><th>{}</th><td>{}</td><td class=\"n\">{} {}</td>{}\
             <td class=\"small\">{} <i>({})</i></td></tr>",
            text(&figure.name),
            text(&figure.variant),
            short(figure.value),
            text(&figure.unit),
            if evaluated {
                format!("<td class=\"n\">{}</td>", uncertainty(figure))
            } else {
                String::new()
            },
            text(&figure.definition),
            text(&figure.source)
        )?;
    }
    out.push_str("</tbody></table>\n");
    if !evaluated {
        out.push_str("<p class=\"note\">No uncertainty was evaluated for these figures.</p>\n");
    }
    errors::of_figures(out, form)?;
    if !removed.is_empty() {
        remainders(out, &removed)?;
    }
    for why in &form.unknown {
        writeln!(out, "<p class=\"note\">Not known: {}.</p>", text(why))?;
    }
    Ok(())
}

fn uncertainty(figure: &FormFigure) -> String {
    match (&figure.expanded, figure.u) {
        (Some(expanded), _) => format!(
            "U = {} {} (k = {:.2}, p = {})",
            short(expanded.value),
            text(&figure.unit),
            expanded.k,
            percent(expanded.p)
        ),
        (None, Some(u)) => format!("u = {} {} (k = 1)", short(u), text(&figure.unit)),
        (None, None) => match (figure.without_noise, figure.noise_adds) {
            (Some(without), _) => {
                format!("without noise {} {}", short(without), text(&figure.unit))
            }
            (None, Some(adds)) => {
                format!("noise adds at most {} {}", short(adds), text(&figure.unit))
            }
            (None, None) => "not evaluated".to_owned(),
        },
    }
}

/// One row a set of terms removed.
fn remainders(out: &mut String, figures: &[&FormFigure]) -> Result {
    let mut sets: Vec<&[String]> = figures.iter().map(|figure| &figure.removed[..]).collect();
    sets.dedup();
    let mut columns: Vec<(&str, &str)> = Vec::new();
    for figure in figures {
        if !columns.iter().any(|(id, _)| *id == figure.id) {
            columns.push((&figure.id, &figure.name));
        }
    }
    out.push_str("<h3>With terms removed</h3>\n<table><thead><tr><th>removed</th>");
    for (_, name) in &columns {
        write!(out, "<th class=\"n\">{}</th>", text(name))?;
    }
    out.push_str("</tr></thead><tbody>\n");
    for set in sets {
        write!(out, "<tr><th>{}</th>", text(&set.join(", ")))?;
        for (id, _) in &columns {
            let found = figures.iter().find(|figure| figure.removed == set && figure.id == *id);
            match found {
                Some(figure) => write!(
                    out,
                    "<td class=\"n\">{} {}</td>",
                    short(figure.value),
                    text(&figure.unit)
                )?,
                None => out.push_str("<td class=\"n\">–</td>"),
            }
        }
        out.push_str("</tr>\n");
    }
    out.push_str(
        "</tbody></table>\n<p class=\"note\">Fringe terms over the aperture, fitted together and \
         subtracted. The verdict is by these only where a limit names them.</p>\n",
    );
    Ok(())
}

/// How the nominal was laid into the points.
pub(super) fn fit(out: &mut String, FormFigures { fit, origin, .. }: &FormFigures) -> Result {
    writeln!(
        out,
        "<p>{}; {}, after {} steps. Free: {}.</p>",
        text(&fit.method),
        text(&fit.termination),
        fit.iterations,
        list(&fit.free, "nothing")
    )?;
    criterion(out, fit)?;
    if !fit.indeterminate.is_empty() {
        writeln!(
            out,
            "<p>Not determined by the points, and left at their start: <b>{}</b>.</p>",
            list(&fit.indeterminate, "")
        )?;
    }
    errors::of_fit(out, &fit.details)?;
    if !fit.parameters.is_empty() {
        out.push_str(
            "<table><thead><tr><th>parameter</th><th class=\"n\">value ± u (k = 1)</th><th>unit</th>\
             </tr></thead><tbody>\n",
        );
        for (name, parameter) in &fit.parameters {
            writeln!(
                out,
                "<tr><th>{}</th><td class=\"n\">{}</td><td>{}</td></tr>",
                text(name),
                with_u(parameter.value, parameter.u),
                text(&parameter.unit)
            )?;
        }
        out.push_str("</tbody></table>\n");
        errors::of_parameters(out, fit)?;
    }
    let pose = &fit.pose;
    if let Some(origin) = origin {
        writeln!(
            out,
            "<p>Places of the part, rings, Zernike terms and slopes along the meridian count from the {}, at {} of the \
             measured frame.</p>",
            text(&origin.place),
            place(&origin.at_mm)
        )?;
    }
    writeln!(
        out,
        "<p class=\"note\">Pose of the part in the measured frame, p′ = Rz·Ry·Rx·p + t: t {}, \
         R ({}, {}, {}) rad.</p>",
        minus(format!("({:.6}, {:.6}, {:.6}) mm", pose.tx_mm, pose.ty_mm, pose.tz_mm)),
        minus(format!("{:.3e}", pose.rx_rad)),
        minus(format!("{:.3e}", pose.ry_rad)),
        minus(format!("{:.3e}", pose.rz_rad)),
    )
}

/// How points were counted, where that is not alike and by squares.
fn criterion(out: &mut String, fit: &FitFigures) -> Result {
    if let Some(loss) = &fit.loss {
        writeln!(
            out,
            "<p>Loss: {}, threshold {} nm ({}), at a scale of {} nm; {} points count by less than half their weight, \
             {} of them not at all.</p>",
            text(&loss.name),
            short(loss.threshold_nm),
            if loss.threshold_given { "given" } else { "found from the deviations" },
            short(loss.scale_nm),
            count(loss.below_half),
            count(loss.left_out)
        )?;
    }
    if let Some(weights) = &fit.weights {
        writeln!(
            out,
            "<p>Weights: 1/u², with u along the normal from {} to {} nm; reduced χ² {}.</p>",
            short(weights.u_min_nm),
            short(weights.u_max_nm),
            short_or_dash(weights.reduced_chi_square, "")
        )?;
    }
    if let Some(points) = fit.effective_points {
        writeln!(out, "<p>They count as {points:.0} points of equal weight would.</p>")?;
    }
    Ok(())
}

/// The surface that was made from the points, where no design is known.
pub(super) fn reference(out: &mut String, form: &FormFigures) -> Result {
    if let Some(reference) = &form.reference {
        let [nx, ny] = reference.cells;
        let rows = [
            ("base under the splines", text(&reference.base)),
            ("RMS from the base alone", format!("{} nm", short(reference.base_rms_nm))),
            ("cells of the splines", format!("{nx} × {ny}")),
            (
                "distance of the knots",
                format!("{} mm", short(reference.knots_mm[0].max(reference.knots_mm[1]))),
            ),
            ("smoothing", format!("{}, λ {}", text(&reference.smoothing), short(reference.lambda))),
            ("effective parameters", format!("{:.0}", reference.effective_parameters)),
            ("half followed: waves of", format!("{} mm", short(reference.follows_mm))),
            ("noise left", short_or_dash(reference.noise_nm, "nm")),
        ];
        pairs(out, &rows)?;
    }
    Ok(())
}

/// Whether the points lie densely enough, and what to measure next.
pub(super) fn sampling(out: &mut String, sampling: &SamplingFigures) -> Result {
    let source = sampling.lfs_source.as_deref().unwrap_or("not known");
    let mut rows = vec![
        ("coverage of the aperture", sampling.coverage.map_or("–".to_owned(), percent)),
        ("scanned too coarsely", short_or_dash(sampling.undersampled_area_mm2, "mm²")),
        ("not scanned", short_or_dash(sampling.uncovered_area_mm2, "mm²")),
        ("largest gap", short_or_dash(sampling.gap_max_mm, "mm")),
        ("gap, 99 % of the area up to", short_or_dash(sampling.gap_p99_mm, "mm")),
        ("gap allowed", short_or_dash(sampling.gap_limit_mm, "mm")),
        ("largest ε", short_or_dash(sampling.epsilon_max, "")),
        ("ε, 99 % of the area up to", short_or_dash(sampling.epsilon_p99, "")),
        ("ε allowed", short_or_dash(sampling.epsilon_target, "")),
    ];
    if let Some(allowed) = sampling.rho_target {
        rows.extend([
            ("largest ρ", short_or_dash(sampling.rho_max, "")),
            ("ρ allowed", short(allowed)),
            ("reach", short_or_dash(sampling.reach_mm, "mm")),
        ]);
    }
    rows.extend([
        ("smallest local feature size", short_or_dash(sampling.lfs_min_mm, "mm")),
        ("its source", text(source)),
        ("noise from point to point", short_or_dash(sampling.noise_sigma_nm, "nm")),
        ("median spacing", short_or_dash(sampling.spacing_median_mm, "mm")),
        ("recommended spacing", short_or_dash(sampling.spacing_recommended_mm, "mm")),
        (
            "denser than the noise allows",
            sampling.overdense_fraction.map_or("–".to_owned(), percent),
        ),
        ("islands, holes", format!("{}, {}", whole(sampling.islands), whole(sampling.holes))),
    ]);
    pairs(out, &rows)?;
    for why in &sampling.unknown {
        writeln!(out, "<p class=\"note\">Not known: {}.</p>", text(why))?;
    }
    if sampling.next.is_empty() {
        return Ok(());
    }
    out.push_str(
        "<h3>To measure next</h3>\n<table><thead><tr><th></th><th class=\"n\">area</th>\
         <th>about</th><th class=\"n\">adds to the coverage</th><th class=\"n\">largest ε</th>\
         <th class=\"n\">spacing needed</th><th class=\"n\">points</th></tr></thead><tbody>\n",
    );
    for (number, next) in (1..).zip(&sampling.next).take(NEXT_SHOWN) {
        writeln!(
            out,
            "<tr><th>{number}</th><td class=\"n\">{} mm²</td><td>{}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            short(next.area_mm2),
            place(&next.at_mm),
            next.adds_coverage.map_or("–".to_owned(), percent),
            short_or_dash(next.epsilon_max, ""),
            short_or_dash(next.spacing_needed_mm, "mm"),
            whole(next.points_needed)
        )?;
    }
    out.push_str("</tbody></table>\n");
    let more = sampling.next.len().saturating_sub(NEXT_SHOWN) as u64 + sampling.next_more;
    if more > 0 {
        writeln!(out, "<p class=\"note\">And {} smaller regions.</p>", count(more))?;
    }
    Ok(())
}

/// Fate of the points, and what the mesh is like.
pub(super) fn points(out: &mut String, report: &Report) -> Result {
    let points = &report.points;
    let mut rows = vec![
        ("received".to_owned(), count(points.received)),
        ("used".to_owned(), count(points.used)),
    ];
    let reason = |name: &str| format!("not used: {}", text(&name.replace('_', " ")));
    rows.extend(points.flagged.iter().map(|(name, number)| (reason(name), count(*number))));
    rows.push(("duplicates".to_owned(), count(points.duplicates)));
    rows.push(("lost triggers".to_owned(), count(points.lost)));
    rows.push(("triangles".to_owned(), count(report.mesh.triangles)));
    rows.push(("area of the mesh".to_owned(), short_or_dash(report.mesh.area_mm2, "mm²")));
    let relief = &report.mesh.relief;
    rows.push((
        "folds, walls, spikes".to_owned(),
        format!("{}, {}, {}", relief.folds.len(), relief.walls, relief.spikes),
    ));
    if let Some(projection) = &report.mesh.projection {
        rows.push(("plane of projection".to_owned(), text(&projection.to_string())));
    }
    let rows: Vec<(&str, String)> =
        rows.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    pairs(out, &rows)
}

/// Bytes and readings of each link and device, delivered and lost.
pub(super) fn links(out: &mut String, links: &[LinkFigures]) -> Result {
    out.push_str(
        "<table class=\"wide\"><thead><tr><th>device</th><th>link</th><th class=\"n\">readings</th>\
         <th class=\"n\">lost</th><th class=\"n\">unjoined</th><th>flags and faults</th>\
         <th>channels: mean (smallest to largest)</th></tr></thead><tbody>\n",
    );
    for link in links {
        for device in &link.devices {
            let mut flags: Vec<String> = named(&device.flagged);
            flags.extend(named(&device.faults));
            let channels = device.channels.iter().map(|(name, channel)| {
                format!(
                    "{} {} {} ({} to {})",
                    text(name),
                    short(channel.mean),
                    text(&channel.unit),
                    short(channel.min),
                    short(channel.max)
                )
            });
            writeln!(
                out,
                "<tr><th>{}</th><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{}</td><td>{}</td><td class=\"small\">{}</td></tr>",
                text(&device.name),
                text(&link.name),
                count(device.readings),
                count(device.lost),
                count(device.unjoined),
                if flags.is_empty() { "none".to_owned() } else { flags.join(", ") },
                channels.collect::<Vec<_>>().join("; ")
            )?;
        }
        writeln!(
            out,
            "<tr class=\"sum\"><th></th><td>{}</td><td colspan=\"5\" class=\"small\">{} bytes received, {} \
             discarded; opened {} times, lost {} times</td></tr>",
            text(&link.name),
            count(link.received_bytes),
            count(link.discarded_bytes),
            link.opened,
            link.closed
        )?;
    }
    out.push_str("</tbody></table>\n");
    Ok(())
}

/// Files, software, command.
pub(super) fn provenance(out: &mut String, report: &Report, provenance: &Provenance) -> Result {
    let mut rows: Vec<(&str, String)> = Vec::new();
    if let Some(session) = &report.session {
        rows.push(("session", text(&session.id)));
        rows.push(("station", text(&session.station)));
        rows.extend(session.label.entries().map(|(name, entry)| (name, text(entry))));
        rows.push(("began", text(&session.started)));
        rows.push(("ended", text(&session.ended)));
        rows.push(("recorded by", format!("asphera {}", text(&session.version))));
    }
    if let Some(instrument) = &provenance.instrument {
        rows.push(("instrument", text(instrument)));
    }
    rows.push(("evaluated by", text(&Provenance::software())));
    rows.push(("command", format!("<code>{}</code>", text(&provenance.command))));
    rows.push(("layout of the figures", text(&report.format)));
    for (name, value) in rows {
        writeln!(out, "<p class=\"origin\"><span>{name}</span> {value}</p>")?;
    }
    if provenance.files.is_empty() {
        return Ok(());
    }
    out.push_str(
        "<table class=\"wide\"><thead><tr><th>file</th><th class=\"n\">bytes</th><th>SHA-256</th></tr>\
         </thead><tbody>\n",
    );
    for file in &provenance.files {
        writeln!(
            out,
            "<tr><td>{}</td><td class=\"n\">{}</td><td><code class=\"hash\">{}</code></td></tr>",
            text(&file.name),
            count(file.bytes),
            text(&file.sha256)
        )?;
    }
    out.push_str("</tbody></table>\n");
    Ok(())
}

/// Names, already escaped or ours, with values that are escaped; many in two columns.
fn pairs(out: &mut String, rows: &[(&str, String)]) -> Result {
    let halves = if rows.len() < 8 { rows.len().max(1) } else { rows.len().div_ceil(2) };
    out.push_str("<div class=\"columns\">\n");
    for half in rows.chunks(halves) {
        out.push_str("<table class=\"pairs\"><tbody>\n");
        for (name, value) in half {
            writeln!(out, "<tr><th>{name}</th><td>{value}</td></tr>")?;
        }
        out.push_str("</tbody></table>\n");
    }
    out.push_str("</div>\n");
    Ok(())
}

fn named(counts: &BTreeMap<String, u64>) -> Vec<String> {
    counts
        .iter()
        .map(|(name, number)| format!("{} {}", count(*number), text(&name.replace('_', " "))))
        .collect()
}

fn whole(number: Option<u64>) -> String {
    number.map_or_else(|| "–".to_owned(), count)
}

fn list(names: &[String], none: &str) -> String {
    if names.is_empty() {
        return none.to_owned();
    }
    text(&names.join(", "))
}

/// Regions that are listed.
const NEXT_SHOWN: usize = 8;
