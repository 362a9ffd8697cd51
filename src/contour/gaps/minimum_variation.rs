//! The curve of least variation of curvature between two places 1 apart on the x axis.

/// A curve from (0, 0) to (1, 0).
pub(super) struct Course {
    /// Places evenly along it.
    pub(super) places: Vec<[f64; 2]>,
    pub(super) length: f64,
    pub(super) energy: f64,
}

/// The curve with given angles to the x axis at its ends, in radians from -π to π; none if none was found.
///
/// With t from 0 to 1 along the curve, its length times its curvature is k(t) = Σ aⱼ·Pⱼ(2t - 1), Pⱼ Legendre's polynomials. Then its angle is the
/// first angle and ∫k, and
///
/// E = ∫k'² dt / c²,   c = ∫cos θ dt,   0 = ∫sin θ dt
///
/// as the length is 1/c. a₀ is the difference of the angles. The others are found by Newton's method for the least E under the last equation, from
/// the clothoid, where all but a₁ are 0.
pub(super) fn course(angles: [f64; 2]) -> Option<Course> {
    let table = Table::new();
    let mut terms = [0.0; TERMS];
    terms[0] = angles[1] - angles[0];
    terms[1] = clothoid(&table, angles[0], terms[0])?;
    let mut state = State::new(&table, angles[0], &terms);
    // At the clothoid the multiplier that leaves least of the gradient.
    let mut multiplier = state.multiplier();
    let mut residual = state.residual(multiplier);
    for _ in 0..MOST_STEPS {
        if residual < 1e-13 {
            break;
        }
        let Some(step) = state.step(&table, multiplier) else { break };
        let mut share = 1.0;
        let accepted = loop {
            let mut next = terms;
            for (term, step) in next[1..].iter_mut().zip(&step) {
                *term += share * step;
            }
            let tried = State::new(&table, angles[0], &next);
            let at = multiplier + share * (step[TERMS - 1] - multiplier);
            let left = tried.residual(at);
            if tried.cosine > 0.0 && left < residual {
                break Some((next, tried, at, left));
            }
            share *= 0.5;
            if share < 1e-4 {
                break None;
            }
        };
        let Some((next, tried, at, left)) = accepted else { break };
        (terms, state, multiplier, residual) = (next, tried, at, left);
    }
    let energy = state.energy / (state.cosine * state.cosine);
    (state.sine.abs() < 1e-9 * state.cosine).then(|| Course {
        places: places(&terms, angles[0], state.cosine),
        length: 1.0 / state.cosine,
        energy,
    })
}

/// The second coefficient of the clothoid that comes back to the x axis: that of least size.
fn clothoid(table: &Table, first: f64, turn: f64) -> Option<f64> {
    let at = |bend: f64| {
        let mut terms = [0.0; TERMS];
        (terms[0], terms[1]) = (turn, bend);
        let state = State::new(table, first, &terms);
        (state.sine, state.cosine)
    };
    if at(0.0).0.abs() < 1e-15 && at(0.0).1 > 0.0 {
        return Some(0.0);
    }
    for step in 0..200 {
        for sign in [1.0, -1.0] {
            let [low, high] = [step, step + 1].map(|step| sign * 0.25 * f64::from(step));
            let (mut low, mut high) = (low, high);
            let begins_above = at(low).0 > 0.0;
            if (at(high).0 > 0.0) == begins_above {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let is_above = at(middle).0 > 0.0;
                *(if is_above == begins_above { &mut low } else { &mut high }) = middle;
            }
            if at(low).1 > 0.0 {
                return Some(low);
            }
        }
    }
    None
}

/// Values of the polynomials where integrals are summed.
struct Table {
    /// Weights of Gauss and Legendre's rule on pieces of 0 to 1.
    weights: Vec<f64>,
    /// The integral of each polynomial from 0 to each place.
    integrals: Vec<[f64; TERMS]>,
}

