//! Contours compared, through the command line's own parser.

use clap::Parser as _;

use super::super::{Cli, Command};
use super::*;

fn arguments(words: &[String]) -> CompareArgs {
    let words = ["asphera", "compare"].into_iter().map(str::to_owned).chain(words.iter().cloned());
    match Cli::try_parse_from(words).map(|cli| cli.command) {
        Ok(Command::Compare(args)) => args,
        Ok(_) => panic!("another command"),
        Err(error) => panic!("{error}"),
    }
}

fn report(edges: &str, closed: bool, side: f64) -> String {
    format!(
        "{{\"format\": \"{CONTOUR_FORMAT}\", \"input\": {{\"points\": 4, \"distinct\": 4, \"spacing_median_mm\": 1.0}}, \
         \"method\": \"crust\", \"parameters\": {{}}, \"guarantee\": \"none\", \"edges\": {edges}, \"chains\": \
         [{{\"closed\": {closed}, \"length_mm\": 4.0, \"points_mm\": [[0, 0], [{side}, 0], [{side}, {side}], [0, {side}]]}}], \
         \"ends\": [], \"junctions\": [], \"left_out\": [], \"unknown\": []}}"
    )
}

fn compare(found: (&str, &str), truth: (&str, &str)) -> Result<ComparisonReport, String> {
    let folder = tempfile::tempdir().unwrap();
    let words = [found, truth].map(|(name, text)| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    });
    compared(&arguments(&words)).map_err(|failure| failure.to_string())
}

#[test]
fn two_contours_of_the_same_points() {
    let truth = report("[[0, 1], [0, 3], [1, 2], [2, 3]]", true, 1.0);
    let found = report("[[0, 1], [1, 2], [0, 2]]", true, 0.5);
    let figures = compare(("a.json", &found), ("b.json", &truth)).unwrap();
    assert_eq!((figures.precision, figures.recall), (Some(2.0 / 3.0), Some(0.5)));
    assert!((figures.iou.unwrap() - 0.25).abs() < 1e-12);
    assert!((figures.hausdorff_mm - 0.5_f64.sqrt()).abs() < 1e-15);
    assert!(figures.unknown.is_empty());
    assert!(summary(&figures).contains("recall     0.500000\n"), "{}", summary(&figures));
}

#[test]
fn what_cannot_be_told_is_absent_and_said() {
    let open = report("[[0, 1]]", false, 1.0);
    let figures = compare(("a.json", &open), ("b.xyz", "0 0\n1 0\n1 1\n0 1\n")).unwrap();
    assert_eq!((figures.iou, figures.precision, figures.hausdorff_mm), (None, None, 0.0));
    assert_eq!(figures.unknown.len(), 2);
    let figures =
        compare(("a.xyz", "0 0\n1 0\n1 1\n0 1\n"), ("b.xyz", "0 0\n1 0\n1 1\n0 1\n")).unwrap();
    assert_eq!(figures.iou, Some(1.0));
    let other = compare(("a.json", "{}"), ("b.xyz", "0 0\n1 0\n1 1\n")).unwrap_err();
    assert!(other.contains("expected what contour --json writes"), "{other}");
    let later = open.replace(CONTOUR_FORMAT, "asphera-contour 9");
    let other = compare(("a.json", &later), ("b.json", &open)).unwrap_err();
    assert!(
        other.ends_with("expected format asphera-contour 1, found asphera-contour 9"),
        "{other}"
    );
}

/// A ring or a disc as text, of a size.
fn cloud(is_ring: bool, size: f64, turn: f64) -> String {
    let at = |step: u32| {
        let share = (f64::from(step) * 0.618_033_988_75).fract();
        let angle = f64::from(step) * 2.399_963 + turn;
        let radius = size * if is_ring { 0.8 + 0.2 * share } else { share.sqrt() };
        format!("{} {} 0\n", radius * angle.cos(), radius * angle.sin())
    };
    (0..1500).map(at).collect()
}

