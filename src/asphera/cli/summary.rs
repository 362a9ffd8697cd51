//! The figures as a person reads them in a terminal.

use std::fmt::Write as _;

use asphera_report::{
    DefectFigures, FeatureFigures, FormFigure, FormFigures, LinkFigures, MeshFigures, Points,
    ProfileFigures, ReadingFigures, RepeatFigures, Report, SamplingFigures, StandardFigures,
    Status, UncertaintyFigures, UnmeasuredFigures, Verdict,
};

/// The report in a few lines.
pub(super) fn of(report: &Report) -> String {
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = write(&mut text, report);
    text
}

fn write(text: &mut String, report: &Report) -> std::fmt::Result {
    if let Some(taken) = &report.reading {
        text.push_str(&reading(taken));
    }
    points(text, &report.points)?;
    mesh(text, &report.mesh)?;
    sampling(text, &report.sampling)?;
    features(text, &report.features)?;
    if let Some(form) = &report.form {
        fit(text, form)?;
        deviation(text, form)?;
        standards(text, &form.standards)?;
    }
    if let Some(profile) = &report.profile {
        profile_lines(text, profile)?;
    }
    report.links.iter().try_for_each(|link| devices(text, link))?;
    if let Some(session) = &report.session {
        writeln!(text, "session    {} ({})", session.id, session.ended)?;
    }
    verdict(text, &report.verdict)
}

/// How many points came and what became of them.
fn points(text: &mut String, points: &Points) -> std::fmt::Result {
    write!(text, "points     {} received, {} used", points.received, points.used)?;
    for (reason, count) in &points.flagged {
        write!(text, ", {count} {}", reason.replace('_', " "))?;
    }
    for (count, what) in [(points.duplicates, "duplicate"), (points.lost, "lost")] {
        if count > 0 {
            write!(text, ", {count} {what}")?;
        }
    }
    writeln!(text)
}

fn mesh(text: &mut String, mesh: &MeshFigures) -> std::fmt::Result {
    write!(text, "mesh       {} triangles", mesh.triangles)?;
    match mesh.area_mm2 {
        Some(area_mm2) => writeln!(text, ", {area_mm2:.4} mm²")?,
        None => writeln!(text)?,
    }
    if let Some(projection) = &mesh.projection {
        writeln!(text, "plane      {projection}")?;
    }
    let relief = &mesh.relief;
    for (count, what) in
        [(relief.folds.len() as u64, "folds"), (relief.walls, "walls"), (relief.spikes, "spikes")]
    {
        if count > 0 {
            writeln!(text, "           {count} {what}")?;
        }
    }
    if let Some(spread_nm) = mesh.repeats.spread_nm {
        let RepeatFigures { places, measurements, .. } = mesh.repeats;
        writeln!(
            text,
            "           {places} places measured {measurements} times, spread {spread_nm:.1} nm"
        )?;
    }
    Ok(())
}

/// What was fitted, and what is known of it.
fn fit(text: &mut String, form: &FormFigures) -> std::fmt::Result {
    writeln!(text, "nominal    {}", form.nominal)?;
    writeln!(
        text,
        "fit        {}, {} in {} steps",
        form.fit.method, form.fit.termination, form.fit.iterations
    )?;
    for (name, parameter) in &form.fit.parameters {
        write!(text, "  {name:<8} {:.9} {}", parameter.value, parameter.unit)?;
        match parameter.u {
            Some(u) => writeln!(text, "   (u {u:.1e})")?,
            None => writeln!(text)?,
        }
    }
    if let Some(model) = &form.fit.details.u_model {
        writeln!(text, "  u (k = 1) by {model}")?;
    }
    if let Some(covers) = &form.fit.details.expanded_covers {
        writeln!(text, "  95 % in report.json: {covers}")?;
    }
    for (name, parameter) in &form.fit.parameters {
        if let Some(u) = parameter.u_by_form {
            writeln!(text, "  {name} by form error from part to part: u about {u:.1e}")?;
        }
    }
    criterion(text, form)?;
    if !form.fit.indeterminate.is_empty() {
        writeln!(text, "  not determined by these points: {}", form.fit.indeterminate.join(", "))?;
    }
    for caution in &form.fit.details.cautions {
        writeln!(text, "  caution: {}", caution.text)?;
    }
    for lacks in form.fit.details.undetermined.iter().filter(|lacks| !lacks.by_shape) {
        writeln!(text, "  the points do not feel {}", lacks.combination.text)?;
    }
    if let Some(origin) = &form.origin {
        writeln!(text, "origin     {}, at {}", origin.place, place(&origin.at_mm))?;
    }
    Ok(())
}

