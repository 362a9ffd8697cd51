//! Which columns hold the points, and their units: by options, names, comments, or the plain default.

use super::head::{Name, Role, Stated, names, remark, units};
use super::stated_units::with_units;
use super::{Unit, unclear};
use crate::ReadError;

/// Options of the user for a text file. All of it may be left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextOptions {
    /// The columns that hold x, y, z, and perhaps u_z; two are x and z, or x and slope.
    pub columns: Vec<Column>,
    /// The unit of every length, or one for each column.
    pub units: Vec<Unit>,
    /// Lines at the start of the file that are not read.
    pub skip_lines: usize,
    /// The file is a matrix of heights with this distance of columns and rows, mm; both finite and above 0.
    pub pitch_mm: Option<[f64; 2]>,
    /// Numbers such as -999 far from all other heights are heights, no marks for no data.
    pub keeps_marks: bool,
    /// The points may lie in a plane: of columns named x and y, or of two without names, the second is y. It is read as the height of
    /// a profile, 0 in y.
    pub in_plane: bool,
}

/// A column of a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Column {
    /// Counted from 1.
    Number(usize),
    /// By its name, with or without its unit.
    Name(String),
}

/// Columns and units as a text file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Those that were read, x first.
    pub columns: Vec<TakenColumn>,
    /// Origin of the names of columns.
    pub named_by: By,
    /// Origin of the units; [`By::Default`] is mm.
    pub units_by: By,
    /// Whether decimals have a comma.
    pub has_decimal_commas: bool,
    /// Lines of text before the points that name neither columns nor units, and were not read.
    pub passed_over: usize,
    /// Doubts about the heights, in words.
    pub cautions: Vec<String>,
}

/// A column that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TakenColumn {
    /// `x`, `y`, `z`, `slope`, `u_z`.
    pub name: &'static str,
    /// Counted from 1.
    pub number: usize,
    /// Its unit in the file.
    pub unit: Unit,
}

/// Where it is said what columns are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// By the user.
    Options,
    /// In the file, before the points.
    Head,
    /// Nowhere: x, y, z in mm.
    Default,
}

/// A line before the points, without its comment mark.
pub(super) struct Line {
    pub(super) text: String,
    pub(super) is_comment: bool,
}

/// How the lines of points are read.
pub(super) struct Layout {
    pub(super) slots: Vec<Slot>,
    /// Whether longer lines are read too: the user named the columns.
    pub(super) may_be_longer: bool,
    pub(super) named_by: By,
    pub(super) units_by: By,
    /// Lines of text before the points that say nothing of them.
    passed_over: usize,
    /// As in [`TextOptions`].
    pub(super) keeps_marks: bool,
}

/// A column to be read; `column` counts from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub(super) role: Role,
    /// As people are told.
    pub(super) name: &'static str,
    pub(super) column: usize,
    pub(super) unit: Unit,
}

/// The line that names the columns.
pub(super) struct Head {
    pub(super) names: Vec<Name>,
    /// Those of a line of units below it.
    pub(super) units: Option<Vec<Stated>>,
}

impl Layout {
    /// For lines of points of `width` columns, the first of which is in line `line`, after `before`.
    pub(super) fn of(
        before: &[Line],
        line: usize,
        width: usize,
        options: &TextOptions,
    ) -> Result<Layout, ReadError> {
        let head = head(before, line, width, options)?;
        let (roles, named_by) = match (&options.columns[..], &head) {
            ([], Some(head)) => (by_names(line, &head.names, options)?, By::Head),
            ([], None) => (by_count(line, width, options)?, By::Default),
            (columns, head) => (by_options(line, width, columns, head.as_ref())?, By::Options),
        };
        let (slots, units_by) = with_units(before, line, roles, head.as_ref(), options)?;
        let may_be_longer = named_by == By::Options;
        let passed_over = passed_over(before, width, head.as_ref());
        let keeps_marks = options.keeps_marks;
        Ok(Layout { slots, may_be_longer, named_by, units_by, passed_over, keeps_marks })
    }

    pub(super) fn has_slopes(&self) -> bool {
        self.slots.iter().any(|slot| slot.role == Role::Slope)
    }

    pub(super) fn taken(&self, has_decimal_commas: bool, cautions: Vec<String>) -> Taken {
        let columns = self.slots.iter().map(|slot| TakenColumn {
            name: slot.name,
            number: slot.column + 1,
            unit: slot.unit,
        });
        Taken {
            columns: columns.collect(),
            named_by: self.named_by,
            units_by: self.units_by,
            has_decimal_commas,
            passed_over: self.passed_over,
            cautions,
        }
    }
}

