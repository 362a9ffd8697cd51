//! The page in a real browser while a demo runs: every plot drawn, no console error.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, root, skipped};

/// The folder of the browser test and the browser; `None`, said on stderr, where one is absent.
pub(super) fn browser() -> Option<(PathBuf, &'static str)> {
    let folder = root().join("tests/browser");
    let chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
        .into_iter()
        .find(|path| Path::new(path).exists());
    let Some(chromium) = chromium else {
        skipped("browser test: no chromium");
        return None;
    };
    if !folder.join("node_modules/playwright-core").exists() {
        skipped("browser test: playwright-core is not installed (npm ci in tests/browser)");
        return None;
    }
    Some((folder, chromium))
}

/// Looks at the page of a demo; `name` is that of its screenshots. The browser is there first: a demo
/// lasts seconds, and a busy machine may need more of them to start a browser.
fn watch(demo: &[&str], options: &[&str], name: &str) {
    let Some((folder, chromium)) = browser() else { return };
    let out = tempfile::tempdir().unwrap();
    let mut check = Command::new("node");
    check.current_dir(&folder).args(["check.mjs", "-", "--chromium", chromium, "--timeout", "300"]);
    check.args(options);
    if let Some(folder) = std::env::var_os("ASPHERA_SCREENSHOTS") {
        let folder = Path::new(&folder);
        check.arg("--screenshot").arg(folder.join(format!("{name}complete.png")));
        check.arg("--measuring-screenshot").arg(folder.join(format!("{name}measuring.png")));
    }
    let mut check =
        check.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(check.stderr.take().unwrap());
    let mut stderr = String::new();
    said.read_line(&mut stderr).unwrap();
    assert!(stderr.starts_with("ready"), "the browser did not start: {stderr}");
    let mut daemon = Running::start(
        Command::new(asphera())
            .arg("demo")
            .args(demo)
            .args(["--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let line = daemon.line("page:", Duration::from_secs(60));
    let url = line.split_once("page: ").unwrap().1;
    writeln!(check.stdin.take().unwrap(), "{url}").unwrap();
    let output = check.wait_with_output().unwrap();
    said.read_to_string(&mut stderr).unwrap();
    assert!(output.status.success(), "{}\n{stderr}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn the_page_shows_a_demo_live() {
    watch(&["--points", "40000"], &["--sampling", "--regions", "--form"], "");
}

#[test]
fn the_page_lists_the_parts_of_a_tray_while_it_is_scanned() {
    watch(&["--scene", "tray", "--speed", "0.5"], &["--parts"], "tray-");
}

#[test]
fn the_page_draws_the_contour_of_a_blade_while_it_is_scanned() {
    watch(&["--scene", "blade"], &["--contour"], "blade-");
}
