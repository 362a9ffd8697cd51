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
        "{{\"format\": \"{FORMAT}\", \"input\": {{\"points\": 4, \"distinct\": 4, \"spacing_median_mm\": 1.0}}, \
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
    let later = open.replace(FORMAT, "asphera-contour 9");
    let other = compare(("a.json", &later), ("b.json", &open)).unwrap_err();
    assert!(
        other.ends_with("expected format asphera-contour 1, found asphera-contour 9"),
        "{other}"
    );
}
