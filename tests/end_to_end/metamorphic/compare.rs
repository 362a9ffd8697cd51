//! Two reports held against each other by the laws.

use serde_json::{Map, Value};

use super::laws::{Change, Turn, power_of_length};

/// Every number of `after` that is not what the change makes of `before`: place, expected, found.
pub(super) fn differences(before: &Value, after: &Value, change: &Change) -> Vec<String> {
    let mut comparison = Comparison { change, wrong: Vec::new() };
    comparison.node(&[], None, before, after);
    comparison.wrong
}

struct Comparison<'a> {
    change: &'a Change,
    wrong: Vec<String>,
}

/// Keys from the root to a value; entries of lists are `*`.
type Path<'a> = [&'a str];

impl Comparison<'_> {
    /// `unit` is what stands beside the value, or beside what holds it.
    fn node(&mut self, path: &Path<'_>, unit: Option<&str>, before: &Value, after: &Value) {
        if listed(UNHELD, path) || (self.change.turn != Turn::Not && listed(UNHELD_TURNED, path)) {
            return;
        }
        match (before, after) {
            (Value::Object(had), Value::Object(has)) => self.object(path, unit, had, has),
            (Value::Array(had), Value::Array(has)) => self.array(path, unit, had, has),
            (Value::String(had), Value::String(has)) => {
                if without_numbers(had) != without_numbers(has) {
                    self.report(path, had, has);
                }
            }
            (Value::Number(had), Value::Number(has)) => {
                self.number(path, unit, had.as_f64().unwrap(), has.as_f64().unwrap());
            }
            _ if before == after => {}
            _ => self.report(path, before, after),
        }
    }

    fn object(
        &mut self,
        path: &Path<'_>,
        unit: Option<&str>,
        had: &Map<String, Value>,
        has: &Map<String, Value>,
    ) {
        match path.last() {
            Some(&"pose") => return self.pose(path, had, has),
            Some(&"parameters") => return self.parameters(path, had, has),
            _ => {}
        }
        // The name of a limit ends with its unit.
        let of_limit = had.get("limit").and(had.get("name")).and_then(Value::as_str);
        let own = had.get("unit").and_then(Value::as_str);
        let unit = own.or(of_limit.and_then(|name| name.rsplit('_').next())).or(unit);
        for key in has.keys().filter(|key| !had.contains_key(*key)) {
            self.report(&[path, &[key]].concat(), &"absent", &has[key]);
        }
        for (key, value) in had {
            let path = [path, &[key.as_str()]].concat();
            let holds = OF_THE_UNIT.contains(&key.as_str()) || value.is_object();
            match has.get(key) {
                Some(has) => self.node(&path, unit.filter(|_| holds), value, has),
                None => self.report(&path, value, &"absent"),
            }
        }
    }

    fn array(&mut self, path: &Path<'_>, unit: Option<&str>, had: &[Value], has: &[Value]) {
        if had.len() != has.len() {
            return self.report(path, &had.len(), &has.len());
        }
        if let (Some(had), Some(has)) = (vector(had), vector(has))
            && path.last().is_some_and(|key| PLACES.contains(key))
        {
            return self.place(path, had, has);
        }
        if path == ["form", "zernike", "terms"] {
            return self.zernike(path, had, has);
        }
        // Numbers of a list have the unit of its key.
        let within = match had.first() {
            Some(Value::Number(_)) => path.to_vec(),
            _ => [path, &["*"]].concat(),
        };
        for (had, has) in had.iter().zip(has) {
            self.node(&within, unit.filter(|_| had.is_number()), had, has);
        }
    }

    fn place(&mut self, path: &Path<'_>, had: [f64; 3], has: [f64; 3]) {
        // Places under `form` are of the part frame, which moves with the part; its origin is of the measured frame.
        let expected = if path[0] == "form" && path[1] != "origin" {
            self.change.direction(had).map(|mm| mm * self.change.scale)
        } else {
            self.change.place_mm(had)
        };
        for axis in 0..3 {
            self.held(path, 1, expected[axis], has[axis]);
        }
    }

    /// Pose of a part that lies nearly along the axes: turns are small.
    fn pose(&mut self, path: &Path<'_>, had: &Map<String, Value>, has: &Map<String, Value>) {
        let three = |map: &Map<String, Value>, keys: [&str; 3]| {
            keys.map(|key| map.get(key).and_then(Value::as_f64).unwrap_or(0.0))
        };
        let shifts = ["tx_mm", "ty_mm", "tz_mm"];
        let turns = ["rx_rad", "ry_rad", "rz_rad"];
        let (shift, turn) =
            (self.change.place_mm(three(had, shifts)), self.change.rotation(three(had, turns)));
        for axis in 0..3 {
            self.held(&[path, &[shifts[axis]]].concat(), 1, shift[axis], three(has, shifts)[axis]);
            self.held(&[path, &[turns[axis]]].concat(), 0, turn[axis], three(has, turns)[axis]);
        }
    }

    /// Estimates: values of the pose stand in `pose`; uncertainties change places when x becomes y.
    fn parameters(&mut self, path: &Path<'_>, had: &Map<String, Value>, has: &Map<String, Value>) {
        for (name, had) in had {
            let other = match (self.change.turn, name.as_str()) {
                (Turn::Quarter, "tx") => "ty",
                (Turn::Quarter, "ty") => "tx",
                (Turn::Quarter, "rx") => "ry",
                (Turn::Quarter, "ry") => "rx",
                (_, name) => name,
            };
            let path = [path, &[name.as_str()]].concat();
            let Some(has) = has.get(other) else {
                self.report(&path, &"present", &"absent");
                continue;
            };
            let (Value::Object(mut had), Value::Object(mut has)) = (had.clone(), has.clone())
            else {
                continue;
            };
            if ["tx", "ty", "tz", "rx", "ry", "rz"].contains(&name.as_str()) {
                had.remove("value");
                has.remove("value");
            }
            self.object(&path, None, &had, &has);
        }
    }

    /// Terms in cos mφ (m > 0) and sin mφ (m < 0) mix when the part is turned.
    fn zernike(&mut self, path: &Path<'_>, had: &[Value], has: &[Value]) {
        let key =
            |term: &Value| (term["n"].as_i64().unwrap() as i32, term["m"].as_i64().unwrap() as i32);
        let value = |terms: &[Value], wanted: (i32, i32)| {
            terms
                .iter()
                .find(|term| key(term) == wanted)
                .map(|term| term["value_nm"].as_f64().unwrap())
        };
        for term in had {
            let (n, m) = key(term);
            let pair = [m.abs(), -m.abs()].map(|m| value(had, (n, m)).unwrap_or(0.0));
            let expected = match m {
                0 => pair[0],
                1.. => self.change.zernike(m, pair)[0],
                _ => self.change.zernike(-m, pair)[1],
            };
            let path = [path, &[term["name"].as_str().unwrap_or("?")]].concat();
            match value(has, (n, m)) {
                Some(has) => self.held(&path, 1, expected * self.change.scale, has),
                None => self.report(&path, &expected, &"absent"),
            }
        }
    }

    fn number(&mut self, path: &Path<'_>, unit: Option<&str>, had: f64, has: f64) {
        let key = path.iter().rev().find(|key| **key != "*").copied().unwrap_or_default();
        if key == "orientation_deg" {
            return self.held(path, 0, self.change.orientation_deg(had), has);
        }
        let Some(power) = power_of_length(key, unit) else {
            return self.wrong.push(format!("{}: no law for this number", joined(path)));
        };
        self.held(path, power, had * self.change.scale.powi(power), has);
    }

    /// Holds a number to what is expected of it, within rounding or the share its figure is known to.
    fn held(&mut self, path: &Path<'_>, power: i32, expected: f64, found: f64) {
        let share = share(path, self.change);
        let key = path.iter().rev().find(|key| **key != "*").copied().unwrap_or_default();
        let smallest = match key {
            _ if key.ends_with("_nm") || key == "value" => 1.0,
            // A place is as good as the fit's, of a part of some millimetres.
            _ if PLACES.contains(&key) => 0.1,
            _ => 1e-3,
        };
        let scale = self.change.scale.powi(power);
        if (found - expected).abs() > share * expected.abs().max(smallest * scale) {
            self.report(path, &expected, &found);
        }
    }

    fn report(
        &mut self,
        path: &Path<'_>,
        expected: &dyn std::fmt::Debug,
        found: &dyn std::fmt::Debug,
    ) {
        self.wrong.push(format!("{}: expected {expected:?}, found {found:?}", joined(path)));
    }
}

