//! Commands to the device and the frame of its answers.
//!
//! A command is `$`, at least three capital letters, arguments separated by spaces, CR. On `$` the
//! device finishes the telegram it is sending, then echoes every character it receives up to CR,
//! answers in text if there is something to say, and ends with `ready` CR LF; then data go on (CR,
//! dollar protocol). Printed dialogues: `$SHZ 1000[CR]ready[CR/LF]` for a setting and
//! `$SHZ ? 1000ready[CR/LF]` for a question (C p. 55), so the text may stand right before `ready`.

/// What ends every answer (C p. 55 and 61).
pub const READY: &[u8] = b"ready\r\n";

/// What the device answers to a value it does not accept (CLS p. 48, command SHZ).
pub const NOT_VALID: &str = "not valid";

/// The commands the driver uses.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// `STO`: stop sending data on this connection (C p. 61).
    Stop,
    /// `STA`: start sending data on this connection (C p. 60).
    Start,
    /// `BIN`: telegrams in binary.
    Binary,
    /// `SODX`: which signals a telegram holds, in this order (C p. 55, CLS p. 49).
    Output(Vec<u16>),
    /// `SHZ`: exposures per second in Hz (C p. 55, CLS p. 48).
    SampleRate(f64),
    /// `AVD`: exposures averaged into one telegram.
    Averaging(u16),
    /// `CTN`: measure without waiting for triggers.
    FreeRun,
    /// `TRE`: one exposure for each trigger (C p. 62).
    TriggerEach,
    /// `SCA ?`: the full scale in µm (CLS p. 47).
    AskFullScale,
}

impl Command {
    /// The command without its closing CR, which is also the echo to wait for.
    pub fn text(&self) -> String {
        match self {
            Command::Stop => "$STO".into(),
            Command::Start => "$STA".into(),
            Command::Binary => "$BIN".into(),
            Command::Output(signals) => {
                signals.iter().fold("$SODX".into(), |text, id| format!("{text} {id}"))
            }
            Command::SampleRate(rate_hz) => format!("$SHZ {rate_hz}"),
            Command::Averaging(exposures) => format!("$AVD {exposures}"),
            Command::FreeRun => "$CTN".into(),
            Command::TriggerEach => "$TRE".into(),
            Command::AskFullScale => "$SCA ?".into(),
        }
    }

    /// The bytes to send: [`Command::text`] and CR.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = self.text().into_bytes();
        bytes.push(b'\r');
        bytes
    }
}

/// A command as the device receives it: name and arguments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// The capital letters after `$`.
    pub name: String,
    /// Arguments; a comma separates like a space.
    pub arguments: Vec<String>,
}

impl Request {
    /// Reads a line from `$` to before CR. `None` where there are not at least three capital letters
    /// or where the line is no ASCII.
    pub fn parse(line: &[u8]) -> Option<Request> {
        let text = std::str::from_utf8(line.strip_prefix(b"$")?).ok()?;
        let mut words = text.split([' ', ',']).filter(|word| !word.is_empty());
        let name = words.next()?;
        (name.len() >= 3 && name.bytes().all(|byte| byte.is_ascii_uppercase()))
            .then(|| Request { name: name.into(), arguments: words.map(Into::into).collect() })
    }

    /// Whether the command asks (`?`) instead of setting.
    pub fn is_question(&self) -> bool {
        self.arguments.first().is_some_and(|argument| argument == "?")
    }
}

/// Splits what follows an echo into the answer's text, trimmed, and the number of bytes up to and
/// including `ready` CR LF. `None` while the answer is incomplete. Linear in the length.
pub fn split_answer(bytes: &[u8]) -> Option<(String, usize)> {
    let text_len = bytes.windows(READY.len()).position(|window| window == READY)?;
    let text = String::from_utf8_lossy(&bytes[..text_len]).trim().to_owned();
    Some((text, text_len + READY.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_back() {
        let request = Request::parse(b"$SODX 83, 16640,16641").unwrap();
        assert_eq!(request.name, "SODX");
        assert_eq!(request.arguments, ["83", "16640", "16641"]);
        assert!(Request::parse(b"$SHZ ?").unwrap().is_question());
        assert!(!Request::parse(b"$SHZ 1000").unwrap().is_question());
        for no_command in [&b"$ST"[..], b"STO", b"$sto", b"$", b"", b"$ST\xFF"] {
            assert_eq!(Request::parse(no_command), None);
        }
    }

    #[test]
    fn answers_end_at_ready() {
        assert_eq!(split_answer(b"\rready\r\n\xFF\xFF"), Some((String::new(), 8)));
        assert_eq!(split_answer(b" 3320ready\r\n"), Some(("3320".into(), 12)));
        assert_eq!(split_answer(b"\r\nnot valid\r\nready\r\n"), Some(("not valid".into(), 20)));
        assert_eq!(split_answer(b"\rready\r"), None);
    }
}
