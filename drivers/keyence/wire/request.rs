//! Requests on the command port.

use thiserror::Error;

use super::u32_at;

/// Series of controllers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// LJ-X8000.
    LjX8000,
    /// LJ-V7000.
    LjV7000,
}

/// Request to a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Models and serial numbers of controller and head, 06h.
    Units,
    /// Errors of the system, 04h.
    Errors,
    /// Start of a batch, 22h.
    StartMeasure,
    /// End of a batch, 23h.
    StopMeasure,
    /// One profile from the memory, 42h: the current one, which stays there.
    Profile,
    /// Preparation of the stream, 47h: from the next profile on.
    Prepare,
    /// Start of the stream, A0h, with the code that the preparation gave.
    Start {
        /// Start code.
        code: u32,
    },
    /// Stop of the stream, 48h.
    Stop,
}

/// Why bytes are no request.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum RequestError {
    /// Another series, or another protocol.
    #[error("a request of series {0:02x?}, expected 03 00 f0 00 or 01 00 f0 00")]
    Series([u8; 4]),
    /// The lengths contradict each other.
    #[error("a body of {body} bytes in a request of {length}, expected {length} - 12")]
    Length {
        /// Length of the request after this field.
        length: u32,
        /// Length of the body.
        body: u32,
    },
    /// A command that is not among [`Request`].
    #[error("command {0:02X}h with {1} bytes of arguments, which we do not know")]
    Command(u8, usize),
}

impl Series {
    const fn magic(self) -> [u8; 4] {
        match self {
            Series::LjX8000 => [0x03, 0x00, 0xF0, 0x00],
            Series::LjV7000 => [0x01, 0x00, 0xF0, 0x00],
        }
    }
}

impl Request {
    /// Number of the command.
    pub const fn command(self) -> u8 {
        match self {
            Request::Units => 0x06,
            Request::Errors => 0x04,
            Request::StartMeasure => 0x22,
            Request::StopMeasure => 0x23,
            Request::Profile => 0x42,
            Request::Prepare => 0x47,
            Request::Start { .. } => 0xA0,
            Request::Stop => 0x48,
        }
    }

    /// Name for a person, with the number.
    pub const fn name(self) -> &'static str {
        match self {
            Request::Units => "unit information (06h)",
            Request::Errors => "errors (04h)",
            Request::StartMeasure => "start of the batch (22h)",
            Request::StopMeasure => "end of the batch (23h)",
            Request::Profile => "one profile (42h)",
            Request::Prepare => "preparation of the stream (47h)",
            Request::Start { .. } => "start of the stream (A0h)",
            Request::Stop => "stop of the stream (48h)",
        }
    }

    /// Bytes of the request.
    pub fn encode(self, series: Series) -> Vec<u8> {
        let mut body = vec![self.command(), 0, 0, 0];
        match self {
            Request::Prepare => body.extend([FROM_NEXT, 0, 0, 0]),
            Request::Start { code } => {
                body.extend([0x47, 0, 0, 0]);
                body.extend(code.to_le_bytes());
            }
            Request::Profile => body.extend(CURRENT_PROFILE),
            Request::Units
            | Request::Errors
            | Request::StartMeasure
            | Request::StopMeasure
            | Request::Stop => {}
        }
        // A body has 20 bytes at most.
        let len = body.len() as u32;
        let mut bytes = (len + 12).to_le_bytes().to_vec();
        bytes.extend(series.magic());
        bytes.extend([0; 4]);
        bytes.extend(len.to_le_bytes());
        bytes.extend(body);
        bytes
    }

    /// Reads the request at the beginning of `bytes`, and its length. `None`: more bytes are needed.
    ///
    /// # Errors
    ///
    /// Why there is none; the length of what is there cannot be known then.
    pub fn decode(bytes: &[u8]) -> Result<Option<(Series, Request, usize)>, RequestError> {
        let Some(head) = bytes.first_chunk::<HEAD>() else { return Ok(None) };
        let [magic @ .., _, _, _, _, _, _, _, _] = head[4..].try_into().unwrap_or([0; 12]);
        let series = [Series::LjX8000, Series::LjV7000].into_iter().find(|it| it.magic() == magic);
        let series = series.ok_or(RequestError::Series(magic))?;
        let [length, body] = [0, 12].map(|at| u32_at(head, at).unwrap_or(0));
        if body.checked_add(12) != Some(length) || !(4..=LONGEST_BODY).contains(&body) {
            return Err(RequestError::Length { length, body });
        }
        let len = HEAD + body as usize;
        let Some(body) = bytes.get(HEAD..len) else { return Ok(None) };
        let arguments = &body[4..];
        let request = match (body[0], arguments) {
            (0x06, []) => Request::Units,
            (0x04, []) => Request::Errors,
            (0x22, []) => Request::StartMeasure,
            (0x23, []) => Request::StopMeasure,
            (0x42, [_, _, _, _, ..]) => Request::Profile,
            (0x47, [FROM_NEXT, 0, 0, 0]) => Request::Prepare,
            (0xA0, [0x47, 0, 0, 0, a, b, c, d]) => {
                Request::Start { code: u32::from_le_bytes([*a, *b, *c, *d]) }
            }
            (0x48, []) => Request::Stop,
            (command, arguments) => return Err(RequestError::Command(command, arguments.len())),
        };
        Ok(Some((series, request, len)))
    }
}

/// Bytes before the body.
const HEAD: usize = 16;

/// No body of ours is longer than a tenth of it.
const LONGEST_BODY: u32 = 256;

/// Where the stream begins: 0 where it ended last, 1 the oldest profile, 2 the next one.
const FROM_NEXT: u8 = 2;

/// Zero; bank active, position current; number 0; one profile, not erased.
const CURRENT_PROFILE: [u8; 16] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0];