/// The share of itself within which a number must be as expected.
fn share(path: &Path<'_>, change: &Change) -> f64 {
    let lists: &[&[(&str, f64)]] = match (change.turn, change.shuffled) {
        (Turn::Not, false) => &[BY_DIFFERENCES],
        (Turn::Not, true) => &[BY_DIFFERENCES, BY_DRAWS],
        _ => &[BY_DIFFERENCES, BY_CELLS, BY_DRAWS],
    };
    lists
        .iter()
        .flat_map(|list| list.iter())
        .find(|(pattern, _)| matches(pattern, path))
        .map_or(ROUNDING, |(_, share)| *share)
}

fn listed(patterns: &[&str], path: &Path<'_>) -> bool {
    patterns.iter().any(|pattern| matches(pattern, path))
}

/// Whether a pattern like `form/*/u` is the path or its beginning; `*` stands for any one key.
fn matches(pattern: &str, path: &Path<'_>) -> bool {
    let mut keys = path.iter();
    pattern.split('/').all(|wanted| keys.next().is_some_and(|key| wanted == "*" || wanted == *key))
}

fn joined(path: &Path<'_>) -> String {
    path.join("/")
}

/// A text with every number in it replaced, so that only words are compared.
fn without_numbers(text: &str) -> String {
    let mut words = String::new();
    let mut in_number = false;
    for letter in text.chars() {
        let digit = letter.is_ascii_digit() || (in_number && ".e-+".contains(letter));
        if !digit {
            words.push(letter);
        } else if !in_number {
            words.push('#');
        }
        in_number = digit;
    }
    words
}

