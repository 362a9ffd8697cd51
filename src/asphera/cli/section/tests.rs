//! Sections of small files, through the command line's own parser.

use std::fs;
use std::path::Path;

use asphera_report::PathFigures;
use clap::{CommandFactory as _, Parser as _};

use super::super::{Cli, Command};
use super::*;

/// z = x/2 + y/4 on a raster of 1 mm, 10 nm up at one place.
const POINTS: &str = "# x y z in mm\n0 0 0\n1 0 0.5\n2 0 1\n0 1 0.25\n1 1 0.75001\n2 1 1.25\n";
const LEVEL: &str = "[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n";

fn arguments(words: &[&str]) -> SectionArgs {
    match parse(words) {
        Ok(args) => args,
        Err(error) => panic!("{error}"),
    }
}

/// The section of these arguments.
fn cut(args: &SectionArgs) -> Result<SectionReport, Failure> {
    super::cut(args, &Progress::start("section"))
}

fn parse(words: &[&str]) -> Result<SectionArgs, String> {
    let words = ["asphera", "section"].iter().chain(words);
    match Cli::try_parse_from(words).map_err(|error| error.to_string())?.command {
        Command::Section(args) => Ok(args),
        _ => panic!("another command"),
    }
}

fn in_folder(test: impl FnOnce(&Path)) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("part.xyz"), POINTS).unwrap();
    fs::write(folder.path().join("plane.toml"), LEVEL).unwrap();
    test(folder.path());
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

#[test]
fn help_is_as_it_was() {
    let mut cli = Cli::command();
    cli.build();
    let help = cli.find_subcommand_mut("section").unwrap().render_help().to_string();
    assert_eq!(help, include_str!("help.txt"), "{help}");
}

#[test]
fn the_csv_names_its_units_and_has_every_crossing() {
    in_folder(|folder| {
        let out = path(folder, "out.csv");
        let args = arguments(&[&path(folder, "part.xyz"), "--line", "-1,0.5,1.75,0.5", "-o", &out]);
        assert_eq!(run(&args).unwrap(), Exit::Done);
        let text = fs::read_to_string(out).unwrap();
        assert_eq!(
            text,
            "piece,s_mm,x_mm,y_mm,z_mm\n\
             0,1,0,0.5,0.125\n\
             0,1.5,0.5,0.5,0.375\n\
             0,2,1,0.5,0.625005\n\
             0,2.5,1.5,0.5,0.875005\n\
             0,2.75,1.75,0.5,1.0000025\n"
        );
    });
}

#[test]
fn a_nominal_adds_the_deviation_and_figures() {
    in_folder(|folder| {
        let [part, plane] = ["part.xyz", "plane.toml"].map(|name| path(folder, name));
        let args = arguments(&[&part, "--line", "0,1,2,1", "--nominal", &plane]);
        let report = cut(&args).unwrap();
        let columns = report.points.as_ref().unwrap();
        assert!(columns.csv().starts_with("piece,s_mm,x_mm,y_mm,z_mm,deviation_nm\n0,0,0,1,0.25,"));
        let deviations_nm = columns.deviation_nm.as_ref().unwrap();
        // Both ends deviate by the same; the deviation is along the normal.
        let slope = (1.0_f64 + 0.25 + 0.0625).sqrt();
        let [left, top, right] = deviations_nm[..] else { panic!("{deviations_nm:?}") };
        let step = top.unwrap() - (left.unwrap() + right.unwrap()) / 2.0;
        assert!((step - 10.0 / slope).abs() < 1e-3, "{step}");
        let deviation = report.deviation.unwrap();
        assert!((deviation.pv_nm - 10.0 / slope).abs() < 1e-3, "{deviation:?}");
        let text = summary(&report);
        assert!(text.starts_with("section    2.000 mm in one piece\nheight     PV 1.000 mm"));
        assert!(text.contains("\ndeviation  PV 8.729 nm, RMS"), "{text}");
    });
}

