//! Parameters of surface texture: the rows of the catalogue.

use crate::catalogue::Row;
use crate::{Definition, Figure, Statistic, Subject, Unit};

/// Which parameter of ISO 25178-2:2021.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
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

impl Parameter {
    /// Figures of the parameters that have a value.
    pub(super) fn known(list: &[(Parameter, Option<f64>)]) -> Vec<Figure> {
        let known = list.iter().filter_map(|&(parameter, value)| Some((parameter, value?)));
        known.map(|(parameter, value)| Figure::new(Definition::Texture(parameter), value)).collect()
    }

    pub(crate) fn row(self) -> &'static Row {
        match self {
            Parameter::Sa => &SA,
            Parameter::Sq => &SQ,
            Parameter::Ssk => &SSK,
            Parameter::Sku => &SKU,
            Parameter::Sp => &SP,
            Parameter::Sv => &SV,
            Parameter::Sz => &SZ,
            Parameter::Sdq => &SDQ,
            Parameter::Sdr => &SDR,
            Parameter::Sal => &SAL,
            Parameter::Str => &STR,
            Parameter::Sk => &SK,
            Parameter::Spk => &SPK,
            Parameter::Svk => &SVK,
            Parameter::Smrk1 => &SMRK1,
            Parameter::Smrk2 => &SMRK2,
        }
    }
}

/// The row of a parameter of the kind of `like`.
const fn row(id: &'static str, symbol: &'static str, like: Row, text: &'static str) -> Row {
    Row { id, symbol, name: symbol, text, ..like }
}

const SA: Row =
    row("sa", "Sa", HEIGHT, "area-weighted mean of the size of the heights about the datum");
const SQ: Row = Row {
    statistic: Statistic::MeanSquare,
    ..row(
        "sq",
        "Sq",
        HEIGHT,
        "root of the area-weighted mean square of the heights about the datum",
    )
};
const SSK: Row = Row {
    unit: Unit::One,
    ..row("ssk", "Ssk", HEIGHT, "area-weighted mean cube of the heights over the cube of Sq")
};
const SKU: Row = Row {
    unit: Unit::One,
    ..row("sku", "Sku", HEIGHT, "area-weighted mean fourth power of the heights over that of Sq")
};
const SP: Row = Row {
    statistic: Statistic::Extreme,
    ..row("sp", "Sp", HEIGHT, "largest height about the datum at a measured place")
};
const SV: Row = Row {
    statistic: Statistic::Extreme,
    ..row("sv", "Sv", HEIGHT, "minus the smallest height about the datum at a measured place")
};
const SZ: Row = Row {
    statistic: Statistic::Extreme,
    ..row("sz", "Sz", HEIGHT, "largest minus smallest height at the measured places")
};
const SDQ: Row = Row {
    unit: Unit::Microradians,
    statistic: Statistic::MeanSquareSlope,
    ..row(
        "sdq",
        "Sdq",
        HYBRID,
        "root mean square gradient of the surface interpolated linearly on triangles; on a grid \
         the mean of both divisions of each cell",
    )
};
const SDR: Row = Row {
    unit: Unit::Percent,
    ..row(
        "sdr",
        "Sdr",
        HYBRID,
        "excess of the area of the surface interpolated linearly on triangles over its \
         projection; on a grid the mean of both divisions of each cell",
    )
};
const SAL: Row = Row {
    unit: Unit::Micrometres,
    ..row(
        "sal",
        "Sal",
        SPATIAL,
        "shortest lag, in any direction, at which the autocorrelation first falls to the \
         threshold; each lag is averaged over the pairs of measured places it has",
    )
};
const STR: Row = Row {
    unit: Unit::One,
    ..row(
        "str",
        "Str",
        SPATIAL,
        "shortest over longest lag, by direction, at which the autocorrelation first falls to \
         the threshold",
    )
};
const SK: Row = row(
    "sk",
    "Sk",
    CORE,
    "fall from 0 to 100 % of the least-squares line through the 40 % of the material ratio \
         curve with the flattest secant",
);
const SPK: Row = row(
    "spk",
    "Spk",
    CORE,
    "height of the triangle on Smrk1 whose area is that of the material above the core",
);
const SVK: Row = row(
    "svk",
    "Svk",
    CORE,
    "depth of the triangle on 100 % − Smrk2 whose area is that of the void below the core",
);
const SMRK1: Row =
    Row { unit: Unit::Percent, ..row("smrk1", "Smrk1", CORE, "share of the area above the core") };
const SMRK2: Row = Row {
    unit: Unit::Percent,
    ..row("smrk2", "Smrk2", CORE, "share of the area above the lower end of the core")
};
const HEIGHT: Row = Row {
    id: "",
    symbol: "",
    name: "",
    unit: Unit::Nanometres,
    subject: Subject::Filtered,
    statistic: Statistic::Compound,
    text: "",
    source: "ISO 25178-2:2021, height parameters",
};
const HYBRID: Row = Row { source: "ISO 25178-2:2021, hybrid parameters", ..HEIGHT };
const SPATIAL: Row = Row { source: "ISO 25178-2:2021, spatial parameters", ..HEIGHT };
const CORE: Row =
    Row { source: "ISO 25178-2:2021, material ratio parameters; ISO 13565-2:1996", ..HEIGHT };
