//! Random bytes, the same in every run.

/// A generator of random bytes: xorshift64*, which has a period of 2⁶⁴ − 1 (Vigna 2016, doi:10.1145/2845077).
#[derive(Clone, Debug)]
pub(crate) struct Noise(u64);

impl Noise {
    /// A generator for a seed; 0 counts as 1.
    pub(crate) fn new(seed: u64) -> Noise {
        Noise(seed.max(1))
    }

    /// The next number.
    pub(crate) fn number(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    /// So many bytes.
    pub(crate) fn bytes(&mut self, len: usize) -> Vec<u8> {
        (0..len).map(|_| (self.number() >> 56) as u8).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_about_as_often() {
        let mut counts = [0_u32; 256];
        Noise::new(7).bytes(256_000).into_iter().for_each(|byte| counts[usize::from(byte)] += 1);
        // Six standard deviations of a count of 1000.
        assert!(counts.iter().all(|count| count.abs_diff(1000) < 190), "{counts:?}");
    }
}
