//! Lines before the points: names of columns, and what comments say of units.

use super::Unit;
use super::dialect::{Separator, fields};

/// Content of a column, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    X,
    Y,
    Z,
    /// dz/dx.
    Slope,
    /// Standard uncertainty of z.
    Uncertainty,
}

impl Role {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Role::X => "x",
            Role::Y => "y",
            Role::Z => "z",
            Role::Slope => "slope",
            Role::Uncertainty => "u_z",
        }
    }

    fn of(name: &str) -> Option<Role> {
        let letters = name.chars().filter(|letter| letter.is_alphanumeric());
        let bare: String = letters.flat_map(char::to_lowercase).collect();
        Some(match bare.as_str() {
            "x" | "xpos" | "posx" | "xposition" | "positionx" | "xcoord" | "xcoordinate"
            | "points0" => Role::X,
            "y" | "ypos" | "posy" | "yposition" | "positiony" | "ycoord" | "ycoordinate"
            | "points1" => Role::Y,
            "z" | "zpos" | "posz" | "zposition" | "positionz" | "zcoord" | "zcoordinate"
            | "points2" | "height" | "heights" | "zheight" | "sag" => Role::Z,
            "slope" | "slopes" | "dzdx" => Role::Slope,
            "uz" => Role::Uncertainty,
            _ => return None,
        })
    }
}

/// Statement of the head on the unit of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stated {
    Nothing,
    Known(Unit),
    /// Something in brackets that is no unit known here.
    Unknown(String),
}

/// The name of a column, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Name {
    /// As the file has it, without quotes.
    pub(super) text: String,
    /// Without its unit.
    pub(super) bare: String,
    pub(super) role: Option<Role>,
    pub(super) unit: Stated,
}

impl Name {
    /// From `x`, `x_um`, `x [µm]`, `X (mm)` or `x/mm`.
    pub(super) fn of(text: &str) -> Name {
        let text = text.trim().trim_matches('"').trim();
        let (bare, unit) = match text.find(['[', '(']) {
            Some(open) => {
                let inner = text[open + 1..].trim_end_matches([']', ')']).trim();
                let stated = match Unit::from_word(inner) {
                    _ if inner.is_empty() => Stated::Nothing,
                    Some(unit) => Stated::Known(unit),
                    None => Stated::Unknown(inner.to_owned()),
                };
                (text[..open].trim(), stated)
            }
            None => {
                let end = text.rsplit_once(['_', '/', ' ', '-', '.']);
                match end.and_then(|(bare, end)| Some((bare, Unit::from_word(end)?))) {
                    Some((bare, unit)) if !bare.is_empty() => (bare, Stated::Known(unit)),
                    _ => (text, Stated::Nothing),
                }
            }
        };
        Name { text: text.to_owned(), bare: bare.to_owned(), role: Role::of(bare), unit }
    }

    /// Whether it is an angle of places in polar coordinates: `theta`, `phi_deg`.
    pub(super) fn is_angle(&self) -> bool {
        let first = self.bare.split(|letter: char| !letter.is_alphanumeric()).next();
        let first = first.unwrap_or_default().to_lowercase();
        ANGLES.contains(&first.as_str())
    }

    /// Whether the user means this column by `word`: its name with or without its unit.
    pub(super) fn is_called(&self, word: &str) -> bool {
        let same = |name: &str| name.to_lowercase() == word.trim().to_lowercase();
        same(&self.text) || same(&self.bare)
    }
}

/// Names of angles about an axis.
const ANGLES: [&str; 13] = [
    "theta", "phi", "angle", "azimuth", "azimut", "polar", "rotation", "rotary", "alpha", "θ", "φ",
    "ϕ", "c",
];

/// The names in a line of text as many columns as it takes, if some separator gives that many.
pub(super) fn names(content: &str, columns: usize) -> Option<Vec<Name>> {
    let words = marked(content, columns).or_else(|| {
        let words = joined(split(content, Separator::Space).into_iter());
        (words.len() == columns).then_some(words)
    });
    words.filter(|_| columns > 1).map(|words| words.iter().map(|word| Name::of(word)).collect())
}

