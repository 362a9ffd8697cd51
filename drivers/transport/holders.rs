//! Who has a port or a file open: for messages that say what to end.
//!
//! It is read from `/proc`, which shows the processes of the same user, and all of them to the superuser. A holder that is
//! not seen is not named.

use std::fmt;
use std::fs;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};

/// A process that holds something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Number of the process.
    pub process: u32,
    /// Its command line, shortened.
    pub command: String,
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {} ({})", self.process, self.command)
    }
}

/// Another process that has a file or a device open. The other end of a pseudo terminal counts for none.
///
/// O(open files of the system).
pub fn holder_of_file(path: &Path) -> Option<Holder> {
    let path = fs::canonicalize(path).ok()?;
    holder(&path, |open| !open.iter().any(|one| one == Path::new("/dev/ptmx")))
}

/// The process that listens on a TCP address, or on its port at every address. This one counts, too.
///
/// O(open files of the system).
pub fn holder_of_port(address: SocketAddr) -> Option<Holder> {
    let inode = ["/proc/net/tcp", "/proc/net/tcp6"].iter().find_map(|table| {
        let table = fs::read_to_string(table).ok()?;
        table.lines().skip(1).find_map(|line| listening(line, address))
    })?;
    holder(&PathBuf::from(format!("socket:[{inode}]")), |_| true)
}

/// The inode of a line of `/proc/net/tcp` (proc_net(5)), if it listens there.
fn listening(line: &str, address: SocketAddr) -> Option<u64> {
    let mut fields = line.split_ascii_whitespace();
    let (local, state) = (fields.nth(1)?, fields.nth(1)?);
    let (ip, port) = local.split_once(':')?;
    let everywhere = ip.bytes().all(|digit| digit == b'0');
    let same = match address.ip() {
        IpAddr::V4(v4) => ip == format!("{:08X}", u32::from_le_bytes(v4.octets())),
        // As four words of the host's order; few machines have other addresses than these.
        IpAddr::V6(v6) => v6.is_loopback() && ip.ends_with("01000000"),
    };
    let there = u16::from_str_radix(port, 16).ok()? == address.port();
    let any = address.ip().is_unspecified();
    (state == LISTEN && there && (same || everywhere || any))
        .then(|| fields.nth(5)?.parse().ok())?
}

fn holder(target: &Path, counts: impl Fn(&[PathBuf]) -> bool) -> Option<Holder> {
    let processes = fs::read_dir("/proc").ok()?;
    processes.flatten().find_map(|entry| {
        let process: u32 = entry.file_name().to_str()?.parse().ok()?;
        let is_file = target.is_absolute();
        if is_file && process == std::process::id() {
            return None;
        }
        let files = fs::read_dir(entry.path().join("fd")).ok()?;
        let open: Vec<PathBuf> =
            files.flatten().filter_map(|file| fs::read_link(file.path()).ok()).collect();
        let holds = open.iter().any(|one| one == target) && counts(&open);
        holds.then(|| Holder { process, command: command(&entry.path()) })
    })
}

fn command(process: &Path) -> String {
    let words = fs::read(process.join("cmdline")).unwrap_or_default();
    let words = String::from_utf8_lossy(&words).replace('\0', " ");
    let words: String = words.trim().chars().filter(|one| !one.is_control()).collect();
    match words.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} …", &words[..end]),
        None => words,
    }
}

/// State of a socket that listens.
const LISTEN: &str = "0A";
/// Characters of a command line that are shown.
const LONGEST: usize = 60;

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::Duration;

    use super::*;

    /// Lines of a Linux 6.1 machine: 127.0.0.1:7717 and [::]:22 listen, and a connection.
    #[test]
    fn lines_of_the_system_are_read() {
        let head = "0: 0100007F:1E25 00000000:0000 0A 00000000:00000000 00:00000000 00000000";
        let line = format!("{head}  1000        0 31337 1 0000000000000000 100 0 0 10 0");
        let at = |text: &str| text.parse().unwrap();
        assert_eq!(listening(&line, at("127.0.0.1:7717")), Some(31337));
        assert_eq!(listening(&line, at("0.0.0.0:7717")), Some(31337));
        assert_eq!(listening(&line, at("127.0.0.1:7718")), None);
        assert_eq!(listening(&line, at("10.0.0.1:7717")), None);
        assert_eq!(listening(&line.replace(" 0A ", " 01 "), at("127.0.0.1:7717")), None);
        let all = line.replace("0100007F", "00000000000000000000000000000000");
        assert_eq!(listening(&all, at("10.0.0.1:7717")), Some(31337));
        assert_eq!(listening("", at("10.0.0.1:7717")), None);
    }

    #[test]
    fn a_port_of_this_process_is_its_own() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let holder = holder_of_port(listener.local_addr().unwrap()).unwrap();
        assert_eq!(holder.process, std::process::id());
    }

    /// Children that other tests start hold every file until their program begins, and a program's words are
    /// written a moment after it began: so each state is awaited.
    #[test]
    fn a_file_of_another_process_is_found() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let seen = |wanted: Option<&Holder>| {
            (0..2_000).any(|_| {
                thread::park_timeout(Duration::from_millis(5));
                holder_of_file(file.path()).as_ref() == wanted
            })
        };
        assert!(seen(None), "this process does not count");
        let mut child = std::process::Command::new("sleep")
            .arg("60")
            .stdin(file.reopen().unwrap())
            .spawn()
            .unwrap();
        let sleeper = Holder { process: child.id(), command: "sleep 60".to_owned() };
        assert!(seen(Some(&sleeper)), "{:?}", holder_of_file(file.path()));
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
