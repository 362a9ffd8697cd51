//! Bytes against a threshold, a row at a time.

/// Sets bit i + 1 of `row` where `values[i]` is `threshold` or more. The row is all 0 before.
pub(crate) fn mask_of_bytes(values: &[u8], threshold: u8, row: &mut [u64]) {
    // Values 0 to 62 fill the first word above the bit of the layer around the volume; then 64 at a time.
    let (first, rest) = values.split_at(values.len().min(63));
    row[0] = word_of(first, threshold) << 1;
    let mut chunks = rest.chunks_exact(64);
    let mut index = 1;
    for chunk in &mut chunks {
        row[index] = word_of_64(chunk, threshold);
        index += 1;
    }
    if !chunks.remainder().is_empty() {
        row[index] = word_of(chunks.remainder(), threshold);
    }
}

fn word_of(values: &[u8], threshold: u8) -> u64 {
    values
        .iter()
        .enumerate()
        .fold(0, |word, (bit, &value)| word | u64::from(value >= threshold) << bit)
}

#[cfg(target_arch = "x86_64")]
fn word_of_64(values: &[u8], threshold: u8) -> u64 {
    use safe_arch::{cmp_eq_mask_i8_m128i, m128i, max_u8_m128i, move_mask_i8_m128i};
    let limit = m128i::from([threshold; 16]);
    values.as_chunks::<16>().0.iter().enumerate().fold(0, |word, (index, part)| {
        let part = m128i::from(*part);
        // The larger of value and threshold is the value where that is not below the threshold.
        let bits = move_mask_i8_m128i(cmp_eq_mask_i8_m128i(max_u8_m128i(part, limit), part));
        word | u64::from(bits as u16) << (16 * index)
    })
}

#[cfg(not(target_arch = "x86_64"))]
fn word_of_64(values: &[u8], threshold: u8) -> u64 {
    word_of(values, threshold)
}
