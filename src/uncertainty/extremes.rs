//! How far errors may have moved the extremes of heights: limits of a range, or of one end of it, that hold whatever the
//! form is.
//!
//! The highest of n heights has more than its share of the noise, and simulated measurements that add noise to heights
//! which hold noise already tell only a part of that (the bootstrap fails for extremes: Bickel & Freedman, Ann. Statist. 9
//! (1981) 1196). So neither limit comes from such draws.
//!
//! Below: the highest place of the form is nowhere lower than the mean of the form over any window, which is known with noise
//! averaged. With h the mean of the heights over a window and s its standard uncertainty, the limit is the largest
//! h − c·s over all windows, from single places up to squares of a quarter of the part: an interval for the largest of
//! many means (Chernozhukov, Lee & Rosen, Econometrica 81 (2013) 667). c is such that no window breaks it but for the wanted
//! share of draws. The window that reaches farthest for sure leads; one that is lower by more than √(ln N) standard deviations
//! of the difference, for N windows, counts by so much less (the selection of Andrews & Soares, Econometrica 78 (2010) 119).
//! Noise of windows counts as independent, though they lie in one another: what is correlated reaches less far (Slepian, Bell
//! Syst. Tech. J. 41 (1962) 463).
//!
//! Above: the place that is the highest of the form, wherever it is, was measured with an error of its own, and is no
//! higher than the highest measured plus that error. A defect of one place's width may hide in noise, and
//! nothing is assumed of its neighbours.
//!
//! A range is the same at both ends at once. What the noise takes off the parameters of a fit is neglected: it is √(p/n) of
//! that of a place.

use rayon::prelude::*;

use super::distribution::normal_exceeded;
use super::linear::dot;
use super::simulate::{Draws, Simulated, factors};
use super::windows::Windows;
use asphera_geometry::Numbers;

/// Heights with what is known of their errors, all in one unit.
pub(super) struct Errors<'a> {
    pub(super) places_mm: &'a [[f64; 2]],
    pub(super) heights: &'a [f64],
    /// Variance of the noise of each place.
    pub(super) noise: &'a [f64],
    /// Variance of noise that is independent from place to place and no less in any mean over places: that before filters,
    /// where these make `noise` smaller.
    pub(super) independent: &'a [f64],
    /// What correlated errors are, function by function, at each of some nodes; functions are as many at all.
    pub(super) functions: &'a [Vec<f64>],
    /// The node of each place.
    pub(super) node_of: &'a [usize],
}

/// What is looked at: the height of the highest place, the depth of the lowest, or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    High,
    Low,
}

/// Windows and places with their errors, by ends.
pub(super) struct Extremes {
    windows: Windows,
    ends: [Contacts; 2],
    /// Standard uncertainty of a window of each class, the correlated part regarded.
    margins: Vec<f64>,
    /// Standard deviation of the noise of each class.
    sigmas: Vec<f64>,
    /// Of each coarse square, what correlated errors are in it.
    functions: Vec<Vec<f64>>,
}

/// What may be an extreme at one end; heights are upside down at the low one.
struct Contacts {
    /// The largest mean of each class; none is −∞.
    highest: Vec<f64>,
    entries: Vec<Entry>,
    /// Windows in the entries.
    windows: usize,
    /// Single places that may be the extreme.
    places: Vec<Candidate>,
}

/// Windows of one class in one coarse square that are lower than the leading one by about as much.
#[derive(Clone, Copy, Debug)]
struct Entry {
    cell: u32,
    class: u32,
    /// How much lower they are at least.
    drop: f64,
    count: f64,
}

/// A window or place at one end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outer {
    /// Its mean, outwards.
    pub(super) height: f64,
    pub(super) margin: f64,
    /// A place at its middle.
    pub(super) middle: usize,
}

/// A place with the variance of its noise.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    height: f64,
    variance: f64,
    cell: u32,
}

/// How the form may lie to the heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Datum {
    /// As given.
    Fixed,
    /// Heights are about a place that was fitted to the extremes themselves, and are off by up to the noise of a place.
    Moving,
}

