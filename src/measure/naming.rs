//! How reports name figures: by the catalogue of the kernel. No figure gets its names elsewhere.

use asphera_figures::{Definition, Figure, Term, Unit};
use asphera_form::Aperture;
use asphera_report::{FigureName, FormFigure};
use asphera_uncertainty::verdict::Limit;

use super::design;
use super::judged::Sure;
use crate::Part;

/// The figure of a limit of a part.
pub(super) fn of_limit(limit: &Limit, part: &Part) -> FigureName {
    let figure = of_figure(limit.definition, part);
    let parts = [limit.scope(), figure.scope];
    let scope = parts.into_iter().flatten().reduce(|one, other| format!("{one}, {other}"));
    FigureName { name: limit.name(), scope, ..figure }
}

/// A figure of the whole part, with what its deviation is from where the fit may change the shape.
pub(super) fn of_figure(definition: Definition, part: &Part) -> FigureName {
    let scope = design::scope(definition.subject(), part);
    FigureName {
        name: definition.key(),
        id: definition.id().to_owned(),
        symbol: definition.symbol().to_owned(),
        unit: definition.unit().to_string(),
        scope: scope.map(str::to_owned),
    }
}

/// A figure of what `variant` says, without an uncertainty.
pub(super) fn figure(Figure { definition, value }: Figure, variant: String) -> FormFigure {
    FormFigure {
        id: definition.id().to_owned(),
        name: definition.to_string(),
        unit: match definition.unit() {
            Unit::One => String::new(),
            unit => unit.to_string(),
        },
        definition: definition.text().to_owned(),
        source: definition.source().to_owned(),
        ..bare(value, variant)
    }
}

/// The figure of a limit that names a length, a part of the aperture or terms removed; `None` of the whole deviation.
pub(super) fn of_narrow_limit(limit: &Limit, value: f64) -> Option<FormFigure> {
    let terms = limit.less.list();
    let part = match limit.zone {
        Aperture::Annulus { inner_mm, outer_mm } => {
            Some(format!("from {inner_mm} to {outer_mm} mm"))
        }
        _ => (!terms.is_empty()).then(|| without(&terms)),
    };
    let over = limit.slope.map(|slope| slope.scope());
    let variant = over.into_iter().chain(part).reduce(|one, other| format!("{one}, {other}"))?;
    let removed = terms.iter().map(ToString::to_string).collect();
    let found = Figure { definition: limit.definition, value };
    Some(FormFigure { removed, ..figure(found, variant) })
}

/// A figure of a deviation over the whole aperture, with its uncertainty where that is known.
pub(super) fn figure_of_all(figure: Figure, variant: &str, sure: &Sure) -> FormFigure {
    let u = sure.of(figure.definition, &[]);
    FormFigure { u, ..self::figure(figure, variant.to_owned()) }
}

/// A figure of a deviation with terms removed, with its uncertainty where that is known.
pub(super) fn figure_without(figure: Figure, terms: &[Term], sure: &Sure) -> FormFigure {
    let removed: Vec<String> = terms.iter().map(ToString::to_string).collect();
    let u = sure.of(figure.definition, terms);
    FormFigure { removed, u, ..self::figure(figure, without(terms)) }
}

/// Terms removed, in words.
pub(super) fn without(terms: &[Term]) -> String {
    let names: Vec<String> = terms.iter().map(ToString::to_string).collect();
    format!("{} removed", names.join(", "))
}

/// Slopes along a profile.
#[derive(Clone, Copy)]
pub(super) enum ProfileSlope {
    Rms,
    RmsAboutMean,
    Max,
}

/// A slope along a profile, in µrad.
pub(super) fn profile_slope(kind: ProfileSlope, value_urad: f64, rule: &str) -> FormFigure {
    let (id, name) = match kind {
        ProfileSlope::Rms => ("profile_slope_rms", "profile slope RMS"),
        ProfileSlope::RmsAboutMean => {
            ("profile_slope_rms_about_mean", "profile slope RMS about mean")
        }
        ProfileSlope::Max => ("profile_slope_max", "profile slope max"),
    };
    FormFigure {
        id: id.to_owned(),
        name: name.to_owned(),
        unit: "µrad".to_owned(),
        definition: rule.to_owned(),
        source: "asphera".to_owned(),
        ..bare(value_urad, "along the line".to_owned())
    }
}

/// A value without a name.
fn bare(value: f64, variant: String) -> FormFigure {
    FormFigure {
        id: String::new(),
        name: String::new(),
        variant,
        removed: Vec::new(),
        value,
        unit: String::new(),
        u: None,
        expanded: None,
        simulated: None,
        noise_adds: None,
        without_noise: None,
        definition: String::new(),
        source: String::new(),
    }
}