impl Table {
    fn new() -> Table {
        let mut table = Table { weights: Vec::new(), integrals: Vec::new() };
        for piece in 0..PIECES {
            for (at, weight) in RULE {
                for sign in [-1.0, 1.0] {
                    let t = (f64::from(piece) + 0.5 + 0.5 * sign * at) / f64::from(PIECES);
                    table.weights.push(0.5 * weight / f64::from(PIECES));
                    table.integrals.push(integrals(t));
                }
            }
        }
        table
    }
}

/// The integrals of Pⱼ(2t - 1) from 0 to t.
fn integrals(t: f64) -> [f64; TERMS] {
    let x = 2.0 * t - 1.0;
    let mut legendre = [1.0; TERMS + 1];
    legendre[1] = x;
    for j in 1..TERMS {
        let n = j as f64;
        legendre[j + 1] = ((2.0 * n + 1.0) * x * legendre[j] - n * legendre[j - 1]) / (n + 1.0);
    }
    let mut found = [t; TERMS];
    for j in 1..TERMS {
        found[j] = (legendre[j + 1] - legendre[j - 1]) / (2.0 * (2.0 * j as f64 + 1.0));
    }
    found
}

/// ∫Pᵢ'Pⱼ' dt for t from 0 to 1: 2·m·(m + 1), m the smaller, if i + j is even, else 0.
fn stiffness(i: usize, j: usize) -> f64 {
    let least = i.min(j) as f64;
    if (i + j).is_multiple_of(2) { 2.0 * least * (least + 1.0) } else { 0.0 }
}

/// Integrals and their derivatives by the terms from a₁ on.
struct State {
    energy: f64,
    sine: f64,
    cosine: f64,
    of_energy: [f64; FREE],
    of_sine: [f64; FREE],
    of_cosine: [f64; FREE],
    angles: Vec<[f64; 2]>,
}

impl State {
    fn new(table: &Table, first: f64, terms: &[f64; TERMS]) -> State {
        let mut state = State {
            energy: 0.0,
            sine: 0.0,
            cosine: 0.0,
            of_energy: [0.0; FREE],
            of_sine: [0.0; FREE],
            of_cosine: [0.0; FREE],
            angles: Vec::new(),
        };
        for i in 0..FREE {
            for j in 0..FREE {
                let product = stiffness(i + 1, j + 1) * terms[j + 1];
                state.of_energy[i] += 2.0 * product;
                state.energy += terms[i + 1] * product;
            }
        }
        for (weight, integrals) in table.weights.iter().zip(&table.integrals) {
            let angle: f64 = integrals.iter().zip(terms).map(|(value, term)| value * term).sum();
            let (sin, cos) = (first + angle).sin_cos();
            state.sine += weight * sin;
            state.cosine += weight * cos;
            for j in 0..FREE {
                state.of_sine[j] += weight * cos * integrals[j + 1];
                state.of_cosine[j] -= weight * sin * integrals[j + 1];
            }
            state.angles.push([sin, cos]);
        }
        state
    }

    /// Derivative of E by a term.
    fn gradient(&self, j: usize) -> f64 {
        let c = self.cosine;
        self.of_energy[j] / (c * c) - 2.0 * self.energy * self.of_cosine[j] / (c * c * c)
    }

    fn multiplier(&self) -> f64 {
        let dot =
            |of: &dyn Fn(usize) -> f64| -> f64 { (0..FREE).map(|j| of(j) * self.of_sine[j]).sum() };
        let bottom = dot(&|j| self.of_sine[j]);
        if bottom > 0.0 { -dot(&|j| self.gradient(j)) / bottom } else { 0.0 }
    }

    /// How far the equations of the least E are from being met.
    fn residual(&self, multiplier: f64) -> f64 {
        let squares = (0..FREE)
            .map(|j| (self.gradient(j) + multiplier * self.of_sine[j]).powi(2))
            .sum::<f64>();
        (squares + self.sine * self.sine).sqrt()
    }