impl Extremes {
    /// `O(n log n)`.
    pub(super) fn new(errors: &Errors<'_>, datum: Datum) -> Extremes {
        let windows = Windows::new(errors.places_mm, errors.heights, errors.independent);
        let largest = errors.noise.iter().copied().fold(0.0, f64::max);
        let functions: Vec<Vec<f64>> = windows
            .middles
            .iter()
            .map(|&place| errors.functions[errors.node_of[place as usize]].clone())
            .collect();
        let sigmas: Vec<f64> =
            (0..CLASSES).map(|class| (largest * 0.5_f64.powi(class as i32)).sqrt()).collect();
        let count = (windows.windows.len() + windows.order.len()) as f64;
        let all = All { windows: &windows, errors, largest };
        let sure = normal_exceeded(SURE / count.max(1.0));
        let leads = [End::High, End::Low].map(|end| all.lead(end, sure));
        let correlated = leads.iter().flatten().map(|lead| {
            let functions = &functions[lead.cell as usize];
            0.5 * dot(functions, functions)
        });
        let correlated: f64 = correlated.sum();
        let margins: Vec<f64> =
            sigmas.iter().map(|sigma| (sigma * sigma + correlated).sqrt()).collect();
        let explained = count.max(1.0).ln().sqrt();
        let known =
            Known { functions: &functions, explained, datum, sigmas: &sigmas, margins: &margins };
        let ends = [(End::High, &leads[0]), (End::Low, &leads[1])]
            .map(|(end, lead)| all.contacts(end, lead.as_ref(), &known));
        Extremes { windows, ends, margins, sigmas, functions }
    }

    /// How far the highest and the lowest lie from the datum, outwards, and how far apart they are. `measured` are the first
    /// two.
    pub(super) fn figures(&self, [high, low]: [f64; 2], draws: &Draws) -> [Simulated; 3] {
        let drawn = self.drawn(draws);
        let end = |end: End, measured: f64| {
            let of_draw = |most: &[Vec<f64>; 2]| {
                let of = most[end as usize].iter().zip(&self.margins);
                let c = of.fold(
                    0.0,
                    |c: f64, (most, margin)| {
                        if *margin > 0.0 { c.max(most / margin) } else { c }
                    },
                );
                self.reached(end, c).max(0.0)
            };
            let above = self.contacts(end).places.iter().map(|place| {
                let functions = &self.functions[place.cell as usize];
                (place.height, (place.variance + dot(functions, functions)).sqrt())
            });
            let limits = drawn.iter().map(of_draw).collect();
            Simulated::of_extremes(measured, limits, above.collect(), self.looked_at())
        };
        [end(End::High, high), end(End::Low, low), self.range_of(high + low, &drawn)]
    }

    /// How far apart the lowest and the highest are.
    pub(super) fn range(&self, measured: f64, draws: &Draws) -> Simulated {
        self.range_of(measured, &self.drawn(draws))
    }

    fn range_of(&self, measured: f64, drawn: &[[Vec<f64>; 2]]) -> Simulated {
        let of_draw = |most: &[Vec<f64>; 2]| {
            let c = self.least_factor(most);
            (self.reached(End::High, c) + self.reached(End::Low, c)).max(0.0)
        };
        let limits = drawn.iter().map(of_draw).collect();
        Simulated::of_extremes(measured, limits, self.pairs(measured), self.looked_at())
    }

    /// The factor of the margins at which no window of a draw is outside, at both ends together.
    pub(super) fn range_factors(&self, draws: &Draws) -> Vec<f64> {
        self.drawn(draws).iter().map(|most| self.least_factor(most)).collect()
    }