/// How far the points lie from the fit.
fn deviation(text: &mut String, form: &FormFigures) -> std::fmt::Result {
    let deviation = &form.deviation;
    let pose = &form.fit.pose;
    writeln!(
        text,
        "deviation  PV {:.1} nm, RMS {:.2} nm ({:+.1} nm at {}, {:+.1} nm at {})",
        deviation.pv_nm,
        deviation.rms_nm,
        deviation.max_nm,
        place(&pose.to_measured(deviation.at_max_mm)),
        deviation.min_nm,
        place(&pose.to_measured(deviation.at_min_mm)),
    )?;
    if let Some(known) = &deviation.uncertainty {
        uncertainty(text, known, deviation.rms_nm)?;
    }
    if let Some(UnmeasuredFigures { between_nm: Some(nm), share: Some(share), .. }) =
        &deviation.unmeasured
    {
        let (nm, share) = (short(*nm), percent(*share));
        writeln!(
            text,
            "           up to {nm} nm may stand out between the points at either end; {share} of the aperture not measured"
        )?;
    }
    Ok(())
}

/// What is known of PV and RMS by the noise of the points.
fn uncertainty(text: &mut String, known: &UncertaintyFigures, rms_nm: f64) -> std::fmt::Result {
    let most = if known.pv_at_most { "at most " } else { "" };
    writeln!(
        text,
        "           u(PV) {most}{} nm, {}u(RMS) {} nm (k = 1, {})",
        short(known.u_pv_nm),
        // The uncertainty is of what noise leaves of the RMS.
        if (known.rms_95_nm[0]..=known.rms_95_nm[1]).contains(&rms_nm) {
            String::new()
        } else {
            format!("RMS without noise {} nm, ", short(known.rms_without_noise_nm))
        },
        short(known.u_rms_nm),
        known.model
    )?;
    for (name, [low, high], covers) in [
        ("PV", known.pv_95_nm, &known.pv_covers),
        ("RMS without noise", known.rms_95_nm, &known.rms_covers),
    ] {
        let (low, high) = (short(low), short(high));
        writeln!(text, "           {name} {low} to {high} nm: 95 % of {covers}")?;
    }
    Ok(())
}

/// The devices on a link, and what the link lost.
fn devices(text: &mut String, link: &LinkFigures) -> std::fmt::Result {
    for device in &link.devices {
        write!(text, "{:<10} {} readings on {}", device.name, device.readings, link.name)?;
        for (count, what) in
            [(device.lost, "lost"), (device.unjoined, "unjoined"), (device.ambiguous, "ambiguous")]
        {
            if count > 0 {
                write!(text, ", {count} {what}")?;
            }
        }
        for (kind, count) in &device.faults {
            write!(text, ", {count} {kind} faults")?;
        }
        for (name, channel) in
            device.channels.iter().filter(|_| device.lost == 0 && device.unjoined == 0)
        {
            write!(text, ", {name} {:.3} {}", channel.mean, channel.unit)?;
        }
        writeln!(text)?;
    }
    if link.discarded_bytes > 0 || link.closed > 0 {
        writeln!(
            text,
            "  {}: {} bytes discarded, opened {} times, lost {} times",
            link.name, link.discarded_bytes, link.opened, link.closed
        )?;
    }
    Ok(())
}

fn verdict(text: &mut String, verdict: &Verdict) -> std::fmt::Result {
    let status = match verdict.status {
        Status::Pass => "PASS",
        Status::Fail => "FAIL",
        Status::Undecided => "UNDECIDED",
        Status::None => "none",
    };
    write!(text, "verdict    {status}")?;
    for check in &verdict.checks {
        let sign = if check.value <= check.limit { "≤" } else { ">" };
        let (name, unit) = (check.figure.words(), &check.figure.unit);
        write!(text, "   {name} {:.2} {sign} {:.2} {unit}", check.value, check.limit)?;
        if let Some(band) = check.guard_band {
            write!(text, " ± {band:.2}")?;
        }
    }
    writeln!(text)?;
    if let Some(rule) = verdict.checks.iter().find_map(|check| check.rule.as_ref()) {
        writeln!(text, "  {rule}")?;
        let known = verdict.checks.iter();
        for (name, covers) in
            known.filter_map(|check| Some((check.figure.words(), check.u_covers.as_ref()?)))
        {
            writeln!(text, "  {name}: {covers}")?;
        }
    }
    verdict.reasons.iter().try_for_each(|reason| writeln!(text, "  {reason}"))
}

