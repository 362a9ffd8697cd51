//! What the command line says of a plan.

use clap::Parser as _;

use super::*;

#[derive(clap::Parser)]
struct Line {
    #[command(flatten)]
    plan: PlanArgs,
}

const SPHERE: &str =
    "[surface]\nkind = \"sphere\"\nradius_mm = 20\n[aperture]\nshape = \"circle\"\nradius_mm = 5\n";

fn run_line(words: &[&str]) -> Result<Exit, String> {
    let line =
        Line::try_parse_from([&["plan"], words].concat()).map_err(|error| error.to_string())?;
    run(&line.plan).map_err(|failure| failure.to_string())
}

#[test]
fn a_path_over_a_nominal_is_written_with_places_and_times() {
    let dir = tempfile::tempdir().unwrap();
    let nominal = dir.path().join("sphere.toml");
    std::fs::write(&nominal, SPHERE).unwrap();
    let [nominal, out] =
        [nominal, dir.path().join("plan.csv")].map(|path| path.display().to_string());
    let spiral =
        [&nominal[..], "--path", "spiral", "--spacing", "1", "-o", &out, "--machine", "polar"];
    assert_eq!(run_line(&spiral), Ok(Exit::Done));
    let text = std::fs::read_to_string(&out).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("x[mm],y[mm],r[mm],c[deg],t[s]"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect();
    for row in &rows {
        let [x, y, r, c, _] = row[..] else { panic!("{row:?}") };
        let (sin, cos) = c.to_radians().sin_cos();
        assert!((r * cos - x).abs() < 1e-6 && (r * sin - y).abs() < 1e-6, "{row:?}");
    }
    assert!(rows.len() > 100 && rows.windows(2).all(|pair| pair[1][4] > pair[0][4]));
    assert!(run_line(&spiral).unwrap_err().contains("--force overwrites it"));
    let forced = [&spiral[..], &["--force", "--json"]].concat();
    assert_eq!(run_line(&forced), Ok(Exit::Done));
}

#[test]
fn what_cannot_be_planned_names_key_and_cure() {
    let dir = tempfile::tempdir().unwrap();
    let [nominal, open, flat, out] =
        ["sphere.toml", "open.toml", "flat.toml", "plan.csv"].map(|name| dir.path().join(name));
    std::fs::write(&nominal, SPHERE).unwrap();
    std::fs::write(&open, &SPHERE[..SPHERE.find("[aperture]").unwrap()]).unwrap();
    std::fs::write(
        &flat,
        "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 5\n",
    )
    .unwrap();
    let [nominal, open, flat, out] =
        [nominal, open, flat, out].map(|path| path.display().to_string());
    let refused = |source: &str, more: &[&str]| {
        run_line(&[&[source, "-o", &out[..], "--path", "raster"], more].concat()).unwrap_err()
    };
    assert!(refused(&nominal, &[]).contains("expected --spacing MM or --from-epsilon E"));
    let error = refused(&nominal, &["--spacing", "1", "--axis", "x=-4,4,10,100"]);
    assert!(error.contains("x.travel: expected -4 to 4 mm, found -"), "{error}");
    let error = refused(&nominal, &["--spacing", "1", "--machine", "polar"]);
    assert!(error.contains("take spiral, rings or meridians"), "{error}");
    let error = refused(&nominal, &["--spacing", "1", "--axis", "c=0,90,10,100"]);
    assert!(error.contains("axis: expected x or y, found c"), "{error}");
    assert!(refused(&nominal, &["--spacing", "1", "--axis", "x=1,2,3"]).contains("AXIS=LOW,HIGH"));
    assert!(refused(&nominal, &["--spacing", "1", "--inward"]).contains("spiral or rings"));
    assert!(refused(&open, &["--spacing", "1"]).contains("[aperture]"));
    assert!(refused(&flat, &["--from-epsilon", "0.05"]).contains("give --spacing MM"));
    assert!(!FilePath::new(&out).exists());
}

/// A cap with two holes: their places, as the sampling lists them, come in a path that is no longer.
#[test]
fn places_to_measure_next_come_in_a_short_path() {
    use std::fmt::Write as _;

    let dir = tempfile::tempdir().unwrap();
    let mut text = String::new();
    for (i, j) in (0..=50).flat_map(|i| (0..=40).map(move |j| (i, j))) {
        let [x, y] = [0.2 * f64::from(i) - 5.0, 0.2 * f64::from(j) - 4.0];
        let is_hole =
            (1.0 < x && x < 2.0 && y.abs() < 1.0) || (-3.0 < x && x < -2.3 && 0.0 < y && y < 2.0);
        if !is_hole {
            writeln!(text, "{x} {y} {}", 20.0 - (400.0 - x * x - y * y).sqrt()).unwrap();
        }
    }
    let [points, nominal, out] = ["part.xyz", "sphere.toml", "next.csv"]
        .map(|name| dir.path().join(name).display().to_string());
    std::fs::write(&points, text).unwrap();
    let rectangle = "[aperture]\nshape = \"rectangle\"\nwidth_mm = 8\nheight_mm = 6\n[sampling]\ngap_limit_mm = 0.2\n";
    let surface = &SPHERE[..SPHERE.find("[aperture]").unwrap()];
    std::fs::write(&nominal, format!("{surface}{rectangle}")).unwrap();
    let words =
        [&points[..], "--nominal", &nominal, "--from", "0,-4", "--dwell", "0.1", "-o", &out];
    let line = Line::try_parse_from([&["plan"], &words[..]].concat()).unwrap();
    let found = missing::find(&line.plan, &Progress::start("plan")).unwrap();
    assert_eq!((found.regions, found.left_out), (2, 0));
    assert_eq!(run_line(&words), Ok(Exit::Done));
    let text = std::fs::read_to_string(&out).unwrap();
    assert_eq!(text.lines().next(), Some("x[mm],y[mm],z[mm],t[s]"));
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|number| number.parse().unwrap()).collect())
        .collect();
    let sorted = |mut places: Vec<[f64; 3]>| {
        places.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
        places
    };
    let written: Vec<[f64; 3]> = rows.iter().map(|row| [row[0], row[1], row[2]]).collect();
    let length = |places: &[[f64; 3]]| {
        asphera_plan::path_length_mm([0.0, -4.0], places.iter().map(|&[x, y, _]| [x, y]))
    };
    assert!(length(&written) < length(&found.places_mm), "{}", length(&written));
    assert_eq!(sorted(written), sorted(found.places_mm));
    // Each place takes its dwell at least.
    assert!(rows.windows(2).all(|pair| pair[1][3] - pair[0][3] > 0.1));
}

#[test]
fn what_gives_no_places_says_why() {
    let dir = tempfile::tempdir().unwrap();
    let [nominal, points, out] = ["sphere.toml", "ball.xyz", "plan.csv"]
        .map(|name| dir.path().join(name).display().to_string());
    std::fs::write(&nominal, SPHERE).unwrap();
    let said = run_line(&[&nominal, "-o", &out]).unwrap_err();
    assert!(said.contains("found a nominal by its name: --path"), "{said}");
    let ball = (0..400).map(|index| {
        let (z, turn) = (f64::from(index) / 200.0 - 0.9975, 2.399_963 * f64::from(index));
        let r = (1.0 - z * z).sqrt();
        format!("{} {} {z}\n", r * turn.cos(), r * turn.sin())
    });
    std::fs::write(&points, ball.collect::<String>()).unwrap();
    let said = run_line(&[&points, "-o", &out, "--along", "none"]).unwrap_err();
    assert!(said.contains("no plan: the points are meshed in space"), "{said}");
}
