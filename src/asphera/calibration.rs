//! Files of calibrations: what a machine's errors are, since when, and for how long.

mod correlated;

use std::fmt::Write as _;
use std::str::FromStr as _;

use asphera_calibrate::{Artefact, Calibration, Correction, HeightMap, Machine, Parameter, Term};
use asphera_form::NM_PER_MM;
use asphera_report::CalibrationFigures;
use asphera_settings::{File, Problems, Section};
use jiff::{SignedDuration, Timestamp};

pub use correlated::Uncertainties;

/// First key of every such file.
const FORMAT: &str = "asphera.calibration/1";

/// Longest validity: a hundred years.
pub const LONGEST_DAYS: u32 = 36_525;

/// A calibration as its file tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFile {
    made: Timestamp,
    valid_days: u32,
    correction: Correction,
    /// Of the parameters that it holds.
    u: Uncertainties,
    /// Terms of the map of heights with their standard uncertainties for values.
    u_heights: Vec<HeightMap>,
}

impl CalibrationFile {
    /// Reads a file; `name` stands in every problem.
    ///
    /// # Errors
    ///
    /// Every problem at once.
    pub fn parse(name: &str, text: &str) -> Result<CalibrationFile, Problems> {
        let file = File::parse(name, text)?;
        let root = file.root();
        let read = read(&root);
        root.finish();
        drop(root);
        file.conclude(read)
    }

    /// What takes the machine's errors out of its points.
    pub fn correction(&self) -> &Correction {
        &self.correction
    }

    /// Standard uncertainties of its parameters, with their correlations where it states these.
    pub fn uncertainties(&self) -> &Uncertainties {
        &self.u
    }

    /// Errors of height, mm, of one standard uncertainty of each term of its map; none without a map.
    pub fn height_uncertainties(&self) -> &[HeightMap] {
        &self.u_heights
    }

    /// Until when it may be used.
    fn valid_until(&self) -> Timestamp {
        let days = SignedDuration::from_hours(24 * i64::from(self.valid_days));
        self.made.checked_add(days).unwrap_or(Timestamp::MAX)
    }

    /// Why it cannot be used at a time of the wall clock, in ns since 1970; `None` if it can.
    pub fn refusal(&self, wall_ns: i64) -> Option<String> {
        let now = Timestamp::from_nanosecond(wall_ns.into()).unwrap_or(Timestamp::MAX);
        if now > self.valid_until() {
            return Some(format!(
                "the calibration of {} was valid for {} days, until {}: measure the artefact again with `asphera calibrate`",
                self.made,
                self.valid_days,
                self.valid_until()
            ));
        }
        // A clock that is set by hand may be off by so much.
        let soon = now.checked_add(SignedDuration::from_hours(24)).unwrap_or(Timestamp::MAX);
        (self.made > soon).then(|| {
            format!(
                "the calibration was made at {}, and this host's clock says {now}: set the clock",
                self.made
            )
        })
    }

    /// What reports say of it.
    pub fn figures(&self) -> CalibrationFigures {
        CalibrationFigures {
            date: self.made.to_string(),
            valid_until: self.valid_until().to_string(),
            machine: self.correction.machine().word().to_owned(),
        }
    }
}

fn read(root: &Section<'_>) -> Option<CalibrationFile> {
    root.required_word("format", &[(FORMAT, ())])?;
    let made: String = root.required("made")?;
    let made = Timestamp::from_str(&made)
        .inspect_err(|_| {
            root.problem("made", "a time like 2026-11-26T08:00:00Z", format!("{made:?}"));
        })
        .ok();
    let valid_days = root.within("valid_days", 90, 1..=LONGEST_DAYS);
    let words = [Machine::Cartesian, Machine::Polar].map(|machine| (machine.word(), machine));
    let machine = root.required_word("machine", &words)?;
    // What was measured, and how well; a person reads that.
    let _ = (root.has("artefact"), root.has("residuals"));
    let parameters = root.section("parameters");
    let (mut values, mut uncertainties) = (Vec::new(), Vec::new());
    for parameter in machine.parameters() {
        let section = parameters.section(parameter.word());
        if section.is_present() {
            let quantity = parameter.quantity();
            let suffix = quantity.suffix();
            let value: Option<f64> = section.required(&format!("value_{suffix}"));
            let u = uncertainty(&section, &format!("u_{suffix}"));
            section.finish();
            values.push((*parameter, value? / quantity.units()));
            uncertainties.push((*parameter, u? / quantity.units()));
        }
    }
    parameters.finish();
    let u = correlated(root, machine, Uncertainties::new(uncertainties));
    let map = root.section("map");
    let found = if map.is_present() { Some(heights(&map)?) } else { None };
    let (heights, u_heights) = found.map_or((None, Vec::new()), |(map, u)| (Some(map), u));
    let correction = Correction::new(machine, values, heights);
    if correction.is_none() {
        root.problem("parameters", "finite values", "another");
    }
    Some(CalibrationFile { made: made?, valid_days, correction: correction?, u: u?, u_heights })
}

