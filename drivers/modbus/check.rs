//! What can be wrong with a register map.

use std::collections::HashSet;

use asphera_link::{MAX_CHANNELS, Problem};

use crate::map::{Field, Kind, Map, Role};

/// Adds every problem of the map. Keys are those of the table of the settings: `field[3].scale`.
pub(crate) fn map(problems: &mut Vec<Problem>, map: &Map, max_words: u16) {
    let mut names = HashSet::new();
    for (index, field) in map.fields.iter().enumerate() {
        let mut check = Check { problems, key: format!("field[{index}]") };
        check.that(!field.name.is_empty(), "name", "a name", "none");
        check.that(names.insert(&field.name), "name", "a name used once", &field.name);
        one_field(&mut check, field, max_words);
        one_role(&mut check, map, field);
    }
    let channels = map.fields.iter().filter(|field| field.role == Role::Channel).count();
    let mut check = Check { problems, key: "field".to_owned() };
    let expected = format!("1 to {MAX_CHANNELS} channels");
    check.that((1..=MAX_CHANNELS).contains(&channels), "", &expected, channels);
    let roles = || map.fields.iter().map(|field| &field.role);
    let once = [
        (
            "field of device seconds",
            roles().filter(|role| **role == Role::DeviceTimeSeconds).count(),
        ),
        (
            "field of device microseconds",
            roles().filter(|role| **role == Role::DeviceTimeMicros).count(),
        ),
        ("trigger count", roles().filter(|role| matches!(role, Role::Count { .. })).count()),
    ];
    for (what, found) in once {
        check.that(found <= 1, "", &format!("at most one {what}"), found);
    }
    blocks(problems, map, max_words);
}

fn one_field(check: &mut Check<'_>, field: &Field, max_words: u16) {
    let block = field.block();
    check.that(block.end() <= ADDRESSES, "address", "registers up to 65535", field.address);
    check.that(field.kind.words() <= max_words, "kind", "no longer than max_words", kind(field));
    if field.function.reads_bits() {
        check.that(field.kind == Kind::Bit(0), "kind", "bit0 for coils and inputs", kind(field));
    }
    if let Kind::Bit(bit) = field.kind {
        check.that(bit < 16, "kind", "bit0 to bit15", kind(field));
    }
    let scale = field.scale;
    check.that(scale.is_finite() && scale != 0.0, "scale", "finite and not zero", scale);
    check.that(field.offset.is_finite(), "offset", "finite", field.offset);
    if let Some((low, high)) = field.valid_range {
        let sound = low.is_finite() && high.is_finite() && low < high;
        check.that(sound, "valid_range", "finite, the lower first", format!("{low} to {high}"));
    }
}

fn one_role(check: &mut Check<'_>, map: &Map, field: &Field) {
    let unsigned = field.kind.is_unsigned();
    if !matches!(field.role, Role::Channel | Role::Alarm) {
        check.that(unsigned, "kind", "u16, u32 or a bit for this role", kind(field));
    }
    match &field.role {
        Role::Channel | Role::Alarm | Role::DeviceTimeSeconds | Role::DeviceTimeMicros => {}
        Role::Count { first, modulus } => {
            let last = u64::from(*first) + u64::from(*modulus);
            let sound = *modulus >= 2 && last <= 1 << 32;
            check.that(sound, "modulus", "at least 2, counts of 32 bits", modulus);
        }
        Role::Quality { good, weak, bad, judges } => {
            check.that(!good.is_empty(), "good", "at least one value", "none");
            let mut seen = HashSet::new();
            for value in [good, weak, bad].into_iter().flatten() {
                check.that(seen.insert(value), "role", "each value in one list", value);
            }
            for name in judges {
                let known = map.field(name).is_some_and(|field| field.role == Role::Channel);
                check.that(known, "judges", "names of channels", name);
            }
        }
    }
}

fn blocks(problems: &mut Vec<Problem>, map: &Map, max_words: u16) {
    for (index, block) in map.blocks.iter().enumerate() {
        let mut check = Check { problems, key: format!("block[{index}]") };
        let bits = block.function.reads_bits();
        let longest = if bits { block.function.max_len() } else { max_words };
        let expected = format!("1 to {longest}");
        check.that((1..=longest).contains(&block.len), "length", &expected, block.len);
        check.that(block.end() <= ADDRESSES, "address", "registers up to 65535", block.address);
        let fields: Vec<_> = map.fields.iter().map(Field::block).collect();
        let used = fields.iter().any(|field| block.contains(field));
        check.that(used, "address", "at least one field inside", block);
        let cut = fields.iter().find(|field| block.overlaps(field) && !block.contains(field));
        if let Some(field) = cut {
            check.that(false, "length", "no field half inside", field);
        }
        let other = map.blocks[..index].iter().find(|other| block.overlaps(other));
        if let Some(other) = other {
            check.that(false, "address", "no overlap with another block", other);
        }
    }
}