    /// Windows and places of the errors it was made from that reach farthest with margins times `c`, those first that do.
    pub(super) fn outermost(
        &self,
        errors: &Errors<'_>,
        end: End,
        c: f64,
        most: usize,
    ) -> Vec<Outer> {
        let all = All { windows: &self.windows, errors, largest: self.sigmas[0] * self.sigmas[0] };
        // One a class and coarse square, so that they are spread out.
        let mut found: Vec<Option<Outer>> = vec![None; self.functions.len() * CLASSES];
        for held in all.each(end) {
            let Held { height, class, cell, middle, .. } = held;
            let best = &mut found[cell as usize * CLASSES + class];
            if best.is_none_or(|best| height > best.height) {
                *best = Some(Outer { height, margin: self.margins[class], middle });
            }
        }
        let mut found: Vec<Outer> = found.into_iter().flatten().collect();
        let reached = |outer: &Outer| outer.height - c * outer.margin;
        found.sort_by(|a, b| reached(b).total_cmp(&reached(a)).then(a.middle.cmp(&b.middle)));
        found.truncate(most);
        found
    }

    /// How many windows and places may be an extreme.
    pub(super) fn looked_at(&self) -> usize {
        self.ends.iter().map(|end| end.windows).sum()
    }

    fn contacts(&self, end: End) -> &Contacts {
        &self.ends[end as usize]
    }

    /// How far outwards the form reaches at least, with margins times `c`.
    fn reached(&self, end: End, c: f64) -> f64 {
        let highest = self.contacts(end).highest.iter().zip(&self.margins);
        highest.fold(f64::NEG_INFINITY, |most, (highest, margin)| most.max(highest - c * margin))
    }

    /// Pairs of places that may be highest and lowest: how far apart they are, and the standard deviation of that.
    fn pairs(&self, measured: f64) -> Vec<(f64, f64)> {
        let mut found: Vec<(f64, f64)> = Vec::new();
        for high in &self.contacts(End::High).places {
            for low in &self.contacts(End::Low).places {
                let [a, b] = [high, low].map(|place| &self.functions[place.cell as usize]);
                let variance = high.variance + low.variance + square_apart(a, b);
                found.push((high.height + low.height, variance.sqrt()));
            }
        }
        found.push((measured, 0.0));
        // Of pairs with less spread only those that are farther apart count.
        found.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.0.total_cmp(&a.0)));
        let mut farthest = f64::NEG_INFINITY;
        found.retain(|pair| {
            let counts = pair.0 > farthest;
            farthest = farthest.max(pair.0);
            counts
        });
        found
    }

    /// The largest errors less drops in each draw, by end and class.
    fn drawn(&self, draws: &Draws) -> Vec<[Vec<f64>; 2]> {
        let of_draw = |draw: u32| {
            let correlated = self.functions.first().map_or(0, Vec::len);
            let factors = factors(draws.seed, draw, correlated);
            let waves: Vec<f64> = self.functions.iter().map(|of| dot(of, &factors)).collect();
            [(End::High, 1.0, HIGH), (End::Low, -1.0, LOW)].map(|(end, sign, stream)| {
                let noise = Numbers::new(draws.seed, draw, stream);
                let mut most = vec![f64::NEG_INFINITY; CLASSES];
                for (index, entry) in self.contacts(end).entries.iter().enumerate() {
                    let sigma = self.sigmas[entry.class as usize];
                    let level = sign * waves[entry.cell as usize] - entry.drop;
                    let most = &mut most[entry.class as usize];
                    let share = noise.uniform(index);
                    if may_exceed(entry.count, share, (*most - level) / sigma) {
                        *most = most.max(level + sigma * largest_of(entry.count, share));
                    }
                }
                most
            })
        };
        (0..draws.count).into_par_iter().map(of_draw).collect()
    }

    /// The least c ≥ 0 with max(high − c·margin) + max(low − c·margin) ≤ 0, by Newton's method, which from the left of a
    /// convex function does not go too far.
    fn least_factor(&self, most: &[Vec<f64>; 2]) -> f64 {
        let mut c = 0.0;
        for _ in 0..STEPS {
            let [mut sum, mut slope] = [0.0; 2];
            for end in most {
                let first = (f64::NEG_INFINITY, 0.0);
                let values =
                    end.iter().zip(&self.margins).map(|(v, margin)| (v - c * margin, *margin));
                let (value, margin) =
                    values.fold(first, |best, next| if next.0 > best.0 { next } else { best });
                sum += value;
                slope += margin;
            }
            if !(sum > 0.0 && slope > 0.0) {
                break;
            }
            c += sum / slope;
        }
        c
    }
}

