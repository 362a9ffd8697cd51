//! What the end-to-end tests share: the daemon's binary, measured surfaces, outside programs.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use serde_json::Value;

mod waiting;

use waiting::deadline;
pub use waiting::{now, snapshot, until, wait_for};

/// The folder of the project.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The daemon, built for the tests; or the one that `ASPHERA_BINARY` names, as built by `tests/run`.
pub fn asphera() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| {
        if let Some(built) = std::env::var_os("ASPHERA_BINARY") {
            return built.into();
        }
        // Tests lie in target/<profile>/deps, binaries beside that folder.
        let test = std::env::current_exe().expect("a running test has a file");
        let profile = test.parent().and_then(Path::parent).expect("tests lie in <profile>/deps");
        let status = Command::new(env!("CARGO"))
            .args(["build", "--quiet", "--bin", "asphera"])
            .args(profile.ends_with("release").then_some("--release"))
            .env("CARGO_TARGET_DIR", profile.parent().expect("profiles lie in the target folder"))
            .current_dir(root())
            .status()
            .expect("cargo runs");
        assert!(status.success(), "the daemon does not build");
        profile.join("asphera")
    })
}

/// Runs a command of the daemon to its end.
pub fn run<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    Command::new(asphera()).args(arguments).stdin(Stdio::null()).output().expect("asphera runs")
}

/// The one JSON object a command printed.
pub fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| {
        panic!(
            "stdout is no JSON object: {error}\nstdout: {}\nstderr: {}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        )
    })
}

/// A JSON file.
pub fn json_file(path: &Path) -> Value {
    let text =
        std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A number at a place like `/form/deviation/rms_nm`.
pub fn number(value: &Value, place: &str) -> f64 {
    value
        .pointer(place)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no number at {place} in {value:#}"))
}

/// A whole number at a place.
pub fn count(value: &Value, place: &str) -> u64 {
    value
        .pointer(place)
        .and_then(Value::as_u64)
        .unwrap_or_else(|| panic!("no count at {place} in {value:#}"))
}

/// The recording in an output folder.
pub fn recording(folder: &Path) -> PathBuf {
    std::fs::read_dir(folder)
        .expect("an output folder")
        .map(|entry| entry.expect("a readable folder").path())
        .find(|path| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("session-"))
        })
        .expect("a recording in the output folder")
}

/// A measured surface that lies beside the project; `None`, said on stderr, where it is not there.
pub fn data(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("ASPHERA_DATA")
        .map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    skipped(&format!("{name} not found in {}", folder.display()));
    None
}

/// A number of repetitions: `in_full` where `./tests/run --long` asks for studies in full length, else `usual`.
pub fn repetitions(usual: usize, in_full: usize) -> usize {
    if std::env::var_os("ASPHERA_LONG").is_some() { in_full } else { usual }
}

/// Says that a test was skipped, and why.
#[expect(clippy::print_stderr, reason = "what is skipped must be seen")]
pub fn skipped(why: &str) {
    eprintln!("skipped: {why}");
}

/// A Python that has these modules; `None`, said on stderr, where there is none.
pub fn python(modules: &str) -> Option<PathBuf> {
    let python = std::env::var_os("ASPHERA_PYTHON").map_or_else(|| "python3".into(), PathBuf::from);
    let found = Command::new(&python)
        .args(["-c", &format!("import {modules}")])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !found {
        skipped(&format!("{} cannot import {modules}", python.display()));
    }
    found.then_some(python)
}

/// A running program whose stderr (or stdout) is read line by line; killed when dropped.
pub struct Running {
    child: Child,
    lines: Receiver<String>,
    seen: Vec<String>,
}

impl Running {
    /// Starts a command and listens to its stderr.
    pub fn start(command: &mut Command) -> Running {
        let mut child = command
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let stderr = child.stderr.take().expect("stderr is piped");
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Running { child, lines, seen: Vec::new() }
    }