fn kind(field: &Field) -> String {
    match field.kind {
        Kind::Bit(bit) => format!("bit{bit}"),
        other => format!("{other:?}").to_lowercase(),
    }
}

struct Check<'a> {
    problems: &'a mut Vec<Problem>,
    key: String,
}

impl Check<'_> {
    /// Without a `key` the table itself is meant.
    fn that(&mut self, holds: bool, key: &str, expected: &str, found: impl std::fmt::Display) {
        if !holds {
            let dot = if key.is_empty() { "" } else { "." };
            let key = format!("{}{dot}{key}", self.key);
            self.problems.push(Problem::new(key, expected, found));
        }
    }
}

/// How many addresses each table has (V1.1b3, section 4.4).
const ADDRESSES: u32 = 65536;

#[cfg(test)]
mod tests {
    use asphera_link::Unit;

    use super::*;
    use crate::map::{Block, Function};

    fn problems_of(map: &Map) -> Vec<String> {
        let mut problems = Vec::new();
        super::map(&mut problems, map, 125);
        let text = |problem: &Problem| format!("{}: {}", problem.key, problem.expected);
        problems.iter().map(text).collect()
    }

    fn sound() -> Map {
        let field = Field::channel("a", Function::ReadInput, 10, Kind::F32, Unit::Millimetre);
        Map { name: "test".to_owned(), fields: vec![field], blocks: Vec::new() }
    }

    #[test]
    fn every_built_in_map_is_sound() {
        for name in crate::BUILT_IN {
            assert_eq!(problems_of(&Map::built_in(name).unwrap()), [""; 0]);
        }
    }

    #[test]
    fn an_empty_map_measures_nothing() {
        assert_eq!(problems_of(&Map::default()), ["field: 1 to 16 channels"]);
    }

    #[test]
    fn each_fault_of_a_field_is_named() {
        type Change = fn(&mut Map);
        let cases: [(Change, &str); 12] = [
            (|map| map.fields[0].name.clear(), "field[0].name: a name"),
            (|map| map.fields.push(sound().fields[0].clone()), "field[1].name: a name used once"),
            (|map| map.fields[0].address = 65535, "field[0].address: registers up to 65535"),
            (|map| map.fields[0].scale = 0.0, "field[0].scale: finite and not zero"),
            (|map| map.fields[0].scale = f64::NAN, "field[0].scale: finite and not zero"),
            (|map| map.fields[0].offset = f64::INFINITY, "field[0].offset: finite"),
            (
                |map| map.fields[0].valid_range = Some((1.0, 1.0)),
                "field[0].valid_range: finite, the lower first",
            ),
            (|map| map.fields[0].kind = Kind::Bit(16), "field[0].kind: bit0 to bit15"),
            (
                |map| map.fields[0].function = Function::ReadCoils,
                "field[0].kind: bit0 for coils and inputs",
            ),
            (
                |map| {
                    let judges = vec!["b".to_owned()];
                    let role = Role::Quality { good: vec![0], weak: vec![], bad: vec![], judges };
                    let kind = Kind::U16;
                    map.fields.push(Field {
                        name: "q".to_owned(),
                        role,
                        kind,
                        ..map.fields[0].clone()
                    });
                },
                "field[1].judges: names of channels",
            ),
            (
                |map| {
                    let role = Role::Count { first: 1, modulus: u32::MAX };
                    let kind = Kind::U32;
                    map.fields.push(Field {
                        name: "n".to_owned(),
                        role,
                        kind,
                        ..map.fields[0].clone()
                    });
                },
                "",
            ),
            (
                |map| {
                    let role = Role::DeviceTimeSeconds;
                    map.fields.push(Field { name: "t".to_owned(), role, ..map.fields[0].clone() });
                },
                "field[1].kind: u16, u32 or a bit for this role",
            ),
        ];
        for (change, expected) in cases {
            let mut map = sound();
            change(&mut map);
            let expected: &[&str] = if expected.is_empty() { &[] } else { &[expected] };
            assert_eq!(problems_of(&map), expected);
        }
    }

    #[test]
    fn blocks_neither_overlap_nor_cut_fields() {
        let block = |address, len| Block { function: Function::ReadInput, address, len };
        let map = Map { blocks: vec![block(8, 4), block(11, 1)], ..sound() };
        let expected = [
            "block[1].address: at least one field inside",
            "block[1].length: no field half inside",
            "block[1].address: no overlap with another block",
        ];
        assert_eq!(problems_of(&map), expected);
    }
}
