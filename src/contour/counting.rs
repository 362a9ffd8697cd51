//! Sorting by counting: numbered things with keys of 32 bits.

/// A key above the number of what has it: so entries sort by key, then by number.
pub(crate) type Entry = u64;

/// The entry of a key and a number.
#[inline]
pub(crate) fn entry(key: u32, number: u32) -> Entry {
    u64::from(key) << 32 | u64::from(number)
}

/// The number of an entry.
#[inline]
pub(crate) fn number(entry: Entry) -> u32 {
    entry as u32
}

/// The key of an entry.
#[inline]
pub(crate) fn key(entry: Entry) -> u32 {
    (entry >> 32) as u32
}

/// Sorts entries whose numbers come in order by their keys, and so equal keys by numbers; linear time.
pub(crate) fn sort_by_key(entries: &mut Vec<Entry>) {
    if entries.len() < FEW {
        entries.sort_unstable();
        return;
    }
    // Byte by byte, the lowest first: each pass leaves those of one byte in their order. Larger digits write to so many places that the
    // tables of memory pages do not hold them.
    let mut sorted = vec![0; entries.len()];
    for digit in 0..4 {
        let digit = |entry: Entry| usize::from(key(entry).to_le_bytes()[digit]);
        let mut next = [0_u32; 1 << 8];
        entries.iter().for_each(|&entry| next[digit(entry)] += 1);
        let mut sum = 0;
        for count in &mut next {
            sum += std::mem::replace(count, sum);
        }
        for &entry in entries.iter() {
            let place = &mut next[digit(entry)];
            sorted[*place as usize] = entry;
            *place += 1;
        }
        std::mem::swap(entries, &mut sorted);
    }
}

/// Fewer are sorted by comparing: counting has to go through all values of a byte.
const FEW: usize = 1 << 9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_sorted_as_whole_numbers() {
        for count in [0, 1, 2, 100, 5_000, 70_000_u32] {
            let keys = (0..count).map(|at| at.wrapping_mul(0x9E37_79B9) >> (at % 32));
            let mut entries: Vec<Entry> = keys.zip(0..).map(|(key, at)| entry(key, at)).collect();
            let mut expected = entries.clone();
            expected.sort_unstable();
            sort_by_key(&mut entries);
            assert_eq!(entries, expected);
        }
    }
}
