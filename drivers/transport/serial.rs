//! Serial ports.

use std::io;
use std::path::Path;

use serialport::{ClearBuffer, ErrorKind, SerialPort as _};
use tokio_serial::{SerialPortBuilderExt as _, SerialStream};

use crate::{FlowControl, OpenError, Parity, SerialSettings, holder_of_file};

/// Opens a serial port for this process alone and empties its input.
///
/// The system keeps other processes off a port that is open, but for those of the superuser: so it is looked up first
/// who has it.
pub(crate) fn open(settings: &SerialSettings) -> Result<SerialStream, OpenError> {
    let path = &settings.path;
    if let Some(holder) = holder_of_file(Path::new(path)) {
        return Err(OpenError::Held { path: path.clone(), holder });
    }
    let stream = tokio_serial::new(path, settings.baud_bd)
        .parity(match settings.parity {
            Parity::None => tokio_serial::Parity::None,
            Parity::Even => tokio_serial::Parity::Even,
            Parity::Odd => tokio_serial::Parity::Odd,
        })
        .stop_bits(if settings.two_stop_bits {
            tokio_serial::StopBits::Two
        } else {
            tokio_serial::StopBits::One
        })
        .flow_control(match settings.flow_control {
            FlowControl::None => tokio_serial::FlowControl::None,
            FlowControl::Hardware => tokio_serial::FlowControl::Hardware,
        })
        .open_native_async()
        .map_err(|error| match error.kind {
            // The C library checks that the kernel took the parity and says EINVAL if it did not.
            ErrorKind::InvalidInput | ErrorKind::Io(io::ErrorKind::InvalidInput)
                if settings.parity != Parity::None =>
            {
                OpenError::Parity { path: path.clone(), parity: settings.parity }
            }
            _ => OpenError::Serial { path: path.clone(), source: error.into() },
        })?;
    // Bytes that arrived while nobody listened belong to no connection.
    stream
        .clear(ClearBuffer::Input)
        .map_err(|error| OpenError::Serial { path: path.clone(), source: error.into() })?;
    Ok(stream)
}
