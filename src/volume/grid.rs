//! Whether the grid was fine enough for the part: the check by theorems 12 to 14.
//!
//! Source: Stelldinger, Latecki, Siqueira, IEEE PAMI 29 (2007). An r-regular solid (two balls of radius r touch every boundary
//! point, one inside, one outside) on a cubic grid of spacing h < r / √3 has no forbidden cell, and its case-8 cells come in
//! pairs. A violation proves that the grid was too coarse. No violation proves nothing by itself.

use rayon::prelude::*;

use crate::cells::{mixed_codes, mixed_words};
use crate::codes::{Case, facts};
use crate::scan::{Gaps, Scan};
use crate::{Histogram, Samples};

/// Most places that a check lists.
pub const PLACES: usize = 100;

/// What the check found in the codes.
#[derive(Clone, Debug, PartialEq)]
pub struct GridCheck {
    /// Cells of case 8.
    pub case8: u64,
    /// Cells of case 8 without a partner across their C1 face.
    pub case8_unpaired: u64,
    /// Cells of the cases 9 to 14.
    pub forbidden: u64,
    /// Faces between cells whose two foreground samples are diagonal (C1).
    pub c1: u64,
    /// Cells in which two samples on a space diagonal stand against six (C2).
    pub c2: u64,
    /// Centres of the cells at fault, in samples, sorted by slice, row and column; [`PLACES`] at most.
    pub places: Vec<Violation>,
    /// Critical configurations, sorted the same way; [`PLACES`] at most.
    pub critical: Vec<Critical>,
    /// Cells at fault beside what was not scanned: they, or the partner they lack, have a corner beyond the volume or on a missing
    /// sample. They contradict nothing.
    pub doubtful: u64,
    /// Cells with surface that have a corner on a missing sample.
    pub near_missing: u64,
}

/// A critical configuration: the union of the voxels of the foreground, or of the background, is no manifold there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// Centre of the face of C1 or of the cell of C2, in samples.
    pub centre: [f64; 3],
    /// Configuration found there.
    pub kind: CriticalKind,
}

/// The two critical configurations of the source (figure 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CriticalKind {
    /// Two foreground samples lie diagonally on a face between cells, two background samples on its other diagonal.
    C1,
    /// Two samples on a space diagonal of a cell stand against its six others.
    C2,
}

/// A cell that no r-regular solid on a fine enough grid has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// Centre of the cell in samples: sample (x, y, z) lies at x, y, z.
    pub centre: [f64; 3],
    /// Its code.
    pub code: u8,
    /// Its case: [`Case::Paired`] stands for a cell of case 8 without its partner.
    pub case: Case,
}

/// What can be said of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// r is stated, h < r / √3, and nothing contradicts it.
    Proved,
    /// The codes, or the spacing, contradict what is stated.
    Contradicted,
    /// Neither.
    Unknown,
}

impl GridCheck {
    /// Checks the codes of a volume, by layers in the caller's pool; `histogram` is that of the same volume.
    pub fn new(samples: &Samples, histogram: &Histogram) -> GridCheck {
        GridCheck::with_missing(samples, histogram, None)
    }

    /// The same of a volume in which samples are missing: they are foreground in `missing`, which is of the same size, and
    /// background in `samples`.
    pub fn with_missing(
        samples: &Samples,
        histogram: &Histogram,
        missing: Option<&Samples>,
    ) -> GridCheck {
        let facts = facts();
        let fact = |code: u8| facts[usize::from(code)];
        let case8 = histogram.count_where(|code| fact(code).case == Case::Paired);
        let forbidden = histogram.count_where(|code| fact(code).case == Case::Forbidden);
        let c2 = histogram.count_where(|code| fact(code).is_c2);
        // Two cells share every face between them.
        let c1 = histogram.sum_whole(|code| i64::from(fact(code).c1_faces.count_ones())) as u64 / 2;
        let (mut unpaired, mut doubtful, mut near_missing) = (0, 0, 0);
        let (mut places, mut critical) = (Vec::new(), Vec::new());
        if case8 + forbidden > 0 || missing.is_some() {
            let scan = Scan::new(samples, Gaps { missing, at_border: false });
            let layers: Vec<Layer> =
                (0..=samples.size()[2]).into_par_iter().map(|z| Layer::of(scan, z)).collect();
            for layer in layers {
                unpaired += layer.unpaired;
                doubtful += layer.doubtful;
                near_missing += layer.near_missing;
                let room = PLACES - places.len();
                places.extend(layer.places.into_iter().take(room));
                let room = PLACES - critical.len();
                critical.extend(layer.critical.into_iter().take(room));
            }
        }
        let case8_unpaired = unpaired;
        GridCheck {
            case8,
            case8_unpaired,
            forbidden,
            c1,
            c2,
            places,
            critical,
            doubtful,
            near_missing,
        }
    }

    /// Whether the codes contradict a grid that is fine enough.
    pub fn is_contradicted(&self) -> bool {
        self.forbidden + self.case8_unpaired > self.doubtful
    }

    /// The verdict on a grid with any axes: `steps_mm` lead from a sample to the next along x, y and z. As [`GridCheck::verdict`].
    pub fn verdict_on_axes(
        &self,
        steps_mm: [[f64; 3]; 3],
        regular_mm: Option<f64>,
    ) -> (Verdict, String) {
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let spacing_mm = steps_mm.map(|step| dot(step, step).sqrt());
        let are_right = [(0, 1), (0, 2), (1, 2)].iter().all(|&(a, b)| {
            dot(steps_mm[a], steps_mm[b]).abs() <= 2.0 * CUBIC * spacing_mm[a] * spacing_mm[b]
        });
        if are_right {
            return self.verdict(spacing_mm, regular_mm);
        }
        let why = "the axes are not at right angles: the theorems hold for cubes only";
        (Verdict::Unknown, why.into())
    }