/// Uncertainties with the correlations that a file states; without any they are as they were.
fn correlated(root: &Section<'_>, machine: Machine, own: Uncertainties) -> Option<Uncertainties> {
    let words: Vec<(&str, Parameter)> =
        machine.parameters().iter().map(|parameter| (parameter.word(), *parameter)).collect();
    let mut pairs = Vec::new();
    for section in root.array("correlation") {
        let first = section.required_word("of", &words);
        let second = section.required_word("with", &words);
        let value: Option<f64> = section.required("value");
        section.finish();
        pairs.push((first?, second?, value?));
    }
    if pairs.is_empty() {
        return Some(own);
    }
    let found = own.correlated(&pairs);
    if found.is_none() {
        let expected = "correlations from -1 to 1 of pairs of its parameters, each pair once, that hold together";
        root.problem("correlation", expected, "others");
    }
    found
}

/// A standard uncertainty: finite and not negative.
fn uncertainty(section: &Section<'_>, key: &str) -> Option<f64> {
    let u: f64 = section.required(key)?;
    if u.is_finite() && u >= 0.0 {
        return Some(u);
    }
    section.problem(key, "a standard uncertainty of 0 or more", u);
    None
}

/// The map, and each of its terms with its standard uncertainty for a value.
fn heights(map: &Section<'_>) -> Option<(HeightMap, Vec<HeightMap>)> {
    let radius_mm: Option<f64> = map.required("radius_mm");
    let (mut terms, mut uncertain) = (Vec::new(), Vec::new());
    for term in map.array("term") {
        let (n, m) = (term.required::<u32>("n"), term.required::<i64>("m"));
        let value_nm: Option<f64> = term.required("value_nm");
        let u_nm = uncertainty(&term, "u_nm");
        term.finish();
        let (n, m) = (n?, i32::try_from(m?).ok()?);
        terms.push((n, m, value_nm? / NM_PER_MM));
        uncertain.push((n, m, u_nm? / NM_PER_MM));
    }
    map.finish();
    let heights = HeightMap::new(radius_mm?, terms);
    if heights.is_none() {
        map.problem(
            "term",
            "Zernike orders n and m, each pair once, and a radius above 0",
            "others",
        );
    }
    let radius_mm = radius_mm?;
    let one = |term| HeightMap::new(radius_mm, vec![term]);
    Some((heights?, uncertain.into_iter().filter_map(one).collect()))
}

const NS_PER_S: i64 = 1_000_000_000;

