//! `[tip]`: the ball at the end of a stylus.

use asphera_measure::{Along, LARGEST_MM, Tip, TipReads};
use asphera_settings::Section;

use crate::station::Kinematics;

/// Reads the table; `None` where it is absent or cannot be used.
pub(super) fn read(
    table: &Section<'_>,
    kinematics: Option<&Kinematics>,
    along: Option<Along>,
    others: [&Section<'_>; 2],
) -> Option<Tip> {
    if !table.is_present() {
        return None;
    }
    let radius_mm: Option<f64> = table.required("radius_mm");
    let radius_mm = radius_mm.filter(|radius_mm| {
        let is_radius = (0.0..=LARGEST_MM).contains(radius_mm);
        if !is_radius {
            table.problem("radius_mm", format!("0 to {LARGEST_MM} mm"), radius_mm);
        }
        is_radius
    });
    let u_radius_mm = table.within("u_radius_mm", 0.0, 0.0..=LARGEST_MM);
    let words = [TipReads::Lowest, TipReads::Centre].map(|reads| (reads.word(), reads));
    let reads = table.word("reads", TipReads::Lowest, &words);
    if let Some(Kinematics::Line(_)) = kinematics {
        let expected = "no such table, or a kind of [kinematics] that has one probe: a line scanner has no ball tip";
        table.problem("radius_mm", expected, "kind = \"line\"");
    }
    if along.is_some_and(|along| !along.suits_tip()) {
        let expected = "along = \"z\", \"fitted\" or three numbers, the third above 0, in [projection]: contacts of a ball need a plane seen from above";
        table.problem(
            "radius_mm",
            expected,
            "points that are meshed in space, or a plane seen from below",
        );
    }
    for (other, name) in others.into_iter().zip(["contour", "parts"]) {
        if other.is_present() {
            let expected = format!(
                "no table [{name}]: it is formed of centres of the ball, which have no contacts there"
            );
            table.problem("radius_mm", expected, format!("[tip] and [{name}]"));
        }
    }
    table.finish();
    Tip::new(radius_mm?, u_radius_mm, reads).ok()
}
