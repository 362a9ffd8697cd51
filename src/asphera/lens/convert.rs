//! The table `[surface]` of each kind of surface that is converted. Coefficients of powers change with the lens unit by their dimension.

use asphera_form::basis::{Counting, Product};
use asphera_formats::zemax::{Lens, LensSurface};

use super::text::Table;
use super::{LensImportError, list, refused};

/// The table of a surface; `heights` is the name of its file of heights, if it has one.
pub(super) fn table(
    lens: &Lens,
    surface: &LensSurface,
    heights: Option<&str>,
) -> Result<Table, LensImportError> {
    let given = Given { surface, unit_mm: lens.unit_mm };
    match (surface.kind.as_str(), heights) {
        ("GRID_SAG", Some(heights)) => given.grid(heights),
        ("GRID_SAG", None) => {
            Err(LensImportError::NoHeights { number: surface.number, line: surface.line })
        }
        (kind, Some(_)) if KNOWN.contains(&kind) => Err(LensImportError::OtherHeights {
            number: surface.number,
            line: surface.line,
            kind: kind.to_owned(),
        }),
        ("STANDARD", _) => Ok(given.standard()),
        ("EVENASPH", _) => given.even(),
        ("XASPHERE", _) => given.extended(),
        ("ODDASPHE", _) => given.odd(),
        ("XOSPHERE", _) => given.extended_odd(),
        ("BICONICX", _) => Ok(given.biconic()),
        ("TOROIDAL", _) => given.toroid(),
        ("QED_TYPE", _) => given.q(),
        ("XPOLYNOM", _) => given.polynomial(),
        ("FZERNSAG", _) => given.zernike(Counting::Fringe),
        ("SZERNSAG", _) => given.zernike(Counting::Noll),
        ("IRREGULA", _) => given.irregular(),
        (kind, _) => Err(LensImportError::Kind {
            number: surface.number,
            line: surface.line,
            hint: refused::why(kind),
            kind: kind.to_owned(),
            known: KNOWN.join(", "),
            listed: list(lens),
        }),
    }
}

/// The kinds that are converted.
const KNOWN: [&str; 13] = [
    "STANDARD", "EVENASPH", "XASPHERE", "ODDASPHE", "XOSPHERE", "BICONICX", "TOROIDAL", "QED_TYPE",
    "XPOLYNOM", "FZERNSAG", "SZERNSAG", "GRID_SAG", "IRREGULA",
];

/// A surface and the size of its unit.
struct Given<'a> {
    surface: &'a LensSurface,
    unit_mm: f64,
}

