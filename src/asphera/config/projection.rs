//! The table `projection`: along which direction the points are projected for their mesh, or that they are meshed in space.

use asphera_settings::{FromItem, Section};
use toml_edit::Item;

use asphera_measure::{Along, DEFAULT_POINTS, MAX_POINTS, MIN_POINTS};

/// Reads the table; an absent one means z.
pub(super) fn read(table: &Section<'_>) -> Option<Along> {
    let fitted = Direction::Word("fitted".to_owned());
    let given = table.or("along", Direction::Word("z".to_owned()));
    let along = match &given {
        Direction::Word(word) if word == "z" => Some(Along::Z),
        Direction::Word(word) if word == "none" => Some(Along::NONE),
        Direction::Word(word) if word == "auto" => Some(Along::AUTO),
        _ if given == fitted => {
            let points = table.within("points", DEFAULT_POINTS, MIN_POINTS..=MAX_POINTS);
            Along::fitted(points).ok()
        }
        Direction::Word(word) => {
            table.problem("along", Direction::EXPECTED, format!("{word:?}"));
            None
        }
        Direction::Numbers(numbers) => direction(table, numbers),
    };
    if given != fitted && table.has("points") {
        table.problem("points", "no such key, or along = \"fitted\"", "`points`");
    }
    table.finish();
    along
}

fn direction(table: &Section<'_>, numbers: &[f64]) -> Option<Along> {
    let Ok(normal) = <[f64; 3]>::try_from(numbers) else {
        let found = format!("{} numbers", numbers.len());
        table.problem("along", "three numbers [nx, ny, nz]", found);
        return None;
    };
    let along = Along::direction(normal);
    if along.is_err() {
        let expected = "a direction of finite length above 0, such as [0, 0.5, 0.866]";
        table.problem("along", expected, format!("{normal:?}"));
    }
    along.ok()
}

/// Words that may stand behind `along`.
#[derive(PartialEq)]
enum Direction {
    Word(String),
    Numbers(Vec<f64>),
}

impl FromItem for Direction {
    const EXPECTED: &'static str =
        "\"z\", \"fitted\", \"none\", \"auto\" or a direction [nx, ny, nz]";

    fn from_item(item: &Item) -> Option<Direction> {
        if let Some(word) = item.as_str() {
            return Some(Direction::Word(word.to_owned()));
        }
        let number = |value: &toml_edit::Value| {
            value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
        };
        let numbers: Option<Vec<f64>> = item.as_array()?.iter().map(number).collect();
        Some(Direction::Numbers(numbers?))
    }
}