#[test]
fn a_radius_starts_in_the_middle_of_the_points_and_circles_close() {
    in_folder(|folder| {
        let part = path(folder, "part.xyz");
        let report = cut(&arguments(&[&part, "--radius", "-180"])).unwrap();
        let columns = report.points.unwrap();
        assert_eq!((columns.x_mm[0], columns.y_mm[0]), (1.0, 0.5));
        assert_eq!((report.length_mm, report.pieces[0].ends), (1.0, "hull"));
        let report = cut(&arguments(&[&part, "--radius", "90", "--centre", "0.5,0"])).unwrap();
        assert_eq!(report.length_mm, 1.0);
        let report = cut(&arguments(&[&part, "--circle", "1,0.5,0.25"])).unwrap();
        assert_eq!((report.pieces[0].begins, report.pieces[0].ends), ("closed", "closed"));
        let height = report.height.unwrap();
        assert_eq!((height.line, height.circle), (None, None));
    });
}

/// Two hills in a level plane at z = 0.3: two closed pieces, numbered.
#[test]
fn a_plane_cuts_in_pieces() {
    in_folder(|folder| {
        let hills: String = (0..21 * 11)
            .map(|index| [f64::from(index % 21), f64::from(index / 21)])
            .map(|[x, y]| {
                let hill = |centre: f64| (-((x - centre).powi(2) + (y - 5.0).powi(2)) / 4.0).exp();
                format!("{x} {y} {}\n", hill(5.0) + hill(15.0))
            })
            .collect();
        let file = path(folder, "hills.xyz");
        fs::write(&file, hills).unwrap();
        let plane = path(folder, "plane.toml");
        let args = arguments(&[&file, "--plane", "0,0,-2,-0.6", "--nominal", &plane]);
        let report = cut(&args).unwrap();
        let level = PathFigures::Plane { normal: [0.0, 0.0, -1.0], offset_mm: -0.3 };
        assert_eq!(report.path, level);
        let ends: Vec<_> = report.pieces.iter().map(|piece| (piece.begins, piece.ends)).collect();
        assert_eq!(ends, [("closed", "closed"); 2]);
        let columns = report.points.as_ref().unwrap();
        assert!(columns.z_mm.iter().all(|z| (z - 0.3).abs() < 1e-12));
        assert_eq!((columns.piece[0], columns.piece.last()), (0, Some(&1)));
        assert!(columns.piece.is_sorted());
        // Each about its own hill, as long as the circle on which a hill is 0.3 high.
        let around_mm = std::f64::consts::TAU * (-4.0 * 0.3_f64.ln()).sqrt();
        for (number, piece) in report.pieces.iter().enumerate() {
            assert!((piece.to_s_mm / around_mm - 1.0).abs() < 0.06, "{piece:?} {around_mm}");
            assert_eq!(piece.from_s_mm, 0.0);
            let own = (0..columns.piece.len()).filter(|&at| columns.piece[at] == number);
            let x_mm: Vec<f64> = own.map(|at| columns.x_mm[at]).collect();
            let middle = if x_mm[0] < 10.0 { 5.0 } else { 15.0 };
            assert!(x_mm.iter().all(|x| (x - middle).abs() < 3.0), "{x_mm:?}");
        }
        assert!(columns.deviation_nm.as_ref().unwrap().iter().all(Option::is_some));
        let height = report.height.unwrap();
        assert!(height.pv_mm < 1e-12 && height.line.is_none() && height.circle.is_none());
        // An upright plane: the same places as along a line.
        let part = path(folder, "part.xyz");
        let upright = cut(&arguments(&[&part, "--plane", "0,1,0,0.5"])).unwrap().points.unwrap();
        let line = cut(&arguments(&[&part, "--line", "0,0.5,2,0.5"])).unwrap().points.unwrap();
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        assert_eq!(sorted(upright.z_mm), sorted(line.z_mm));
    });
}