impl Given<'_> {
    fn standard(&self) -> Table {
        match (self.surface.curvature, self.surface.conic) {
            (0.0, _) => Table::new("plane"),
            (_, 0.0) => Table::new("sphere").number("radius_mm", self.radius_mm()),
            (_, conic) => {
                Table::new("conic").number("radius_mm", self.radius_mm()).number("conic", conic)
            }
        }
    }

    /// Parameters 1 to 8 belong to r² to r¹⁶.
    fn even(&self) -> Result<Table, LensImportError> {
        self.no_parameters_from(9)?;
        let powers = self.powers(1..=8, |number| 2 * number);
        if powers.is_empty() {
            return Ok(self.standard());
        }
        Ok(self.over_base("asphere").powers(&powers))
    }

    /// Extra data: 1 the number of terms, 2 the radius ρ is normalised by, from 3 on the coefficients of ρ², ρ⁴ … in lens units.
    fn extended(&self) -> Result<Table, LensImportError> {
        self.normalised("asphere", LARGEST_TERM, |term| 2 * term)
    }

    /// As the extended asphere, from 3 on the coefficients of ρ, ρ², ρ³ ….
    fn extended_odd(&self) -> Result<Table, LensImportError> {
        self.normalised("odd-asphere", 2 * LARGEST_TERM, |term| term)
    }

    /// Powers of the distance from the axis over a normalisation radius; `order` is that of a term, from 1 on.
    fn normalised(
        &self,
        kind: &str,
        most: usize,
        order: impl Fn(u32) -> u32,
    ) -> Result<Table, LensImportError> {
        // Programs other than OpticStudio put an even asphere's parameters here, which would be lost in silence.
        self.no_parameters_from(1)?;
        let terms = self.terms(most)?;
        if terms.is_empty() {
            return Ok(self.standard());
        }
        let radius_mm = self.normalisation_mm(2)?;
        let power = |(index, value_mm): (usize, f64)| {
            // At most 254 of them.
            let order = order(index as u32 + 1);
            (order, value_mm / radius_mm.powi(order as i32))
        };
        let powers: Vec<(u32, f64)> = terms.into_iter().map(power).collect();
        Ok(self.over_base(kind).powers(&powers))
    }

    /// Parameters 1 to 8 belong to r to r⁸.
    fn odd(&self) -> Result<Table, LensImportError> {
        self.no_parameters_from(9)?;
        let powers = self.powers(1..=8, |number| number);
        if powers.is_empty() {
            return Ok(self.standard());
        }
        Ok(self.over_base("odd-asphere").powers(&powers))
    }

    /// Radius and conic constant are those along y; parameters 1 and 2 those along x, a radius of 0 being infinite.
    fn biconic(&self) -> Table {
        let radius_x_mm = self.surface.parameter(1) * self.unit_mm;
        let is_flat_y = self.surface.curvature == 0.0;
        if radius_x_mm == 0.0 && is_flat_y {
            return Table::new("plane");
        }
        let mut table = Table::new("biconic");
        if radius_x_mm != 0.0 {
            table = table
                .number("radius_x_mm", radius_x_mm)
                .number("conic_x", self.surface.parameter(2));
        }
        if !is_flat_y {
            table =
                table.number("radius_y_mm", self.radius_mm()).number("conic_y", self.surface.conic);
        }
        table
    }

    /// Parameter 1 is the radius of rotation, 0 being infinite; 2 to 8 belong to y² to y¹⁴. Extra data may add Zernike terms.
    fn toroid(&self) -> Result<Table, LensImportError> {
        self.no_parameters_from(9)?;
        if let Some((number, value)) =
            self.surface.extra.iter().find(|(number, value)| **number > 2 && **value != 0.0)
        {
            return Err(self.refused(
                format!("XDAT {number}, a Zernike term"),
                *value,
                "0: a toroid here has none",
            ));
        }
        let powers = self.powers(2..=8, |number| 2 * (number - 1));
        let rotation_mm = self.surface.parameter(1) * self.unit_mm;
        if rotation_mm != 0.0 {
            let table = self.over_base("toroid").powers(&powers);
            return Ok(table.number("rotation_radius_mm", rotation_mm));
        }
        if self.surface.curvature == 0.0 && powers.is_empty() {
            return Ok(Table::new("plane"));
        }
        Ok(self.over_base("cylinder").word("straight_along", "x").powers(&powers))
    }

    /// Extra data: 1 the type (0 Q-bfs, 1 Q-con), 2 the number of terms, 3 the normalisation radius, from 4 on the coefficients.
    fn q(&self) -> Result<Table, LensImportError> {
        let count = self.count(2)?;
        let coefficients_mm: Vec<f64> =
            (4..4 + count).map(|number| self.surface.extra(number) * self.unit_mm).collect();
        let (kind, is_bfs) = match self.surface.extra(1) {
            0.0 => ("q-bfs", true),
            1.0 => ("q-con", false),
            found => {
                return Err(self.refused(
                    "XDAT 1, the type".to_owned(),
                    found,
                    "0 (Q-bfs) or 1 (Q-con)",
                ));
            }
        };
        if coefficients_mm.iter().all(|coefficient| *coefficient == 0.0) {
            return Ok(self.standard());
        }
        let mut table =
            self.over_base(kind).number("normalisation_radius_mm", self.normalisation_mm(3)?);
        if is_bfs {
            table = table.word("projection", "conic-normal");
        }
        Ok(table.numbers("coefficients_mm", &coefficients_mm))
    }

    /// Extra data: 1 the number of terms, 2 the normalisation radius, from 3 on the coefficients of x, y, x², xy, y² ….
    fn polynomial(&self) -> Result<Table, LensImportError> {
        let orders = Product::degree_orders(1, LARGEST_DEGREE);
        let terms = self.terms(orders.len())?;
        if terms.is_empty() {
            return Ok(self.standard());
        }
        let base =
            self.over_base("xy").number("normalisation_radius_mm", self.normalisation_mm(2)?);
        Ok(terms.into_iter().fold(base, |table, (index, value_mm)| {
            let (x, y) = orders[index];
            table.term(&[("x", x), ("y", y)], value_mm)
        }))
    }

    /// Parameters 1 to 8 as of an even asphere, then decentrings; extra data as of the polynomial. Fringe terms are of unit height,
    /// standard ones (Noll's) of unit RMS.
    fn zernike(&self, counting: Counting) -> Result<Table, LensImportError> {
        self.no_parameters_from(9)?;
        let (indices, normalisation, most) = match counting {
            Counting::Fringe => ("fringe", "unit-height", 37),
            Counting::Noll | Counting::Ansi => ("noll", "unit-rms", 231),
        };
        let terms = self.terms(most)?;
        if terms.is_empty() {
            return self.even();
        }
        let base = self
            .over_base("zernike")
            .word("indices", indices)
            .word("normalisation", normalisation)
            .number("normalisation_radius_mm", self.normalisation_mm(2)?)
            .powers(&self.powers(1..=8, |number| 2 * number));
        Ok(terms.into_iter().fold(base, |table, (index, value_mm)| {
            // At most 231 of them.
            table.term(&[("index", index as u32 + 1)], value_mm)
        }))
    }

    /// Parameters 1 to 8 as of an even asphere, then decentrings of the Zernike terms; extra data may add such terms.
    fn grid(&self, heights: &str) -> Result<Table, LensImportError> {
        self.no_parameters_from(11)?;
        if !self.terms(MOST_TERMS as usize)?.is_empty() {
            return Err(self.refused(
                "XDAT 1, the number of Zernike terms".to_owned(),
                self.surface.extra(1),
                "0: a grid here has none; add them to its heights",
            ));
        }
        let powers = self.powers(1..=8, |number| 2 * number);
        let is_plain = self.surface.curvature == 0.0 && powers.is_empty();
        let table = if is_plain { Table::new("grid") } else { self.over_base("grid") };
        Ok(table.note(BETWEEN_HEIGHTS).file(heights).powers(&powers))
    }

    /// A conic with decentre, tilt, spherical aberration, astigmatism and coma as parameters 1 to 7, at the angle of parameter 8.
    fn irregular(&self) -> Result<Table, LensImportError> {
        match self.surface.parameters.range(1..8).find(|(_, value)| **value != 0.0) {
            Some((number, value)) => Err(self.refused(
                format!("PARM {number}"),
                *value,
                "0: this kind models what a part may deviate by; its design is the surface without",
            )),
            None => Ok(self.standard()),
        }
    }

    /// The terms that are not 0, by their place from 0 on: extra data from 3 on, as many as extra datum 1 says.
    fn terms(&self, most: usize) -> Result<Vec<(usize, f64)>, LensImportError> {
        let count = self.count(1)?;
        if count as usize > most {
            return Err(self.refused(
                "XDAT 1, the number of terms".to_owned(),
                f64::from(count),
                "no more than there are of this kind",
            ));
        }
        let terms = (3..3 + count).map(|number| self.surface.extra(number) * self.unit_mm);
        Ok(terms.enumerate().filter(|(_, value_mm)| *value_mm != 0.0).collect())
    }

    /// The kind over its conic, or over a plane.
    fn over_base(&self, kind: &str) -> Table {
        let table = Table::new(kind);
        if self.surface.curvature == 0.0 {
            return table.word("base", "flat");
        }
        let table = table.number("radius_mm", self.radius_mm());
        if self.surface.conic == 0.0 { table } else { table.number("conic", self.surface.conic) }
    }

    /// Parameters that are not 0 as coefficients of powers, in mm^(1−order).
    fn powers(
        &self,
        numbers: std::ops::RangeInclusive<u32>,
        order: impl Fn(u32) -> u32,
    ) -> Vec<(u32, f64)> {
        numbers
            .map(|number| (order(number), self.surface.parameter(number)))
            .filter(|(_, value)| *value != 0.0)
            .map(|(order, value)| (order, value * self.unit_mm / self.unit_mm.powi(order as i32)))
            .collect()
    }

    /// The shortest decimal whose inverse is the curvature, to rounding: 11.65 where the file has 0.0858369098712….
    fn radius_mm(&self) -> f64 {
        let curvature = self.surface.curvature / self.unit_mm;
        let radius_mm = curvature.recip();
        (0..17)
            .filter_map(|digits| format!("{radius_mm:.digits$e}").parse::<f64>().ok())
            .find(|short| (short.recip() - curvature).abs() <= 2.0 * f64::EPSILON * curvature.abs())
            .unwrap_or(radius_mm)
    }

    fn count(&self, number: u32) -> Result<u32, LensImportError> {
        let found = self.surface.extra(number);
        if found.fract() == 0.0 && (0.0..=MOST_TERMS).contains(&found) {
            // A whole number in that range.
            return Ok(found as u32);
        }
        Err(self.refused(
            format!("XDAT {number}, the number of terms"),
            found,
            "a whole number up to 250",
        ))
    }

    fn normalisation_mm(&self, number: u32) -> Result<f64, LensImportError> {
        let found = self.surface.extra(number);
        if found > 0.0 {
            return Ok(found * self.unit_mm);
        }
        Err(self.refused(format!("XDAT {number}, the normalisation radius"), found, "above 0"))
    }

    fn no_parameters_from(&self, first: u32) -> Result<(), LensImportError> {
        match self.surface.parameters.range(first..).find(|(_, value)| **value != 0.0) {
            Some((number, value)) => Err(self.refused(
                format!("PARM {number}"),
                *value,
                "0: such surfaces are not converted",
            )),
            None => Ok(()),
        }
    }

    fn refused(&self, value: String, found: f64, expected: &'static str) -> LensImportError {
        LensImportError::Value {
            number: self.surface.number,
            line: self.surface.line,
            kind: self.surface.kind.clone(),
            value,
            found: found.to_string(),
            expected,
        }
    }
}

/// Of every grid.
const BETWEEN_HEIGHTS: &str = "Between heights OpticStudio interpolates as parameter 0 says (0 bicubic, 1 linear), a nominal by quintics.";
/// Of the extended asphere, which has 240: nominal files have r²⁵⁴ at the highest.
const LARGEST_TERM: usize = 127;
/// Of the extended polynomial.
const LARGEST_DEGREE: u32 = 20;
/// Above what any of these surfaces has.
const MOST_TERMS: f64 = 250.0;
