//! The nominal file as text.

use std::fmt::Write as _;

use asphera_formats::zemax::{Lens, LensAperture, LensSurface};

/// `[surface]`, line by line.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Table {
    notes: String,
    lines: String,
    terms: String,
}

impl Table {
    /// A table that begins with its kind.
    pub(super) fn new(kind: &str) -> Table {
        Table { lines: format!("kind = \"{kind}\"\n"), ..Table::default() }
    }

    /// Cautions to be known before the table.
    pub(super) fn note(mut self, note: &str) -> Table {
        self.notes += &format!("# {note}\n");
        self
    }

    /// `file = path`, which may hold any letter.
    pub(super) fn file(mut self, path: &str) -> Table {
        self.lines += &format!("file = {}\n", toml_edit::Value::from(path));
        self
    }

    /// `key = word`.
    pub(super) fn word(mut self, key: &str, word: &str) -> Table {
        self.lines += &format!("{key} = \"{word}\"\n");
        self
    }

    /// `key = number`, by the shortest decimal that is this number.
    pub(super) fn number(mut self, key: &str, value: f64) -> Table {
        self.lines += &format!("{key} = {value:?}\n");
        self
    }

    /// `key = [numbers]`.
    pub(super) fn numbers(mut self, key: &str, values: &[f64]) -> Table {
        self.lines += &format!("{key} = {values:?}\n");
        self
    }

    /// A2, A4 …: order and coefficient.
    pub(super) fn powers(self, terms: &[(u32, f64)]) -> Table {
        terms.iter().fold(self, |table, (order, value)| table.number(&format!("A{order}"), *value))
    }

    /// One term: what names it, and its coefficient in mm.
    pub(super) fn term(mut self, names: &[(&str, u32)], value_mm: f64) -> Table {
        self.terms += "\n[[surface.terms]]\n";
        for (name, value) in names {
            self.terms += &format!("{name} = {value}\n");
        }
        self.terms += &format!("mm = {value_mm:?}\n");
        self
    }
}

/// The whole file.
pub(super) fn write(lens: &Lens, surface: &LensSurface, file: &str, table: &Table) -> String {
    let mut text = String::new();
    let name =
        lens.name.as_deref().map(|name| format!(" ({})", one_line(name))).unwrap_or_default();
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "# Surface {} of {}{name}, Zemax type {}.",
        surface.number,
        one_line(file),
        surface.kind
    );
    if let Some(comment) = &surface.comment {
        let _ = writeln!(text, "# Comment there: {}", one_line(comment));
    }
    text += "#\n# As in the file z runs along the light, and a radius is positive where its centre lies at +z. A probe looks at a first\n\
             # surface along the light: the fit then finds the part upside down (rx or ry near 3.14), and material that stands out towards\n\
             # the probe is a negative deviation.\n";
    if lens.unit_mm != 1.0 {
        let _ = writeln!(text, "# Lengths were converted from a lens unit of {} mm.", lens.unit_mm);
    }
    if lens.configurations > 1 {
        let _ = writeln!(
            text,
            "# The file has {} configurations: these are the values of the surface itself, which a configuration may replace.",
            lens.configurations
        );
    }
    if lens.surfaces.iter().any(|surface| surface.kind == "COORDBRK") {
        text += "# The coordinate breaks of the file were left out: decentres and tilts are no part of a nominal, a fit finds them.\n";
    }
    let _ = write!(text, "{}\n[surface]\n{}{}", table.notes, table.lines, table.terms);
    text += &aperture(lens, surface);
    text += "\n[fit]\n# The file does not say from which side the part is measured: the fit takes the one that fits.\nside = \"either\"\n";
    text
}

/// The aperture of the file, else the circle of its semi-diameter; where it is decentred, the piece of the surface within it.
fn aperture(lens: &Lens, surface: &LensSurface) -> String {
    let mm = |length: f64| length * lens.unit_mm;
    let is_decentred = surface.aperture_centre != [0.0; 2];
    let (what, shape) = match surface.aperture {
        Some(LensAperture::Round { radius }) if radius > 0.0 => {
            ("aperture", format!("shape = \"circle\"\nradius_mm = {:?}\n", mm(radius)))
        }
        Some(LensAperture::Rectangle { half_x, half_y }) if half_x > 0.0 && half_y > 0.0 => {
            let (width_mm, height_mm) = (mm(2.0 * half_x), mm(2.0 * half_y));
            let shape = "shape = \"rectangle\"";
            ("aperture", format!("{shape}\nwidth_mm = {width_mm:?}\nheight_mm = {height_mm:?}\n"))
        }
        // The semi-diameter is about the vertex, also where the aperture is not.
        _ if surface.semi_diameter > 0.0 && !is_decentred => {
            let radius_mm = mm(surface.semi_diameter);
            ("semi-diameter", format!("shape = \"circle\"\nradius_mm = {radius_mm:?}\n"))
        }
        _ => ("", String::new()),
    };
    let mut text = String::new();
    if is_decentred {
        let [x_mm, y_mm] = surface.aperture_centre.map(mm);
        text += "\n# The aperture of the file is decentred. The nominal is the piece within it, x and y from its middle.\n";
        text += &format!(
            "[surface.off_axis]\ndx_mm = {x_mm:?}\ndy_mm = {y_mm:?}\naxes = \"parallel\"\n"
        );
    }
    if !shape.is_empty() {
        text += &format!(
            "\n[aperture]\n# The {what} of the file: the edge of a part is seldom to be judged.\n{shape}"
        );
    }
    text
}

/// A text that stays in its comment.
fn one_line(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}
