//! What a nominal file says, as a person reads it.

use std::fmt::Write as _;

use asphera_form::{Aperture, Base, Knots, Loss, MeasuredFrom, Pose, ReferenceSettings, Smoothing};

use super::super::output::Failure;
use super::super::usage::misused;
use asphera_measure::{Part, Weights};
use asphera_report::words::{raised, unit as with_unit};
use asphera_settings::number;

/// Surface, aperture, fit and limits, and heights at the distances `at_mm` from the axis, or to the rim of the aperture.
pub(super) fn describe(part: &Part, at_mm: &[f64]) -> Result<String, Failure> {
    if let Some(bad) = at_mm.iter().find(|r_mm| !(r_mm.is_finite() && **r_mm >= 0.0)) {
        return Err(misused(format!(
            "--sag {bad}: expected distances from the axis in mm, not below 0"
        )));
    }
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = write(&mut text, part, at_mm);
    Ok(text)
}

fn write(text: &mut String, part: &Part, at_mm: &[f64]) -> std::fmt::Result {
    let nominal = &part.nominal;
    match &part.reference {
        Some(reference) => writeln!(text, "nominal    {}", unknown(reference))?,
        None => writeln!(text, "nominal    {}", nominal.kind())?,
    }
    let pose = Pose::default();
    if part.reference.is_none() {
        let own = nominal.parameters();
        // The first six are those of the pose.
        for (parameter, name) in own.iter().skip(POSE) {
            let value = parameter.value(&pose, nominal).unwrap_or_default();
            let unit = parameter.unit(nominal).unwrap_or_default();
            let is_free = part.free.contains(parameter);
            if value == 0.0 && !is_free {
                continue;
            }
            let free = if is_free { "   free" } else { "" };
            writeln!(text, "  {name:<8} {value:?}{}{free}", with_unit(&raised(&unit)))?;
        }
        if nominal.domain_mm().is_finite() {
            writeln!(text, "  ends {:.6} mm from the axis", nominal.domain_mm())?;
        }
    }
    write!(text, "aperture   {}", aperture(&part.aperture))?;
    match part.centre_mm {
        [0.0, 0.0] => writeln!(text)?,
        [x_mm, y_mm] => writeln!(text, ", its middle at x {x_mm} y {y_mm} mm")?,
    }
    if part.reference.is_none() {
        writeln!(text, "fit        {}", fit(part))?;
    }
    limits(text, part)?;
    if part.reference.is_some() {
        return writeln!(text, "heights    not known before the points are");
    }
    let radii_mm = if at_mm.is_empty() { to_the_rim_mm(&part.aperture) } else { at_mm.to_vec() };
    if radii_mm.is_empty() {
        return writeln!(text, "heights    --sag R1,R2 tells them at distances from the axis, mm");
    }
    heights(text, part, &radii_mm)
}

/// Where places along x and, where the surface is not of revolution, along y lie, with height, slope and the smallest
/// radius of curvature.
fn heights(text: &mut String, part: &Part, radii_mm: &[f64]) -> std::fmt::Result {
    writeln!(
        text,
        "{:>12} {:>12} {:>18} {:>12} {:>16}",
        "x mm", "y mm", "z mm", "slope deg", "least R mm"
    )?;
    let directions: &[[f64; 2]] =
        if part.nominal.is_rotational() { &[[1.0, 0.0]] } else { &[[1.0, 0.0], [0.0, 1.0]] };
    for [along_x, along_y] in directions {
        for r_mm in radii_mm {
            let (x, y) = (along_x * r_mm, along_y * r_mm);
            write!(text, "{x:>12.6} {y:>12.6} ")?;
            match part.nominal.jet(x, y) {
                Some(jet) => {
                    let slope_deg = jet.gradient[0].hypot(jet.gradient[1]).atan().to_degrees();
                    let least_mm = part.nominal.lfs_bound_at_mm(x, y).filter(|mm| mm.is_finite());
                    let least = least_mm.map_or("flat".to_owned(), |mm| format!("{mm:.6}"));
                    writeln!(text, "{:>18.9} {slope_deg:>12.6} {least:>16}", jet.z_mm)?;
                }
                None => writeln!(text, "{:>18}", "no surface")?,
            }
        }
    }
    Ok(())
}

fn unknown(reference: &ReferenceSettings) -> String {
    let base = reference.base.map_or("found by the points", Base::name);
    let knots = match reference.knots {
        Knots::Auto => "found by the points".to_owned(),
        Knots::Spacing(mm) => format!("every {mm} mm"),
        Knots::Across(cells) => format!("{cells} cells across"),
    };
    let smoothing = match reference.smoothing {
        Smoothing::CrossValidation => "by cross validation".to_owned(),
        Smoothing::Noise { sigma_mm } => format!("to a noise of {} nm", 1e6 * sigma_mm),
        Smoothing::Relative { lambda } => format!("λ {lambda}"),
    };
    format!(
        "unknown, to be made from the points: base {base}, knots {knots}, smoothing {smoothing}"
    )
}

