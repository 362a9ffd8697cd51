//! The page in a real browser while a demo runs: every plot drawn, no console error.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, root, skipped};

#[test]
fn the_page_shows_a_demo_live() {
    let folder = root().join("tests/browser");
    let chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
        .into_iter()
        .find(|path| Path::new(path).exists());
    let Some(chromium) = chromium else {
        return skipped("browser test: no chromium");
    };
    if !folder.join("node_modules/playwright-core").exists() {
        return skipped("browser test: playwright-core is not installed (npm ci in tests/browser)");
    }
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--points", "40000", "--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let line = daemon.line("page:", Duration::from_secs(60));
    let url = line.split_once("page: ").unwrap().1;
    let screenshots = std::env::var_os("ASPHERA_SCREENSHOTS");
    let mut check = Command::new("node");
    check.current_dir(&folder).args(["check.mjs", url, "--chromium", chromium, "--timeout", "120"]);
    check.args(["--sampling", "--regions", "--form"]);
    if let Some(folder) = screenshots {
        let folder = Path::new(&folder);
        check.arg("--screenshot").arg(folder.join("complete.png"));
        check.arg("--measuring-screenshot").arg(folder.join("measuring.png"));
    }
    let output = check.stdin(Stdio::null()).output().unwrap();
    assert!(
        output.status.success(),
        "{}\n{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}
