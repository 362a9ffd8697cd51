//! What the command line says of the columns and units of a file that leaves them open.

use std::str::FromStr;

use asphera_formats::Topography;
use asphera_formats::xyz::{By, Column, Taken, TextOptions, Unit};
use asphera_geometry::TINY_MM;
use asphera_report::words::counted;
use asphera_report::{ColumnFigures, ReadingFigures};
use clap::Args;

/// Columns and units of a file that does not state them.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct TextArgs {
    /// The columns of a text or NumPy file that hold x,y,z, or x,y,z,u_z, or of a profile x,z: names, or numbers from 1. Without
    /// it the file's own line of names says so, and three columns without names are x, y, z.
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',', value_parser = column)]
    columns: Vec<Column>,
    /// The unit of a file that states none (text, PLY, STL, OBJ, OFF, LAS, NumPy): mm, um, nm, cm, m or in; one for all
    /// columns, or one for each, as mm,mm,um. Slopes of a profile are in rad, mrad, urad or arcsec.
    #[arg(long, value_name = "UNIT", value_delimiter = ',', value_parser = unit)]
    unit: Vec<Unit>,
    /// Lines at the start of a text file that are not read.
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    skip_lines: usize,
    /// The text or NumPy file is a matrix of heights, the top row first: distance of its columns and rows in mm.
    #[arg(long, value_name = "DX[,DY]")]
    pitch: Option<Pitch>,
    /// Numbers such as -999 far from all other heights are heights. Without it they are marks for no data, and left out.
    #[arg(long)]
    keep_marks: bool,
}

/// The unit of a mesh that states none, for commands whose other files state theirs.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct UnitArgs {
    /// The unit of a mesh that states none (PLY, STL, OBJ, OFF): mm, um, nm, cm, m or in.
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    unit: Option<Unit>,
}

impl UnitArgs {
    pub(super) fn is_given(&self) -> bool {
        self.unit.is_some()
    }

    pub(super) fn options(&self) -> TextOptions {
        TextArgs { unit: self.unit.into_iter().collect(), ..TextArgs::default() }.options()
    }
}

#[derive(Clone, Copy, Debug)]
struct Pitch([f64; 2]);

impl FromStr for Pitch {
    type Err = String;

    fn from_str(word: &str) -> Result<Pitch, String> {
        let number = |word: &str| {
            let value = word.trim().parse::<f64>().ok().filter(|value| value.is_finite());
            value.filter(|value| *value > 0.0)
        };
        let (dx, dy) = word.split_once(',').unwrap_or((word, word));
        match (number(dx), number(dy)) {
            (Some(dx_mm), Some(dy_mm)) => Ok(Pitch([dx_mm, dy_mm])),
            _ => Err(format!("expected one or two numbers above 0 in mm, found `{word}`")),
        }
    }
}

impl TextArgs {
    /// Whether anything is said.
    pub(super) fn is_given(&self) -> bool {
        self.options() != TextOptions::default()
    }

    pub(super) fn options(&self) -> TextOptions {
        TextOptions {
            columns: self.columns.clone(),
            units: self.unit.clone(),
            skip_lines: self.skip_lines,
            pitch_mm: self.pitch.map(|Pitch(pitch_mm)| pitch_mm),
            keeps_marks: self.keep_marks,
            in_plane: false,
        }
    }
}

/// How columns and units of a file were read, as reports write it; `None` of files that state both for every reader.
pub(super) fn reading(topography: &Topography) -> Option<ReadingFigures> {
    let taken = topography.source().taken.as_ref()?;
    let Taken { columns, named_by, units_by, has_decimal_commas, passed_over, cautions } = taken;
    let by = |by: &By| match by {
        By::Options => "the command line",
        By::Head => "the file",
        By::Default => "nothing: x, y, z in mm are assumed",
    };
    let column = |column: &asphera_formats::xyz::TakenColumn| ColumnFigures {
        name: column.name.to_owned(),
        number: column.number as u64,
        unit: column.unit.name().to_owned(),
    };
    Some(ReadingFigures {
        columns: columns.iter().map(column).collect(),
        named_by: by(named_by).to_owned(),
        units_by: by(units_by).to_owned(),
        units_assumed: *units_by == By::Default,
        decimal_commas: *has_decimal_commas,
        lines_passed_over: *passed_over as u64,
        cautions: cautions.iter().cloned().chain(tiny_points(topography)).collect(),
    })
}

/// What is said of points so near to an axis that they are taken to lie on it.
fn tiny_points(topography: &Topography) -> Option<String> {
    let is_tiny = |value: &f64| *value != 0.0 && value.abs() < TINY_MM;
    let tiny = topography.points().filter(|point| point.iter().any(is_tiny)).count() as u64;
    (tiny > 0).then(|| {
        format!(
            "coordinates below {TINY_MM:e} mm count as zero, and {} had some: those that then share a place are duplicates. Is the unit right? `--unit` gives another",
            counted(tiny, "point")
        )
    })
}

fn column(word: &str) -> Result<Column, String> {
    match word.trim().parse::<usize>() {
        Ok(0) => Err("columns count from 1".to_owned()),
        Ok(number) => Ok(Column::Number(number)),
        Err(_) if word.trim().is_empty() => Err("expected a name or a number".to_owned()),
        Err(_) => Ok(Column::Name(word.trim().to_owned())),
    }
}

fn unit(word: &str) -> Result<Unit, String> {
    Unit::from_word(word).ok_or_else(|| {
        format!(
            "expected mm, um, nm, cm, m, in, or of slopes rad, mrad, urad, arcsec; found `{word}`"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_that_count_as_zero_are_told() {
        let cautions = |text: &str| {
            let options = TextOptions::default();
            let read = asphera_formats::read_with("a.xyz", text.as_bytes(), &options).unwrap();
            reading(&read).unwrap().cautions
        };
        let [said] = &cautions("1e-150 0 0\n2e-150 0 0\n0 1e-150 0\n")[..] else { panic!("none") };
        assert!(
            said.starts_with("coordinates below 1e-40 mm count as zero, and 3 points"),
            "{said}"
        );
        assert!(cautions("0 0 0\n1e-30 0 0\n0 1 0\n").is_empty());
    }

    #[test]
    fn columns_are_names_or_numbers_and_a_pitch_is_one_number_or_two() {
        assert_eq!(column("2"), Ok(Column::Number(2)));
        assert_eq!(column("x_um"), Ok(Column::Name("x_um".to_owned())));
        assert!(column("0").is_err() && column("").is_err() && unit("furlong").is_err());
        assert_eq!("0.5".parse::<Pitch>().unwrap().0, [0.5, 0.5]);
        assert_eq!("0.5,2".parse::<Pitch>().unwrap().0, [0.5, 2.0]);
        assert!("0".parse::<Pitch>().is_err() && "1,nan".parse::<Pitch>().is_err());
    }
}