/// The names in a line of text that a mark separates, if some mark gives as many columns.
pub(super) fn marked_names(content: &str, columns: usize) -> Option<Vec<Name>> {
    marked(content, columns).map(|words| words.iter().map(|word| Name::of(word)).collect())
}

/// The fields of a line that a mark separates, if some mark gives that many. One at the end makes no column.
fn marked(content: &str, columns: usize) -> Option<Vec<String>> {
    [Separator::Semicolon, Separator::Tab, Separator::Comma].into_iter().find_map(|separator| {
        let mut words = split(content, separator);
        if words.len() == columns + 1 && words[columns].is_empty() {
            words.pop();
        }
        (words.len() == columns).then_some(words)
    })
}

fn split(content: &str, separator: Separator) -> Vec<String> {
    let mut found = Vec::new();
    fields(content.as_bytes(), separator, &mut found);
    found.iter().map(|field| String::from_utf8_lossy(field).into_owned()).collect()
}

/// Words with a unit in brackets that stands alone joined to the name before it.
fn joined(words: impl Iterator<Item = String>) -> Vec<String> {
    words.fold(Vec::new(), |mut joined, word| {
        match joined.last_mut() {
            Some(name) if word.starts_with(['[', '(']) => *name = format!("{name} {word}"),
            _ => joined.push(word),
        }
        joined
    })
}

/// What a line says of each column that holds nothing but their units, as some heads have below their names. Columns that
/// are no lengths may have others, as s or %, or none.
pub(super) fn units(content: &str, columns: usize) -> Option<Vec<Stated>> {
    let words = marked(content, columns).or_else(|| {
        let words = split(content, Separator::Space);
        (words.len() == columns).then_some(words)
    });
    let stated = words?.into_iter().map(|word| unit_alone(&word));
    let stated: Vec<Stated> = stated.collect::<Option<_>>()?;
    stated.iter().any(|unit| matches!(unit, Stated::Known(_))).then_some(stated)
}

/// A word as a unit: none where it is empty, unknown where it is short and names no column.
fn unit_alone(word: &str) -> Option<Stated> {
    let bare = word.trim_matches(['[', ']', '(', ')']).trim();
    match Unit::from_word(bare) {
        Some(unit) => Some(Stated::Known(unit)),
        None if bare.is_empty() || bare == "-" => Some(Stated::Nothing),
        None if Role::of(bare).is_none() && bare.chars().count() <= LONGEST_UNIT => {
            Some(Stated::Unknown(bare.to_owned()))
        }
        None => None,
    }
}

/// Letters of the longest unit that is no length and is taken for one, as `counts`.
const LONGEST_UNIT: usize = 6;

/// Statement of one comment on the units of x, y and z, or slope.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Said {
    /// Of columns that it names.
    Of(Vec<(Role, Unit)>),
    /// Of all lengths: it has the word `unit`, or names x, y and z before.
    All(Unit),
    /// It says `in …` or `[…]` of something that is not named as a column.
    OfSomething(Unit),
}

/// A comment taken apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Remark {
    /// The columns it names, in its order.
    pub(super) roles: Vec<(Role, Stated)>,
    pub(super) said: Vec<Said>,
}

/// Names of columns and statements of units in a comment, such as `x y z in metres`, `x, y in mm, z in um`, `units: um`.
pub(super) fn remark(comment: &str) -> Remark {
    let words =
        comment.split(|mark: char| mark.is_whitespace() || [',', ';', ':', '='].contains(&mark));
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    let mut remark = Remark { roles: Vec::new(), said: Vec::new() };
    let mut pending: Vec<Role> = Vec::new();
    let mut names_unit = false;
    for (index, word) in words.iter().enumerate() {
        let before = index.checked_sub(1).map_or("", |index| words[index]).to_lowercase();
        let is_bracketed = word.starts_with(['[', '(']);
        let bare = word.trim_matches(['[', ']', '(', ')', '.']);
        let may_be_unit = before == "in"
            || is_bracketed
            || names_unit && !["in", "of", "is", "are", "length"].contains(&bare);
        if let Some(unit) = Unit::from_word(bare).filter(|_| may_be_unit) {
            remark.said.push(match &pending[..] {
                [] if names_unit => Said::All(unit),
                [] => Said::OfSomething(unit),
                roles => Said::Of(roles.iter().map(|&role| (role, unit)).collect()),
            });
            pending.clear();
            names_unit = false;
            continue;
        }
        names_unit |= ["unit", "units"].contains(&bare.to_lowercase().as_str());
        let name = Name::of(word);
        if let Some(role) = name.role {
            if let Stated::Known(unit) = name.unit {
                remark.said.push(Said::Of(vec![(role, unit)]));
            } else {
                pending.push(role);
            }
            remark.roles.push((role, name.unit));
        }
    }
    remark
}