    /// The verdict on a grid of spacing `spacing_mm` along x, y and z, with the reason in words.
    ///
    /// `regular_mm` is the r of the part, where the user states it: its least local feature size on both sides, mm.
    pub fn verdict(&self, spacing_mm: [f64; 3], regular_mm: Option<f64>) -> (Verdict, String) {
        let is_cubic = spacing_mm.iter().all(|side| (side / spacing_mm[0] - 1.0).abs() <= CUBIC);
        if !is_cubic {
            return (
                Verdict::Unknown,
                "voxels are not cubes: the theorems hold for cubes only".into(),
            );
        }
        if self.is_contradicted() {
            let why = format!(
                "no part whose radius r is above √3 times the spacing has these samples: {} forbidden cells and {} cells of \
                 case 8 without a partner; scan finer, or filter noise",
                self.forbidden, self.case8_unpaired
            );
            return (Verdict::Contradicted, why);
        }
        if self.doubtful > 0 {
            let why = format!(
                "{} cells are at fault, but all lie beside what was not scanned, and contradict nothing",
                self.doubtful
            );
            return (Verdict::Unknown, why);
        }
        let Some(regular_mm) = regular_mm else {
            let why = "nothing contradicts the grid, but r of the part is not stated: `asphera volume --regular` takes it";
            return (Verdict::Unknown, why.into());
        };
        let needed_mm = needed_spacing_mm(regular_mm);
        if spacing_mm[0] < needed_mm {
            let why = format!(
                "the spacing of {:.4} mm is below r / √3 = {needed_mm:.4} mm, and no cell contradicts that",
                spacing_mm[0]
            );
            (Verdict::Proved, why)
        } else {
            let why = format!(
                "the spacing of {:.4} mm is not below r / √3 = {needed_mm:.4} mm: scan finer",
                spacing_mm[0]
            );
            (Verdict::Contradicted, why)
        }
    }
}

/// The spacing that a part with radius `regular_mm` needs: samples must be nearer than r / √3.
pub fn needed_spacing_mm(regular_mm: f64) -> f64 {
    regular_mm / 3_f64.sqrt()
}

/// Sides that differ by less than this share count as equal: files round spacings to six digits.
const CUBIC: f64 = 1e-5;

/// The cells of one layer that are of case 8 or forbidden, or beside what is missing.
#[derive(Default)]
struct Layer {
    /// Cells of case 8 without a partner.
    unpaired: u64,
    doubtful: u64,
    near_missing: u64,
    places: Vec<Violation>,
    critical: Vec<Critical>,
}

impl Layer {
    fn of(scan: Scan<'_>, z: usize) -> Layer {
        let mut layer = Layer::default();
        mixed_words(scan.samples, z, |y, word, corners, mixed| {
            mixed_codes(word, corners, mixed, |x, code| layer.add(scan, [x, y, z], code));
        });
        layer
    }

    fn add(&mut self, scan: Scan<'_>, cell: [usize; 3], code: u8) {
        let facts = facts()[usize::from(code)];
        let is_alone = facts.case == Case::Paired && !has_partner(scan.samples, cell, code);
        self.unpaired += u64::from(is_alone);
        self.near_missing += u64::from(scan.is_near_missing(cell));
        let centre = cell.map(|place| place as f64 - 0.5);
        if is_alone || facts.case == Case::Forbidden {
            let is_doubtful =
                scan.is_doubtful(cell) || is_alone && scan.is_doubtful(across(cell, code));
            self.doubtful += u64::from(is_doubtful);
            if self.places.len() < PLACES {
                self.places.push(Violation { centre, code, case: facts.case });
            }
        }
        // A face belongs to the cell below it: so each counts once.
        let upper = (0..3).filter(|axis| facts.c1_faces >> (2 * axis + 1) & 1 == 1);
        let faces = upper.map(|axis| {
            let mut centre = centre;
            centre[axis] += 0.5;
            Critical { centre, kind: CriticalKind::C1 }
        });
        let whole = facts.is_c2.then_some(Critical { centre, kind: CriticalKind::C2 });
        let room = PLACES - self.critical.len();
        self.critical.extend(faces.chain(whole).take(room));
    }
}

/// The cell across the C1 face of a case-8 cell.
fn across(cell: [usize; 3], code: u8) -> [usize; 3] {
    let face = facts()[usize::from(code)].c1_faces.trailing_zeros() as usize;
    let (axis, is_upper) = (face / 2, face % 2 == 1);
    let mut other = cell;
    // A C1 face has foreground samples, so the layer around the volume is not on it and there is a cell beyond.
    if is_upper {
        other[axis] += 1;
    } else {
        other[axis] -= 1;
    }
    other
}

/// Whether the cell across the C1 face of a case-8 cell is of case 8 too, with 6 foreground samples for 2 and 2 for 6.
fn has_partner(samples: &Samples, cell: [usize; 3], code: u8) -> bool {
    let face = facts()[usize::from(code)].c1_faces.trailing_zeros();
    let partner = samples.code(across(cell, code));
    facts()[usize::from(partner)].case == Case::Paired
        && partner.count_ones() + code.count_ones() == 8
        && facts()[usize::from(partner)].c1_faces == 1 << (face ^ 1)
}
