//! The object dictionary of a simulated node.

use std::collections::BTreeMap;

use asphera_cia406::wire::object::{self, Address};
use asphera_cia406::wire::{AbortCode, Cob, Expedited, MappedObject};

use crate::NodeConfig;

/// Objects by address, with what an SDO server has to know of each.
#[derive(Clone, Debug)]
pub(crate) struct Dictionary {
    entries: BTreeMap<Address, Entry>,
    tpdo_cob: u32,
    fixed_mapping: bool,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    value: u32,
    bytes: u8,
    access: Access,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Access {
    ReadOnly,
    ReadWrite,
    /// Read only for SDO, and may stand in a PDO.
    Process,
}

impl Dictionary {
    /// The dictionary as after power-on.
    pub(crate) fn new(config: &NodeConfig, tpdo: Cob) -> Dictionary {
        use Access::{Process, ReadOnly, ReadWrite};
        let tpdo_cob = u32::from(tpdo.id());
        let mapping = object::TPDO1_MAPPING.index;
        let default_mapping =
            [(config.position, 32), (object::VELOCITY_1, 16), (object::AREA_STATE_1, 8)];
        let mut entries = BTreeMap::new();
        let mut add = |address: Address, bytes, access, value| {
            entries.insert(address, Entry { value, bytes, access });
        };
        add(object::DEVICE_TYPE, 4, ReadOnly, config.device_type);
        add(object::ERROR_REGISTER, 1, ReadOnly, 0);
        add(object::HEARTBEAT_TIME, 2, ReadWrite, 0);
        add(Address::new(object::VENDOR.index, 0), 1, ReadOnly, 1);
        add(object::VENDOR, 4, ReadOnly, config.vendor_id);
        add(object::SYNC_OVERFLOW, 1, ReadWrite, 0);
        add(Address::new(object::TPDO1_COB.index, 0), 1, ReadOnly, 5);
        add(object::TPDO1_COB, 4, ReadWrite, tpdo_cob | object::PDO_NO_REMOTE);
        add(object::TPDO1_TYPE, 1, ReadWrite, 254);
        add(object::TPDO1_EVENT_TIMER, 2, ReadWrite, 1);
        add(object::TPDO1_MAPPING, 1, ReadWrite, default_mapping.len() as u32);
        for sub in 1..=MAPPED_MAX {
            let object = default_mapping.get(usize::from(sub) - 1);
            let entry = object.map_or(0, |&(address, bits)| MappedObject { address, bits }.entry());
            add(Address::new(mapping, sub), 4, ReadWrite, entry);
        }
        add(config.position, 4, Process, 0);
        add(object::POSITION_STEP, 4, ReadWrite, config.position_step_nm);
        add(object::VELOCITY_STEP, 4, ReadWrite, config.velocity_step_10_um_s);
        add(object::VELOCITY_1, 2, Process, 0);
        add(object::AREA_STATE_1, 1, Process, 0);
        add(object::MEASURING_STEP, 4, ReadOnly, config.position_step_nm);
        entries.retain(|address, _| !config.absent.contains(&address.index));
        Dictionary { entries, tpdo_cob, fixed_mapping: config.fixed_mapping }
    }

    /// The value of an object, 0 where there is none.
    pub(crate) fn value(&self, address: Address) -> u32 {
        self.entries.get(&address).map_or(0, |entry| entry.value)
    }

    /// Sets an object from inside the node.
    pub(crate) fn set(&mut self, address: Address, value: u32) {
        if let Some(entry) = self.entries.get_mut(&address) {
            entry.value = value;
        }
    }

    /// Reads an object over SDO.
    pub(crate) fn upload(&self, address: Address) -> Result<Expedited, AbortCode> {
        let entry = self.entry(address)?;
        Ok(match entry.bytes {
            1 => Expedited::u8(entry.value as u8),
            2 => Expedited::u16(entry.value as u16),
            _ => Expedited::u32(entry.value),
        })
    }

    /// Writes an object over SDO.
    pub(crate) fn download(&mut self, address: Address, value: Expedited) -> Result<(), AbortCode> {
        let entry = *self.entry(address)?;
        if entry.access != Access::ReadWrite {
            return Err(AbortCode::READ_ONLY);
        }
        if value.byte_len().is_some_and(|len| len != entry.bytes) {
            return Err(AbortCode::WRONG_LENGTH);
        }
        let number = value.number();
        self.check(address, number)?;
        self.set(address, number);
        Ok(())
    }

    /// Objects of the TPDO, in order.
    pub(crate) fn mapped(&self) -> impl Iterator<Item = MappedObject> + '_ {
        let count = self.value(object::TPDO1_MAPPING) as u8;
        (1..=count).map(|sub| {
            let address = Address::new(object::TPDO1_MAPPING.index, sub);
            MappedObject::from_entry(self.value(address))
        })
    }

    /// Whether the TPDO is switched on.
    pub(crate) fn tpdo_enabled(&self) -> bool {
        self.value(object::TPDO1_COB) & object::PDO_INVALID == 0
    }

    fn entry(&self, address: Address) -> Result<&Entry, AbortCode> {
        self.entries.get(&address).ok_or_else(|| {
            let index = Address::new(address.index, 0)..=Address::new(address.index, u8::MAX);
            if self.entries.range(index).next().is_some() {
                AbortCode::NO_SUB_INDEX
            } else {
                AbortCode::NO_OBJECT
            }
        })
    }

    fn check(&self, address: Address, number: u32) -> Result<(), AbortCode> {
        let mapping = object::TPDO1_MAPPING.index;
        match address {
            object::TPDO1_COB => {
                let flags = object::PDO_INVALID | object::PDO_NO_REMOTE;
                if number & !flags != self.tpdo_cob {
                    return Err(AbortCode::OUT_OF_RANGE);
                }
            }
            object::TPDO1_TYPE if matches!(number, 241..=253) => {
                return Err(AbortCode::OUT_OF_RANGE);
            }
            object::SYNC_OVERFLOW if number == 1 || number > 240 => {
                return Err(AbortCode::OUT_OF_RANGE);
            }
            // CiA 301: the mapping changes only while the PDO is off, its entries only while the
            // count is 0.
            Address { index, .. } if index == mapping && self.fixed_mapping => {
                return Err(AbortCode::READ_ONLY);
            }
            Address { index, .. } if index == mapping && self.tpdo_enabled() => {
                return Err(AbortCode::UNSUPPORTED_ACCESS);
            }
            object::TPDO1_MAPPING => return self.check_mapping(number),
            Address { index, .. } if index == mapping => {
                if self.value(object::TPDO1_MAPPING) != 0 {
                    return Err(AbortCode::UNSUPPORTED_ACCESS);
                }
                let object = MappedObject::from_entry(number);
                let known = self.entries.get(&object.address);
                if !known.is_some_and(|entry| {
                    entry.access == Access::Process && 8 * entry.bytes == object.bits
                }) {
                    return Err(AbortCode::NOT_MAPPABLE);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn check_mapping(&self, count: u32) -> Result<(), AbortCode> {
        if count > u32::from(MAPPED_MAX) {
            return Err(AbortCode::PDO_TOO_LONG);
        }
        let entries = (1..=count as u8).map(|sub| {
            let address = Address::new(object::TPDO1_MAPPING.index, sub);
            MappedObject::from_entry(self.value(address))
        });
        let bits: u32 = entries.map(|object| u32::from(object.bits)).sum();
        if bits > 64 { Err(AbortCode::PDO_TOO_LONG) } else { Ok(()) }
    }
}

/// Entries a mapping has room for.
const MAPPED_MAX: u8 = 4;
