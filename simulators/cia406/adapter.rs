//! What a host has set in the adapter, and what the adapter says to its commands.

use asphera_slcan::{AdapterStatus, CR, Command};

/// What a host has set in the adapter.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Adapter {
    bit_rate_set: bool,
    pub(crate) open: bool,
    pub(crate) listen_only: bool,
    pub(crate) timestamps: bool,
}

impl Adapter {
    /// Does a command and says CR with what it asks for; or does not.
    pub(crate) fn command(&mut self, command: Command, said: &mut Vec<u8>) -> bool {
        let allowed = match command {
            Command::BitRate(_) | Command::DataBitRate(_) | Command::Registers { .. } => !self.open,
            Command::Open | Command::Listen => !self.open && self.bit_rate_set,
            Command::Close | Command::Status => self.open,
            Command::Timestamps(_)
            | Command::AcceptanceCode(_)
            | Command::AcceptanceMask(_)
            | Command::AutoPoll(_) => !self.open,
            Command::Version | Command::SerialNumber => true,
            Command::PollOne | Command::PollAll | Command::Uart(_) | Command::FilterMode(_) => {
                false
            }
        };
        if !allowed {
            return false;
        }
        match command {
            Command::BitRate(_) | Command::Registers { .. } => self.bit_rate_set = true,
            Command::Open | Command::Listen => {
                self.open = true;
                self.listen_only = command == Command::Listen;
            }
            Command::Close => self.open = false,
            Command::Timestamps(on) => self.timestamps = on,
            Command::Version => said.extend(b"V1013"),
            Command::SerialNumber => said.extend(b"NS406"),
            Command::Status => {
                said.extend(format!("F{:02X}", AdapterStatus::empty().bits()).bytes());
            }
            _ => {}
        }
        said.push(CR);
        true
    }
}