/// The text of a file for a calibration that was made at a time, and what it was made with.
pub fn written(
    found: &Calibration,
    artefact: Artefact,
    made_wall_ns: i64,
    valid_days: u32,
) -> String {
    let made_s = made_wall_ns.div_euclid(NS_PER_S);
    let made = Timestamp::from_second(made_s).unwrap_or(Timestamp::MAX);
    let mut text = format!(
        "# Errors of a measuring machine. `[calibration] file` of a station's configuration names this file.\n\
         format = \"{FORMAT}\"\n\
         # When it was made, and for how many days a station may use it.\n\
         made = \"{made}\"\nvalid_days = {valid_days}\nmachine = \"{}\"\n",
        found.correction.machine().word()
    );
    let artefact = match artefact {
        Artefact::Sphere { radius_mm, u_radius_mm } => format!(
            "kind = \"sphere\"\nradius_mm = {}\nu_radius_nm = {}",
            float(radius_mm),
            float(u_radius_mm * NM_PER_MM)
        ),
        Artefact::Flat => "kind = \"flat\"".to_owned(),
    };
    let _ = writeln!(text, "\n[artefact]\n{artefact}");
    let _ = writeln!(
        text,
        "\n# Root mean squares of the distances from the artefact before and after; by how much correlated ones enlarge variances.\n\
         [residuals]\npoints = {}\nbefore_nm = {}\nafter_nm = {}\ninflation = {}",
        found.points,
        float(found.before_mm * NM_PER_MM),
        float(found.after_mm * NM_PER_MM),
        float(found.inflation)
    );
    let _ = writeln!(
        text,
        "\n# Values are added to points, times what each parameter moves; u is a standard uncertainty."
    );
    let _ = writeln!(text, "[parameters]");
    for estimate in &found.parameters {
        let (suffix, units) =
            (estimate.parameter.quantity().suffix(), estimate.parameter.quantity().units());
        let _ = writeln!(
            text,
            "\n[parameters.{}]\nvalue_{suffix} = {}\nu_{suffix} = {}",
            estimate.parameter.word(),
            float(estimate.value * units),
            float(estimate.u * units)
        );
    }
    text.push_str(&correlations(found));
    for undetermined in &found.undetermined {
        let _ = writeln!(
            text,
            "\n# {} is not determined by these points and counts as 0.",
            undetermined.word()
        );
    }
    if let Some(map) = found.correction.map() {
        text.push_str(&map_text(map.radius_mm(), &found.map));
    }
    text
}

/// Correlations of the parameters, each pair once.
fn correlations(found: &Calibration) -> String {
    let size = found.parameters.len();
    let covariance = |row: usize, column: usize| found.covariance[row * size + column];
    let mut text = String::new();
    for row in 0..size {
        for column in row + 1..size {
            let of_both = (covariance(row, row) * covariance(column, column)).sqrt();
            let value = covariance(row, column) / of_both;
            if value.is_finite() && value != 0.0 {
                let [of, with] = [row, column].map(|at| found.parameters[at].parameter.word());
                let value = float(value.clamp(-1.0, 1.0));
                let _ = writeln!(
                    text,
                    "\n[[correlation]]\nof = \"{of}\"\nwith = \"{with}\"\nvalue = {value}"
                );
            }
        }
    }
    text
}

fn map_text(radius_mm: f64, terms: &[Term]) -> String {
    let mut text = format!(
        "\n# Errors of height, taken off: Zernike terms of unit RMS over a disc about the origin. Points beyond it are flagged.\n\
         [map]\nradius_mm = {}\n",
        float(radius_mm)
    );
    for Term { n, m, value_mm, u_mm } in terms {
        let _ = writeln!(
            text,
            "\n[[map.term]]\nn = {n}\nm = {m}\nvalue_nm = {}\nu_nm = {}",
            float(value_mm * NM_PER_MM),
            float(u_mm * NM_PER_MM)
        );
    }
    text
}

