//! What a texture parameter means, and where that is laid down.

use std::fmt;

/// A parameter with its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Definition.
    pub definition: Definition,
    /// Its value in [`Definition::unit`].
    pub value: f64,
}

impl Figure {
    /// Parameters of a list that have a value.
    pub(super) fn known(list: &[(Definition, Option<f64>)]) -> Vec<Figure> {
        let known = list.iter().filter_map(|&(definition, value)| Some((definition, value?)));
        known.map(|(definition, value)| Figure { definition, value }).collect()
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

/// Unit of a parameter.
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

/// Which parameter of ISO 25178-2:2021. `Display` gives its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Definition {
    /// Arithmetical mean height.
    Sa,
    /// Root mean square height.
    Sq,
    /// Skewness.
    Ssk,
    /// Kurtosis.
    Sku,
    /// Maximum peak height.
    Sp,
    /// Maximum pit depth.
    Sv,
    /// Maximum height.
    Sz,
    /// Root mean square gradient.
    Sdq,
    /// Developed interfacial area ratio.
    Sdr,
    /// Autocorrelation length.
    Sal,
    /// Texture aspect ratio.
    Str,
    /// Core height.
    Sk,
    /// Reduced peak height.
    Spk,
    /// Reduced dale depth.
    Svk,
    /// Material ratio above the core.
    Smrk1,
    /// Material ratio down to the lower end of the core.
    Smrk2,
}

impl Definition {
    /// Parameters that a limit can be given for.
    pub const LIMITED: [Definition; 3] = [Definition::Sa, Definition::Sq, Definition::Sz];

    /// Its identity: `sa`.
    pub fn id(&self) -> String {
        self.to_string().to_lowercase()
    }

    /// Its key in configurations, which is its name in a verdict: `sa_nm`. Only heights have one.
    pub fn key(&self) -> String {
        format!("{}_nm", self.id())
    }

    /// The unit of its values.
    pub fn unit(&self) -> Unit {
        match self {
            Definition::Sa
            | Definition::Sq
            | Definition::Sp
            | Definition::Sv
            | Definition::Sz
            | Definition::Sk
            | Definition::Spk
            | Definition::Svk => Unit::Nanometres,
            Definition::Sdq => Unit::Microradians,
            Definition::Sal => Unit::Micrometres,
            Definition::Sdr | Definition::Smrk1 | Definition::Smrk2 => Unit::Percent,
            Definition::Ssk | Definition::Sku | Definition::Str => Unit::One,
        }
    }

    /// Definition of the parameter, in one sentence.
    pub fn text(&self) -> &'static str {
        match self {
            Definition::Sa => "area-weighted mean of the size of the heights about the datum",
            Definition::Sq => {
                "root of the area-weighted mean square of the heights about the datum"
            }
            Definition::Ssk => "area-weighted mean cube of the heights over the cube of Sq",
            Definition::Sku => "area-weighted mean fourth power of the heights over that of Sq",
            Definition::Sp => "largest height about the datum at a measured place",
            Definition::Sv => "minus the smallest height about the datum at a measured place",
            Definition::Sz => "largest minus smallest height at the measured places",
            Definition::Sdq => {
                "root mean square gradient of the surface interpolated linearly on triangles; on a \
                 grid the mean of both divisions of each cell"
            }
            Definition::Sdr => {
                "excess of the area of the surface interpolated linearly on triangles over its \
                 projection; on a grid the mean of both divisions of each cell"
            }
            Definition::Sal => {
                "shortest lag, in any direction, at which the autocorrelation first falls to the \
                 threshold; each lag is averaged over the pairs of measured places it has"
            }
            Definition::Str => {
                "shortest over longest lag, by direction, at which the autocorrelation first falls \
                 to the threshold"
            }
            Definition::Sk => {
                "fall from 0 to 100 % of the least-squares line through the 40 % of the material \
                 ratio curve with the flattest secant"
            }
            Definition::Spk => {
                "height of the triangle on Smrk1 whose area is that of the material above the core"
            }
            Definition::Svk => {
                "depth of the triangle on 100 % − Smrk2 whose area is that of the void below the core"
            }
            Definition::Smrk1 => "share of the area above the core",
            Definition::Smrk2 => "share of the area above the lower end of the core",
        }
    }

    /// The clause that defines the parameter.
    pub fn source(&self) -> &'static str {
        match self {
            Definition::Sa
            | Definition::Sq
            | Definition::Ssk
            | Definition::Sku
            | Definition::Sp
            | Definition::Sv
            | Definition::Sz => "ISO 25178-2:2021, height parameters",
            Definition::Sdq | Definition::Sdr => "ISO 25178-2:2021, hybrid parameters",
            Definition::Sal | Definition::Str => "ISO 25178-2:2021, spatial parameters",
            Definition::Sk
            | Definition::Spk
            | Definition::Svk
            | Definition::Smrk1
            | Definition::Smrk2 => "ISO 25178-2:2021, material ratio parameters; ISO 13565-2:1996",
        }
    }
}

impl fmt::Display for Definition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_has_its_sign_and_unit() {
        let figure = |definition| Figure { definition, value: 2.5 }.to_string();
        assert_eq!(figure(Definition::Sq), "Sq 2.5 nm");
        assert_eq!(figure(Definition::Sku), "Sku 2.5");
        assert_eq!(figure(Definition::Sdr), "Sdr 2.5 %");
    }
}
