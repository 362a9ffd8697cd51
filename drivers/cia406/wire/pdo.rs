//! Mapping and content of the transmit PDO.

use super::MappedObject;
use super::object::{self, Address};

/// What is mapped into TPDO1: the position always, then velocity and work-area state if wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TpdoLayout {
    /// The object of the position, 32 bits.
    pub position: Address,
    /// Whether 6030.01h follows, 16 bits.
    pub velocity: bool,
    /// Whether 6400.01h follows, 8 bits.
    pub area_state: bool,
}

/// State of the work area (BEI p.51).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AreaState(pub u8);

impl AreaState {
    /// Whether out of range (bit 0), above (bit 1) or below (bit 2) the limits. The other bits are reserved.
    pub const fn is_outside(self) -> bool {
        self.0 & 0b111 != 0
    }
}

/// What one TPDO says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// The position as sent, in steps; two's complement where the object is signed.
    pub position: u32,
    /// The velocity in steps, where it is mapped and the frame reaches that far.
    pub velocity: Option<i16>,
    /// The state of the work area, likewise.
    pub area_state: Option<AreaState>,
}

impl TpdoLayout {
    /// The entries of the mapping, in order.
    pub fn objects(self) -> impl Iterator<Item = MappedObject> {
        let position = MappedObject { address: self.position, bits: 32 };
        let velocity = MappedObject { address: object::VELOCITY_1, bits: 16 };
        let area_state = MappedObject { address: object::AREA_STATE_1, bits: 8 };
        [Some(position), self.velocity.then_some(velocity), self.area_state.then_some(area_state)]
            .into_iter()
            .flatten()
    }

    /// The entry at `index` of [`TpdoLayout::objects`].
    pub fn object(self, index: u8) -> Option<MappedObject> {
        self.objects().nth(index.into())
    }

    /// Number of entries, 1 to 3.
    pub fn count(self) -> u8 {
        1 + u8::from(self.velocity) + u8::from(self.area_state)
    }

    /// Bytes of the frame, 4 to 7.
    pub fn byte_len(self) -> usize {
        4 + 2 * usize::from(self.velocity) + usize::from(self.area_state)
    }

    /// Reads a frame's data. `None` if it is too short for a position.
    ///
    /// The length received counts, not the one mapped: the manual of one device maps seven bytes and
    /// says the frame has six (MTS p.32 and p.36). What does not fit is missing, what is too much is
    /// left.
    pub fn decode(self, data: &[u8]) -> Option<Position> {
        let (&position, mut rest) = data.split_first_chunk::<4>()?;
        let mut velocity = None;
        if self.velocity {
            velocity = rest.first_chunk::<2>().map(|&bytes| i16::from_le_bytes(bytes));
            rest = rest.get(2..).unwrap_or_default();
        }
        let area_state = if self.area_state { rest.first().copied().map(AreaState) } else { None };
        Some(Position { position: u32::from_le_bytes(position), velocity, area_state })
    }
}
