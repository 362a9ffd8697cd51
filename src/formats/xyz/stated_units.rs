//! The units of columns: by the head, by comments, by options, or mm where nothing says otherwise.

use super::head::{Role, Said, Stated, marked_names, remark};
use super::layout::{By, Head, Line, Roles, Slot, TextOptions, short};
use super::{Unit, unclear};
use crate::ReadError;

/// The unit of every column, and what said it.
pub(super) fn with_units(
    before: &[Line],
    line: usize,
    roles: Roles,
    head: Option<&Head>,
    options: &TextOptions,
) -> Result<(Vec<Slot>, By), ReadError> {
    let comments = Comments::of(before, head);
    let count = roles.len();
    if options.units.len() > 1 && options.units.len() != count {
        let found = format!("{} units for {count} columns", options.units.len());
        return Err(unclear(line, found, "`--unit` takes one for all, or one for each column"));
    }
    let mut found: Vec<(Role, usize, Option<Unit>)> = Vec::with_capacity(count);
    for (role, column) in roles {
        let stated = stated(line, role, column, head, &comments, !options.units.is_empty())?;
        found.push((role, column, stated));
    }
    let lacks = found.iter().any(|(role, _, unit)| unit.is_none() && *role != Role::Uncertainty);
    let mut units_by = By::Default;
    for (at, (role, _, unit)) in found.iter_mut().enumerate() {
        let asked = match &options.units[..] {
            [] => None,
            // One unit for all is that of the columns that state none, if there are any.
            [_] if lacks && unit.is_some() => None,
            [one] => Some(*one).filter(|one| *role != Role::Slope || one.is_slope()),
            units => Some(units[at]),
        };
        if let (Some(asked), Some(stated)) = (asked, *unit)
            && asked != stated
        {
            let name = role.name();
            let found =
                format!("the file says that {name} is in {stated}, and `--unit` says {asked}");
            return Err(unclear(line, found, "leave `--unit` out, or mend the file"));
        }
        units_by = match (*unit, asked) {
            (None, Some(_)) => By::Options,
            (Some(_), _) if units_by == By::Default => By::Head,
            _ => units_by,
        };
        *unit = asked.or(*unit);
    }
    let slots = completed(line, &found, (&comments, units_by), options.in_plane)?;
    Ok((slots, units_by))
}

/// Statement of the file on the unit of one column.
fn stated(
    line: usize,
    role: Role,
    column: usize,
    head: Option<&Head>,
    comments: &Comments,
    is_asked: bool,
) -> Result<Option<Unit>, ReadError> {
    if let Some(head) = head {
        let named = head.names.get(column).map(|name| &name.unit);
        let below = head.units.as_ref().and_then(|units| units.get(column));
        for unit in [named, below].into_iter().flatten() {
            match unit {
                Stated::Known(unit) => return Ok(Some(*unit)),
                Stated::Unknown(_) if is_asked => return Ok(None),
                Stated::Unknown(word) => {
                    let found = format!(
                        "\"{}\" of column {} is no unit known here",
                        short(word),
                        column + 1
                    );
                    let cure = "add `--unit` with mm, um, nm, cm, m or in";
                    return Err(unclear(line, found, cure));
                }
                Stated::Nothing => {}
            }
        }
    }
    match comments.unit(line, role) {
        // The user decides between comments that contradict each other.
        Err(_) if is_asked => Ok(None),
        found => found,
    }
}

/// The columns with the units that nothing states: that of z for its uncertainty, mm where nothing says otherwise.
fn completed(
    line: usize,
    found: &[(Role, usize, Option<Unit>)],
    (comments, units_by): (&Comments, By),
    in_plane: bool,
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
        let name =
            if in_plane && is_profile && role == Role::Z { Role::Y.name() } else { role.name() };
        Ok(Slot { role, name, column, unit })
    };
    found.iter().map(slot).collect()
}

/// Statements of all comments before the points on units.
struct Comments {
    of: Vec<(Role, Unit)>,
    all: Vec<Unit>,
    /// A unit other than mm of something that is not named.
    doubtful: Option<Unit>,
}

impl Comments {
    /// Those of all lines but the head where marks separate its names: a unit behind one of these is of that column alone.
    fn of(before: &[Line], head: Option<&Head>) -> Comments {
        let mut comments = Comments { of: Vec::new(), all: Vec::new(), doubtful: None };
        let is_head = |line: &&Line| {
            let names = marked_names(&line.text, head.map_or(0, |head| head.names.len()));
            !line.is_comment && names.is_some() && names.as_ref() == head.map(|head| &head.names)
        };
        let lines = before.iter().filter(|line| !is_head(line));
        for said in lines.flat_map(|line| remark(&line.text).said) {
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