    /// Newton's step of the terms, and the new multiplier.
    fn step(&self, table: &Table, multiplier: f64) -> Option<[f64; TERMS]> {
        let c = self.cosine;
        let mut rows = [[0.0; TERMS + 1]; TERMS];
        for i in 0..FREE {
            for j in 0..FREE {
                let [mut ss, mut cc] = [0.0, 0.0];
                for ((weight, q), [sin, cos]) in
                    table.weights.iter().zip(&table.integrals).zip(&self.angles)
                {
                    let product = weight * q[i + 1] * q[j + 1];
                    ss -= sin * product;
                    cc -= cos * product;
                }
                let crossed =
                    self.of_energy[i] * self.of_cosine[j] + self.of_energy[j] * self.of_cosine[i];
                rows[i][j] = 2.0 * stiffness(i + 1, j + 1) / (c * c) - 2.0 * crossed / (c * c * c)
                    + 6.0 * self.energy * self.of_cosine[i] * self.of_cosine[j] / c.powi(4)
                    - 2.0 * self.energy * cc / (c * c * c)
                    + multiplier * ss;
            }
            rows[i][FREE] = self.of_sine[i];
            rows[FREE][i] = self.of_sine[i];
            rows[i][TERMS] = -self.gradient(i);
        }
        rows[FREE][TERMS] = -self.sine;
        solved(rows)
    }
}

/// The solution of linear equations by elimination with pivots; none if they are dependent.
fn solved(mut rows: [[f64; TERMS + 1]; TERMS]) -> Option<[f64; TERMS]> {
    for column in 0..TERMS {
        let pivot = (column..TERMS).fold(column, |best, row| {
            if rows[row][column].abs() > rows[best][column].abs() { row } else { best }
        });
        rows.swap(column, pivot);
        let lead = rows[column];
        if lead[column] == 0.0 {
            return None;
        }
        for row in rows.iter_mut().skip(column + 1) {
            let share = row[column] / lead[column];
            for (value, lead) in row.iter_mut().zip(lead).skip(column) {
                *value -= share * lead;
            }
        }
    }
    let mut found = [0.0; TERMS];
    for row in (0..TERMS).rev() {
        let sum: f64 = (row + 1..TERMS).map(|column| rows[row][column] * found[column]).sum();
        found[row] = (rows[row][TERMS] - sum) / rows[row][row];
    }
    found.iter().all(|value| value.is_finite()).then_some(found)
}

/// Places evenly along the curve: the integral of its direction, piece by piece.
fn places(terms: &[f64; TERMS], first: f64, cosine: f64) -> Vec<[f64; 2]> {
    let mut at = [0.0; 2];
    let mut places = vec![at];
    for piece in 0..PLACES {
        for (offset, weight) in RULE {
            for sign in [-1.0, 1.0] {
                let t = (f64::from(piece) + 0.5 + 0.5 * sign * offset) / f64::from(PLACES);
                let integrals = integrals(t);
                let angle: f64 =
                    integrals.iter().zip(terms).map(|(value, term)| value * term).sum();
                let (sin, cos) = (first + angle).sin_cos();
                let weight = 0.5 * weight / f64::from(PLACES) / cosine;
                at = [at[0] + weight * cos, at[1] + weight * sin];
            }
        }
        places.push(at);
    }
    places
}

/// Terms of the curvature.
const TERMS: usize = 11;
/// Terms but the first, which the angles give.
const FREE: usize = TERMS - 1;
/// Pieces of the sums.
const PIECES: u32 = 16;
/// Pieces of the curve that is given back.
const PLACES: u32 = 64;
const MOST_STEPS: usize = 60;
/// Gauss and Legendre's rule of four places from -1 to 1 (M. Abramowitz, I. A. Stegun 1964, table 25.4): two of them, each with its mirror.
const RULE: [(f64, f64); 2] = [
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];
