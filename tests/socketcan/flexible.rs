//! CAN FD frames through a link, against the bytes of the kernel's `struct canfd_frame`.

use std::io::{Read as _, Write as _};

use asphera_link::{CanFrame, CanId, FD_LENGTHS, FD_RECORD_LEN, FdFlags};
use asphera_transport::{LinkCommand, What};
use socketcan::{CanFdSocket, Socket as _};

use crate::frames::{PATIENCE, Probe};
use crate::interface::Interface;
use crate::report::Report;

/// Frames of every length and flag go both ways, classic ones among them.
pub(crate) async fn round_trips(interface: &Interface, report: &mut Report) {
    let result = async {
        interface.set_mtu(72)?;
        let mut probe = Probe::start(interface.name(), 16)?;
        let epoch = probe.opened().await?;
        let words = |error: std::io::Error| error.to_string();
        let peer = CanFdSocket::open(interface.name()).map_err(words)?;
        peer.set_read_timeout(PATIENCE).map_err(words)?;
        let frames = frames();
        for frame in &frames {
            let record = frame.to_record();
            probe.link.command(LinkCommand::Send { epoch, bytes: record.clone() });
            let mut got = [0; FD_RECORD_LEN];
            let count = peer.as_raw_socket().read(&mut got).map_err(words)?;
            if got[..count] != record[..] {
                return Err(format!(
                    "sent {record:02X?}, the kernel carried {:02X?}",
                    &got[..count]
                ));
            }
            peer.as_raw_socket().write_all(&record).map_err(words)?;
            match probe.next().await? {
                What::Received(bytes) if bytes == record => {}
                other => return Err(format!("the kernel carried {record:02X?}, got {other:?}")),
            }
        }
        Ok(format!(
            "{} frames each way, 0 to 64 bytes, BRS and ESI, classic ones between them",
            frames.len()
        ))
    };
    report.check("CAN FD frames round trip", result.await);
}

/// An interface for classic frames refuses one of CAN FD, and the link says how it is set up.
pub(crate) async fn refused(interface: &Interface, report: &mut Report) {
    let result = async {
        interface.set_mtu(16)?;
        let mut probe = Probe::start(interface.name(), 16)?;
        let epoch = probe.opened().await?;
        let bytes = frames()[0].to_record();
        probe.link.command(LinkCommand::Send { epoch, bytes });
        match probe.next().await? {
            What::Closed(words) if words.contains("fd on") => Ok(format!("Closed \"{words}\"")),
            other => Err(format!("expected Closed with \"fd on\", got {other:?}")),
        }
    };
    report.check("CAN FD on a classic interface", result.await);
    if let Err(why) = interface.set_mtu(72) {
        report.check("interface for CAN FD", Err(why));
    }
}

fn frames() -> Vec<CanFrame> {
    let mut all = Vec::new();
    for id in [CanId::Standard(0x123), CanId::Extended(0x1234_5678)] {
        for len in FD_LENGTHS {
            for bits in 0..4_u8 {
                let flags =
                    FdFlags { bit_rate_switch: bits & 1 != 0, error_passive: bits & 2 != 0 };
                let data: Vec<u8> = (0..len).map(|k| k as u8 ^ 0xA5).collect();
                all.extend(CanFrame::fd_frame(id, &data, flags));
            }
            all.extend(CanFrame::data_frame(id, &[len as u8]));
        }
    }
    all
}
