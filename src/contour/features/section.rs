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
    /// Its middle is as far from the one side as from the other, and nowhere are they farther. The sides are polynomials of degree 4 over 8 % of
    /// the chord to both sides of where they stand farthest apart roughly.
    pub(super) fn thickness(&self, noise: &Noise) -> Result<(Estimate, PlaceMm), String> {
        let rough = self.rough_thickest()?;
        let half = WINDOW * self.length_mm();
        let [low, high] = [rough - half, rough + half];
        let fitted = [0, 1].map(|side| {
            Polynomial::fit(4, &self.side(side, [low, high]))
                .filter(|polynomial| polynomial.range()[0] < polynomial.range()[1])
        });
        let [Some(first), Some(second)] = fitted else {
            return Err(format!(
                "airfoil: a side has under 8 points within {half:.4} mm of its thickest place; measure more points there"
            ));
        };
        let sides = [first, second];
        let (mut from, mut to) = (low, high);
        for _ in 0..SEARCHES {
            let [p, q] = [from + (to - from) / 3.0, to - (to - from) / 3.0];
            let [at_p, at_q] = [p, q].map(|u| Inscribed::new(&sides, u).radius_mm);
            if at_p < at_q { from = p } else { to = q }
        }
        let u = 0.5 * (from + to);
        if u - low < 0.02 * half || high - u < 0.02 * half {
            return Err("airfoil: its sides do not stand farthest apart at one place".to_owned());
        }
        let Inscribed { radius_mm, middle, feet } = Inscribed::new(&sides, u);
        // Across the sides.
        let variance = |side: &Polynomial, u: f64| side.variance(u) / (1.0 + side.slope(u).powi(2));
        let variance = variance(&sides[0], feet[0]) + variance(&sides[1], feet[1]);
        let u_mm = noise.sigma_mm * variance.sqrt();
        Ok((Estimate { value: 2.0 * radius_mm, u: u_mm }, middle))
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
        let threes: Vec<Option<f64>> = threes.collect();
        let best = threes.iter().enumerate().filter_map(|(index, sum)| Some((index, (*sum)?)));
        let best = best.reduce(|best, next| if next.1 > best.1 { next } else { best });
        let (index, sum) = best.ok_or_else(|| {
            format!("airfoil: expected points on both sides in three parts of {part:.4} mm one after the other, found gaps; measure more points")
        })?;
        // Of sides that are parallel noise chooses a part: the middle of all that are as thick is away from where they bend.
        let is_level = |at: &usize| threes[*at].is_some_and(|it| it >= (1.0 - LEVEL) * sum);
        let first = (0..=index).rev().take_while(is_level).last().unwrap_or(index);
        let last = (index..threes.len()).take_while(is_level).last().unwrap_or(index);
        Ok(start + part * (0.5 * (first + last) as f64 + 1.5))
    }

    /// A place as words, in the frame of the points.
    pub(super) fn words(&self, end: usize) -> String {
        let [x, y] = self.frame.back(self.places[self.ends[end]]);
        format!("{x:.4}, {y:.4} mm")
    }
}

/// The circle that touches both sides, its middle at a place along the chord.
struct Inscribed {
    radius_mm: f64,
    middle: PlaceMm,
    /// Where along the chord it touches them.
    feet: [f64; 2],
}

impl Inscribed {
    /// The circle with its middle at `u`, by halving the way from one side to the other.
    fn new(sides: &[Polynomial; 2], u: f64) -> Inscribed {
        let mut ends = [0, 1].map(|side| sides[side].value(u));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (ends[0] + ends[1]);
            let [first, second] = [0, 1].map(|side| nearest(&sides[side], [u, middle]).0);
            ends[usize::from(first > second)] = middle;
        }
        let middle = [u, 0.5 * (ends[0] + ends[1])];
        let [first, second] = [0, 1].map(|side| nearest(&sides[side], middle));
        let radius_mm = 0.5 * (first.0 + second.0);
        Inscribed { radius_mm, middle, feet: [first.1, second.1] }
    }
}

/// The distance of a place from a polynomial, and where along it its nearest place lies, by Newton's iteration from beneath it.
fn nearest(of: &Polynomial, [u, v]: PlaceMm) -> (f64, f64) {
    let [low, high] = of.range();
    let mut at = u;
    for _ in 0..FOOT_STEPS {
        let slope = of.slope(at);
        let along = (u - at) + (v - of.value(at)) * slope;
        let step = along / (1.0 + slope * slope);
        let curvature = 0.5 * (of.slope(at + 1e-4) - of.slope(at - 1e-4)) / 1e-4;
        // 0 where the place is the centre of curvature: then no step leads nearer.
        let bend = 1.0 - (v - of.value(at)) * curvature / (1.0 + slope * slope);
        let next = (at + step / bend.max(0.2)).clamp(low, high);
        if next.to_bits() == at.to_bits() {
            break;
        }
        at = next;
    }
    (distance_mm([u, v], [at, of.value(at)]), at)
}

/// Share of the chord to each side that the sides are fitted over.
const WINDOW: f64 = 0.08;
/// Parts of the chord for a first look.
const PARTS: usize = 50;
/// Share of the thickness by which parts that stand for the thickest are thinner at most.
const LEVEL: f64 = 1e-3;
/// Steps of the search; each leaves two thirds.
const SEARCHES: usize = 50;
/// Steps by which the middle of a circle is found between the sides.
const HALVINGS: usize = 50;
/// Most steps to the nearest place of a side.
const FOOT_STEPS: usize = 20;
