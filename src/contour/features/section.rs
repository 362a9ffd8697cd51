//! An airfoil's section in the frame of its chord.

use super::course::Noise;
use super::polynomial::Polynomial;
use super::profile::Estimate;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The frame of a chord: where it begins, and its direction.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    from_mm: PlaceMm,
    along: PlaceMm,
}

impl Frame {
    pub(super) fn new(from_mm: PlaceMm, to_mm: PlaceMm) -> Frame {
        let length = distance_mm(from_mm, to_mm);
        let along = [0, 1].map(|axis| (to_mm[axis] - from_mm[axis]) / length);
        Frame { from_mm, along }
    }

    /// Along the chord and to its left.
    fn local(&self, [x, y]: PlaceMm) -> PlaceMm {
        let [x, y] = [x - self.from_mm[0], y - self.from_mm[1]];
        [x * self.along[0] + y * self.along[1], y * self.along[0] - x * self.along[1]]
    }

    /// A place in the frame of the points.
    pub(super) fn back(&self, [u, v]: PlaceMm) -> PlaceMm {
        let [x, y] = self.along;
        [self.from_mm[0] + u * x - v * y, self.from_mm[1] + u * y + v * x]
    }
}

/// A section: its points along and across the chord, counter-clockwise.
pub(super) struct Section {
    pub(super) frame: Frame,
    pub(super) places: Vec<PlaceMm>,
    /// The points farthest apart, between which both sides lie.
    pub(super) ends: [usize; 2],
}

impl Section {
    pub(super) fn new(places_mm: &[PlaceMm], ends: [usize; 2], frame: Frame) -> Section {
        let places = places_mm.iter().map(|&place| frame.local(place)).collect();
        Section { frame, places, ends }
    }

    /// The same with a point moved across the curve, mm.
    pub(super) fn moved(&self, index: usize, by_mm: f64) -> Section {
        let count = self.places.len();
        let [before, after] = [index + count - 1, index + 1].map(|it| self.places[it % count]);
        let [x, y] = [after[0] - before[0], after[1] - before[1]];
        let share = by_mm / x.hypot(y);
        let mut places = self.places.clone();
        places[index] = [places[index][0] + share * y, places[index][1] - share * x];
        Section { frame: self.frame, places, ends: self.ends }
    }

    /// 1 at the end of the chord, -1 where it begins.
    pub(super) fn outward(end: usize) -> f64 {
        if end == 0 { -1.0 } else { 1.0 }
    }

    /// Distance of the points farthest apart along the chord.
    pub(super) fn length_mm(&self) -> f64 {
        self.places[self.ends[1]][0] - self.places[self.ends[0]][0]
    }

    /// How far a point lies from an end of the chord, along it.
    pub(super) fn depth_mm(&self, end: usize, place: PlaceMm) -> f64 {
        Section::outward(end) * (self.places[self.ends[end]][0] - place[0])
    }

    /// The points within a depth of an end, in order.
    pub(super) fn near(&self, end: usize, depth_mm: f64) -> Vec<usize> {
        let count = self.places.len();
        // From the other end on, so that they follow each other.
        let order = (0..count).map(|step| (self.ends[1 - end] + step) % count);
        order.filter(|&index| self.depth_mm(end, self.places[index]) <= depth_mm).collect()
    }

    /// The points of a side whose places along the chord lie in a range: of side 0 from the beginning of the chord to its end.
    pub(super) fn side(&self, side: usize, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let count = self.places.len();
        let [from, to] = [self.ends[side], self.ends[1 - side]];
        let steps = (to + count - from) % count;
        let order = (1..steps).map(|step| self.places[(from + step) % count]);
        order.filter(|place| (low..=high).contains(&place[0])).collect()
    }

