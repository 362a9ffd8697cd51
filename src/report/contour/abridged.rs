//! Long lists of a contour, cut to what a report can hold.

use super::{ChainFigures, ContourReport};

/// Entries of all lists of a contour in a report, at most: beyond, they would make it longer than all else.
const MOST_ENTRIES: usize = 20_000;

impl ContourReport {
    /// The contour with lists that a report can hold. Where they are longer, edges, rows and deviations of single points are
    /// left out, and lines keep every k-th place. Figures stay as they are.
    #[must_use]
    pub fn abridged(mut self) -> ContourReport {
        let places = |chains: &[ChainFigures]| -> usize {
            chains.iter().map(|chain| chain.points_mm.len()).sum()
        };
        let deviations = self.deviation.as_ref().map_or(0, |it| it.deviations_mm.len());
        let rows = self.ends.len() + self.junctions.len() + self.left_out.len();
        let places = places(&self.chains);
        if self.edges.len().max(deviations).max(rows).max(places) <= MOST_ENTRIES {
            return self;
        }
        let every = places.div_ceil(MOST_ENTRIES).max(1);
        let mut words = format!(
            "left out: {} edges, {rows} rows of ends, junctions and points left out, {deviations} deviations",
            self.edges.len()
        );
        if every > 1 {
            words.push_str(&format!("; of {places} places of lines 1 in {every} is listed"));
        }
        for list in [&mut self.ends, &mut self.junctions, &mut self.left_out] {
            list.clear();
        }
        self.edges.clear();
        if !self.beziers_mm.is_empty() {
            words.push_str("; Bézier curves of all lines");
            self.beziers_mm.clear();
        }
        if let Some(deviation) = &mut self.deviation {
            deviation.deviations_mm.clear();
        }
        self.chains.iter_mut().for_each(|chain| thin(&mut chain.points_mm, every, chain.closed));
        for part in self.regions.iter_mut().flatten() {
            thin(&mut part.outline_mm, every, true);
            part.holes_mm.iter_mut().for_each(|hole| thin(hole, every, true));
        }
        // A line of two ends and what lies evenly between them.
        self.gaps.iter_mut().for_each(|gap| thin(&mut gap.points_mm, every, false));
        self.abridged = Some(words);
        self
    }
}

/// Keeps every k-th place of a line; an open one also its last, a closed one at least three.
fn thin(places_mm: &mut Vec<[f64; 2]>, every: usize, closed: bool) {
    let every = if closed { every.min(places_mm.len() / 3) } else { every };
    if every < 2 {
        return;
    }
    let last = places_mm
        .last()
        .copied()
        .filter(|_| !closed && !(places_mm.len() - 1).is_multiple_of(every));
    *places_mm = places_mm.iter().copied().step_by(every).chain(last).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::{CONTOUR_FORMAT, InputFigures};

    fn chain(count: usize, closed: bool) -> ChainFigures {
        let points_mm = (0..count).map(|index| [index as f64, 0.0]).collect();
        ChainFigures { closed, length_mm: 1.0, points_mm }
    }

    fn contour(edges: usize, chains: Vec<ChainFigures>) -> ContourReport {
        ContourReport {
            format: CONTOUR_FORMAT.to_owned(),
            input: InputFigures {
                points: edges,
                distinct: edges,
                spacing_median_mm: Some(1.0),
                ..InputFigures::default()
            },
            method: "crust".to_owned(),
            edges: vec![[0, 1]; edges],
            chains,
            ends: vec![3],
            ..ContourReport::default()
        }
    }

    #[test]
    fn short_lists_stay_whole_and_long_ones_are_cut_in_words() {
        let whole = contour(20_000, vec![chain(20_000, true)]);
        assert_eq!(whole.clone().abridged(), whole);
        let long =
            contour(100_000, vec![chain(90_000, true), chain(10_000, false), chain(4, true)]);
        let cut = long.abridged();
        assert!(cut.edges.is_empty() && cut.ends.is_empty());
        let lengths: Vec<usize> = cut.chains.iter().map(|chain| chain.points_mm.len()).collect();
        // Every sixth, of the open one also the last.
        assert_eq!(lengths, [15_000, 1_668, 4]);
        assert_eq!(cut.chains[1].points_mm[1_667], [9_999.0, 0.0]);
        let words = cut.abridged.clone().unwrap();
        assert_eq!(
            words,
            "left out: 100000 edges, 1 rows of ends, junctions and points left out, 0 deviations; of 100004 places of lines \
             1 in 6 is listed"
        );
        let again = cut.clone().abridged();
        assert_eq!(again, cut);
    }
}
