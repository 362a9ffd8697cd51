//! Types that a value of a TOML file can be read as.

use toml_edit::{Item, Value};

/// A type that a TOML value can be read as.
pub trait FromItem: Sized {
    /// What would do, in words: `a finite number`.
    const EXPECTED: &'static str;
    /// What would do for an array of them, in words.
    const EXPECTED_MANY: &'static str = "an array of values of one kind";

    /// The value; `None` if the item is of another kind or out of the type's range.
    fn from_item(item: &Item) -> Option<Self>;
}

impl FromItem for String {
    const EXPECTED: &'static str = "a string";
    const EXPECTED_MANY: &'static str = "an array of strings";

    fn from_item(item: &Item) -> Option<String> {
        item.as_str().map(str::to_owned)
    }
}

impl FromItem for bool {
    const EXPECTED: &'static str = "true or false";

    fn from_item(item: &Item) -> Option<bool> {
        item.as_bool()
    }
}

impl FromItem for f64 {
    const EXPECTED: &'static str = "a finite number";
    const EXPECTED_MANY: &'static str = "an array of finite numbers";

    fn from_item(item: &Item) -> Option<f64> {
        let number = item.as_float().or_else(|| item.as_integer().map(|number| number as f64));
        number.filter(|number| number.is_finite())
    }
}

/// A number, or that it is found by itself: the word `auto`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OrAuto {
    /// The word.
    Auto,
    /// The number.
    Number(f64),
}

impl FromItem for OrAuto {
    const EXPECTED: &'static str = "a finite number or \"auto\"";

    fn from_item(item: &Item) -> Option<OrAuto> {
        if item.as_str() == Some("auto") {
            return Some(OrAuto::Auto);
        }
        f64::from_item(item).map(OrAuto::Number)
    }
}

macro_rules! integers {
    ($($kind:ty: $expected:literal),*) => {$(
        impl FromItem for $kind {
            const EXPECTED: &'static str = $expected;

            fn from_item(item: &Item) -> Option<$kind> {
                item.as_integer()?.try_into().ok()
            }
        }
    )*};
}

integers! {
    u8: "a whole number from 0 to 255",
    u16: "a whole number from 0 to 65535",
    u32: "a whole number from 0 to 4294967295",
    u64: "a whole number, not negative",
    i64: "a whole number",
    usize: "a whole number, not negative"
}

impl<T: FromItem> FromItem for Vec<T> {
    const EXPECTED: &'static str = T::EXPECTED_MANY;

    fn from_item(item: &Item) -> Option<Vec<T>> {
        item.as_array()?.iter().map(|value| T::from_item(&Item::Value(value.clone()))).collect()
    }
}

/// What stands there, in words.
pub(crate) fn found(item: &Item) -> String {
    match item {
        Item::Value(Value::String(text)) => format!("the string {:?}", text.value()),
        Item::Value(Value::Integer(number)) => number.value().to_string(),
        Item::Value(Value::Float(value)) => number(*value.value()),
        Item::Value(Value::Boolean(value)) => value.value().to_string(),
        Item::Value(Value::Array(array)) => {
            array.to_string().trim().chars().take(LONGEST_ARRAY).collect()
        }
        other => format!("a value of type {}", other.type_name()),
    }
}

/// A number in as few digits as tell it: with a power of ten where it is very large or small.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value.is_finite() && size != 0.0 && !(1e-6..1e15).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// Letters of an array that are shown.
const LONGEST_ARRAY: usize = 60;