#[test]
fn the_report_is_json() {
    in_folder(|folder| {
        let args = arguments(&[&path(folder, "part.xyz"), "--line", "0,0,2,0", "--json"]);
        let mut report = cut(&args).unwrap();
        let whole = serde_json::to_value(&report).unwrap();
        assert_eq!(whole["points"]["z_mm"], serde_json::json!([0.0, 0.5, 1.0]));
        report.points = None;
        let figures = serde_json::to_value(&report).unwrap();
        assert_eq!(figures["format"], "asphera.section/1");
        assert_eq!(
            figures["path"],
            serde_json::json!({"kind": "line", "from_mm": [0.0, 0.0], "to_mm": [2.0, 0.0]})
        );
        assert_eq!(figures["pieces"][0]["points"], 3);
        assert!(figures["height"]["line"]["pv_nm"].as_f64().unwrap() < 1e-6);
        assert_eq!(figures["height"]["circle"], serde_json::Value::Null);
        assert_eq!(
            figures["reasons"],
            serde_json::json!([
                "no circle: the profile comes from 3 vertices, and a fit of 3 parameters needs 4"
            ])
        );
        assert_eq!(figures.get("points"), None);
    });
}

#[test]
fn points_out_of_range_are_named_for_what_they_are() {
    in_folder(|folder| {
        let far = path(folder, "far.xyz");
        fs::write(&far, "1e15 0 0\n2e15 0 0\n1e15 1e15 0\n").unwrap();
        let said = run(&arguments(&[&far, "--line", "0,0,2,0"])).unwrap_err().to_string();
        assert!(
            said.contains("far.xyz: the points span no area: 3 of 3 lie farther than"),
            "{said}"
        );
        assert!(said.contains("Check the unit of the file"), "{said}");
    });
}

#[test]
fn mistakes_are_named() {
    let failed = |words: &[&str]| {
        let mut said = String::new();
        in_folder(|folder| {
            let part = path(folder, "part.xyz");
            let words: Vec<&str> = [&part[..]].iter().chain(words).copied().collect();
            said = run(&arguments(&words)).unwrap_err().to_string();
        });
        said
    };
    assert!(failed(&["--line", "5,5,9,9"]).starts_with("the section meets no measured surface"));
    assert!(failed(&["--line", "0,0,2,0", "--gap-limit", "0.1"]).contains("or in a gap"));
    assert_eq!(
        failed(&["--line", "1,1,1,1"]),
        "the section starts and ends at (1, 1) mm: it has no length"
    );
    assert!(failed(&["--circle", "1,0.5,-2"]).starts_with("radius -2 mm: expected"));
    assert!(failed(&["--circle", "1,0.5,0.1", "--gap-limit", "0"]).starts_with("gap limit 0 mm"));
    assert!(
        failed(&["--plane", "0,0,0,1"]).starts_with("plane with normal (0, 0, 0) and offset 1")
    );
    assert!(failed(&["--plane", "0,0,1,9"]).starts_with("the section meets no measured surface"));
    assert!(failed(&["--radius", "0", "--json", "-o", "-"]).contains("both want stdout"));
    for (words, said) in [
        (&["f", "--line", "1,2,3"][..], "expected 4 numbers with commas between, found 3"),
        (&["f", "--circle", "1,NaN,3"], "expected a finite number, found `NaN`"),
        (&["f", "--plane", "1,2,3"], "expected 4 numbers with commas between, found 3"),
        (&["f", "--plane", "1,0,0,0", "--line", "0,0,1,1"], "cannot be used with"),
        (&["f", "--plane", "1,0,0,0", "--centre", "1,1"], "cannot be used with"),
        (&["f", "--radius", "east"], "expected a finite number, found `east`"),
        (&["f"], "--line <X1,Y1,X2,Y2>|--circle <X,Y,R>|--radius <DEG>|--plane"),
        (&["f", "--radius", "1", "--circle", "0,0,1"], "cannot be used with"),
        (&["f", "--centre", "1,1", "--circle", "0,0,1"], "cannot be used with"),
    ] {
        let error = parse(words).err().unwrap();
        assert!(error.contains(said), "{words:?}: {error}");
    }
}
