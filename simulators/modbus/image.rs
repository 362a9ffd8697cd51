//! The registers of a device.

use std::collections::BTreeMap;

use asphera_modbus::{Block, Function, Kind, Map, ValueError, encode, encode_field};
use thiserror::Error;

/// The four tables of a Modbus device: registers, and bits as registers of 0 or 1.
#[derive(Clone, Debug)]
pub struct Image {
    map: Map,
    registers: BTreeMap<(Function, u16), u16>,
    parts: Vec<Block>,
}

/// Why a field cannot be set.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SetError {
    /// The map has no such field.
    #[error("no field `{0}` in the map")]
    Unknown(String),
    /// The registers cannot hold the value.
    #[error("field `{name}` cannot be set")]
    Value {
        /// The field.
        name: String,
        /// What is wrong with the value.
        source: ValueError,
    },
}

impl Image {
    /// The registers of all fields and blocks of the map, all zero. There are no others.
    pub fn new(map: Map) -> Image {
        let fields = map.fields.iter().map(asphera_modbus::Field::block);
        let blocks = fields.chain(map.blocks.iter().copied());
        let addresses = blocks.flat_map(|block| {
            (block.address..=u16::MAX)
                .take(usize::from(block.len))
                .map(move |address| ((block.function, address), 0))
        });
        let registers = addresses.collect();
        Image { map, registers, parts: Vec::new() }
    }

    /// The map served.
    pub fn map(&self) -> &Map {
        &self.map
    }

    /// Sets a field to a value in its unit. Bits beside a bit field keep their values.
    ///
    /// # Errors
    ///
    /// When there is no such field or its registers cannot hold the value.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), SetError> {
        let field = self.map.field(name).ok_or_else(|| SetError::Unknown(name.to_owned()))?;
        let wrong = |source| SetError::Value { name: name.to_owned(), source };
        let words = encode_field(field, value).map_err(wrong)?;
        let (function, start) = (field.function, field.address);
        let mask = match field.kind {
            // The register in which only this bit is set, in the field's byte order.
            Kind::Bit(_) => encode(field.kind, field.word_order, 1.0).map_err(wrong)?[0],
            _ => u16::MAX,
        };
        for (address, word) in (start..=u16::MAX).zip(words) {
            let register = self.registers.entry((function, address)).or_default();
            *register = *register & !mask | word & mask;
        }
        Ok(())
    }

    /// Sets one register (or bit, to 0 or 1) as it is, and makes it if there was none.
    pub fn set_register(&mut self, function: Function, address: u16, word: u16) {
        self.registers.insert((function, address), word);
    }

    /// The registers of a block, or `None` when one of them does not exist.
    pub fn read(&self, block: Block) -> Option<Vec<u16>> {
        if block.end() > 65536 {
            return None;
        }
        (block.address..=u16::MAX)
            .take(usize::from(block.len))
            .map(|address| self.registers.get(&(block.function, address)).copied())
            .collect()
    }

    /// Lets exactly these registers be read alone, though they are a part of a block that must be
    /// read whole.
    pub fn allow_part(&mut self, part: Block) {
        self.parts.push(part);
    }

    /// Whether a request reads only a part of a block that must be read whole.
    pub fn cuts_block(&self, request: Block) -> bool {
        !self.parts.contains(&request)
            && self
                .map
                .blocks
                .iter()
                .any(|block| block.overlaps(&request) && !request.contains(block))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn om20_shows_its_worked_example() {
        let mut image = Image::new(Map::built_in("baumer-om20").unwrap());
        image.set("distance", 69.742_607).unwrap();
        image.set("alarm", 1.0).unwrap();
        image.set("switch_output", 1.0).unwrap();
        image.set("alarm", 0.0).unwrap();
        let block = Block { function: Function::ReadInput, address: 201, len: 3 };
        assert_eq!(image.read(block), Some(vec![1, 0x7C37, 0x428B]));
        assert!(image.cuts_block(block));
        let distance = Block { address: 202, len: 2, ..block };
        assert!(image.cuts_block(distance));
        image.allow_part(distance);
        assert!(!image.cuts_block(distance) && image.cuts_block(block));
        assert_eq!(image.read(Block { len: 13, ..block }), None, "213 does not exist");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let mut image = Image::new(Map::built_in("baumer-om20").unwrap());
        assert_eq!(image.set("colour", 1.0), Err(SetError::Unknown("colour".to_owned())));
        assert!(matches!(image.set("quality", -1.0), Err(SetError::Value { .. })));
    }
}
