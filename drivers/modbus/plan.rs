//! Which requests read a map.

use crate::map::{Block, Field, Map};

/// Gathers the fields of a map into requests, in ascending order of function and address.
///
/// A field inside one of [`Map::blocks`] is read by that block. The others are joined as long as
/// there are at most `max_gap` registers (or bits) nobody asked for between them and a request reads
/// at most `max_words` registers (or 16 times as many bits, at most 2000). O(n log n) in the fields.
pub(crate) fn requests(map: &Map, max_gap: u16, max_words: u16) -> Vec<Block> {
    let mut blocks = map.blocks.clone();
    let mut loose: Vec<Block> = map
        .fields
        .iter()
        .map(Field::block)
        .filter(|field| !map.blocks.iter().any(|block| block.contains(field)))
        .collect();
    loose.sort_by_key(|field| (field.function, field.address, field.len));

    let mut open: Option<Block> = None;
    for field in loose {
        if let Some(block) = &mut open {
            let end = block.end().max(field.end());
            let len = end - u32::from(block.address);
            let near = u32::from(field.address) <= block.end() + u32::from(max_gap);
            if block.function == field.function
                && near
                && len <= u32::from(longest(block, max_words))
                && !crosses(map, block, len)
            {
                block.len = len as u16;
                continue;
            }
            blocks.push(*block);
        }
        open = Some(field);
    }
    blocks.extend(open);
    blocks.sort_by_key(|block| (block.function, block.address));
    blocks
}

/// Whether a request this long would read into a block that must be read whole.
fn crosses(map: &Map, block: &Block, len: u32) -> bool {
    let grown = Block { len: len as u16, ..*block };
    map.blocks.iter().any(|whole| whole.overlaps(&grown))
}

fn longest(block: &Block, max_words: u16) -> u16 {
    let words = if block.function.reads_bits() { max_words.saturating_mul(16) } else { max_words };
    words.min(block.function.max_len())
}

#[cfg(test)]
mod tests {
    use asphera_link::Unit;
    use proptest::prelude::*;
    use proptest::test_runner::FileFailurePersistence;

    use super::*;
    use crate::map::{Function, Kind};

    fn map(fields: &[(Function, u16, Kind)], blocks: &[(u16, u16)]) -> Map {
        Map {
            name: "test".to_owned(),
            fields: fields
                .iter()
                .map(|(function, address, kind)| {
                    Field::channel("field", *function, *address, *kind, Unit::One)
                })
                .collect(),
            blocks: blocks
                .iter()
                .map(|(address, len)| block(Function::ReadInput, *address, *len))
                .collect(),
        }
    }

    fn block(function: Function, address: u16, len: u16) -> Block {
        Block { function, address, len }
    }

    #[test]
    fn neighbours_are_read_together_and_strangers_apart() {
        let input = Function::ReadInput;
        let map = map(
            &[
                (input, 10, Kind::F32),
                (input, 12, Kind::U16),
                (input, 15, Kind::U16),
                (Function::ReadHolding, 12, Kind::U16),
            ],
            &[],
        );
        let holding = block(Function::ReadHolding, 12, 1);
        assert_eq!(requests(&map, 2, 125), [holding, block(input, 10, 6)]);
        assert_eq!(requests(&map, 1, 125), [holding, block(input, 10, 3), block(input, 15, 1)]);
        let short = [holding, block(input, 10, 2), block(input, 12, 1), block(input, 15, 1)];
        assert_eq!(requests(&map, 100, 2), short);
    }

    #[test]
    fn whole_blocks_stay_whole() {
        let input = Function::ReadInput;
        let map = map(
            &[(input, 199, Kind::U16), (input, 202, Kind::F32), (input, 213, Kind::U16)],
            &[(200, 13)],
        );
        let expected = [block(input, 199, 1), block(input, 200, 13), block(input, 213, 1)];
        assert_eq!(requests(&map, 100, 125), expected);
    }

    #[test]
    fn bits_are_counted_in_words_of_sixteen() {
        let coils = Function::ReadCoils;
        let map = map(&[(coils, 0, Kind::Bit(0)), (coils, 31, Kind::Bit(0))], &[]);
        assert_eq!(requests(&map, 30, 2), [block(coils, 0, 32)]);
        assert_eq!(requests(&map, 30, 1), [block(coils, 0, 1), block(coils, 31, 1)]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_failure_persistence(FileFailurePersistence::WithSource(
            "regressions"
        )))]

        #[test]
        fn every_field_is_read_and_no_request_is_too_long(
            addresses in prop::collection::vec(0_u16..400, 1..40), max_gap in 0_u16..20, max_words in 4_u16..=125,
        ) {
            let fields: Vec<_> =
                addresses.iter().map(|at| (Function::ReadHolding, *at, Kind::F32)).collect();
            let map = map(&fields, &[]);
            let blocks = requests(&map, max_gap, max_words);
            for field in &map.fields {
                prop_assert!(blocks.iter().any(|block| block.contains(&field.block())));
            }
            for block in &blocks {
                prop_assert!(block.len <= max_words);
            }
        }
    }
}
