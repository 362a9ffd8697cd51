//! Closed ways over samples that keep up to two sides each.

use crate::SampleId;

/// The sides on closed ways that go from sample to sample by the steps each offers, and never straight back; none of a way with fewer than
/// three sides.
///
/// `step` gives the sample at the end of a side that a sample keeps, for the slots 0 and 1. A side walked one way is on such a way if the walks
/// that follow it come back to it: R. E. Tarjan's strongly connected components (SIAM Journal on Computing 1 (1972) 146-160). So the
/// result does not depend on an order. Linear time.
pub(super) fn closed_ways(
    samples: usize,
    step: impl Fn(SampleId, usize) -> Option<SampleId>,
) -> Vec<[SampleId; 2]> {
    let of = |walk: usize| (walk / 2) as SampleId;
    let next = |walk: usize, slot: usize| {
        let to = step(of(walk), walk % 2)?;
        (step(to, slot)? != of(walk)).then_some(2 * to as usize + slot)
    };
    let mut ways = Vec::new();
    let mut search = Search { number: vec![0; 2 * samples], low: vec![0; 2 * samples], count: 0 };
    for walk in 0..2 * samples {
        if step(of(walk), walk % 2).is_some() && search.number[walk] == 0 {
            search.components(walk, &next, |component| {
                if component.len() > 2 {
                    let sides = component.iter().filter_map(|&walk| {
                        let (from, to) = (of(walk), step(of(walk), walk % 2)?);
                        Some([from, to])
                    });
                    ways.extend(sides);
                }
            });
        }
    }
    ways
}

/// The search in depth with a stack of its own.
struct Search {
    /// When a walk was first met, counted from 1; 0 for not yet, and the largest number once its component is known.
    number: Vec<u32>,
    /// The least number that can be reached.
    low: Vec<u32>,
    count: u32,
}

impl Search {
    fn components(
        &mut self,
        first: usize,
        next: &impl Fn(usize, usize) -> Option<usize>,
        mut found: impl FnMut(&[usize]),
    ) {
        let (mut open, mut path) = (Vec::new(), vec![(first, 0)]);
        self.meet(first, &mut open);
        while let Some((walk, slot)) = path.last_mut() {
            let walk = *walk;
            if *slot < 2 {
                let onward = next(walk, *slot);
                *slot += 1;
                match onward {
                    Some(other) if self.number[other] == 0 => {
                        self.meet(other, &mut open);
                        path.push((other, 0));
                    }
                    Some(other) if self.number[other] != KNOWN => {
                        self.low[walk] = self.low[walk].min(self.number[other]);
                    }
                    _ => {}
                }
                continue;
            }
            path.pop();
            if let Some((before, _)) = path.last() {
                self.low[*before] = self.low[*before].min(self.low[walk]);
            }
            if self.low[walk] == self.number[walk] {
                let begins = open.iter().rposition(|&other| other == walk).unwrap_or(0);
                let component = open.split_off(begins);
                component.iter().for_each(|&other| self.number[other] = KNOWN);
                found(&component);
            }
        }
    }

    fn meet(&mut self, walk: usize, open: &mut Vec<usize>) {
        self.count += 1;
        self.number[walk] = self.count;
        self.low[walk] = self.count;
        open.push(walk);
    }
}

/// A walk whose component is known.
const KNOWN: u32 = u32::MAX;
