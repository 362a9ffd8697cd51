//! Command lines that do not go together: exit code 2, whoever sees it.

use asphera_tests::run;

/// Fails unless the command line ends with 2, prints nothing, and its one complaint has the words.
fn is_misuse(line: &str, points: &str, words: &str) {
    let line = line.replace("POINTS", points);
    let output = run(line.split(' '));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{line}: {said}");
    assert!(output.stdout.is_empty(), "{line}");
    assert!(said.contains(words) && said.matches("error: ").count() == 1, "{line}: {said}");
}

#[test]
fn options_that_do_not_go_together_are_a_wrong_command_line() {
    let dir = tempfile::tempdir().unwrap();
    let points = dir.path().join("points.xyz");
    std::fs::write(&points, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n").unwrap();
    let points = points.to_str().unwrap();
    let flat = asphera_tests::root().join("config/examples/flat.toml");
    let flat = flat.to_str().unwrap();
    let plan = format!("plan {flat} --path raster -o {points}.csv");
    let spaced = format!("{plan} --spacing 1");
    let lines = [
        ("compare POINTS", "expected two contours, found 1"),
        ("compare --shapes POINTS", "1 clouds: expected two at least"),
        ("reconstruct POINTS --method alpha", "--alpha MM belong together"),
        ("reconstruct POINTS --alpha 1", "--alpha MM belong together"),
        ("reconstruct POINTS --hops 3", "belong to --method graph"),
        ("measure POINTS", "--nominal FILE says what the part should be"),
        ("measure POINTS --nominal FLAT --threshold 3", "expected a volume for --threshold"),
        ("section POINTS --line 0,0,1,1 --json --out -", "both want stdout"),
        ("contour POINTS --method emst", "expected one of"),
        ("contour POINTS --method none-such", "no method is called"),
        ("contour POINTS --set theta=", "theta"),
        ("contour POINTS --tolerance -1", "expected 0 mm or more"),
        ("graph POINTS --halvings 2 --components grown", "--components exact"),
        ("benchmark curves --category none-such", "--category: expected one of"),
        ("benchmark regions --methods crust", "expected methods for regions"),
        ("calibrate POINTS --flat --machine cartesian --turn 1,2", "expected --turn for each"),
        ("report POINTS --nominal FLAT -o POINTS.html --qif POINTS.html", "are both"),
        ("nominal FLAT --surface 1", "--surface is for lens files"),
        ("demo --scene none-such --exit", "no scene"),
        ("demo --scene ct --points 900 --exit", "expected no --points"),
        ("describe POINTS --name a*b", "--name: expected letters"),
        (plan.as_str(), "--spacing MM or --from-epsilon"),
        (&format!("{spaced} --unit um"), "--unit, --skip-lines"),
        (&format!("{spaced} --inward"), "--inward: expected"),
        (&format!("{spaced} --machine polar --axis x=0,1,1,1"), "name an axis of this --machine"),
    ];
    for (line, words) in lines {
        is_misuse(&line.replace("FLAT", flat), points, words);
    }
}

/// What a file holds is no matter of the command line.
#[test]
fn a_file_that_cannot_be_used_is_no_wrong_command_line() {
    let dir = tempfile::tempdir().unwrap();
    let missing = dir.path().join("none.xyz");
    let output = run(["sampling", missing.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
}