/// All windows and places, before it is known which matter.
struct All<'a> {
    windows: &'a Windows,
    errors: &'a Errors<'a>,
    /// Variance of the noisiest place.
    largest: f64,
}

/// Measure of which of them matter.
struct Known<'a> {
    /// Of each coarse square.
    functions: &'a [Vec<f64>],
    /// Standard deviations of a difference of two windows that are taken for noise.
    explained: f64,
    datum: Datum,
    /// Of each class.
    sigmas: &'a [f64],
    margins: &'a [f64],
}

/// A window or a place.
#[derive(Clone, Copy)]
struct Held {
    /// Its mean, outwards.
    height: f64,
    variance: f64,
    class: usize,
    cell: u32,
    middle: usize,
    is_place: bool,
}

impl All<'_> {
    fn each(&self, end: End) -> impl Iterator<Item = Held> + '_ {
        let Windows { order, windows, cell_of, .. } = self.windows;
        let held = move |height: f64, variance: f64, middle: usize, is_place: bool| Held {
            height: if end == End::High { height } else { -height },
            variance,
            class: class(variance, self.largest),
            cell: cell_of[middle],
            middle: order[middle] as usize,
            is_place,
        };
        let places = order.iter().enumerate().map(move |(at, &place)| {
            let place = place as usize;
            held(self.errors.heights[place], self.errors.noise[place], at, true)
        });
        let of_windows = windows.iter().map(move |window| {
            held(window.mean, window.variance.min(self.largest), window.middle(), false)
        });
        places.chain(of_windows)
    }

    /// The one that reaches farthest for sure; `None` without a place.
    fn lead(&self, end: End, sure: f64) -> Option<Held> {
        let sure = |held: &Held| held.height - sure * held.variance.sqrt();
        self.each(end).max_by(|a, b| sure(a).total_cmp(&sure(b)))
    }

    fn contacts(&self, end: End, lead: Option<&Held>, known: &Known<'_>) -> Contacts {
        let Known { functions, explained, datum, sigmas, margins } = *known;
        let mut found = Contacts {
            highest: vec![f64::NEG_INFINITY; CLASSES],
            entries: Vec::new(),
            windows: 0,
            places: Vec::new(),
        };
        let Some(lead) = lead else { return found };
        let cells = functions.len();
        // Without correlated errors it does not matter where a window lies.
        let apart = functions.iter().map(|of| square_apart(of, &functions[lead.cell as usize]));
        let apart: Vec<f64> = apart.collect();
        let is_apart = functions.iter().any(|of| !of.is_empty());
        let mut counts = vec![0_u32; if is_apart { cells } else { 1 } * CLASSES * BINS];
        let mut places: Vec<Option<Candidate>> = vec![None; cells * CLASSES];
        for held in self.each(end) {
            let Held { height, variance, class, cell, is_place, .. } = held;
            found.highest[class] = found.highest[class].max(height);
            let noise = match datum {
                Datum::Fixed => lead.variance + variance,
                Datum::Moving => 2.0 * self.largest,
            };
            let explained = explained * (noise + apart[cell as usize]).sqrt();
            let drop = (lead.height - height - explained).max(0.0);
            let bin = drop / step(sigmas[class], margins[class]);
            // Without any error a step is nought: then only what is no lower counts.
            if drop > 0.0 && (bin.is_nan() || bin >= BINS as f64) {
                continue;
            }
            found.windows += 1;
            let row = if is_apart { cell as usize } else { 0 };
            let bin = if drop > 0.0 { bin as usize } else { 0 };
            counts[(row * CLASSES + class) * BINS + bin] += 1;
            let best = &mut places[cell as usize * CLASSES + class];
            if is_place && best.is_none_or(|best| height > best.height) {
                *best = Some(Candidate { height, variance, cell });
            }
        }
        for (index, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let (row, bin) = (index / BINS, index % BINS);
            let class = row % CLASSES;
            found.entries.push(Entry {
                cell: (row / CLASSES) as u32,
                class: class as u32,
                drop: bin as f64 * step(sigmas[class], margins[class]),
                count: f64::from(count),
            });
        }
        found.places = places.into_iter().flatten().collect();
        let reach = |place: &Candidate| {
            let functions = &functions[place.cell as usize];
            place.height + 2.0 * (place.variance + dot(functions, functions)).sqrt()
        };
        found.places.sort_by(|a, b| reach(b).total_cmp(&reach(a)));
        found.places.truncate(MOST_PLACES);
        found
    }
}

