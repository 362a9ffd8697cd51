//! Sums over the samples of a cell, from one visit to each, and the plane through those of nine cells.

/// What the samples of a cell add up to. Places count from the middle of the cell, in its sides.
#[derive(Clone, Copy)]
pub(super) struct Tally {
    pub(super) count: u32,
    pub(super) sum: f64,
    pub(super) squares: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Sums of the places.
    places: [f64; 2],
    /// Sums of the products of places: along x, mixed, along y.
    spread: [f64; 3],
    /// Sums of places by heights.
    products: [f64; 2],
}

impl Tally {
    pub(super) const EMPTY: Tally = Tally {
        count: 0,
        sum: 0.0,
        squares: 0.0,
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
        places: [0.0; 2],
        spread: [0.0; 3],
        products: [0.0; 2],
    };

    pub(super) fn add(&mut self, [x, y]: [f64; 2], height: f64) {
        self.count += 1;
        self.sum += height;
        self.squares += height * height;
        self.low = self.low.min(height);
        self.high = self.high.max(height);
        self.places = [self.places[0] + x, self.places[1] + y];
        let [xx, xy, yy] = self.spread;
        self.spread = [xx + x * x, xy + x * y, yy + y * y];
        self.products = [self.products[0] + x * height, self.products[1] + y * height];
    }

    /// Adds the samples of a cell that lies so many cells away.
    fn add_moved(&mut self, of: &Tally, [dx, dy]: [f64; 2]) {
        let count = f64::from(of.count);
        let [x, y] = of.places;
        let [xx, xy, yy] = of.spread;
        self.count += of.count;
        self.sum += of.sum;
        self.places = [self.places[0] + x + count * dx, self.places[1] + y + count * dy];
        self.spread[0] += xx + 2.0 * dx * x + count * dx * dx;
        self.spread[1] += xy + dx * y + dy * x + count * dx * dy;
        self.spread[2] += yy + 2.0 * dy * y + count * dy * dy;
        self.products[0] += of.products[0] + dx * of.sum;
        self.products[1] += of.products[1] + dy * of.sum;
    }

    /// The middle of the places; of one sample at least.
    pub(super) fn middle(&self) -> [f64; 2] {
        self.places.map(|sum| sum / f64::from(self.count))
    }

    /// Sums of products of places about their middle, and of these places by heights.
    fn centred(&self) -> ([f64; 3], [f64; 2]) {
        let [[x, y], [mx, my]] = [self.places, self.middle()];
        let [xx, xy, yy] = self.spread;
        let spread = [xx - mx * x, xy - mx * y, yy - my * y];
        (spread, [self.products[0] - mx * self.sum, self.products[1] - my * self.sum])
    }

    /// The sum of the squares of the heights about a plane that has a level at the middle of the places.
    pub(super) fn squares_about(&self, level: f64, [p, q]: [f64; 2]) -> f64 {
        let ([xx, xy, yy], [xz, yz]) = self.centred();
        let about_level =
            self.squares - 2.0 * level * self.sum + level * level * f64::from(self.count);
        let by_slope = p * (p * xx + 2.0 * (q * xy - xz)) + q * (q * yy - 2.0 * yz);
        (about_level + by_slope).max(0.0)
    }
}

/// Slope of the form in a cell, over its side: that of the plane of least squares through its samples and those of the
/// cells about it. Zero where these do not span one.
pub(super) fn slope(size: [usize; 2], tallies: &[Tally], slot: usize) -> [f64; 2] {
    let at = [slot % size[0], slot / size[0]];
    let about = |axis: usize| at[axis].saturating_sub(1)..(at[axis] + 2).min(size[axis]);
    let mut all = Tally::EMPTY;
    for row in about(1) {
        for column in about(0) {
            let away = [column as f64 - at[0] as f64, row as f64 - at[1] as f64];
            all.add_moved(&tallies[row * size[0] + column], away);
        }
    }
    if all.count == 0 {
        return [0.0; 2];
    }
    let ([xx, xy, yy], [xz, yz]) = all.centred();
    let determinant = xx * yy - xy * xy;
    let spans_a_plane = determinant > SPANNED * (xx + yy) * (xx + yy);
    if !spans_a_plane {
        return [0.0; 2];
    }
    [(yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant]
}

/// Samples nearer to one line than this, in squares of its length, span no plane.
const SPANNED: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve cells of a side of 1 in three rows, with five samples each of a function of the place.
    fn tallies(height: impl Fn(f64, f64) -> f64) -> Vec<Tally> {
        let mut random = crate::curvature::truth::Random::new(8);
        let cells = (0..12).map(|slot| {
            let mut tally = Tally::EMPTY;
            for _ in 0..5 {
                let [x, y] = [random.unit() - 0.5, random.unit() - 0.5];
                tally.add([x, y], height(f64::from(slot % 4) + x, f64::from(slot / 4) + y));
            }
            tally
        });
        cells.collect()
    }

    #[test]
    fn a_plane_is_left_without_remainder() {
        let tallies = tallies(|x, y| 3.0 + 0.7 * x - 0.2 * y);
        for (slot, tally) in tallies.iter().enumerate() {
            let [p, q] = slope([4, 3], &tallies, slot);
            assert!((p - 0.7).abs() < 1e-12 && (q + 0.2).abs() < 1e-12, "{p} {q}");
            let left = tally.squares_about(tally.sum / 5.0, [p, q]);
            assert!(left < 1e-12, "{left}");
        }
    }

    #[test]
    fn squares_about_any_plane_are_those_of_the_samples() {
        let samples = [[-0.3, 0.2, 1.0], [0.4, -0.1, 2.5], [0.1, 0.45, -0.5]];
        let mut tally = Tally::EMPTY;
        samples.iter().for_each(|&[x, y, z]| tally.add([x, y], z));
        let [mx, my] = tally.middle();
        let truth: f64 = samples
            .iter()
            .map(|[x, y, z]| (z - 0.3 - 2.0 * (x - mx) + 1.5 * (y - my)).powi(2))
            .sum();
        assert!((tally.squares_about(0.3, [2.0, -1.5]) - truth).abs() < 1e-12);
    }

    #[test]
    fn nothing_and_a_line_have_no_slope() {
        assert_eq!(slope([1, 1], &[Tally::EMPTY], 0), [0.0; 2]);
        let mut line = Tally::EMPTY;
        (0..5).for_each(|at| line.add([0.1 * f64::from(at), 0.2], f64::from(at)));
        assert_eq!(slope([1, 1], &[line], 0), [0.0; 2]);
    }
}