fn aperture(aperture: &Aperture) -> String {
    match aperture {
        Aperture::None => "every point counts".to_owned(),
        Aperture::Circle { radius_mm } => format!("circle, radius {radius_mm} mm"),
        Aperture::Rectangle { width_mm, height_mm } => {
            format!("rectangle, {width_mm} × {height_mm} mm")
        }
        Aperture::Annulus { inner_mm, outer_mm } => {
            format!("annulus, radii {inner_mm} to {outer_mm} mm")
        }
        Aperture::Outline { outline, .. } => {
            let [[left, low], [right, high]] = outline.bounds_mm();
            let sides = outline.sides().count();
            let holes = match outline.rings().len() - 1 {
                0 => String::new(),
                1 => ", 1 hole".to_owned(),
                holes => format!(", {holes} holes"),
            };
            format!("outline, {sides} sides{holes}, x {left} to {right}, y {low} to {high} mm")
        }
    }
}

fn fit(part: &Part) -> String {
    let names: Vec<String> =
        part.free.iter().map(|parameter| parameter.name(&part.nominal)).collect();
    let names = if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
    let (loss, k) = match part.criterion.loss {
        Loss::Squares => ("squares", 0.0),
        Loss::Huber { k } => ("Huber's loss", k),
        Loss::Tukey { k } => ("Tukey's loss", k),
    };
    let threshold = match part.criterion.loss_scale_mm {
        Some(scale_mm) => format!(", threshold {} nm", (1e9 * k * scale_mm).round() / 1e3),
        None => String::new(),
    };
    let weights = match part.criterion.weights {
        Weights::None => "",
        Weights::Uncertainty => ", weights by uncertainty",
    };
    let side = match part.side {
        MeasuredFrom::Given => "",
        MeasuredFrom::Either => "; measured from either side",
    };
    format!("{names} free; by {loss}{threshold}{weights}{side}")
}

fn limits(text: &mut String, part: &Part) -> std::fmt::Result {
    let all: Vec<String> = part
        .limits()
        .iter()
        .map(|limit| format!("{} {}", limit.name(), number(limit.value)))
        .collect();
    let all = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
    writeln!(text, "limits     {all}")?;
    match &part.judging.guard {
        Some(guard) => writeln!(text, "  {guard}"),
        None => Ok(()),
    }
}

/// Five distances from the axis to the rim.
fn to_the_rim_mm(aperture: &Aperture) -> Vec<f64> {
    let Some([half_x_mm, half_y_mm]) = aperture.half_extents_mm() else { return Vec::new() };
    let rim_mm = half_x_mm.min(half_y_mm);
    [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * rim_mm).to_vec()
}

/// Parameters of a pose.
const POSE: usize = 6;

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str, at_mm: &[f64]) -> String {
        describe(&asphera_nominal::parse("n.toml", text).unwrap(), at_mm).unwrap()
    }

    #[test]
    fn a_sphere_is_told_with_its_heights() {
        let text = "[surface]\nkind = \"sphere\"\nradius_mm = 5\n[aperture]\nshape = \"circle\"\nradius_mm = 4\n\
                    [fit]\nfree = [\"tz\", \"radius\"]\nloss = \"huber\"\nthreshold_nm = 25\n[tolerance]\npv_nm = 100\n";
        let found = told(text, &[3.0, 6.0]);
        for said in [
            "nominal    sphere\n",
            "  radius   5.0 mm   free\n",
            "ends 5.000000 mm from the axis",
            "circle, radius 4 mm",
            "tz, radius free; by Huber's loss, threshold 25 nm",
            "limits     pv_nm 100\n",
            "    3.000000     0.000000        1.000000000    36.869898         5.000000\n",
            "    6.000000     0.000000         no surface\n",
        ] {
            assert!(found.contains(said), "{said:?} is not in\n{found}");
        }
        // From the axis to the rim, and no head line.
        assert_eq!(told(text, &[]).lines().filter(|line| line.contains(" 0.000000 ")).count(), 5);
    }

    #[test]
    fn freeforms_are_told_along_both_axes_and_unknown_ones_not_at_all() {
        let text = "[surface]\nkind = \"biconic\"\nradius_x_mm = 20\n";
        let found = told(text, &[2.0]);
        assert!(
            found.contains("    2.000000     0.000000 ")
                && found.contains("    0.000000     2.000000 ")
        );
        assert!(found.contains("flat") || found.contains("20.0"), "{found}");
        let found = told("[surface]\nkind = \"unknown\"\ncells = 8\n", &[1.0]);
        assert!(found.contains("8 cells across") && found.contains("not known before"), "{found}");
    }

    #[test]
    fn distances_are_not_negative() {
        let part = asphera_nominal::parse("n.toml", "[surface]\nkind = \"plane\"\n").unwrap();
        for bad in [-1.0, f64::NAN] {
            assert!(describe(&part, &[bad]).unwrap_err().to_string().contains("not below 0"));
        }
    }
}