/// The line that names the columns: the last of text that names x, or else a comment that does, or else the last line
/// of text with as many words as there are columns.
fn head(
    before: &[Line],
    line: usize,
    width: usize,
    options: &TextOptions,
) -> Result<Option<Head>, ReadError> {
    let mut below = None;
    let (mut other, mut commented) = (None, None);
    for Line { text, is_comment, .. } in before.iter().rev() {
        if *is_comment {
            commented = commented.or_else(|| in_comment(text, width));
            continue;
        }
        if let Some(units) = units(text, width) {
            below.get_or_insert(units);
            continue;
        }
        let found = names(text, width);
        if found.as_ref().is_some_and(|names| has(names, Role::X) || is_radial(names)) {
            return Ok(found.map(|names| Head { names, units: below }));
        }
        let roles: Vec<Role> = remark(text).roles.into_iter().map(|(role, _)| role).collect();
        if found.is_none()
            && roles.contains(&Role::X)
            && roles.len() > 1
            && options.columns.is_empty()
        {
            let found =
                format!("lines of {width} columns do not fit the names \"{}\"", short(text));
            return Err(unclear(line, found, COLUMNS));
        }
        other = other.or(found);
    }
    Ok(commented.or(other).map(|names| Head { names, units: below }))
}

/// How many lines of text say nothing of the points: neither names nor units.
fn passed_over(before: &[Line], width: usize, head: Option<&Head>) -> usize {
    let is_read = |text: &str| {
        units(text, width).is_some()
            || head.is_some_and(|head| names(text, width).as_ref() == Some(&head.names))
    };
    before.iter().filter(|line| !line.is_comment && !is_read(&line.text)).count()
}

/// The names of columns in a comment. Its units are those that it states.
fn in_comment(comment: &str, width: usize) -> Option<Vec<Name>> {
    let roles = remark(comment).roles;
    let distinct = roles
        .iter()
        .enumerate()
        .all(|(at, (role, _))| roles[..at].iter().all(|(other, _)| other != role));
    let bare = |names: Vec<Name>| {
        let nameless = |name: Name| match name.unit {
            Stated::Known(_) => Name { unit: Stated::Nothing, ..name },
            _ => name,
        };
        names.into_iter().map(nameless).collect::<Vec<Name>>()
    };
    let label = comment.rsplit_once(':').map_or(comment, |(_, after)| after);
    // Each with a unit of its own is as plain as a line of text.
    let whole = [comment, label].into_iter().find_map(|text| {
        let has_unit = |name: &Name| matches!(name.unit, Stated::Known(_));
        names(text, width).filter(|names| is_enough(names) && names.iter().all(has_unit))
    });
    if whole.is_some() {
        return whole;
    }
    let listed = [comment, label].into_iter().find_map(|text| {
        let words =
            text.split_whitespace().take_while(|word| !["in", "unit", "units"].contains(word));
        let text = words.filter(|word| !word.starts_with(['[', '('])).collect::<Vec<_>>().join(" ");
        names(&text, width).filter(|names| is_enough(names))
    });
    let roles_only = || {
        let names = roles.iter().map(|(role, unit)| Name {
            text: role.name().to_owned(),
            bare: role.name().to_owned(),
            role: Some(*role),
            unit: unit.clone(),
        });
        (distinct && roles.len() == width)
            .then(|| names.collect())
            .filter(|names: &Vec<Name>| is_enough(names))
    };
    listed.or_else(roles_only).map(bare)
}

fn has(names: &[Name], role: Role) -> bool {
    names.iter().any(|name| name.role == Some(role))
}

fn is_enough(names: &[Name]) -> bool {
    let has_place = has(names, Role::X) || is_radial(names);
    has_place && (has(names, Role::Z) || has(names, Role::Slope))
}

/// Whether the names are those of a profile over the radius: one column r, and neither x nor y.
fn is_radial(names: &[Name]) -> bool {
    let has_profile = has(names, Role::Z) || has(names, Role::Slope);
    has_profile && !has(names, Role::X) && !has(names, Role::Y) && radius(names).is_some()
}

/// The one column whose name is that of a radius.
fn radius(names: &[Name]) -> Option<usize> {
    let is_radius = |name: &Name| ["r", "radius"].contains(&name.bare.to_lowercase().as_str());
    let mut places = (0..names.len()).filter(|&at| is_radius(&names[at]));
    places.next().filter(|_| places.next().is_none())
}

pub(super) type Roles = Vec<(Role, usize)>;