/// |a − b|².
fn square_apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// How many times the variance is halved.
fn class(variance: f64, largest: f64) -> usize {
    if variance <= 0.0 {
        return CLASSES - 1;
    }
    // A hair more, for variances of 4 and 16 places are a quarter and a sixteenth but for rounding.
    (((largest / variance).log2() + 1e-9).max(0.0) as usize).min(CLASSES - 1)
}

/// Drops are counted in steps, up to what no error makes up for.
fn step(sigma: f64, margin: f64) -> f64 {
    let correlated = (margin * margin - sigma * sigma).max(0.0);
    BEYOND * (sigma * sigma + 2.0 * correlated).sqrt() / BINS as f64
}

/// Whether [`largest_of`] can be more than `x`, told in few operations: with U the share, 1 − U^(1/m) ≥ (1 − U)/m, and a
/// normal number exceeds x > 0 with a probability of exp(−x²/2)/2 at most.
fn may_exceed(count: f64, share: f64, x: f64) -> bool {
    !(x > 0.0 && 1.0 - share > 0.5 * count * (-0.5 * x * x).exp())
}

/// The largest of `count` normal numbers, which a share `share` of such is below.
fn largest_of(count: f64, share: f64) -> f64 {
    let exceeded = -(share.max(f64::MIN_POSITIVE).ln() / count).exp_m1();
    normal_exceeded(exceeded)
}

/// Classes of variances, each the half of the one before.
const CLASSES: usize = 24;
/// Of drops.
const BINS: usize = 32;
/// A normal deviate that is beyond all of as many as there are places.
const BEYOND: f64 = 6.5;
/// Share of measurements in which another window may lead than one of the highest.
const SURE: f64 = 1e-2;
/// Places at either end that are paired, one a coarse square.
const MOST_PLACES: usize = 64;
/// Newton's method ends in as many steps as there are pairs of classes, and mostly in three.
const STEPS: usize = 64;
/// Streams of random numbers, beside those of the measurements.
const HIGH: u32 = 5;
const LOW: u32 = 6;

#[cfg(test)]
mod tests {
    use super::*;

    fn of(heights: &[f64], places_mm: &[[f64; 2]], sigma: f64) -> [Simulated; 3] {
        let noise = vec![sigma * sigma; heights.len()];
        let errors = Errors {
            places_mm,
            heights,
            noise: &noise,
            independent: &noise,
            functions: &[Vec::new()],
            node_of: &vec![0; heights.len()],
        };
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let draws = Draws { count: 2000, seed: 2 };
        Extremes::new(&errors, Datum::Fixed).figures([high, -low], &draws)
    }

    fn lattice() -> Vec<[f64; 2]> {
        (0..400).map(|i| [f64::from(i % 20), f64::from(i / 20)]).collect()
    }

    fn close(found: f64, truth: f64, within: f64) {
        assert!((found - truth).abs() < within, "{found} {truth}");
    }