    /// The diameter of the largest circle within, and its middle along and across the chord.
    ///
    /// It touches both sides where they are as far apart as they get: between P on one side and the nearest place Q to it on the other, PQ the
    /// largest. The sides are polynomials of degree 4 over 8 % of the chord to both sides of where they stand farthest apart roughly.
    pub(super) fn thickness(&self, noise: &Noise) -> Result<(Estimate, PlaceMm), String> {
        let rough = self.rough_thickest()?;
        let half = WINDOW * self.length_mm();
        let fitted = [0, 1].map(|side| {
            Polynomial::fit(4, &self.side(side, [rough - half, rough + half]))
                .filter(|polynomial| polynomial.range()[0] < polynomial.range()[1])
        });
        let [Some(first), Some(second)] = &fitted else {
            return Err(format!(
                "airfoil: a side has under 8 points within {half:.4} mm of its thickest place; measure more points there"
            ));
        };
        let [low, high] = [rough - half, rough + half];
        let (mut from, mut to) = (low, high);
        let nearest_mm = |u: f64| {
            let at = [u, first.value(u)];
            let foot = foot(second, at);
            (distance_mm(at, [foot, second.value(foot)]), foot)
        };
        for _ in 0..SEARCHES {
            let [p, q] = [from + (to - from) / 3.0, to - (to - from) / 3.0];
            if nearest_mm(p).0 < nearest_mm(q).0 { from = p } else { to = q }
        }
        let u = 0.5 * (from + to);
        let (thickness_mm, foot) = nearest_mm(u);
        if u - low < 0.02 * half || high - u < 0.02 * half {
            return Err("airfoil: its sides do not stand farthest apart at one place".to_owned());
        }
        // Across the sides.
        let variance = |side: &Polynomial, u: f64| side.variance(u) / (1.0 + side.slope(u).powi(2));
        let variance = variance(first, u) + variance(second, foot);
        let middle = [0.5 * (u + foot), 0.5 * (first.value(u) + second.value(foot))];
        Ok((Estimate { value: thickness_mm, u: noise.sigma_mm * variance.sqrt() }, middle))
    }

    /// Where along the chord the means of both sides stand farthest apart, of 50 parts, three by three.
    fn rough_thickest(&self) -> Result<f64, String> {
        let length = self.length_mm();
        let [start, _] = self.ends.map(|end| self.places[end][0]);
        let part = length / PARTS as f64;
        let means: Vec<Option<f64>> = (0..PARTS)
            .map(|index| {
                let low = start + part * index as f64;
                let mean = |side: usize| {
                    let rows = self.side(side, [low, low + part]);
                    let sum: f64 = rows.iter().map(|row| row[1]).sum();
                    (!rows.is_empty()).then(|| sum / rows.len() as f64)
                };
                Some((mean(0)? - mean(1)?).abs())
            })
            .collect();
        let threes = means.windows(3).map(|three| Some(three[0]? + three[1]? + three[2]?));
        let best = threes.enumerate().filter_map(|(index, sum)| Some((index, sum?)));
        let best = best.reduce(|best, next| if next.1 > best.1 { next } else { best });
        best.map(|(index, _)| start + part * (index as f64 + 1.5)).ok_or_else(|| {
            format!("airfoil: expected points on both sides in three parts of {part:.4} mm one after the other, found gaps; measure more points")
        })
    }

    /// A place as words, in the frame of the points.
    pub(super) fn words(&self, end: usize) -> String {
        let [x, y] = self.frame.back(self.places[self.ends[end]]);
        format!("{x:.4}, {y:.4} mm")
    }
}

/// Where along a polynomial its nearest place to a place lies, by Newton's iteration from beneath it.
fn foot(of: &Polynomial, [u, v]: PlaceMm) -> f64 {
    let mut at = u;
    for _ in 0..20 {
        // The way to the place along the curve's direction; curvature is left out, so steps converge fast only near.
        let slope = of.slope(at);
        let along = (u - at) + (v - of.value(at)) * slope;
        let step = along / (1.0 + slope * slope);
        let curvature = 0.5 * (of.slope(at + 1e-4) - of.slope(at - 1e-4)) / 1e-4;
        let bend = 1.0 - (v - of.value(at)) * curvature / (1.0 + slope * slope);
        at += step / bend.max(0.2);
    }
    at
}

/// Share of the chord to each side that the sides are fitted over.
const WINDOW: f64 = 0.08;
/// Parts of the chord for a first look.
const PARTS: usize = 50;
/// Steps of the search; each leaves two thirds.
const SEARCHES: usize = 80;
