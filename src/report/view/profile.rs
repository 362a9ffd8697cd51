//! A profile in words.

use super::{Chapter, ChapterId, Fact};
use crate::ProfileFigures;
use crate::words::short;

pub(super) fn chapter(profile: &ProfileFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Profile, "Profile");
    let mut line = format!("of {}, {:.2}° from x", profile.source, profile.direction_deg);
    let mut facts = vec![
        Fact::new("Of", profile.source.clone()),
        Fact::new("Direction", format!("{:.2}° from x", profile.direction_deg)),
    ];
    if let (Some(length), Some(covered)) = (profile.length_mm, profile.covered_mm) {
        let covered = format!("{} of {} mm", short(covered), short(length));
        line.push_str(&format!(", {covered} covered"));
        facts.push(Fact::new("Covered", covered));
    }
    chapter.brief.push(line);
    if let (Some(rms), Some(about), Some(most)) =
        (profile.slope_rms_urad, profile.slope_rms_about_mean_urad, profile.slope_max_urad)
    {
        let [rms, about, most] = [rms, about, most].map(short);
        chapter
            .brief
            .push(format!("slope RMS {rms} µrad ({about} about the mean), largest {most} µrad"));
        facts.extend([
            Fact::new("Slope RMS", format!("{rms} µrad")).noted(profile.slope_rule.clone()),
            Fact::new("Slope RMS about the mean", format!("{about} µrad")),
            Fact::new("Largest slope", format!("{most} µrad")),
        ]);
    }
    if let (Some(sigma), Some(urad)) = (profile.noise_sigma_nm, profile.slope_noise_urad) {
        let [sigma, urad] = [sigma, urad].map(short);
        chapter.brief.push(format!(
            "noise or roughness of {sigma} nm from point to point, which alone makes slopes of {urad} µrad RMS"
        ));
        facts.extend([
            Fact::new("Noise or roughness from point to point", format!("{sigma} nm"))
                .noted("By third differences along the line.".to_owned()),
            Fact::new("Slope RMS by that alone", format!("{urad} µrad")),
        ]);
    }
    chapter.facts(facts);
    if profile.turned {
        chapter.note("The fit's x runs along the line.");
    }
    if !profile.held.is_empty() {
        chapter.note(format!("Held, not felt by a profile: {}.", profile.held.join(", ")));
    }
    chapter
}
