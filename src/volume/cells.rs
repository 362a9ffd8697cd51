//! The cells and edges of a volume, 64 at a time, those that are all inside or all outside skipped.

use crate::Samples;

/// Eight words of corner bits: bit i of word c is corner c of cell i.
pub(crate) type CornerWords = [u64; 8];

/// Calls `visit(y, word, corners, mixed)` for every word of cells of layer `z` that holds a mixed one; `mixed` has a bit for each.
///
/// Layers, rows and words count in the padded volume: cell (x, y, z) has its lowest corner there.
pub(crate) fn mixed_words(
    samples: &Samples,
    z: usize,
    mut visit: impl FnMut(usize, usize, &CornerWords, u64),
) {
    let rows = samples.size()[1] + 1;
    let words = samples.words_per_row();
    for y in 0..rows {
        let four = [
            &samples.row(y, z)[..words],
            &samples.row(y + 1, z)[..words],
            &samples.row(y, z + 1)[..words],
            &samples.row(y + 1, z + 1)[..words],
        ];
        for word in 0..words {
            let low = four.map(|row| row[word]);
            let next = if word + 1 < words { four.map(|row| row[word + 1]) } else { [0; 4] };
            // Most words are all background or, with what follows, all foreground.
            let any =
                low[0] | low[1] | low[2] | low[3] | (next[0] | next[1] | next[2] | next[3]) & 1;
            if any == 0 {
                continue;
            }
            let high: [u64; 4] = std::array::from_fn(|row| low[row] >> 1 | next[row] << 63);
            let all = low[0] & low[1] & low[2] & low[3] & high[0] & high[1] & high[2] & high[3];
            let any = low[0] | low[1] | low[2] | low[3] | high[0] | high[1] | high[2] | high[3];
            let mixed = any & !all;
            if mixed != 0 {
                let corners = [low[0], high[0], low[1], high[1], low[2], high[2], low[3], high[3]];
                visit(y, word, &corners, mixed);
            }
        }
    }
}

/// The codes of the eight cells of byte `group` of the words, one a byte.
pub(crate) fn codes_of_group(corners: &CornerWords, group: usize) -> [u8; 8] {
    let shift = 8 * group;
    // Byte c of the square holds bit i of corner c for cell i; transposed, byte i is the code of cell i.
    let mut square =
        (0..8).fold(0, |square, corner| square | (corners[corner] >> shift & 0xFF) << (8 * corner));
    for (step, keep) in
        [(7, 0x00AA_00AA_00AA_00AA_u64), (14, 0x0000_CCCC_0000_CCCC), (28, 0x0000_0000_F0F0_F0F0)]
    {
        let swapped = (square ^ square >> step) & keep;
        square ^= swapped ^ swapped << step;
    }
    square.to_le_bytes()
}

/// Calls `visit(x, code)` for every mixed cell of one word, x ascending.
pub(crate) fn mixed_codes(
    word: usize,
    corners: &CornerWords,
    mixed: u64,
    mut visit: impl FnMut(usize, u8),
) {
    for group in 0..8 {
        let mut bits = mixed >> (8 * group) & 0xFF;
        if bits == 0 {
            continue;
        }
        let codes = codes_of_group(corners, group);
        while bits != 0 {
            let bit = bits.trailing_zeros() as usize;
            visit(word * 64 + group * 8 + bit, codes[bit]);
            bits &= bits - 1;
        }
    }
}

/// Calls `visit(direction, y, word, bits)` for every word of mixed edges of a slice: along x and y, or (`is_upward`) to the next slice.
pub(crate) fn mixed_edges(
    samples: &Samples,
    z: usize,
    is_upward: bool,
    mut visit: impl FnMut(usize, usize, usize, u64),
) {
    let [_, ny, nz] = samples.size();
    if is_upward && z > nz {
        return;
    }
    for y in 0..ny + 2 {
        let row = samples.row(y, z);
        if is_upward {
            for (word, (a, b)) in row.iter().zip(samples.row(y, z + 1)).enumerate() {
                if a != b {
                    visit(2, y, word, a ^ b);
                }
            }
            continue;
        }
        for (word, &bits) in row.iter().enumerate() {
            // The last bit of a row is the layer around the volume, so nothing is lost behind it.
            let next = row.get(word + 1).map_or(0, |next| next << 63);
            let mixed = bits ^ (bits >> 1 | next);
            if mixed != 0 {
                visit(0, y, word, mixed);
            }
        }
        if y <= ny {
            for (word, (a, b)) in row.iter().zip(samples.row(y + 1, z)).enumerate() {
                if a != b {
                    visit(1, y, word, a ^ b);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_give_the_codes_that_single_samples_give() {
        let size = [131, 6, 5];
        let mut state = 1_u32;
        let samples = Samples::from_fn(size, |_, _, _| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 28 < 5
        })
        .unwrap();
        let mut found = std::collections::BTreeMap::new();
        for z in 0..=size[2] {
            mixed_words(&samples, z, |y, word, corners, mixed| {
                mixed_codes(word, corners, mixed, |x, code| {
                    assert!(found.insert([x, y, z], code).is_none());
                });
            });
        }
        for z in 0..=size[2] {
            for y in 0..=size[1] {
                for x in 0..=size[0] {
                    let code = samples.code([x, y, z]);
                    let expected = (code != 0 && code != 255).then_some(code);
                    assert_eq!(found.get(&[x, y, z]).copied(), expected);
                }
            }
        }
    }
}