/// A number that TOML reads as a float, to its last digit.
fn float(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_calibrate::{Axes, Pose, Settings, calibrate};

    /// A ball of 10 mm seen from above by a perfect machine.
    fn pose() -> Pose {
        let axes =
            (-8..=8).flat_map(|i| (-8..=8).map(move |j| [0.5 * f64::from(i), 0.5 * f64::from(j)]));
        let axes =
            axes.map(|[x, y]| Axes::Cartesian([x, y, (100.0 - x * x - y * y).sqrt() - 10.0]));
        Pose { axes: axes.collect(), turn_rad: 0.0, shift_mm: [0.0; 2] }
    }

    const DAY_NS: i64 = 86_400_000_000_000;

    fn text(map_order: u32, made_wall_ns: i64) -> (Calibration, String) {
        let artefact = Artefact::Sphere { radius_mm: 10.0, u_radius_mm: 0.0 };
        let parameters = Machine::Cartesian.parameters()[3..].to_vec();
        let settings = Settings { parameters, map_order, form_order: 0 };
        let mut found = calibrate(Machine::Cartesian, artefact, &[pose()], &settings).unwrap();
        // Values that have all their digits.
        let values = found.parameters.iter().map(|one| (one.parameter, 1e-5 / 3.0)).collect();
        found.parameters.iter_mut().for_each(|one| one.value = 1e-5 / 3.0);
        // A perfect ball leaves no uncertainty: some, with correlations that halve from one to the next.
        let size = found.parameters.len();
        for (at, one) in found.parameters.iter_mut().enumerate() {
            one.u = 1e-6 * (at + 1) as f64 / 3.0;
        }
        let covariance = |at: usize| {
            let (row, column) = (at / size, at % size);
            let apart = i32::try_from(row.abs_diff(column)).unwrap();
            found.parameters[row].u * found.parameters[column].u * 0.5_f64.powi(apart)
        };
        found.covariance = (0..size * size).map(covariance).collect();
        let map = found.correction.map().cloned();
        found.correction = Correction::new(Machine::Cartesian, values, map).unwrap();
        let text = written(&found, artefact, made_wall_ns, 30);
        (found, text)
    }

    #[test]
    fn a_file_reads_as_it_was_written() {
        for map_order in [0, 4] {
            let (found, text) = text(map_order, 0);
            let read = CalibrationFile::parse("c.toml", &text).unwrap();
            let at = Axes::Cartesian([1.0, -2.0, 3.0]);
            let [expected, corrected] = [&found.correction, read.correction()]
                .map(|correction| correction.apply(at).unwrap());
            assert!(expected != [1.0, -2.0, 3.0]);
            for axis in 0..3 {
                assert!((corrected[axis] - expected[axis]).abs() < 1e-15, "{text}");
            }
            assert_eq!(read.figures().valid_until, "1970-01-31T00:00:00Z");
            for (estimate, (parameter, u)) in
                found.parameters.iter().zip(&read.uncertainties().parameters)
            {
                assert!(estimate.parameter == *parameter && (estimate.u - u).abs() < 1e-15);
            }
            assert_eq!(read.height_uncertainties().len(), found.map.len());
            let size = found.parameters.len();
            let errors = &read.uncertainties().errors;
            for at in 0..size * size {
                let (row, column) = (at / size, at % size);
                let sum: f64 = errors.iter().map(|error| error[row] * error[column]).sum();
                let expected = found.covariance[at];
                let scale = found.parameters[row].u * found.parameters[column].u;
                assert!((sum - expected).abs() < 1e-12 * scale, "{row} {column}: {sum} {expected}");
            }
        }
    }

    #[test]
    fn it_is_refused_after_its_validity_and_long_before_it_was_made() {
        let made = 100 * DAY_NS;
        let read = CalibrationFile::parse("c.toml", &text(0, made).1).unwrap();
        assert_eq!(read.refusal(made), None);
        assert_eq!(read.refusal(made + 30 * DAY_NS), None);
        let late = read.refusal(made + 30 * DAY_NS + 1_000_000_000).unwrap();
        assert!(
            late.starts_with("the calibration of 1970-04-11T00:00:00Z was valid for 30 days"),
            "{late}"
        );
        let early = read.refusal(made - 2 * DAY_NS).unwrap();
        assert!(early.contains("set the clock"), "{early}");
    }

    #[test]
    fn mistakes_are_told_with_line_and_key() {
        let (_, text) = text(2, 0);
        for (from, to, expected) in [
            ("asphera.calibration/1", "asphera.calibration/9", "format"),
            ("1970-01-01T00:00:00Z", "yesterday", "made: expected a time like"),
            ("valid_days = 30", "valid_days = 0", "valid_days"),
            ("machine = \"cartesian\"", "machine = \"polar\"", "parameters.squareness"),
            ("value_urad", "value_mrad", "value_urad"),
            ("u_urad = ", "u_urad = -", "u_urad: expected a standard uncertainty of 0 or more"),
            ("\nm = 0\n", "\nm = 1\n", "map.term"),
            ("radius_mm = 10.0", "radius_mm = 10.0", ""),
        ] {
            let changed = text.replacen(from, to, 1);
            let problems =
                CalibrationFile::parse("c.toml", &changed).err().map(|all| all.to_string());
            match expected {
                "" => assert_eq!(problems, None),
                _ => {
                    let problems = problems.unwrap_or_default();
                    assert!(
                        problems.contains("c.toml:") && problems.contains(expected),
                        "{problems}"
                    );
                }
            }
        }
    }
}