    /// A single place that is far above all others and one far below: the errors of these two are all there is. Of 2000
    /// draws a quantile of 2.5 % is known to 0.06 σ.
    #[test]
    fn two_places_that_stand_out_have_the_errors_of_two_normal_numbers() {
        let mut heights = vec![0.0; 400];
        (heights[31], heights[333]) = (1000.0, -2000.0);
        let [high, low, range] = of(&heights, &lattice(), 2.0);
        for (found, value, sigma) in
            [(&high, 1000.0, 2.0), (&low, 2000.0, 2.0), (&range, 3000.0, 2.0 * 2.0_f64.sqrt())]
        {
            close(found.u, sigma, 1e-9);
            close(found.bias, 0.0, 0.3);
            let [least, most] = found.interval(0.95);
            close(least, value - 1.959_964 * sigma, 0.2 * sigma);
            close(most, value + 1.959_964 * sigma, 1e-5);
        }
    }

    /// Heights that are nothing but noise: below there is nothing but in 1 of 40, and above no more than a single place
    /// may have.
    #[test]
    fn noise_alone_may_be_nothing() {
        let (mut more, mut bias) = ([0; 3], 0.0);
        for seed in 0..80 {
            let numbers = Numbers::new(seed, 0, 0);
            let heights: Vec<f64> = (0..400).map(|i| numbers.normal(i)).collect();
            for (more, found) in more.iter_mut().zip(of(&heights, &lattice(), 1.0)) {
                let [least, most] = found.interval(0.95);
                *more += i32::from(least > 0.0);
                assert!(most > found.measured && most < found.measured + 2.8);
                bias += found.bias / found.measured / 240.0;
            }
        }
        assert!(more.iter().all(|more| *more <= 6) && bias > 0.9, "{more:?} {bias}");
    }

    /// A plateau of 64 places is known as their mean, within what windows that lie in it are tried, and not as the highest.
    #[test]
    fn a_plateau_is_known_by_its_mean() {
        let places: Vec<[f64; 2]> =
            (0..1024).map(|i| [f64::from(i % 32), f64::from(i / 32)]).collect();
        let numbers = Numbers::new(4, 0, 0);
        let is_high = |&[x, y]: &[f64; 2]| x >= 24.0 && y >= 24.0;
        let heights: Vec<f64> = (0..)
            .zip(&places)
            .map(|(i, place)| numbers.normal(i) + if is_high(place) { 50.0 } else { 0.0 })
            .collect();
        let [high, ..] = of(&heights, &places, 1.0);
        assert!(high.measured > 51.5);
        let [least, _] = high.interval(0.95);
        assert!((49.2..50.0).contains(&least), "{least}");
        assert!((high.measured - high.bias - 50.0).abs() < 0.4, "{high:?}");
    }

    #[test]
    fn nothing_one_place_and_no_noise() {
        for found in of(&[5.0], &[[1.0, 1.0]], 0.0) {
            let [least, most] = found.interval(0.95);
            assert_eq!(
                ([least, most], found.u, found.bias),
                ([found.measured.max(0.0), found.measured], 0.0, 0.0)
            );
        }
        let heights: Vec<f64> = (0..400).map(|i| f64::from(i * 7 % 400)).collect();
        let [_, _, range] = of(&heights, &lattice(), 0.0);
        assert_eq!((range.interval(0.95), range.u, range.bias), ([399.0, 399.0], 0.0, 0.0));
    }

    /// The median of the largest of m normal numbers is at Φ⁻¹(½^(1/m)): 3.198 of a thousand.
    #[test]
    fn the_largest_of_many_normal_numbers() {
        close(largest_of(1000.0, 0.5), 3.198, 1e-3);
        close(largest_of(1.0, 0.975), 1.959_964, 1e-5);
        for count in [1.0, 30.0, 1e6] {
            for share in [1e-9, 0.2, 0.7, 0.999, 1.0 - 1e-12] {
                let value = largest_of(count, share);
                assert!(may_exceed(count, share, value - 1e-5), "{count} {share}");
            }
        }
        assert!(!may_exceed(1.0, 0.5, 3.0));
    }
}