fn profile_lines(text: &mut String, profile: &ProfileFigures) -> std::fmt::Result {
    write!(text, "profile    of {}, {:.2}° from x", profile.source, profile.direction_deg)?;
    if let (Some(length), Some(covered)) = (profile.length_mm, profile.covered_mm) {
        write!(text, ", {covered:.4} of {length:.4} mm covered")?;
    }
    writeln!(text)?;
    if let (Some(rms), Some(about), Some(most)) =
        (profile.slope_rms_urad, profile.slope_rms_about_mean_urad, profile.slope_max_urad)
    {
        writeln!(
            text,
            "           slope RMS {rms:.4} µrad ({about:.4} about the mean), largest {most:.4} µrad"
        )?;
    }
    if profile.turned {
        writeln!(text, "           the fit's x runs along the line")?;
    }
    if !profile.held.is_empty() {
        writeln!(text, "           held, not felt by a profile: {}", profile.held.join(", "))?;
    }
    Ok(())
}

/// How columns and units of a file were read, in a line.
pub(super) fn reading(taken: &ReadingFigures) -> String {
    if let [only] = &taken.columns[..] {
        return format!("columns    a matrix of heights in {}, the top row first\n", only.unit);
    }
    let columns = taken
        .columns
        .iter()
        .map(|column| format!("{} in column {} in {}", column.name, column.number, column.unit));
    let columns = columns.collect::<Vec<_>>().join(", ");
    let commas = if taken.decimal_commas { ", decimal commas" } else { "" };
    let assumed =
        if taken.units_assumed { " (mm is assumed: the file states no unit)" } else { "" };
    format!("columns    {columns}{commas}{assumed}\n")
}

/// Those that the nominal file asks for, in a line each.
fn standards(text: &mut String, of: &StandardFigures) -> std::fmt::Result {
    if let Some(zone) = &of.minimum_zone {
        writeln!(
            text,
            "zone       {:.1} nm, {}; none near by is narrower than {:.1} nm",
            zone.width.value, zone.termination, zone.lower_nm
        )?;
        if let (Some(u), Some(of)) = (zone.width.u, &zone.width.simulated) {
            let (low, high) = (short(of.low), short(of.high));
            writeln!(
                text,
                "           u {} nm (k = 1), {low} to {high} nm: 95 % of {}",
                short(u),
                of.covers
            )?;
        }
    }
    if let Some((found, asked)) =
        of.indication.as_ref().and_then(|of| Some((&of.found, of.asked.as_ref()?)))
    {
        writeln!(text, "drawing    {asked}\n  found    {found}")?;
    }
    if let Some(texture) = &of.texture {
        let heights =
            texture.figures.iter().filter(|figure| ["Sa", "Sq", "Sz"].contains(&&figure.name[..]));
        let heights = heights.map(|figure| {
            format!("{} {} nm{}", figure.name, short(figure.value), known_of(figure))
        });
        let heights: Vec<String> = heights.collect();
        writeln!(text, "texture    {}: {}", texture.surface, heights.join(", "))?;
    }
    Ok(())
}

/// What is known of a figure: the interval is of what noise leaves of it where it does not hold the value.
fn known_of(figure: &FormFigure) -> String {
    let (Some(u), Some(of)) = (figure.u, &figure.simulated) else { return String::new() };
    let without = if (of.low..=of.high).contains(&figure.value) {
        String::new()
    } else {
        format!("without noise {} nm, ", short(of.without_noise))
    };
    let (u, low, high) = (short(u), short(of.low), short(of.high));
    format!(" ({without}u {u} nm, {} %: {low} to {high} nm)", (100.0 * of.p).round())
}

