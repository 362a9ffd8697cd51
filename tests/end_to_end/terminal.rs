//! What the command line shows beside results: progress on a terminal, completions, pages of the manual.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use asphera_tests::{asphera, python, run, skipped};

/// Points of a cap of a sphere of 50 mm, as many as take some seconds to measure.
fn points(folder: &Path) -> (PathBuf, PathBuf) {
    let file = folder.join("points.xyz");
    let mut writer = std::io::BufWriter::new(fs::File::create(&file).unwrap());
    writeln!(writer, "x[mm] y[mm] z[mm]").unwrap();
    for index in 0..400 * 400 {
        let (x, y) = (0.05 * f64::from(index % 400 - 200), 0.05 * f64::from(index / 400 - 200));
        let z = 50.0 - (2500.0 - x * x - y * y).sqrt();
        writeln!(writer, "{x} {y} {z}").unwrap();
    }
    writer.flush().unwrap();
    let nominal = folder.join("sphere.toml");
    fs::write(&nominal, "[surface]\nkind = \"sphere\"\nradius_mm = 50\n").unwrap();
    (file, nominal)
}

fn words(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Runs a command under a terminal of its own, and prints what it showed there. The last line is its exit code.
const TERMINAL: &str = "
import os, pty, sys
shown = bytearray()
def read(fd):
    data = os.read(fd, 4096)
    shown.extend(data)
    return data
devnull = os.open(os.devnull, os.O_WRONLY)
stdout = os.dup(1)
os.dup2(devnull, 1)
status = pty.spawn(sys.argv[1:], read, lambda fd: b'')
os.dup2(stdout, 1)
sys.stdout.buffer.write(bytes(shown))
sys.stdout.buffer.write(b'\\n%d\\n' % os.waitstatus_to_exitcode(status))
";

/// What a command shows on a terminal; `None` where no Python is there to make one.
fn on_terminal(arguments: &[&str], environment: &[(&str, &str)]) -> Option<String> {
    let python = python("pty")?;
    let output = Command::new(python)
        .args(["-c", TERMINAL])
        .arg(asphera())
        .args(arguments)
        .env("TERM", "xterm")
        .envs(environment.iter().copied())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    // 11: the points were measured, and no verdict could be given.
    let has_ended = shown.ends_with("\n0\n") || shown.ends_with("\n11\n");
    assert!(has_ended, "{shown}{}", String::from_utf8_lossy(&output.stderr));
    Some(shown)
}

#[test]
fn progress_is_shown_on_a_terminal_and_cleared_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let (file, nominal) = points(folder.path());
    let measure = ["measure", words(&file), "--nominal", words(&nominal)];
    let Some(shown) = on_terminal(&measure, &[]) else { return };
    let drawn: Vec<&str> = shown.split("\r\x1b[K").collect();
    assert!(drawn.len() > 3, "{shown:?}");
    // Every line but the last, which is the result, is of this verb and ends with the time.
    for line in &drawn[1..drawn.len() - 1] {
        let is_progress = line.starts_with("measure: ") && line.ends_with(" s");
        assert!(line.is_empty() || is_progress, "{line:?}");
        assert!(line.len() < 80 && !line.contains('\n'), "{line:?}");
    }
    let stages: Vec<&str> = drawn.iter().filter_map(|line| line.split(',').next()).collect();
    assert!(shown.contains("of 160,000 points") || stages.len() > 3, "{stages:?}");
    // What stands after the last clearing is the result alone.
    let last = drawn[drawn.len() - 1];
    assert!(last.contains("points     160000 received"), "{last:?}");
    assert!(!last.contains('\x1b') && !last.contains("measure:"), "{last:?}");

    // A terminal that cannot clear a line gets none.
    let dumb = on_terminal(&measure, &[("TERM", "dumb")]).unwrap();
    assert!(!dumb.contains('\x1b') && !dumb.contains("measure:"), "{dumb:?}");
}

#[test]
fn nothing_but_text_goes_to_what_is_no_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let (file, nominal) = points(folder.path());
    let out = folder.path().join("out.csv");
    let [file, nominal, out] = [&file, &nominal, &out].map(|path| words(path));
    for command in [
        vec!["measure", file, "--nominal", nominal, "--log", "trace"],
        vec!["section", file, "--line", "-5,0,5,0"],
        vec!["export", file, "-o", out],
        vec!["measure", "no.xyz", "--nominal", nominal],
    ] {
        let output = run(&command);
        for stream in [&output.stdout, &output.stderr] {
            assert!(!stream.contains(&0x1B), "{command:?}: {}", String::from_utf8_lossy(stream));
            assert!(!stream.contains(&b'\r'), "{command:?}");
        }
    }
}

