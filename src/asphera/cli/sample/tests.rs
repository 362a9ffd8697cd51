//! Samples of small curves, through the command line's own parser.

use clap::Parser as _;

use super::super::{Cli, Command};
use asphera_report::contour::ContourReport;

use super::*;

const CIRCLE: &str = "<svg><circle cx='5' cy='-5' r='5'/></svg>";

/// The figures, the samples and the true contour of a curve; or why not.
fn made(
    name: &str,
    bytes: &[u8],
    words: &[&str],
) -> Result<(String, Vec<PlaceMm>, String), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path(name), bytes).unwrap();
    let files = [path(name), path("out.xy"), path("truth.json")];
    let given = ["asphera", "sample", &files[0], "-o", &files[1], "--truth", &files[2]];
    let args = match Cli::try_parse_from(given.iter().chain(words)).map(|cli| cli.command) {
        Ok(Command::Sample(args)) => args,
        Ok(_) => panic!("another command"),
        Err(error) => return Err(error.to_string()),
    };
    run(&args).map_err(|failure| failure.to_string().replace(&files[0], name))?;
    let text = std::fs::read_to_string(&files[1]).unwrap();
    let places = text.lines().map(|line| {
        let mut words = line.split(' ').map(|word| word.parse().unwrap());
        [words.next().unwrap(), words.next().unwrap()]
    });
    Ok((text.clone(), places.collect(), std::fs::read_to_string(&files[2]).unwrap()))
}

#[test]
fn a_circle_gets_the_samples_that_its_condition_asks_for() {
    let (_, places, truth) = made("a.svg", CIRCLE.as_bytes(), &["--rho", "0.9"]).unwrap();
    // 2π over 4·asin(0.45), rounded up.
    assert_eq!(places.len(), 4);
    assert!(
        places.iter().all(|[x, y]| ((x - 5.0).hypot(y - 5.0) - 5.0).abs() < 1e-7),
        "{places:?}"
    );
    let truth: ContourReport = serde_json::from_str(&truth).unwrap();
    assert_eq!(truth.edges, [[0, 1], [0, 3], [1, 2], [2, 3]]);
    assert!((truth.chains[0].length_mm - 10.0 * std::f64::consts::PI).abs() < 1e-3);
    let words = ["--epsilon", "0.2", "--noise", "0.01", "--outliers", "10", "--seed", "4"];
    let first = made("a.svg", CIRCLE.as_bytes(), &words).unwrap();
    assert_eq!(first, made("a.svg", CIRCLE.as_bytes(), &words).unwrap());
    let truth: ContourReport = serde_json::from_str(&first.2).unwrap();
    assert_eq!((first.1.len(), truth.input.points, truth.left_out.len()), (18, 18, 2));
}

#[test]
fn images_and_drawings_of_other_kinds() {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 4, 3);
    encoder.set_color(png::ColorType::Grayscale);
    let pixels = [255, 255, 255, 255, 255, 0, 0, 255, 255, 255, 255, 255];
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    let (text, ..) = made("a.png", &png, &["--pixel", "2"]).unwrap();
    assert_eq!(text, "3 2\n5 2\n6 3\n5 4\n3 4\n2 3\n");
    let dxf = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n10\n0\n20\n0\n40\n5\n0\nENDSEC\n0\nEOF\n";
    assert_eq!(made("a.dxf", dxf.as_bytes(), &["--rho", "0.9"]).unwrap().1.len(), 4);
}

/// What a person reads of a curve that was sampled, and its samples.
fn told(name: &str, bytes: &[u8], words: &[&str], out: &str) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path(name), bytes).unwrap();
    let files = [path(name), path(out)];
    let given = ["asphera", "sample", &files[0], "-o", &files[1]];
    let Ok(Cli { command: Command::Sample(args), .. }) =
        Cli::try_parse_from(given.iter().chain(words))
    else {
        panic!("another command");
    };
    let Taken { curve, samples, left_out, image } = sampled(&args).unwrap();
    assert_eq!(run(&args).unwrap(), Exit::Done);
    let report = SampleReport {
        format: "",
        lines: samples.len(),
        closed: 0,
        diagonal_mm: curve.diagonal_mm(),
        lfs_least_mm: None,
        samples: 0,
        outliers: 0,
        seed: 1,
        left_out,
        image,
    };
    (report.summary(&args.out), std::fs::read_to_string(&files[1]).unwrap())
}