/// How points were counted, and what a surface made from them is.
fn criterion(text: &mut String, form: &FormFigures) -> std::fmt::Result {
    if let Some(reference) = &form.reference {
        write!(
            text,
            "  RMS {} nm from the {} alone, {:.0} effective parameters (smoothing by {})",
            short(reference.base_rms_nm),
            reference.base,
            reference.effective_parameters,
            reference.smoothing
        )?;
        match reference.noise_nm {
            Some(noise_nm) => writeln!(text, ", noise left {} nm", short(noise_nm))?,
            None => writeln!(text)?,
        }
    }
    if let Some(loss) = &form.fit.loss {
        writeln!(
            text,
            "  loss     {}, threshold {} nm ({}): {} points below half weight, {} of them left out",
            loss.name,
            short(loss.threshold_nm),
            if loss.threshold_given { "given" } else { "found" },
            loss.below_half,
            loss.left_out
        )?;
    }
    if let Some(weights) = &form.fit.weights {
        write!(
            text,
            "  weights  1/u², u from {} to {} nm",
            short(weights.u_min_nm),
            short(weights.u_max_nm)
        )?;
        match weights.reduced_chi_square {
            Some(chi) => writeln!(text, ", reduced χ² {}", short(chi))?,
            None => writeln!(text)?,
        }
    }
    match form.fit.effective_points {
        Some(points) => writeln!(text, "  as many as {points:.0} points of equal weight"),
        None => Ok(()),
    }
}

/// The sampling in a few lines: what is known of it.
pub(super) fn sampling(text: &mut String, sampling: &SamplingFigures) -> std::fmt::Result {
    // Where nothing else is said the reason comes first.
    let mut unknown = sampling.unknown.iter();
    if let Some(coverage) = sampling.coverage {
        writeln!(text, "sampling   {} sampled densely enough", percent(coverage))?;
    } else if let (None, Some(why)) = (sampling.gap_max_mm, unknown.clone().next()) {
        unknown.next();
        writeln!(text, "sampling   {why}")?;
    }
    let areas = [
        (sampling.undersampled_area_mm2, "mm² too coarse"),
        (sampling.uncovered_area_mm2, "mm² not scanned"),
    ];
    let figures = [
        (sampling.gap_max_mm, "largest gap", "mm"),
        (sampling.gap_p99_mm, "99 % up to", "mm"),
        (sampling.gap_limit_mm, "allowed", "mm"),
    ];
    let line = |text: &mut String, parts: Vec<String>| match &parts[..] {
        [] => Ok(()),
        parts => writeln!(text, "           {}", parts.join(", ")),
    };
    let open = areas.iter().filter_map(|&(value, unit)| Some(format!("{} {unit}", short(value?))));
    line(text, open.collect())?;
    if sampling.gap_max_mm.is_some() {
        let gaps = figures
            .iter()
            .filter_map(|&(value, name, unit)| Some(format!("{name} {} {unit}", short(value?))));
        line(text, gaps.collect())?;
    }
    if let Some(epsilon) = sampling.epsilon_max {
        let mut parts = vec![format!("largest ε {}", short(epsilon))];
        parts.extend(sampling.epsilon_p99.map(|epsilon| format!("99 % up to {}", short(epsilon))));
        parts.extend(sampling.epsilon_target.map(|allowed| format!("allowed {}", short(allowed))));
        let source = sampling.lfs_source.as_deref().unwrap_or("unknown");
        parts.extend(
            sampling.lfs_min_mm.map(|mm| format!("feature size from {} mm ({source})", short(mm))),
        );
        line(text, parts)?;
    }
    if let (Some(allowed), Some(rho)) = (sampling.rho_target, sampling.rho_max) {
        let mut parts =
            vec![format!("largest ρ {}", short(rho)), format!("allowed {}", short(allowed))];
        parts.extend(sampling.reach_mm.map(|mm| format!("reach {} mm", short(mm))));
        line(text, parts)?;
    }
    line(text, density(sampling))?;
    unknown.try_for_each(|why| writeln!(text, "           {why}"))
}

/// Noise and spacing, with the spacings that would do.
fn density(sampling: &SamplingFigures) -> Vec<String> {
    let noise = sampling.noise_sigma_nm.map(|nm| format!("noise {} nm", short(nm)));
    let bounds = [
        sampling.spacing_coarsest_mm.map(|mm| format!("coarsest that meets ε: {} mm", short(mm))),
        sampling.spacing_finest_mm.map(|mm| format!("finest useful: {} mm", short(mm))),
    ];
    let bounds: Vec<String> = bounds.into_iter().flatten().collect();
    let spacing = sampling.spacing_median_mm.map(|mm| {
        let around =
            if bounds.is_empty() { String::new() } else { format!(" ({})", bounds.join("; ")) };
        format!("point spacing {} mm{around}", short(mm))
    });
    let share = sampling.overdense_fraction.filter(|share| *share > 0.0);
    let dense = share.map(|share| format!("{} of the surface finer than that", percent(share)));
    let said = [noise, spacing, dense].into_iter().flatten();
    vec![said.collect::<Vec<_>>().join("; ")].into_iter().filter(|said| !said.is_empty()).collect()
}