fn by_names(line: usize, names: &[Name], options: &TextOptions) -> Result<Roles, ReadError> {
    let listed = || {
        let texts: Vec<&str> = names.iter().map(|name| name.text.as_str()).collect();
        short(&texts.join(", "))
    };
    let find = |role: Role| {
        let mut places = (0..names.len()).filter(|&at| names[at].role == Some(role));
        match (places.next(), places.next()) {
            (_, Some(_)) => {
                let found = format!("two of the columns {} are {}", listed(), role.name());
                Err(unclear(line, found, COLUMNS))
            }
            (place, None) => Ok(place.map(|place| (role, place))),
        }
    };
    let [mut x, y, z] = [find(Role::X)?, find(Role::Y)?, find(Role::Z)?];
    if is_radial(names) {
        if let Some(angle) = names.iter().find(|name| name.is_angle()) {
            let found = format!(
                "the columns {} are places by radius and angle ({})",
                listed(),
                short(&angle.text)
            );
            return Err(unclear(line, found, POLAR));
        }
        // A profile of a figure of revolution: its radius is x.
        x = radius(names).map(|place| (Role::X, place));
    }
    match (x, y, z, find(Role::Slope)?) {
        (Some(x), Some(y), Some(z), _) => {
            Ok([x, y, z].into_iter().chain(find(Role::Uncertainty)?).collect())
        }
        (Some(x), None, Some(z), None) => {
            Ok([x, z].into_iter().chain(find(Role::Uncertainty)?).collect())
        }
        (Some(x), None, None, Some(slope)) => Ok(vec![x, slope]),
        (Some(x), Some((_, y)), None, None) if options.in_plane => Ok(vec![x, (Role::Z, y)]),
        _ => {
            let found = format!(
                "the columns {} are neither x, y, z nor x, z nor r, z nor x, slope",
                listed()
            );
            Err(unclear(line, found, COLUMNS))
        }
    }
}

fn by_count(line: usize, width: usize, options: &TextOptions) -> Result<Roles, ReadError> {
    match width {
        0 | 1 => {
            let found = format!("{width} column");
            Err(super::malformed(
                line,
                0,
                "at least 2 columns: x, y, z, or of a profile x, z (`--skip-lines` passes over lines before the points)",
                found,
            ))
        }
        2 if options.units.is_empty() && !options.in_plane => Err(unclear(
            line,
            "two columns without names may be heights or slopes of a profile",
            "add `--unit mm` for x and z in mm, `--unit mm,nm`, or `--unit mm,urad` for slopes",
        )),
        2 => Ok(vec![(Role::X, 0), (Role::Z, 1)]),
        3 => Ok(vec![(Role::X, 0), (Role::Y, 1), (Role::Z, 2)]),
        4..=6 => {
            let found = format!("{width} columns without names do not say which are x, y and z");
            Err(unclear(line, found, COLUMNS))
        }
        _ => {
            let found = format!("{width} columns without names may be a matrix of heights");
            Err(unclear(line, found, MATRIX))
        }
    }
}

fn by_options(
    line: usize,
    width: usize,
    columns: &[Column],
    head: Option<&Head>,
) -> Result<Roles, ReadError> {
    let roles: &[Role] = match columns.len() {
        2 => &[Role::X, Role::Z],
        3 => &[Role::X, Role::Y, Role::Z],
        4 => &[Role::X, Role::Y, Role::Z, Role::Uncertainty],
        found => {
            return Err(unclear(
                line,
                format!("{found} columns are asked for"),
                "`--columns` takes x,y,z, or x,y,z,u_z, or of a profile x,z",
            ));
        }
    };
    let place = |column: &Column| match column {
        Column::Number(number) if (1..=width).contains(number) => Ok(number - 1),
        Column::Number(number) => Err(unclear(
            line,
            format!("there is no column {number}, for there are {width}"),
            "`--columns` counts from 1",
        )),
        Column::Name(word) => {
            let names = head.map_or(&[][..], |head| &head.names);
            let mut places = (0..names.len()).filter(|&at| names[at].is_called(word));
            match (places.next(), places.next()) {
                (Some(place), None) => Ok(place),
                (found, _) => {
                    let texts: Vec<&str> = names.iter().map(|name| name.text.as_str()).collect();
                    let many =
                        if found.is_some() { "more than one column is" } else { "no column is" };
                    let named = if names.is_empty() {
                        "none has a name".to_owned()
                    } else {
                        format!("they are {}", short(&texts.join(", ")))
                    };
                    Err(unclear(
                        line,
                        format!("{many} called {word}: {named}"),
                        "`--columns` takes numbers, too",
                    ))
                }
            }
        }
    };
    let places = columns.iter().map(place).collect::<Result<Vec<usize>, _>>()?;
    let slope = |place: usize| {
        head.and_then(|head| head.names.get(place))
            .is_some_and(|name| name.role == Some(Role::Slope))
    };
    let roles = roles.iter().zip(places);
    Ok(roles
        .map(|(&role, place)| match role {
            Role::Z if columns.len() == 2 && slope(place) => (Role::Slope, place),
            _ => (role, place),
        })
        .collect())
}

/// The start of a text as an error shows it.
pub(super) fn short(text: &str) -> String {
    const SHOWN: usize = 60;
    let shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() { format!("{shown}…") } else { shown }
}

const POLAR: &str = "write x = r·cos(angle) and y = r·sin(angle) in their place; of a profile at one angle add `--columns` with those of r and z, as 1,3";
const COLUMNS: &str =
    "add `--columns` with the names or numbers of x, y and z, as 2,3,4; of a profile two, x and z";
pub(super) const MATRIX: &str = "add `--pitch DX,DY` in mm and `--unit` of the heights, or `--columns` with those of x, y and z";
