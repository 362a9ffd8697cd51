//! Which columns hold the points, and their units: by options, names, comments, or the plain default.

use super::head::{Name, Role, Said, Stated, names, remark, units};
use super::{Unit, unclear};
use crate::ReadError;

/// What the user says of a text file. All of it may be left out.
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
    /// What named the columns.
    pub named_by: By,
    /// What stated the units; [`By::Default`] is mm.
    pub units_by: By,
    /// Whether decimals have a comma.
    pub has_decimal_commas: bool,
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
    pub(super) number: usize,
    pub(super) text: String,
    pub(super) is_comment: bool,
}

/// How the lines of points are read.
pub(super) struct Layout {
    pub(super) slots: Vec<Slot>,
    /// Columns of every line.
    pub(super) width: usize,
    /// Whether longer lines are read too: the user named the columns.
    pub(super) may_be_longer: bool,
    pub(super) named_by: By,
    pub(super) units_by: By,
}

/// A column to be read; `column` counts from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub(super) role: Role,
    pub(super) column: usize,
    pub(super) unit: Unit,
}

struct Head {
    names: Vec<Name>,
    units: Option<Vec<Unit>>,
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
            ([], Some(head)) => (by_names(line, &head.names)?, By::Head),
            ([], None) => (by_count(line, width, options)?, By::Default),
            (columns, head) => (by_options(line, width, columns, head.as_ref())?, By::Options),
        };
        let (slots, units_by) = with_units(before, line, roles, head.as_ref(), options)?;
        let may_be_longer = named_by == By::Options;
        Ok(Layout { slots, width, may_be_longer, named_by, units_by })
    }

    pub(super) fn has_slopes(&self) -> bool {
        self.slots.iter().any(|slot| slot.role == Role::Slope)
    }

    pub(super) fn taken(&self, has_decimal_commas: bool) -> Taken {
        let columns = self.slots.iter().map(|slot| TakenColumn {
            name: slot.role.name(),
            number: slot.column + 1,
            unit: slot.unit,
        });
        Taken {
            columns: columns.collect(),
            named_by: self.named_by,
            units_by: self.units_by,
            has_decimal_commas,
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
        if found.as_ref().is_some_and(|names| has(names, Role::X)) {
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
    has(names, Role::X) && (has(names, Role::Z) || has(names, Role::Slope))
}

type Roles = Vec<(Role, usize)>;

fn by_names(line: usize, names: &[Name]) -> Result<Roles, ReadError> {
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
    let [x, y, z] = [find(Role::X)?, find(Role::Y)?, find(Role::Z)?];
    match (x, y, z, find(Role::Slope)?) {
        (Some(x), Some(y), Some(z), _) => {
            Ok([x, y, z].into_iter().chain(find(Role::Uncertainty)?).collect())
        }
        (Some(x), None, Some(z), None) => {
            Ok([x, z].into_iter().chain(find(Role::Uncertainty)?).collect())
        }
        (Some(x), None, None, Some(slope)) => Ok(vec![x, slope]),
        _ => {
            let found =
                format!("the columns {} are neither x, y, z nor x, z nor x, slope", listed());
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
                "at least 2 columns: x, y, z, or of a profile x, z",
                found,
            ))
        }
        2 if options.units.is_empty() => Err(unclear(
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

/// The unit of every column, and what said it.
fn with_units(
    before: &[Line],
    line: usize,
    roles: Roles,
    head: Option<&Head>,
    options: &TextOptions,
) -> Result<(Vec<Slot>, By), ReadError> {
    let comments = Comments::of(before);
    let count = roles.len();
    if options.units.len() > 1 && options.units.len() != count {
        let found = format!("{} units for {count} columns", options.units.len());
        return Err(unclear(line, found, "`--unit` takes one for all, or one for each column"));
    }
    let mut found: Vec<(Role, usize, Option<Unit>)> = Vec::with_capacity(count);
    let mut units_by = By::Default;
    for (at, (role, column)) in roles.into_iter().enumerate() {
        let asked = match &options.units[..] {
            [] => None,
            [unit] => Some(*unit).filter(|unit| role != Role::Slope || unit.is_slope()),
            units => Some(units[at]),
        };
        let stated = stated(line, role, column, head, &comments, asked)?;
        if let (Some(asked), Some(stated)) = (asked, stated)
            && asked != stated
        {
            let found = format!(
                "the file says that {} is in {stated}, and `--unit` says {asked}",
                role.name()
            );
            return Err(unclear(line, found, "leave `--unit` out, or mend the file"));
        }
        units_by = match (stated, asked) {
            (None, Some(_)) => By::Options,
            (Some(_), _) if units_by == By::Default => By::Head,
            _ => units_by,
        };
        found.push((role, column, asked.or(stated)));
    }
    let slots = completed(line, &found, &comments, units_by)?;
    Ok((slots, units_by))
}

/// What the file says of the unit of one column.
fn stated(
    line: usize,
    role: Role,
    column: usize,
    head: Option<&Head>,
    comments: &Comments,
    asked: Option<Unit>,
) -> Result<Option<Unit>, ReadError> {
    if let Some(head) = head {
        match head.names.get(column).map(|name| &name.unit) {
            Some(Stated::Known(unit)) => return Ok(Some(*unit)),
            Some(Stated::Unknown(_)) if asked.is_some() => return Ok(None),
            Some(Stated::Unknown(word)) => {
                let found =
                    format!("\"{}\" of column {} is no unit known here", short(word), column + 1);
                return Err(unclear(line, found, "add `--unit` with mm, um, nm, cm, m or in"));
            }
            _ => {}
        }
        if let Some(unit) = head.units.as_ref().and_then(|units| units.get(column)) {
            return Ok(Some(*unit));
        }
    }
    match comments.unit(line, role) {
        // The user decides between comments that contradict each other.
        Err(_) if asked.is_some() => Ok(None),
        found => found,
    }
}

/// The columns with the units that nothing states: that of z for its uncertainty, mm where nothing says otherwise.
fn completed(
    line: usize,
    found: &[(Role, usize, Option<Unit>)],
    comments: &Comments,
    units_by: By,
) -> Result<Vec<Slot>, ReadError> {
    let z = found.iter().find(|(role, ..)| *role == Role::Z).and_then(|(.., unit)| *unit);
    let none = found.iter().all(|(.., unit)| unit.is_none());
    let all_mm = || {
        let mut known = found.iter().filter_map(|(.., unit)| *unit);
        units_by == By::Head && comments.are_mm() && known.all(|unit| unit == Unit::Mm)
    };
    if none && let Some(unit) = comments.doubtful {
        let found = format!("a comment says \"in {unit}\", but not of what");
        return Err(unclear(line, found, "add `--unit` with the unit of x, y and z"));
    }
    let slot = |&(role, column, unit): &(Role, usize, Option<Unit>)| {
        let unit = match (role, unit) {
            (_, Some(unit)) => unit,
            (Role::Slope, None) => {
                let cure = "add `--unit mm,urad`, or another unit of slope: rad, mrad, arcsec";
                return Err(unclear(line, "the unit of the slopes is not stated", cure));
            }
            (Role::Uncertainty, None) => z.unwrap_or(Unit::Mm),
            _ if none || all_mm() => Unit::Mm,
            _ => {
                let found =
                    format!("the unit of {} is not stated, while that of others is", role.name());
                return Err(unclear(
                    line,
                    found,
                    "add `--unit` with the unit of each column, as mm,mm,um",
                ));
            }
        };
        let is_profile = found.len() == 2;
        let role =
            if is_profile && role == Role::Z && unit.is_slope() { Role::Slope } else { role };
        if (role == Role::Slope) != unit.is_slope() {
            let found = format!("{} in {unit}", role.name());
            return Err(unclear(
                line,
                found,
                "slopes are in rad, mrad, urad or arcsec, lengths are not",
            ));
        }
        Ok(Slot { role, column, unit })
    };
    found.iter().map(slot).collect()
}

/// What all comments before the points say of units.
struct Comments {
    of: Vec<(Role, Unit)>,
    all: Vec<Unit>,
    /// A unit other than mm of something that is not named.
    doubtful: Option<Unit>,
}

impl Comments {
    fn of(before: &[Line]) -> Comments {
        let mut comments = Comments { of: Vec::new(), all: Vec::new(), doubtful: None };
        for said in before.iter().flat_map(|line| remark(&line.text).said) {
            match said {
                Said::Of(units) => comments.of.extend(units),
                Said::All(unit) => comments.all.push(unit),
                Said::OfSomething(unit) if unit == Unit::Mm || unit.is_slope() => {}
                Said::OfSomething(unit) => comments.doubtful = Some(unit),
            }
        }
        comments
    }

    fn are_mm(&self) -> bool {
        self.of.iter().map(|(_, unit)| unit).chain(&self.all).all(|unit| *unit == Unit::Mm)
    }

    fn unit(&self, line: usize, role: Role) -> Result<Option<Unit>, ReadError> {
        let of = self.of.iter().filter(|(other, _)| *other == role).map(|(_, unit)| *unit);
        let is_slope = role == Role::Slope;
        let all = self.all.iter().copied().filter(|unit| unit.is_slope() == is_slope);
        let mut units = of.chain(all);
        let Some(first) = units.next() else { return Ok(None) };
        match units.find(|unit| *unit != first) {
            None => Ok(Some(first)),
            Some(other) => Err(unclear(
                line,
                format!("comments say that {} is in {first}, and in {other}", role.name()),
                "add `--unit` with the unit of each column, as mm,mm,um",
            )),
        }
    }
}

/// The start of a text as an error shows it.
fn short(text: &str) -> String {
    const SHOWN: usize = 60;
    let shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() { format!("{shown}…") } else { shown }
}

const COLUMNS: &str =
    "add `--columns` with the names or numbers of x, y and z, as 2,3,4; of a profile two, x and z";
const MATRIX: &str = "add `--pitch DX,DY` in mm and `--unit` of the heights, or `--columns` with those of x, y and z";