/// The first regions to measure, one a line.
pub(super) fn next(text: &mut String, sampling: &SamplingFigures) -> std::fmt::Result {
    for (number, next) in (1..).zip(&sampling.next).take(SHOWN) {
        let name = if number == 1 { "next" } else { "" };
        write!(
            text,
            "{name:<10} {number}. {} mm² about {}",
            short(next.area_mm2),
            place(&next.at_mm)
        )?;
        if let Some(share) = next.adds_coverage {
            write!(text, ", adds {}", percent(share))?;
        }
        if let Some(epsilon) = next.epsilon_max {
            write!(text, ", ε {}", short(epsilon))?;
        }
        if let Some(spacing_mm) = next.spacing_needed_mm {
            write!(text, ", every {} mm", short(spacing_mm))?;
        }
        writeln!(text)?;
    }
    let more = sampling.next.len().saturating_sub(SHOWN) as u64 + sampling.next_more;
    if more > 0 {
        writeln!(text, "           and {more} more")?;
    }
    Ok(())
}

/// Defects, the first of them one a line, and which way the surface bends.
pub(super) fn features(text: &mut String, features: &FeatureFigures) -> std::fmt::Result {
    if let Some(why) = &features.defects_unknown {
        writeln!(text, "defects    not looked for: {why}")?;
    }
    if let Some(defects) = &features.defects {
        let all = defects.len() as u64 + features.defects_more;
        write!(text, "defects    {}", if all == 0 { "none".to_owned() } else { all.to_string() })?;
        if let Some(by) = &features.defects_search {
            let (sigmas, sigma_nm) = (by.threshold_sigmas, short(by.sigma_nm));
            write!(
                text,
                " beyond {sigmas:.1} σ of {sigma_nm} nm, up to {} mm wide",
                short(by.largest_mm)
            )?;
            if by.lower > 0 {
                write!(text, "; {} lower than {} nm", by.lower, short(by.min_height_nm))?;
            }
        }
        writeln!(text)?;
        defects
            .iter()
            .take(SHOWN)
            .try_for_each(|found| writeln!(text, "           {}", defect(found)))?;
        let more = all.saturating_sub(SHOWN as u64);
        if more > 0 {
            writeln!(text, "           and {more} more")?;
        }
    }
    if let Some(partition) = &features.partition {
        let shares: Vec<String> = partition
            .shares
            .iter()
            .map(|(class, share)| format!("{class} {}", percent(*share)))
            .collect();
        writeln!(text, "bends      {}", shares.join(", "))?;
    }
    Ok(())
}

fn defect(found: &DefectFigures) -> String {
    let mut text = format!("{} {:+.1} nm", found.kind, found.height_nm);
    let known = |mm: Option<f64>| mm.filter(|mm| mm.is_finite());
    match (known(found.length_mm), known(found.width_mm)) {
        (Some(length), Some(width)) => {
            text.push_str(&format!(", {} × {} mm", short(length), short(width)));
        }
        (Some(length), None) => text.push_str(&format!(", {} mm long", short(length))),
        _ => {}
    }
    text.push_str(&format!(" at {}, {:.0} σ", place(&found.at_mm), found.significance));
    text
}

/// Regions and defects that are shown.
const SHOWN: usize = 3;

/// Four significant digits.
pub(super) fn short(value: f64) -> String {
    if value.abs() < 1e-12 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "not known".to_owned();
    }
    let places = (3 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{value:.places$}")
}

/// A share in percent; 100 % only where nothing is missing, 0 % only where there is nothing.
fn percent(share: f64) -> String {
    let rounded = (1e4 * share).round() / 1e2;
    if rounded >= 100.0 && share < 1.0 {
        "99.99 %".to_owned()
    } else if rounded <= 0.0 && share > 0.0 {
        "< 0.01 %".to_owned()
    } else {
        format!("{rounded:.2} %")
    }
}

fn place([x, y, _]: &[f64; 3]) -> String {
    // Adding zero makes negative zero positive.
    let [x, y] = [x, y].map(|mm| (1e3 * mm).round() / 1e3 + 0.0);
    format!("x {x:.3} y {y:.3} mm")
}
