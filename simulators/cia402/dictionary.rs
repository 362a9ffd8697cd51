//! Object dictionary of the drive.

use std::collections::BTreeMap;

use asphera_cia402::wire::{AbortCode, Address, Cob, Expedited, MappedObject, NodeId, object};

/// Objects by address.
#[derive(Clone, Debug)]
pub(crate) struct Dictionary {
    entries: BTreeMap<Address, Entry>,
    tpdo_cob: u32,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    value: u32,
    bytes: u8,
    is_writable: bool,
}

impl Dictionary {
    /// The dictionary as after power-on. TPDO1 has the statusword alone.
    pub(crate) fn new(node: NodeId, acceleration: u32) -> Dictionary {
        let tpdo_cob = u32::from(Cob::Tpdo1(node).id());
        let mut entries = BTreeMap::new();
        let mut add = |address: Address, bytes, is_writable, value| {
            entries.insert(address, Entry { value, bytes, is_writable });
        };
        add(object::DEVICE_TYPE, 4, false, 0x0002_0192);
        add(object::ERROR_REGISTER, 1, false, 0);
        add(object::HEARTBEAT_TIME, 2, true, 0);
        add(Address::new(object::VENDOR.index, 0), 1, false, 1);
        add(object::VENDOR, 4, false, 0x1402);
        add(Address::new(object::TPDO1_COB.index, 0), 1, false, 5);
        add(object::TPDO1_COB, 4, true, tpdo_cob | object::PDO_NO_REMOTE);
        add(object::TPDO1_TYPE, 1, true, 255);
        add(object::TPDO1_EVENT_TIMER, 2, true, 0);
        add(object::TPDO1_MAPPING, 1, true, 1);
        for sub in 1..=4 {
            let entry = if sub == 1 { object::TPDO1[0].entry() } else { 0 };
            add(Address::new(object::TPDO1_MAPPING.index, sub), 4, true, entry);
        }
        add(object::ERROR_CODE, 2, false, 0);
        add(object::CONTROLWORD, 2, true, 0);
        add(object::STATUSWORD, 2, false, 0);
        add(object::QUICK_STOP_OPTION, 2, true, 2);
        add(object::MODE, 1, true, 0);
        add(object::MODE_DISPLAY, 1, false, 0);
        add(object::POSITION, 4, false, 0);
        for address in [object::TARGET, object::HOME_OFFSET] {
            add(address, 4, true, 0);
        }
        for address in
            [object::PROFILE_VELOCITY, object::HOMING_SPEED_SWITCH, object::HOMING_SPEED_ZERO]
        {
            add(address, 4, true, 1000);
        }
        add(Address::new(object::HOMING_SPEED_ZERO.index, 0), 1, false, 2);
        for address in [
            object::PROFILE_ACCELERATION,
            object::PROFILE_DECELERATION,
            object::HOMING_ACCELERATION,
        ] {
            add(address, 4, true, acceleration);
        }
        add(object::HOMING_METHOD, 1, true, 0);
        let modes = object::HAS_PROFILE_POSITION | object::HAS_HOMING;
        add(object::SUPPORTED_MODES, 4, false, modes);
        Dictionary { entries, tpdo_cob }
    }

    /// The value of an object, 0 where there is none.
    pub(crate) fn value(&self, address: Address) -> u32 {
        self.entries.get(&address).map_or(0, |entry| entry.value)
    }

    pub(crate) fn signed(&self, address: Address) -> i32 {
        self.value(address).cast_signed()
    }

    /// Sets an object from inside the drive.
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
        if !entry.is_writable {
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

    /// Whether TPDO1 is on.
    pub(crate) fn has_tpdo(&self) -> bool {
        self.value(object::TPDO1_COB) & object::PDO_INVALID == 0
    }

    /// Data of TPDO1 as it is mapped.
    pub(crate) fn tpdo(&self) -> Vec<u8> {
        let count = self.value(object::TPDO1_MAPPING) as u8;
        let mut data = Vec::with_capacity(8);
        for sub in 1..=count {
            let entry = self.value(Address::new(object::TPDO1_MAPPING.index, sub));
            let mapped = MappedObject::from_entry(entry);
            let value = self.value(mapped.address).to_le_bytes();
            data.extend(&value[..usize::from(mapped.bits / 8).min(4)]);
        }
        data.truncate(8);
        data
    }

    fn entry(&self, address: Address) -> Result<&Entry, AbortCode> {
        self.entries.get(&address).ok_or_else(|| {
            let index = Address::new(address.index, 0)..=Address::new(address.index, u8::MAX);
            match self.entries.range(index).next() {
                Some(_) => AbortCode::NO_SUB_INDEX,
                None => AbortCode::NO_OBJECT,
            }
        })
    }

    /// CiA 301: the mapping changes only while the PDO is off, its entries only while the count is 0.
    fn check(&self, address: Address, number: u32) -> Result<(), AbortCode> {
        let is_mapping = address.index == object::TPDO1_MAPPING.index;
        match address {
            object::TPDO1_COB => {
                let flags = object::PDO_INVALID | object::PDO_NO_REMOTE;
                if number & !flags == self.tpdo_cob { Ok(()) } else { Err(AbortCode::OUT_OF_RANGE) }
            }
            _ if is_mapping && self.has_tpdo() => Err(AbortCode::UNSUPPORTED_ACCESS),
            object::TPDO1_MAPPING if number > 4 => Err(AbortCode::PDO_TOO_LONG),
            object::TPDO1_MAPPING => Ok(()),
            _ if is_mapping && self.value(object::TPDO1_MAPPING) != 0 => {
                Err(AbortCode::UNSUPPORTED_ACCESS)
            }
            _ if is_mapping => {
                let mapped = MappedObject::from_entry(number);
                let known = self.entries.get(&mapped.address);
                let fits = known.is_some_and(|entry| 8 * entry.bytes == mapped.bits);
                if fits { Ok(()) } else { Err(AbortCode::NOT_MAPPABLE) }
            }
            _ => Ok(()),
        }
    }
}
