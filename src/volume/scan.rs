//! A volume with what of it was not scanned: no surface lies in a cell that has a corner there.

use crate::Samples;
use crate::cells::{CornerWords, mixed_edges, mixed_words};

/// What of a volume was not scanned: surfaces end there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gaps<'a> {
    /// Samples without a value, as the foreground of a volume of the same size.
    pub missing: Option<&'a Samples>,
    /// Whether surfaces end in the outermost samples, too: nothing is known beyond. Otherwise a layer of background closes them.
    pub at_border: bool,
}

impl<'a> Gaps<'a> {
    /// Missing samples, the foreground of a volume of the same size; the border is closed by background.
    pub fn missing(missing: &'a Samples) -> Gaps<'a> {
        Gaps { missing: Some(missing), at_border: false }
    }

    /// Whether a surface may end anywhere.
    pub fn is_any(self) -> bool {
        self.missing.is_some() || self.at_border
    }
}

/// A volume, and what of it was not scanned.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scan<'a> {
    pub(crate) samples: &'a Samples,
    gaps: Gaps<'a>,
}

impl<'a> Scan<'a> {
    /// A scan with its gaps.
    ///
    /// # Panics
    ///
    /// Where the sizes of samples and missing samples differ.
    pub(crate) fn new(samples: &'a Samples, gaps: Gaps<'a>) -> Scan<'a> {
        let same = gaps.missing.is_none_or(|missing| missing.size() == samples.size());
        assert!(same, "missing samples have the size of the volume");
        Scan { samples, gaps }
    }

    /// Whether a cell has a corner in a gap.
    pub(crate) fn is_in_gap(self, cell: [usize; 3]) -> bool {
        self.gaps.at_border && self.is_at_border(cell) || self.is_near_missing(cell)
    }

    /// Whether a cell has a corner on a missing sample.
    pub(crate) fn is_near_missing(self, cell: [usize; 3]) -> bool {
        self.gaps.missing.is_some_and(|missing| missing.code(cell) != 0)
    }

    /// Whether a cell has a corner beyond the volume.
    fn is_at_border(self, cell: [usize; 3]) -> bool {
        let size = self.samples.size();
        (0..3).any(|axis| cell[axis] == 0 || cell[axis] == size[axis])
    }

    /// Whether a cell has a corner beyond the volume or on a missing sample.
    pub(crate) fn is_doubtful(self, cell: [usize; 3]) -> bool {
        self.is_at_border(cell) || self.is_near_missing(cell)
    }

    /// Calls `visit(y, word, bits)` for every word of cells of a layer of which some are near missing samples.
    pub(crate) fn near_missing(self, z: usize, mut visit: impl FnMut(usize, usize, u64)) {
        let Some(missing) = self.gaps.missing else { return };
        let ny = self.samples.size()[1];
        for y in 0..=ny {
            for word in 0..missing.words_per_row() {
                let bits = near(missing, y, z, word);
                if bits != 0 {
                    visit(y, word, bits);
                }
            }
        }
    }

    /// The words of mixed cells of a layer, as [`mixed_words`] gives them, without cells in gaps.
    pub(crate) fn mixed_words(
        self,
        z: usize,
        mut visit: impl FnMut(usize, usize, &CornerWords, u64),
    ) {
        if !self.gaps.is_any() {
            return mixed_words(self.samples, z, visit);
        }
        mixed_words(self.samples, z, |y, word, corners, mixed| {
            let mixed = mixed & !self.cells_in_gaps(y, z, word);
            if mixed != 0 {
                visit(y, word, corners, mixed);
            }
        });
    }

    /// The words of mixed edges of a slice, as [`mixed_edges`] gives them, without edges all of whose cells are in gaps.
    pub(crate) fn mixed_edges(
        self,
        z: usize,
        is_upward: bool,
        mut visit: impl FnMut(usize, usize, usize, u64),
    ) {
        if !self.gaps.is_any() {
            return mixed_edges(self.samples, z, is_upward, visit);
        }
        mixed_edges(self.samples, z, is_upward, |direction, y, word, bits| {
            let bits = bits & !self.edges_in_gaps(direction, [word, y, z]);
            if bits != 0 {
                visit(direction, y, word, bits);
            }
        });
    }

    /// The cells of a word of row `y` and layer `z` that have a corner in a gap.
    fn cells_in_gaps(self, y: usize, z: usize, word: usize) -> u64 {
        let near = self.gaps.missing.map_or(0, |missing| near(missing, y, z, word));
        if !self.gaps.at_border {
            return near;
        }
        let [nx, ny, nz] = self.samples.size();
        if y == 0 || y == ny || z == 0 || z == nz {
            return u64::MAX;
        }
        let end = |x: usize| if x / 64 == word { 1 << (x % 64) } else { 0 };
        near | end(0) | end(nx)
    }

    /// The mixed edges of a word along `direction` whose four cells all have a corner in a gap.
    ///
    /// A mixed edge has a foreground sample, which is none of the layer around the volume: so it has four cells.
    fn edges_in_gaps(self, direction: usize, [word, y, z]: [usize; 3]) -> u64 {
        let near = |y: usize, z: usize| self.cells_in_gaps(y, z, word);
        // Cells before an edge along x: bit x of the word before them.
        let before = |y: usize, z: usize| {
            let carried = if word > 0 { self.cells_in_gaps(y, z, word - 1) >> 63 } else { 0 };
            near(y, z) << 1 | carried
        };
        let both = |y: usize, z: usize| near(y, z) & before(y, z);
        let [_, rows, slices] = self.samples.size();
        // Rows and slices of the layer around the volume hold no mixed edge in the other directions.
        let [low_y, high_y] = [y.saturating_sub(1), y.min(rows)];
        let [low_z, high_z] = [z.saturating_sub(1), z.min(slices)];
        match direction {
            0 => [(low_y, low_z), (high_y, low_z), (low_y, high_z), (high_y, high_z)]
                .into_iter()
                .fold(u64::MAX, |all, (y, z)| all & near(y, z)),
            1 => both(y, low_z) & both(y, high_z),
            _ => both(low_y, z) & both(high_y, z),
        }
    }
}

/// The cells of a word of row `y` and layer `z` that have a corner on a missing sample.
fn near(missing: &Samples, y: usize, z: usize, word: usize) -> u64 {
    let rows = [(y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)];
    rows.into_iter().fold(0, |near, (y, z)| {
        let row = missing.row(y, z);
        let next = row.get(word + 1).map_or(0, |next| next << 63);
        near | row[word] | row[word] >> 1 | next
    })
}