#[test]
fn shapes_are_compared_and_classes_found() {
    let folder = tempfile::tempdir().unwrap();
    for (class, is_ring) in [("disc", false), ("ring", true)] {
        std::fs::create_dir(folder.path().join(class)).unwrap();
        for (name, size, turn) in [("a.xyz", 1.0, 0.3), ("b.xyz", 4.0, 1.1), ("c.xyz", 2.0, 2.0)] {
            std::fs::write(folder.path().join(class).join(name), cloud(is_ring, size, turn))
                .unwrap();
        }
    }
    let of = |words: &[&str]| {
        let args = arguments(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>());
        let how = args.how().map_err(|failure| failure.to_string())?;
        match &args.evaluate {
            Some(folder) => shapes::evaluated(folder, &how),
            None => shapes::shapes(&args.files, &how),
        }
        .map(|report| (report.summary(), serde_json::to_value(&report).unwrap()))
        .map_err(|failure| failure.to_string())
    };
    let root = folder.path().to_str().unwrap();
    let (text, json) = of(&["--evaluate", root, "--scale-free"]).unwrap();
    assert_eq!(json["evaluation"]["nearest_neighbour"], 1.0, "{text}");
    assert_eq!(json["evaluation"]["classes"][5], "ring");
    assert!(text.contains("mAP        1.0000") && text.contains("ring: 3 shapes"), "{text}");
    let (_, json) = of(&["--evaluate", root, "--method", "seed", "--strips", "12"]).unwrap();
    assert_eq!((&json["method"], &json["functions"][0]), (&"seed".into(), &"pca:1".into()));
    let file = |name: &str| folder.path().join(name).display().to_string();
    let files = [file("disc/a.xyz"), file("disc/b.xyz"), file("ring/a.xyz")];
    let (text, json) = of(&["--shapes", "--scale-free", &files[0], &files[1], &files[2]]).unwrap();
    assert_eq!(json["distances"][1][1], 0.0);
    assert!(text.lines().nth(1).unwrap().ends_with("disc/b.xyz"), "{text}");
    assert!(of(&["--shapes", &files[0]]).unwrap_err().contains("expected two"));
    assert!(of(&["--evaluate", &file("disc")]).unwrap_err().contains("a folder of each class"));
    let three: Vec<String> = files.to_vec();
    let refused = compared(&arguments(&three)).unwrap_err().to_string();
    assert!(refused.contains("--shapes compares clouds"), "{refused}");
}

#[test]
fn two_places_are_no_closed_line() {
    let other = compare(("a.xyz", "0 0\n1 0\n1 1\n"), ("b.xyz", "0 0\n1 0\n")).unwrap_err();
    assert!(other.contains("b.xyz: expected three places or more"), "{other}");
    assert!(other.ends_with("found 2"), "{other}");
}

#[test]
fn places_in_no_order_have_no_area_in_common() {
    let square = "0 0\n1 0\n1 1\n0 1\n";
    // Steps of a fraction of the turn that no number of turns repeats.
    let places = (0..20_000).map(|index| {
        let (sin, cos) = (2.399_963 * f64::from(index)).sin_cos();
        format!("{cos} {sin}\n")
    });
    let scattered: String = places.collect();
    let figures = compare(("a.xyz", &scattered), ("b.xyz", square)).unwrap();
    assert_eq!(figures.iou, None);
    assert!(figures.unknown[0].starts_with("iou: expected places in order"), "{figures:?}");
    // A line that goes to and fro, but in order, has its area.
    let comb = (0..40).map(|index| {
        let x = f64::from(index) / 40.0;
        let [low, high] = if index % 2 == 0 { [0.1, 0.9] } else { [0.9, 0.1] };
        format!("{x} {low}\n{x} {high}\n")
    });
    let comb: String = comb.chain(["1 0\n0 0\n".to_owned()]).collect();
    assert!(compare(("a.xyz", &comb), ("b.xyz", square)).unwrap().iou.is_some());
}

#[test]
fn options_of_shapes_are_refused_for_contours() {
    for option in [&["--scale-free"][..], &["--strips", "5"], &["--function", "height:x"]] {
        let words = [&["a.xy", "b.xy"], option].concat();
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        let error = run(&arguments(&words)).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{} is of shapes", option[0])), "{error}");
    }
    let words = ["--shapes", "a.xyz", "b.xyz", "--strips", "5"].map(str::to_owned);
    let error = arguments(&words).how().map(|_| ()).unwrap_err().to_string();
    assert_eq!(error, "--function and --strips are of --method seed: add it");
}
