//! Morton's curve through the cells of a square.

/// Position along Morton's curve of a cell in a square of 2¹⁶ by 2¹⁶: bits of x and y in turn, y above x. Cells of any square of the
/// quadtree follow one another.
#[inline]
pub fn along_morton([x, y]: [u16; 2]) -> u32 {
    spread(x) | spread(y) << 1
}

/// Sixteen bits with a nought before each.
#[inline]
fn spread(bits: u16) -> u32 {
    let mut bits = u32::from(bits);
    for (by, mask) in [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        bits = (bits | bits << by) & mask;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_of_both_coordinates_take_turns() {
        for cell in [[0, 0], [1, 0], [0, 1], [0x8001, 0x1234], [u16::MAX, 0], [u16::MAX; 2]] {
            let bit =
                |axis: usize, at: u32| u32::from(cell[axis] >> at & 1) << (2 * at + axis as u32);
            let expected: u32 = (0..16).flat_map(|at| [bit(0, at), bit(1, at)]).sum();
            assert_eq!(along_morton(cell), expected, "{cell:?}");
        }
    }
}
