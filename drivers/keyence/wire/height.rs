//! Heights of 20 bits, one after the other from the least significant bit on: two points in five bytes.

/// Height of a point, in units of the profile.
pub type Height = Result<i32, NoHeight>;

/// Why a point has no height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoHeight {
    /// No peak on the detector, 80000h.
    NoPeak,
    /// Invalid, or masked, 80001h.
    Masked,
    /// In a dead zone, 80002h.
    DeadZone,
    /// Not processed, 80003h.
    Unprocessed,
}

/// Heights of so many points; fewer where the bytes end before.
pub fn heights(bytes: &[u8], points: usize) -> impl Iterator<Item = Height> + '_ {
    let pairs = bytes.chunks(5).flat_map(|five| {
        let mut whole = [0; 8];
        whole[..five.len()].copy_from_slice(five);
        let bits = u64::from_le_bytes(whole);
        [bits as u32 & MASK, (bits >> 20) as u32 & MASK]
    });
    pairs.take(points.min(bytes.len() * 8 / 20)).map(height_of)
}

fn height_of(bits: u32) -> Height {
    match bits {
        0x80000 => Err(NoHeight::NoPeak),
        0x80001 => Err(NoHeight::Masked),
        0x80002 => Err(NoHeight::DeadZone),
        0x80003 => Err(NoHeight::Unprocessed),
        _ => Ok((bits << 12).cast_signed() >> 12),
    }
}

/// Packs heights, and fills the last u32 with zeros. A height beyond 20 bits counts as masked.
pub fn pack_heights(heights: impl IntoIterator<Item = Height>, out: &mut Vec<u8>) {
    let (mut pending, mut bits) = (0_u64, 0);
    for height in heights {
        let value = match height {
            Ok(value) if (LOWEST..=HIGHEST).contains(&value) => value.cast_unsigned() & MASK,
            Err(NoHeight::NoPeak) => 0x80000,
            Ok(_) | Err(NoHeight::Masked) => 0x80001,
            Err(NoHeight::DeadZone) => 0x80002,
            Err(NoHeight::Unprocessed) => 0x80003,
        };
        pending |= u64::from(value) << bits;
        bits += 20;
        if bits >= 32 {
            out.extend((pending as u32).to_le_bytes());
            pending >>= 32;
            bits -= 32;
        }
    }
    if bits > 0 {
        out.extend((pending as u32).to_le_bytes());
    }
}

const MASK: u32 = 0xF_FFFF;

/// The four lowest numbers of 20 bits say why there is no height.
const LOWEST: i32 = -(1 << 19) + 4;
const HIGHEST: i32 = (1 << 19) - 1;
