//! How gap and ε are distributed over the places of a surface.
//!
//! A percentile is the value up to which there is so much area of places (`nearness.rs`). It is found without keeping
//! the triangles: a sample of them tells about where it lies, a pass over all tells the area up to there and how
//! fast that grows, and so where it is. A few passes more, over nothing else, are made where that is
//! not near enough. Sums are made over fixed chunks and joined in their order: the result does not depend on how many
//! threads there are.

use asphera_geometry::nearness::{self, Entry, Held, Nearness, Search};

use super::block::{Block, total};

/// How a figure is distributed over an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Half of the area has at most this.
    pub median: f64,
    /// 99 % of the area has at most this.
    pub p99: f64,
    /// The largest value.
    pub max: f64,
}

/// A figure of places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Figure {
    Gap,
    Epsilon,
}

/// How many figures there are.
const FIGURES: usize = 2;

/// What is looked for: of which figure the value up to which there is which share of the area.
const SEARCHES: [(Figure, f64); 4] =
    [(Figure::Gap, 0.5), (Figure::Gap, 0.99), (Figure::Epsilon, 0.5), (Figure::Epsilon, 0.99)];

/// The values looked at, one for each search.
pub(super) type Values = [f64; SEARCHES.len()];

/// The median and the 99th percentile of gap and ε; `None` where nothing counts.
pub(super) type Percentiles = [Option<[f64; 2]>; FIGURES];

/// One triangle in a distribution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) nearness: Nearness,
    /// The share of it that counts.
    pub(super) weight: f64,
    /// NaN where it is not known.
    pub(super) lfs_mm: f64,
}

impl Placed {
    /// As it counts for a figure, if it does.
    fn entry(&self, figure: Figure) -> Option<Entry> {
        let unit_mm = match figure {
            Figure::Gap => 1.0,
            Figure::Epsilon => Some(self.lfs_mm).filter(|lfs_mm| !lfs_mm.is_nan())?,
        };
        Some(Entry { nearness: self.nearness, unit_mm, weight: self.weight })
    }
}

/// Where the percentiles lie, as a sample tells.
pub(super) fn values_of(sample: &[Placed]) -> Values {
    let entries = [Figure::Gap, Figure::Epsilon].map(|figure| {
        let entries = sample.iter().filter_map(|placed| placed.entry(figure));
        entries.collect::<Vec<Entry>>()
    });
    SEARCHES.map(|(figure, share)| {
        nearness::quantile(&entries[figure as usize], share).unwrap_or_default()
    })
}

/// What all triangles hold up to some values.
#[derive(Clone, Copy)]
pub(super) struct Places {
    values: Values,
    /// All area, for each figure that of the triangles that have it.
    areas_mm2: [f64; FIGURES],
    held: [Held; SEARCHES.len()],
}

impl Places {
    pub(super) fn up_to(values: Values) -> Places {
        Places { values, areas_mm2: [0.0; FIGURES], held: [Held::default(); SEARCHES.len()] }
    }

    /// Takes in a triangle.
    pub(super) fn add(&mut self, placed: &Placed) {
        for figure in [Figure::Gap, Figure::Epsilon] {
            let Some(entry) = placed.entry(figure) else { continue };
            self.areas_mm2[figure as usize] += entry.weight * entry.nearness.area_mm2;
            for (search, (of, _)) in SEARCHES.into_iter().enumerate() {
                if of == figure {
                    self.held[search] = self.held[search].and(entry.held(self.values[search]));
                }
            }
        }
    }

    /// Takes in all triangles of a block that count, whose ε is known; `area_mm2` is the sum of theirs.
    pub(super) fn add_block(&mut self, block: &Block, area_mm2: f64) {
        self.areas_mm2.iter_mut().for_each(|sum| *sum += area_mm2);
        for (search, (figure, _)) in SEARCHES.into_iter().enumerate() {
            let value = self.values[search];
            let mut held = [Held::default(); super::block::BLOCK];
            for (row, held) in held.iter_mut().enumerate() {
                let unit_mm = match figure {
                    Figure::Gap => 1.0,
                    Figure::Epsilon => block.lfs_mm[row],
                };
                *held = block.nearness(row).within(value * unit_mm);
                held.rate_mm *= if held.rate_mm > 0.0 { unit_mm } else { 1.0 };
            }
            self.held[search] = self.held[search].and(Held {
                area_mm2: total(|row| held[row].area_mm2),
                rate_mm: total(|row| held[row].rate_mm),
            });
        }
    }

    /// Takes in the triangles of another one, which come after these.
    pub(super) fn join(&mut self, after: Places) {
        self.areas_mm2.iter_mut().zip(after.areas_mm2).for_each(|(sum, area)| *sum += area);
        self.held.iter_mut().zip(after.held).for_each(|(sum, held)| *sum = sum.and(held));
    }
}

/// The search for all percentiles.
pub(super) struct Searches {
    searches: [Search; SEARCHES.len()],
    found: [Option<f64>; SEARCHES.len()],
    /// How many passes are left before what is known has to do.
    left: usize,
}

impl Searches {
    /// Where the largest gap and the largest ε are these.
    pub(super) fn up_to(most: [f64; FIGURES]) -> Searches {
        Searches {
            searches: SEARCHES.map(|(figure, _)| Search::new(most[figure as usize])),
            found: [None; SEARCHES.len()],
            left: MOST_PASSES,
        }
    }

    /// The percentiles, as what all triangles hold up to some values tells.
    ///
    /// # Errors
    ///
    /// The values to look at next.
    pub(super) fn percentiles(&mut self, places: &Places) -> Result<Percentiles, Values> {
        let mut values = places.values;
        self.left -= 1;
        let mut is_done = true;
        for (search, (figure, share)) in SEARCHES.into_iter().enumerate() {
            let wanted = share * places.areas_mm2[figure as usize];
            if self.found[search].is_some() || wanted <= 0.0 {
                continue;
            }
            let at = places.values[search];
            match self.searches[search].next(at, places.held[search], wanted) {
                Ok(value) => self.found[search] = Some(value),
                Err(value) if self.left > 0 => (values[search], is_done) = (value, false),
                Err(value) => self.found[search] = Some(value),
            }
        }
        if !is_done {
            return Err(values);
        }
        let both = |first: usize| Some([self.found[first]?, self.found[first + 1]?]);
        Ok([both(0), both(2)])
    }
}

/// More passes than Newton's steps ever take from where a sample puts a percentile.
const MOST_PASSES: usize = 60;
