//! What stands off the surface, and which way it bends.

use std::fmt::{Result, Write as _};

use asphera_report::FeatureFigures;

use super::words::{count, percent, place, short, short_or_dash, text};

/// Defects, the most significant first, and the partition by curvature; nothing where neither was looked for.
pub(super) fn features(out: &mut String, features: &FeatureFigures) -> Result {
    if let Some(why) = &features.defects_unknown {
        writeln!(out, "<p class=\"note\">Defects were not looked for: {}.</p>", text(why))?;
    }
    match features.defects.as_deref() {
        None => {}
        Some([]) => out.push_str("<p>No defect was found.</p>\n"),
        Some(_) => table(out, features)?,
    }
    if let Some(search) = &features.defects_search {
        writeln!(
            out,
            "<p class=\"note\">Against a smooth surface through the {}, in windows of {} mm, up to {} mm wide; \
             threshold {} times a noise of {} nm, {} false ones expected; {} lower than {} nm not listed.</p>",
            if search.reference == "nominal" { "deviation from the nominal" } else { "points" },
            short(search.window_mm),
            short(search.largest_mm),
            short(search.threshold_sigmas),
            short(search.sigma_nm),
            short(search.false_expected),
            count(search.lower),
            short(search.min_height_nm)
        )?;
    }
    if let Some(partition) = &features.partition {
        let shares: Vec<String> = partition
            .shares
            .iter()
            .map(|(class, share)| format!("{} {}", text(class), percent(*share)))
            .collect();
        writeln!(out, "<p>By curvature: {}.</p>", shares.join(", "))?;
    }
    if let Some(why) = &features.partition_unknown {
        writeln!(out, "<p class=\"note\">Curvature is not known: {}.</p>", text(why))?;
    }
    Ok(())
}

fn table(out: &mut String, features: &FeatureFigures) -> Result {
    out.push_str(
        "<table><thead><tr><th></th><th>kind</th><th>about, measured frame</th><th class=\"n\">height ± u</th>\
         <th class=\"n\">area</th><th class=\"n\">length</th><th class=\"n\">width</th>\
         <th class=\"n\">significance</th></tr></thead><tbody>\n",
    );
    let defects = features.defects.as_deref().unwrap_or_default();
    for (number, defect) in (1..).zip(defects).take(SHOWN) {
        writeln!(
            out,
            "<tr><th>{number}</th><td>{}, {}</td><td>{}</td><td class=\"n\">{} ± {} nm</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            text(&defect.kind),
            text(&defect.shape),
            place(&defect.at_mm),
            short(defect.height_nm),
            short(defect.height_u_nm),
            short_or_dash(defect.area_mm2, "mm²"),
            short_or_dash(defect.length_mm, "mm"),
            short_or_dash(defect.width_mm, "mm"),
            short(defect.significance)
        )?;
    }
    out.push_str("</tbody></table>\n");
    let more = defects.len().saturating_sub(SHOWN) as u64 + features.defects_more;
    if more > 0 {
        writeln!(out, "<p class=\"note\">And {} less significant ones.</p>", count(more))?;
    }
    Ok(())
}

/// Defects that are listed on paper.
const SHOWN: usize = 20;
