//! Samples as files hold them: type and byte order.

use super::Values;

/// The type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Element {
    pub(super) fn bytes(self) -> usize {
        match self {
            Element::U8 | Element::I8 => 1,
            Element::U16 | Element::I16 => 2,
            Element::U32 | Element::I32 | Element::F32 => 4,
            Element::U64 | Element::I64 | Element::F64 => 8,
        }
    }

    /// Samples of this type; `bytes` is a whole number of them.
    pub(super) fn decoded(self, bytes: Vec<u8>, is_big: bool) -> Values {
        macro_rules! floats {
            ($kind:ty) => {{
                let read = |part: &[u8]| {
                    let mut own = [0; size_of::<$kind>()];
                    own.copy_from_slice(part);
                    let value = if is_big {
                        <$kind>::from_be_bytes(own)
                    } else {
                        <$kind>::from_le_bytes(own)
                    };
                    value as f32
                };
                Values::Floats(bytes.chunks_exact(size_of::<$kind>()).map(read).collect())
            }};
        }
        match self {
            Element::U8 => Values::Bytes(bytes),
            Element::I8 => floats!(i8),
            Element::U16 => floats!(u16),
            Element::I16 => floats!(i16),
            Element::U32 => floats!(u32),
            Element::I32 => floats!(i32),
            Element::U64 => floats!(u64),
            Element::I64 => floats!(i64),
            Element::F32 => floats!(f32),
            Element::F64 => floats!(f64),
        }
    }
}