#[test]
fn what_is_not_taken_is_told() {
    let svg = "<svg><defs><text>a</text><circle id='c' r='5'/></defs><circle r='5'/><use href='#c' x='9'/><text>b</text><use href='#c'/></svg>";
    let (summary, csv) = told("a.svg", svg.as_bytes(), &["--rho", "0.9"], "out.csv");
    assert!(summary.contains("left out   1 text, 2 use: paths"), "{summary}");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!((lines[0], lines.len()), ("x[mm],y[mm]", 5));
    assert!(lines[1..].iter().all(|line| line.split(',').count() == 2), "{csv}");
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 4, 3);
    encoder.set_color(png::ColorType::Rgba);
    let (red, yellow, white, none) = ([255, 0, 0, 255], [255, 255, 0, 255], [255; 4], [0; 4]);
    let pixels = [white, none, white, white, white, red, red, white, white, yellow, white, none];
    encoder.write_header().unwrap().write_image_data(&pixels.concat()).unwrap();
    let (summary, _) = told("a.png", &png, &[], "out.xy");
    assert!(
        summary.contains(
            "shape      2 of 12 pixels, darker than half way from black to white; of 3 coloured ones the mean of red, green and blue counts; 2 less than half opaque are left out\n"
        ),
        "{summary}"
    );
}

#[test]
fn what_cannot_be_sampled_is_refused() {
    let refused =
        |name: &str, text: &str, words: &[&str]| made(name, text.as_bytes(), words).unwrap_err();
    assert!(refused("a.svg", CIRCLE, &[]).contains("expected --epsilon, --rho or --chord"));
    assert!(
        refused("a.svg", CIRCLE, &["--rho", "0"]).contains("expected a number above 0, found `0`")
    );
    assert!(refused("a.svg", CIRCLE, &["--rho", "1", "--noise", "2"]).contains("from 0 to 1"));
    let empty = refused("a.svg", "<svg/>", &["--rho", "1"]);
    assert_eq!(empty, "a.svg: expected a path or a shape, found none");
    assert!(refused("a.svg", "<svg><path d='x'/></svg>", &["--rho", "1"]).contains("path data"));
    assert!(refused("a.txt", "1 2", &["--rho", "1"]).contains(".svg, .dxf or .png"));
    assert!(refused("a.png", "no image", &[]).contains("PNG"));
    for option in [&["--pixel", "0.1"][..], &["--light"]] {
        let words = [&["--rho", "1"], option].concat();
        assert!(refused("a.svg", CIRCLE, &words).contains("--pixel and --light are of an image"));
    }
}

#[test]
fn one_file_for_samples_and_truth_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("a.svg"), CIRCLE).unwrap();
    let words = ["asphera", "sample", &path("a.svg"), "--rho", "0.9", "-o", &path("a.xy")];
    let words = words.into_iter().map(str::to_owned).chain(["--truth".to_owned(), path("a.xy")]);
    let Ok(Cli { command: Command::Sample(args), .. }) = Cli::try_parse_from(words) else {
        panic!("another command");
    };
    let failure = run(&args).unwrap_err().to_string();
    assert!(failure.contains("--out and --truth are both"), "{failure}");
    assert!(!folder.path().join("a.xy").exists());
    let words = ["asphera", "sample", &path("a.svg"), "--rho", "0.9", "-o", "-"];
    let Ok(Cli { command: Command::Sample(args), .. }) = Cli::try_parse_from(words) else {
        panic!("another command");
    };
    assert!(run(&args).unwrap_err().to_string().contains("names of files, found -"));
    let words = ["asphera", "sample", &path("a.svg"), "--rho", "0.9", "-o", &path("a.ply")];
    let Ok(Cli { command: Command::Sample(args), .. }) = Cli::try_parse_from(words) else {
        panic!("another command");
    };
    assert!(run(&args).unwrap_err().to_string().contains("expected a name in .xy, .xyz"));
}
