//! How often each code occurs: the one pass that every local figure is made of.

use rayon::prelude::*;

use crate::Samples;
use crate::cells::{mixed_codes, mixed_words};

/// The number of cells of each code, the cells at the layer around the volume included.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    counts: [u64; 256],
}

impl Histogram {
    /// Counts the codes of a volume by layers of cells, in the caller's pool. The result does not depend on threads.
    pub fn new(samples: &Samples) -> Histogram {
        let [nx, ny, nz] = samples.size();
        let counts = (0..=nz)
            .into_par_iter()
            .fold(|| [0; 256], |counts, z| add_layer(samples, z, counts))
            .reduce(
                || [0; 256],
                |mut a, b| {
                    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                    a
                },
            );
        let cells = (nx as u64 + 1) * (ny as u64 + 1) * (nz as u64 + 1);
        Histogram::with_empty_cells(counts, cells)
    }

    /// The counts with what is missing to all cells: they are empty.
    fn with_empty_cells(mut counts: [u64; 256], cells: u64) -> Histogram {
        counts[0] = cells - counts[1..].iter().sum::<u64>();
        Histogram { counts }
    }

    /// The number of cells of one code.
    pub fn count(&self, code: u8) -> u64 {
        self.counts[usize::from(code)]
    }

    /// The numbers of cells, by code.
    pub fn counts(&self) -> &[u64; 256] {
        &self.counts
    }

    /// All cells.
    pub fn cells(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Cells with both foreground and background corners.
    pub fn mixed(&self) -> u64 {
        self.counts[1..255].iter().sum()
    }

    /// A sum over all cells of a figure that the code decides.
    pub fn sum(&self, figure: impl Fn(u8) -> f64) -> f64 {
        (0..=255_u8).map(|code| self.count(code) as f64 * figure(code)).sum()
    }

    /// A sum over all cells of a whole number that the code decides.
    pub fn sum_whole(&self, figure: impl Fn(u8) -> i64) -> i64 {
        (0..=255_u8).map(|code| self.count(code) as i64 * figure(code)).sum()
    }

    /// The number of cells whose code meets a condition.
    pub fn count_where(&self, condition: impl Fn(u8) -> bool) -> u64 {
        (0..=255_u8).filter(|&code| condition(code)).map(|code| self.count(code)).sum()
    }
}

fn add_layer(samples: &Samples, z: usize, mut counts: [u64; 256]) -> [u64; 256] {
    mixed_words(samples, z, |_, word, corners, mixed| {
        mixed_codes(word, corners, mixed, |_, code| counts[usize::from(code)] += 1);
    });
    counts[255] += full_cells(samples, z);
    counts
}

/// Cells of one layer with eight foreground corners.
fn full_cells(samples: &Samples, z: usize) -> u64 {
    let mut full = 0;
    for y in 1..samples.size()[1] {
        let [a, b, c, d] =
            [(y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)].map(|(y, z)| samples.row(y, z));
        let mut before = 0_u64;
        for (((a, b), c), d) in a.iter().zip(b).zip(c).zip(d) {
            let all = a & b & c & d;
            // A full cell is two full columns of samples side by side; it is counted at the second one.
            full += u64::from((all & (all << 1 | before)).count_ones());
            before = all >> 63;
        }
    }
    full
}