/// Log lines have colours on a terminal, and none where `NO_COLOR` asks for none.
#[test]
fn no_color_is_respected() {
    let folder = tempfile::tempdir().unwrap();
    let listen = ["demo", "--exit", "--points", "500", "--speed", "max", "--log", "info", "--out"];
    for (value, coloured) in [("", true), ("1", false)] {
        let out = folder.path().join(format!("out{value}"));
        let mut arguments = listen.to_vec();
        arguments.push(words(&out));
        let Some(shown) = on_terminal(&arguments, &[("NO_COLOR", value)]) else { return };
        assert!(shown.contains("INFO"), "{shown:?}");
        assert_eq!(shown.contains("\x1b[32m"), coloured, "{shown:?}");
    }
}

/// A program of this machine that says nothing about a text on its stdin; skipped where it is not there.
fn accepts(program: &str, arguments: &[&str], text: &[u8]) -> bool {
    let child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    let Ok(mut child) = child else {
        skipped(&format!("no {program} here"));
        return false;
    };
    child.stdin.take().unwrap().write_all(text).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty(), "{program}: {said}");
    true
}

#[test]
fn completions_are_accepted_by_their_shells() {
    for (shell, program, arguments) in [
        ("bash", "bash", vec!["-n"]),
        ("zsh", "zsh", vec!["-n"]),
        ("fish", "fish", vec!["--no-execute"]),
    ] {
        let output = run(["completions", shell]);
        assert_eq!(output.status.code(), Some(0));
        let script = String::from_utf8_lossy(&output.stdout).into_owned();
        for verb in ["measure", "export", "replay", "completions"] {
            assert!(script.contains(verb), "{shell}: {verb}");
        }
        accepts(program, &arguments, &output.stdout);
    }
    assert_eq!(run(["completions", "cmd"]).status.code(), Some(2));
}

#[test]
fn every_verb_has_a_page_that_is_typeset_without_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man1");
    assert_eq!(run(["man", words(&pages)]).status.code(), Some(0));
    let help = String::from_utf8(run(["--help"]).stdout).unwrap();
    let commands = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let verbs: Vec<&str> = commands
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|verb| *verb != "help")
        .collect();
    assert!(verbs.len() >= 15, "{verbs:?}");
    let mut names: Vec<String> = verbs.iter().map(|verb| format!("asphera-{verb}.1")).collect();
    names.push("asphera.1".to_owned());
    for name in &names {
        let page = fs::read(pages.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let text = String::from_utf8_lossy(&page);
        assert!(text.contains(".TH") && text.contains("Example"), "{name}");
        if !accepts("mandoc", &["-T", "lint", "-W", "warning"], &page) {
            accepts("groff", &["-man", "-ww", "-T", "utf8", "-K", "utf8"], &page);
        }
    }
    assert_eq!(fs::read_dir(&pages).unwrap().count(), names.len());
    // The page alone is that of asphera; pages that are there stay unless told otherwise.
    assert_eq!(run(["man"]).stdout, fs::read(pages.join("asphera.1")).unwrap());
    let again = run(["man", words(&pages)]);
    assert_eq!(again.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&again.stderr).contains("--force overwrites it"));
    assert_eq!(run(["man", words(&pages), "--force"]).status.code(), Some(0));
}

/// A full disk behind `> results.json` must not look like a measurement that is done.
#[test]
fn results_that_cannot_be_written_to_stdout_are_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let (file, nominal) = points(folder.path());
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(asphera());
    command.args(["sampling", "--json", "--nominal", words(&nominal), words(&file)]);
    let output = command.stdout(full).stderr(Stdio::piped()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write the results to stdout: No space left"), "{said}");
}

/// Whoever reads the messages may go before the work is done, as `head` does.
#[test]
fn messages_that_nobody_reads_end_no_command() {
    let folder = tempfile::tempdir().unwrap();
    let (file, nominal) = points(folder.path());
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = Command::new(asphera());
    command.args(["sampling", "--json", "--nominal", words(&nominal), words(&file)]);
    let output = command.stdout(Stdio::piped()).stderr(writer).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap();
}