    /// The first line that holds `what`.
    pub fn line(&mut self, what: &str, limit: Duration) -> String {
        let until = deadline(limit);
        loop {
            match self.lines.recv_timeout(until.saturating_duration_since(now())) {
                Ok(line) => {
                    self.seen.push(line.clone());
                    if line.contains(what) {
                        return line;
                    }
                }
                Err(RecvTimeoutError::Timeout) => {
                    panic!("no line with {what:?} in {limit:?}; seen: {:#?}", self.seen)
                }
                Err(RecvTimeoutError::Disconnected) => {
                    panic!("the program ended without a line with {what:?}; seen: {:#?}", self.seen)
                }
            }
        }
    }

    /// The number of its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal: `TERM`, `KILL`, `INT`.
    pub fn signal(&self, name: &str) {
        let status =
            Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status();
        assert!(status.expect("kill runs").success());
    }

    /// Waits for the end and gives stdout.
    pub fn wait(mut self, limit: Duration) -> Output {
        let status = wait_for("end of the program", limit, || {
            let status = self.child.try_wait().expect("a child can be waited for");
            status.ok_or_else(|| self.seen.join("\n"))
        });
        let mut stdout = Vec::new();
        if let Some(mut pipe) = self.child.stdout.take() {
            std::io::Read::read_to_end(&mut pipe, &mut stdout).expect("stdout can be read");
        }
        // It has ended; what it started may hold the other end of the pipe still.
        while let Ok(line) = self.lines.recv_timeout(Duration::from_millis(200)) {
            self.seen.push(line);
        }
        Output { status, stdout, stderr: self.seen.join("\n").into_bytes() }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended; then there is nothing to kill.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Address and token of a page, from the line that prints them.
pub fn page(line: &str) -> (String, String) {
    let (_, url) = line.split_once("http://").expect("the line holds an address");
    let (address, token) = url.trim().split_once("/#token=").expect("the address holds a token");
    (address.to_owned(), token.to_owned())
}

/// One request over HTTP: the status and the body.
pub fn http(address: &str, method: &str, path: &str, headers: &[(&str, &str)]) -> (u16, Vec<u8>) {
    request(address, method, path, headers, "")
}

/// A POST with the header `Authorization` and a body.
pub fn post(address: &str, path: &str, authorization: &str, body: &str) -> (u16, Vec<u8>) {
    request(address, "POST", path, &[("Authorization", authorization)], body)
}

fn request(
    address: &str,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &str,
) -> (u16, Vec<u8>) {
    use std::io::{Read as _, Write as _};
    let mut stream = std::net::TcpStream::connect(address).expect("the page listens");
    let mut request = format!(
        "{method} {path} HTTP/1.1\r\nConnection: close\r\nContent-Length: {}\r\n",
        body.len()
    );
    if !headers.iter().any(|(name, _)| *name == "Host") {
        request.push_str(&format!("Host: {address}\r\n"));
    }
    for (name, value) in headers {
        request.push_str(&format!("{name}: {value}\r\n"));
    }
    request.push_str("\r\n");
    request.push_str(body);
    stream.write_all(request.as_bytes()).expect("the request can be sent");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).expect("the answer can be read");
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("an answer has a head");
    let head = String::from_utf8_lossy(&answer[..end]).into_owned();
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
    let body = answer.split_off(end + 4);
    if head.to_lowercase().contains("transfer-encoding: chunked") {
        return (status, unchunk(&body));
    }
    (status, body)
}

fn unchunk(mut body: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    while let Some(end) = body.windows(2).position(|two| two == b"\r\n") {
        let size = usize::from_str_radix(&String::from_utf8_lossy(&body[..end]), 16)
            .expect("a chunk size");
        whole.extend_from_slice(&body[end + 2..end + 2 + size]);
        body = &body[end + 2 + size + 2..];
        if size == 0 {
            break;
        }
    }
    whole
}
