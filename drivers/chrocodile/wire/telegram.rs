//! Binary telegrams: two sync bytes, then the signals in the order of `SODX`.
//!
//! The sync bytes are not unique: any signal may hold them. A telegram's length follows from its
//! signals alone, and a receiver resynchronizes only when the sync is missing where it is due (CR,
//! binary mode).

use super::signal::{Quantity, Signal, SignalError};

/// The sync bytes a device has by default; `$SSQ` changes them.
pub const SYNC: [u8; 2] = [0xFF, 0xFF];

/// Most signals of one telegram (CR, command SODX).
pub const MAX_SIGNALS: usize = 32;

/// Where each signal stands in a telegram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    sync: [u8; 2],
    fields: Vec<(usize, Signal)>,
    len: usize,
}

impl Layout {
    /// The layout of telegrams with the signals of these identifiers, in this order.
    pub fn new(sync: [u8; 2], ids: &[u16]) -> Result<Layout, SignalError> {
        let mut len = sync.len();
        let mut fields = Vec::with_capacity(ids.len());
        for &id in ids {
            let signal = Signal::from_id(id)?;
            fields.push((len, signal));
            len += signal.value_type.size();
        }
        Ok(Layout { sync, fields, len })
    }

    /// Bytes of a telegram, its sync included.
    pub fn telegram_len(&self) -> usize {
        self.len
    }

    /// The sync bytes.
    pub fn sync(&self) -> [u8; 2] {
        self.sync
    }

    /// Each signal with its offset from the first sync byte.
    pub fn fields(&self) -> &[(usize, Signal)] {
        &self.fields
    }

    /// Offset of a quantity from the first sync byte, where the telegram holds it.
    pub fn offset_of(&self, quantity: Quantity) -> Option<usize> {
        self.fields
            .iter()
            .find(|(_, signal)| signal.quantity == quantity)
            .map(|&(offset, _)| offset)
    }

    /// Appends a telegram whose signals have the values `value_of` gives, in µm, °C, ns or counts.
    pub fn encode(
        &self,
        full_scale_um: f64,
        mut value_of: impl FnMut(&Signal) -> f64,
        out: &mut Vec<u8>,
    ) {
        out.extend(self.sync);
        for (_, signal) in &self.fields {
            signal.write(value_of(signal), full_scale_um, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_follow_the_order_of_the_signals() {
        let layout = Layout::new(SYNC, &[75, 76, 65, 256, 257]).unwrap();
        let offsets: Vec<usize> = layout.fields().iter().map(|&(offset, _)| offset).collect();
        assert_eq!(offsets, [2, 4, 6, 10, 14]);
        assert_eq!(layout.telegram_len(), 18);
        assert_eq!(layout.offset_of(Quantity::ExposureFlags), Some(4));
        assert_eq!(layout.offset_of(Quantity::StartTime), None);
    }
}