/// The unit that a comment states of all lengths: `units: um`, `x y z in metres`, `coordinates in mm`.
pub(crate) fn unit_in_comment(comment: &str) -> Option<Unit> {
    let lower = comment.to_lowercase();
    let names_all = ["coordinate", "length", "vertices", "vertex", "points", "positions"]
        .iter()
        .any(|word| lower.contains(word));
    let of_all = |said: Said| match said {
        Said::All(unit) => Some(unit),
        Said::OfSomething(unit) if names_all => Some(unit),
        Said::Of(units) => {
            let unit = units.first()?.1;
            (units.len() == 3 && units.iter().all(|(_, other)| *other == unit)).then_some(unit)
        }
        Said::OfSomething(_) => None,
    };
    let found = remark(comment).said.into_iter().find_map(of_all);
    found.filter(|unit| !unit.is_slope() && !lower.contains("wavelength"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_their_units_are_taken_apart() {
        for (text, role, unit) in [
            ("x", Role::X, None),
            ("x_um", Role::X, Some(Unit::Um)),
            ("x [µm]", Role::X, Some(Unit::Um)),
            ("X (mm)", Role::X, Some(Unit::Mm)),
            ("\"Y/mm\"", Role::Y, Some(Unit::Mm)),
            ("Pos_Y", Role::Y, None),
            ("height_nm", Role::Z, Some(Unit::Nm)),
            ("z[m]", Role::Z, Some(Unit::M)),
            ("u_z(um)", Role::Uncertainty, Some(Unit::Um)),
            ("slope_urad", Role::Slope, Some(Unit::Urad)),
            ("dz/dx", Role::Slope, None),
        ] {
            let name = Name::of(text);
            let stated = unit.map_or(Stated::Nothing, Stated::Known);
            assert_eq!((name.role, name.unit), (Some(role), stated), "{text}");
        }
        for text in ["index", "x_nom", "id", "lon", "x2", ""] {
            assert_eq!(Name::of(text).role, None, "{text}");
        }
        assert_eq!(Name::of("z (furlong)").unit, Stated::Unknown("furlong".into()));
    }

    #[test]
    fn comments_state_units_of_what_they_name() {
        use Role::{X, Y, Z};
        let said = |text: &str| remark(text).said;
        let all = |unit| Said::Of(vec![(X, unit), (Y, unit), (Z, unit)]);
        assert_eq!(said("x y z in metres"), [all(Unit::M)]);
        assert_eq!(said("X, Y, Z [mm]"), [all(Unit::Mm)]);
        assert_eq!(
            said("x and y in mm, z in um"),
            [Said::Of(vec![(X, Unit::Mm), (Y, Unit::Mm)]), Said::Of(vec![(Z, Unit::Um)])]
        );
        assert_eq!(said("Units: um"), [Said::All(Unit::Um)]);
        assert_eq!(said("unit of length = m"), [Said::All(Unit::M)]);
        assert_eq!(said("wavelength in nm: 632.8"), [Said::OfSomething(Unit::Nm)]);
        assert!(said("pitch 5 um, made in 2024").is_empty());
    }

    #[test]
    fn comments_of_meshes_state_one_unit_of_all_lengths() {
        assert_eq!(unit_in_comment("coordinates in mm, measured frame"), Some(Unit::Mm));
        assert_eq!(unit_in_comment("comment units: um"), Some(Unit::Um));
        assert_eq!(unit_in_comment("x y z in metres"), Some(Unit::M));
        assert_eq!(unit_in_comment("deviation in nm, nan where there is none"), None);
        assert_eq!(unit_in_comment("wavelength in nm: 632.8"), None);
        assert_eq!(unit_in_comment("VCGLIB generated"), None);
    }
}
