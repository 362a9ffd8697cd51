//! What a figure means, and where that is laid down.

use std::fmt;

use super::Definition;

/// A figure with its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Definition.
    pub definition: Definition,
    /// Its value in [`Definition::unit`].
    pub value: f64,
}

impl Figure {
    pub(crate) fn new(definition: Definition, value: f64) -> Figure {
        Figure { definition, value }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Figure { definition, value } = self;
        match definition.unit() {
            Unit::One => write!(f, "{definition} {value}"),
            unit => write!(f, "{definition} {value} {unit}"),
        }
    }
}

/// Unit of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nanometres of surface height.
    Nanometres,
    /// Microradians, that is nanometres per millimetre.
    Microradians,
    /// Micrometres along the surface.
    Micrometres,
    /// Percent of an area.
    Percent,
    /// A number without unit.
    One,
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Unit::Nanometres => "nm",
            Unit::Microradians => "µrad",
            Unit::Micrometres => "µm",
            Unit::Percent => "%",
            Unit::One => "1",
        })
    }
}

impl Definition {
    /// Its identity: `pv`, `rmsi`, `slope_max`. Stable.
    pub fn id(&self) -> &'static str {
        self.row().id
    }

    /// Its key in configurations, which is its name in a verdict: identity and unit, `pv_nm`.
    pub fn key(&self) -> String {
        let unit = match self.unit() {
            Unit::Nanometres => "nm",
            Unit::Microradians => "urad",
            Unit::Micrometres => "um",
            Unit::Percent => "percent",
            Unit::One => return self.id().to_owned(),
        };
        format!("{}_{unit}", self.id())
    }

    /// The figure of deviations of an identity, in its usual variant; in any case of letters.
    pub fn of_id(id: &str) -> Option<Definition> {
        Definition::LIMITED.into_iter().find(|one| one.id().eq_ignore_ascii_case(id))
    }

    /// Its short sign: `PV`, `RMSi`, `slope max`.
    pub fn symbol(&self) -> &'static str {
        self.row().symbol
    }

    /// The unit of its values.
    pub fn unit(&self) -> Unit {
        self.row().unit
    }

    /// Definition of the figure, in one sentence.
    pub fn text(&self) -> &'static str {
        self.row().text
    }

    /// The standard or paper that defines the figure; for the robust range, which none defines, that.
    pub fn source(&self) -> &'static str {
        self.row().source
    }
}

impl fmt::Display for Definition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.row().name;
        match self {
            Definition::RobustPeakToValley { share } => write!(f, "{name}{}%", percent(*share)),
            Definition::Pvr { terms } => write!(f, "{name} (Fringe 1 to {terms})"),
            _ => f.write_str(name),
        }
    }
}

/// A share in percent, without the rounding of the product with 100.
fn percent(share: f64) -> f64 {
    (share * 1e11).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Parameter;

    #[test]
    fn a_figure_names_its_variant() {
        let robust = Figure::new(Definition::RobustPeakToValley { share: 0.995 }, 12.5);
        assert_eq!(robust.to_string(), "PV99.5% 12.5 nm");
        assert_eq!(Definition::Pvr { terms: 37 }.to_string(), "PVr (Fringe 1 to 37)");
        assert_ne!(Definition::Pvr { terms: 36 }.source(), Definition::Pvr { terms: 37 }.source());
        assert_eq!(Definition::GradientRms.unit().to_string(), "µrad");
        let texture = |parameter| Figure::new(Definition::Texture(parameter), 2.5).to_string();
        assert_eq!(texture(Parameter::Sq), "Sq 2.5 nm");
        assert_eq!(texture(Parameter::Sku), "Sku 2.5");
        assert_eq!(texture(Parameter::Sdr), "Sdr 2.5 %");
    }

    #[test]
    fn identities_lead_to_figures_and_differ() {
        for definition in Definition::LIMITED {
            assert_eq!(Definition::of_id(definition.id()), Some(definition));
        }
        let keys = Definition::LIMITED.map(|one| one.key());
        assert_eq!((&*keys[0], &*keys[11]), ("pv_nm", "slope_max_urad"));
        assert_eq!(
            Definition::AT_END.map(|one| one.key()),
            ["minimum_zone_nm", "sa_nm", "sq_nm", "sz_nm"]
        );
        assert_eq!(Definition::of_id("RMSi"), Some(Definition::RmsIrregularity));
        assert_eq!(Definition::of_id("minimum_zone"), None, "no figure of deviations");
    }
}
