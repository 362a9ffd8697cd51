//! QIF documents of every sort of report, judged by a validator of XML schemas (lxml).

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use asphera_tests::{python, root, run, skipped};

const DISC: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 3.0\n\
    [fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n";

/// The name of a report and its nominal: with limits kept, broken, in doubt, none at all; with every figure; by zones; of nothing.
const NOMINALS: [(&str, &str, usize); 7] = [
    ("pass", "[tolerance]\npv_nm = 500\nrms_nm = 100\n", 3721),
    ("fail", "[tolerance]\npv_nm = 500\nrms_nm = 3\n", 3721),
    ("undecided", "[tolerance]\npv_nm = 500\n[sampling]\ncoverage_min = 1.0\n", 200),
    ("no-limit", "", 3721),
    (
        "standards",
        "[tolerance]\npv_nm = 500\nminimum_zone_nm = 300\nindication = \"3/0.8(0.6); λ=633 nm\"\n[figures]\n\
         minimum_zone = true\n[figures.texture]\nl_mm = 1.0\n",
        3721,
    ),
    (
        "zones",
        "[tolerance]\npv_nm = 500\n[[tolerance.zone]]\ninner_mm = 0\nouter_mm = 1.5\npv_nm = 100\n[[tolerance.zone]]\n\
         inner_mm = 1.5\nouter_mm = 3\npv_nm = 1\nrms_nm = 50\n",
        3721,
    ),
    ("nothing", "[tolerance]\npv_nm = 500\n", 1),
];

/// A plane with 60 nm of astigmatism, the first `count` of 61 by 61 points.
fn points(count: usize) -> String {
    let mut text = String::new();
    for index in 0..count {
        let place = |step: usize| 0.1 * (step as f64 - 30.0);
        let (x, y) = (place(index % 61), place(index / 61));
        writeln!(text, "{x:?} {y:?} {:?}", 60e-6 / 9.0 * (x * x - y * y)).unwrap();
    }
    text
}

fn document(folder: &Path, name: &str, rest: &str, count: usize) -> PathBuf {
    let [file, nominal, page, qif] =
        ["xyz", "toml", "html", "xml"].map(|end| folder.join(format!("{name}.{end}")));
    fs::write(&file, points(count)).unwrap();
    fs::write(&nominal, format!("{DISC}{rest}")).unwrap();
    let output = run([
        "report".as_ref(),
        file.as_os_str(),
        "--nominal".as_ref(),
        nominal.as_os_str(),
        "--part".as_ref(),
        "Lens <7> & \"8\"".as_ref(),
        "-o".as_ref(),
        page.as_os_str(),
        "--qif".as_ref(),
        qif.as_os_str(),
    ]);
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 10 | 11)), "{name}: {words}");
    qif
}

/// What the validator finds in documents.
fn faults(python: &Path, schema: &Path, documents: &[PathBuf]) -> String {
    let script = root().join("tests/end_to_end/qif.py");
    let output = Command::new(python).arg(script).arg(schema).args(documents).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Against the rules for the elements used, which stand beside this test; and, where ASPHERA_QIF_XSD names it, the whole QIFDocument.xsd
/// of the standard.
#[test]
fn a_validator_accepts_the_qif_document_of_every_report() {
    let Some(python) = python("lxml.etree") else { return };
    let dir = tempfile::tempdir().unwrap();
    let documents =
        NOMINALS.map(|(name, rest, count)| document(dir.path(), name, rest, count)).to_vec();
    let texts: Vec<String> =
        documents.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    let statuses = ["PASS", "FAIL", "UNKNOWN", "UNKNOWN", "PASS", "FAIL", "UNKNOWN"];
    for ((text, status), (name, ..)) in texts.iter().zip(statuses).zip(NOMINALS) {
        let status = format!("<InspectionStatusEnum>{status}<");
        assert!(text.contains(&status), "{name}: {text}");
    }
    let rules = root().join("tests/end_to_end/qif3.xsd");
    assert_eq!(faults(&python, &rules, &documents), "");
    match std::env::var_os("ASPHERA_QIF_XSD") {
        Some(whole) => assert_eq!(faults(&python, Path::new(&whole), &documents), ""),
        None => skipped("QIF's own schemas: ASPHERA_QIF_XSD does not name QIFDocument.xsd"),
    }

    // The validator sees what it must: one mistake each.
    for (right, wrong) in [
        ("<Designator>10110-5</Designator>", "<Designation>10110-5</Designation>"),
        ("versionQIF=\"3.0.0\"", "versionQIF=\"3\""),
        ("<CharacteristicItemId>", "<CharacteristicItemId>9"),
        ("name=\"software\"", "name=\"part\""),
        ("<SIUnitName>meter<", "<SIUnitName>mm<"),
        ("n=\"2\"", "n=\"3\""),
    ] {
        let text = texts[0].replacen(right, wrong, 1);
        assert_ne!(text, texts[0], "{right}");
        let path = dir.path().join("wrong.xml");
        fs::write(&path, text).unwrap();
        assert_ne!(faults(&python, &rules, &[path]), "", "{wrong}");
    }
}
