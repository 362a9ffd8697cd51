//! The report of a recording and of a file, read and printed.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use asphera_tests::{json, recording, root, run, skipped};

use crate::demo::timeless;

fn failure(arguments: &[&str]) -> String {
    ends_with(1, arguments)
}

/// The words of a command that ends with an exit code.
fn ends_with(code: i32, arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(code));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_recorded_demo_makes_the_same_report_every_time() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let demo = run(["demo", "--exit", "--points", "20000", "--speed", "max", "--out", folder]);
    assert_eq!(demo.status.code(), Some(0), "{}", String::from_utf8_lossy(&demo.stderr));
    let session = recording(out.path());
    let (page, qif) = (out.path().join("report.html"), out.path().join("report.xml"));
    let report = || {
        let output = run([
            "report",
            session.to_str().unwrap(),
            "-o",
            page.to_str().unwrap(),
            "--qif",
            qif.to_str().unwrap(),
            "--part",
            "Lens <7>",
            "--force",
        ]);
        assert!(
            matches!(output.status.code(), Some(0 | 10 | 11)),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        (fs::read_to_string(&page).unwrap(), fs::read_to_string(&qif).unwrap())
    };
    let (html, xml) = report();
    assert_eq!((html.clone(), xml.clone()), report(), "two runs differ");
    let id = session.file_name().unwrap().to_string_lossy().into_owned();
    for words in [
        "Form deviation: Lens &lt;7&gt;",
        "data:image/png;base64,",
        "primary astigmatism 45°",
        "RMSi",
        "ISO 10110-5:2015",
        "SHA-256",
        "manifest.json",
        &id,
        env!("CARGO_PKG_VERSION"),
        "Links and devices",
    ] {
        assert!(html.contains(words), "{words} is missing");
    }
    // The only address is the name of the language it is written in.
    let addresses: Vec<&str> = html.split("http").skip(1).collect();
    assert_eq!(addresses.len(), 1);
    assert!(addresses[0].starts_with("://www.w3.org/1999/xhtml"), "{}", addresses[0]);
    assert!(xml.contains("<OtherFormCharacteristicMeasurement") && xml.contains(&id));
    prints(&page, out.path());
}

/// What `--out` leaves is what the other commands take, and nothing of the bench beside it.
#[test]
fn a_folder_of_a_demo_is_the_session_in_it() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let demo = ["demo", "--exit", "--points", "2000", "--speed", "max", "--out", folder];
    assert!(run(demo).status.success());
    for left in ["ports", ".asphera.lock"] {
        assert!(!out.path().join(left).exists(), "{left} is left behind");
    }
    let session = recording(out.path());
    let figures = |source: &str| {
        let output = run(["replay", source, "--json"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        timeless(json(&output))
    };
    assert_eq!(figures(folder), figures(session.to_str().unwrap()));
    let page = out.path().join("paper.html");
    let paper = ["report", folder, "--serial", "17", "--operator", "Ada L.", "-o"];
    let output = run(paper.into_iter().chain([page.to_str().unwrap()]));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("no. 17") && html.contains("Ada L.") && html.contains("manifest.json"));
    let paper = fs::read_to_string(session.join("report.html")).unwrap();
    assert!(paper.contains("demo --exit --points 2000"), "the command is the one that ran");
    assert!(failure(&demo).contains("--force overwrites it"));
}

/// Prints a page in a browser, where there is one, to several sheets.
fn prints(page: &Path, folder: &Path) {
    let chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
        .into_iter()
        .find(|path| Path::new(path).exists());
    let Some(chromium) = chromium else {
        return skipped("printing a report: no chromium");
    };
    let pdf = folder.join("report.pdf");
    let output = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"])
        .arg(format!("--user-data-dir={}", folder.join("browser").display()))
        .arg(format!("--print-to-pdf={}", pdf.display()))
        .arg(format!("file://{}", page.display()))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let pdf = fs::read(pdf).unwrap();
    assert!(pdf.starts_with(b"%PDF-"));
    // The node above the sheets is of the type Pages.
    let is_sheet = |bytes: &&[u8]| bytes.starts_with(b"/Type /Page") && bytes[11] != b's';
    let sheets = pdf.windows(12).filter(is_sheet).count();
    assert!((4..=6).contains(&sheets), "{sheets} sheets");
}

#[test]
fn a_file_needs_its_nominal_and_a_recording_has_its_own() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("flat.xyz");
    let rows = (0..900).map(|index| {
        let (x, y) = (f64::from(index % 30), f64::from(index / 30));
        format!("{} {} {}\n", x * 0.1, y * 0.1, 1e-5 * (x - y))
    });
    fs::write(&file, rows.collect::<String>()).unwrap();
    let (file, out) = (file.to_str().unwrap(), dir.path().join("out.html"));
    let out = out.to_str().unwrap();
    let nominal = root().join("config/examples/flat.toml");
    let nominal = nominal.to_str().unwrap();

    let words = ends_with(2, &["report", file, "-o", out]);
    assert!(words.contains("--nominal"), "{words}");
    let words = failure(&["report", dir.path().to_str().unwrap(), "-o", out, "--nominal", nominal]);
    assert!(words.contains("expected a folder session-…"), "{words}");
    let words = failure(&["report", file, "--nominal", nominal, "-o", file]);
    assert!(words.contains("is the file that is read"), "{words}");
    let words = ends_with(2, &["report", file, "--nominal", nominal, "-o", out, "--qif", out]);
    assert!(words.contains("--qif"), "{words}");

    let output = run(["report", file, "--nominal", nominal, "-o", out]);
    assert!(
        matches!(output.status.code(), Some(0 | 10 | 11)),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let html = fs::read_to_string(out).unwrap();
    assert!(html.contains("Form deviation: flat.xyz") && html.contains("at a date not stated"));
    assert!(html.contains("flat.toml"), "the nominal is one of the files");
}