/// A list of two or three numbers; the third of two is 0.
fn vector(values: &[Value]) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = values.iter().map(Value::as_f64).collect();
    match numbers?[..] {
        [x, y] => Some([x, y, 0.0]),
        [x, y, z] => Some([x, y, z]),
        _ => None,
    }
}

/// Largest share that rounding of coordinates may change.
const ROUNDING: f64 = 2e-6;

/// Keys of a value whose unit stands beside it.
const OF_THE_UNIT: &[&str] = &[
    "value",
    "limit",
    "u",
    "guard_band",
    "interval_95",
    "hidden",
    "low",
    "high",
    "bias",
    "noise_adds",
    "without_noise",
    "expanded_95",
    "u_by_form",
];

/// Keys of places.
const PLACES: &[&str] = &[
    "at_mm",
    "at_max_mm",
    "at_min_mm",
    "min_mm",
    "max_mm",
    "origin_mm",
    "outline_mm",
    "steepest_at_mm",
    "hollow_at_mm",
];

/// Not held by any change, and why.
const UNHELD: &[&str] = &[
    "timing",
    // Steps to an end that is held.
    "form/fit/iterations",
    "form/fit/evaluations",
    "form/minimum_zone/passes",
    "points/tip/passes",
    "points/tip/last_move_nm",
    // A sphere is as hollow everywhere.
    "points/tip/hollow_at_mm",
    // Bins of round widths.
    "form/histogram",
    // The square of u, which is held; of correlations the shares of the weakest combination tell.
    "form/fit/covariance",
    // A ratio of lengths and angles.
    "form/fit/condition",
    "form/fit/weakest",
    "form/fit/undetermined",
    // A likelihood that is flat along sigma and length together.
    "form/fit/correlation",
    // Formed in cells of the plane of a surface's own, some dozens over the part.
    "partition/shares",
    "partition/regions",
];

/// Not held where the part is turned or mirrored, and why.
const UNHELD_TURNED: &[&str] = &[
    // The sides of the raster of the map, x first.
    "form/psd/spacing_mm",
    // Of scattered points from a map made anew, whose nodes lie about the corner of the points.
    "form/psd",
    // What scattered places do is counted over strata that are cut along the axes.
    "form/figures/*/u",
    "form/fit/parameters/*/u",
    "form/fit/parameters/*/u_by_form",
    "form/fit/parameters/*/expanded_95",
    "form/deviation/uncertainty",
    "verdict/checks/*/u",
    "verdict/checks/*/interval_95",
];

/// Differences of figures of two fits: the share they are known to.
const BY_DIFFERENCES: &[(&str, f64)] = &[
    ("form/deviation/systematic", 1e-3),
    ("points/tip/u_pv_nm", 1e-3),
    ("points/tip/u_rms_nm", 1e-3),
    ("points/tip/neglected_nm", 1e-5),
];

/// Figures by draws, whose random numbers go by the order of the points: the share they are known to.
const BY_DRAWS: &[(&str, f64)] = &[
    ("form/figures/*/u", 0.15),
    ("form/minimum_zone/width/simulated", 0.1),
    ("form/deviation/uncertainty", 0.02),
    // Of scattered points: sums in order of the points; where the response falls below one half.
    ("form/psd/up_to_per_mm", 5e-3),
    ("form/psd", 1e-3),
    // Scatter of the points about a defect, in order.
    ("defects", 1e-3),
    ("verdict/checks/*/u", 0.15),
    ("verdict/checks/*/interval_95", 0.15),
];

/// Figures formed in cells or windows along the axes: the share they are known to.
const BY_CELLS: &[(&str, f64)] = &[
    ("sampling/noise_sigma_nm", 0.02),
    ("sampling/noise_u_nm", 0.05),
    ("sampling/spacing_recommended_mm", 0.02),
    ("sampling/spacing_finest_mm", 0.02),
    // Pixels of the ACF lie along the axes, and so do windows of the filters.
    ("form/texture/figures/*/simulated/bias", 0.2),
    ("form/texture/figures", 0.05),
    ("form/deviation/unmeasured", 0.05),
    ("verdict/checks/*/hidden", 0.05),
    ("defects", 0.04),
    // Of coarse rasters it holds form that the windows of the search do not follow, and these lie along the axes: over
    // twelve seeds of the sphere, turned over not, 0.95 to 1.23.
    ("defects_search", 0.25),
];
