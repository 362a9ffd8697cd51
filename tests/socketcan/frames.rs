//! Single frames through a link, against the bytes of the kernel's `struct can_frame`.

use std::time::Duration;

use asphera_link::RECORD_LEN;
use asphera_transport::{
    Backoff, Endpoint, Link, LinkCommand, LinkEvent, LinkSettings, What, can_interfaces,
};
use socketcan::tokio::CanSocket;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, timeout};

use crate::interface::Interface;
use crate::report::{Report, note};

/// A link and what it tells.
pub(crate) struct Probe {
    pub(crate) link: Link,
    pub(crate) events: mpsc::Receiver<LinkEvent>,
}

impl Probe {
    /// A link to a CAN interface with room for `room` events.
    pub(crate) fn start(interface: &str, room: usize) -> Result<Probe, String> {
        Probe::with_times(interface, room, false)
    }

    /// The same, which asks for the times of the controller or not.
    pub(crate) fn with_times(
        interface: &str,
        room: usize,
        timestamps: bool,
    ) -> Result<Probe, String> {
        let (events, receiver) = mpsc::channel(room);
        let backoff = Backoff::try_new(Duration::from_millis(20), Duration::from_millis(200), 1)
            .map_err(|error| error.to_string())?;
        let endpoint = Endpoint::SocketCan { interface: interface.to_owned(), timestamps };
        let link = Link::spawn(LinkSettings { index: 0, endpoint, backoff }, events);
        Ok(Probe { link, events: receiver })
    }

    pub(crate) async fn next(&mut self) -> Result<What, String> {
        match timeout(PATIENCE, self.events.recv()).await {
            Ok(Some(event)) => Ok(event.what),
            Ok(None) => Err("the link ended".to_owned()),
            Err(_) => Err(format!("the link told nothing for {PATIENCE:?}")),
        }
    }

    pub(crate) async fn opened(&mut self) -> Result<u64, String> {
        match self.next().await? {
            What::Opened { epoch } => Ok(epoch),
            other => Err(format!("expected Opened, got {other:?}")),
        }
    }
}

/// A missing interface is named, and so is one that is no CAN interface.
pub(crate) async fn missing_interface(report: &mut Report) {
    for interface in ["nocan9", "lo"] {
        let result = async {
            let mut probe = Probe::start(interface, 16)?;
            for _ in 0..2 {
                match probe.next().await? {
                    What::OpenFailed(words) if words.contains(interface) => {}
                    other => {
                        return Err(format!("expected OpenFailed with its name, got {other:?}"));
                    }
                }
            }
            match probe.next().await? {
                What::OpenFailed(words) => Ok(format!("\"{words}\"")),
                other => Err(format!("expected OpenFailed again, got {other:?}")),
            }
        };
        report.check(&format!("open failed {interface}"), result.await);
    }
}

/// The interface is among those listed.
pub(crate) fn listed(interface: &Interface, report: &mut Report) {
    let found = can_interfaces();
    let result = match found.iter().find(|can| can.name == interface.name()) {
        Some(can) => Ok(format!("{} is {}", can.name, can.state)),
        None => Err(format!("{} is not among {found:?}", interface.name())),
    };
    report.check("interfaces listed", result);
}

/// Data and remote frames, standard and extended, go both ways with every bit.
pub(crate) async fn round_trips(interface: &Interface, report: &mut Report) {
    let result = async {
        let mut probe = Probe::start(interface.name(), 16)?;
        let epoch = probe.opened().await?;
        let mut peer = CanSocket::open(interface.name()).map_err(|error| error.to_string())?;
        let records = records();
        for record in &records {
            probe.link.command(LinkCommand::Send { epoch, bytes: record.to_vec() });
            let got = read(&mut peer).await?;
            if got != *record {
                return Err(format!("sent {record:02X?}, the kernel carried {got:02X?}"));
            }
            peer.write_all(record).await.map_err(|error| error.to_string())?;
            match probe.next().await? {
                What::Received(bytes) if bytes == record => {}
                other => return Err(format!("the kernel carried {record:02X?}, got {other:?}")),
            }
        }
        Ok(format!("{} frames each way, standard, extended, remote, 0 to 8 bytes", records.len()))
    };
    report.check("frames round trip", result.await);
}

/// Error frames of the controller become bus errors in words, and the connection stays.
pub(crate) async fn bus_errors(interface: &Interface, report: &mut Report) {
    // <linux/can/error.h>: class bits in the identifier, detail in the data.
    let cases: [(&str, [u8; RECORD_LEN], &str); 3] = [
        ("bus-off", [0x40, 0, 0, 0x20, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], "bus off"),
        ("error passive", [0x04, 0, 0, 0x20, 8, 0, 0, 0, 0, 0x30, 0, 0, 0, 0, 0, 0], "passive"),
        (
            "all classes",
            [0xFF, 0x03, 0, 0x20, 8, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255],
            "",
        ),
    ];
    for (name, record, word) in cases {
        let result = async {
            let mut probe = Probe::start(interface.name(), 16)?;
            probe.opened().await?;
            let mut peer = CanSocket::open(interface.name()).map_err(|error| error.to_string())?;
            peer.write_all(&record).await.map_err(|error| error.to_string())?;
            let words = match probe.next().await? {
                What::BusError(words) if words.to_lowercase().contains(word) => words,
                other => return Err(format!("expected BusError with \"{word}\", got {other:?}")),
            };
            let after = records()[0];
            peer.write_all(&after).await.map_err(|error| error.to_string())?;
            match probe.next().await? {
                What::Received(bytes) if bytes == after => Ok(format!("\"{words}\"")),
                other => Err(format!("expected the frame after it, got {other:?}")),
            }
        };
        report.check(&format!("bus error {name}"), result.await);
    }
}

/// More frames at once than the transmit queue holds are sent all the same, in order.
pub(crate) async fn full_queue(interface: &Interface, report: &mut Report) {
    const FRAMES: u8 = 64;
    let name = "full transmit queue";
    if let Err(why) = interface.slow("500kbit") {
        return report.skip(name, &why);
    }
    let result = async {
        let mut probe = Probe::start(interface.name(), 16)?;
        let epoch = probe.opened().await?;
        let mut peer = CanSocket::open(interface.name()).map_err(|error| error.to_string())?;
        let bytes = (0..FRAMES).flat_map(numbered).collect();
        probe.link.command(LinkCommand::Send { epoch, bytes });
        for place in 0..FRAMES {
            let got = tokio::select! {
                got = read(&mut peer) => got?,
                told = probe.next() => return Err(format!("after {place} of {FRAMES} frames: {:?}", told?)),
            };
            if got != numbered(place) {
                return Err(format!("frame {place} is {got:02X?}"));
            }
        }
        Ok(format!("{FRAMES} frames in order through a queue of 10 at 500 kbit/s"))
    };
    report.check(name, result.await);
    if let Err(why) = interface.fast() {
        report.check("transmit queue as before", Err(why));
    }
}

/// A queue that does not drain, as on a bus where nobody acknowledges, closes the link instead of holding it
/// for ever.
pub(crate) async fn stalled_queue(interface: &Interface, report: &mut Report) {
    let name = "stalled transmit queue";
    if let Err(why) = interface.slow("10bit") {
        return report.skip(name, &why);
    }
    let result = async {
        let mut probe = Probe::start(interface.name(), 16)?;
        let epoch = probe.opened().await?;
        // A frame of 16 bytes takes more than 12 s.
        let bytes = (0..64).flat_map(numbered).collect();
        probe.link.command(LinkCommand::Send { epoch, bytes });
        match probe.next().await? {
            What::Closed(words) if words.contains("stalled") => Ok(format!("Closed \"{words}\"")),
            other => Err(format!("expected Closed with \"stalled\", got {other:?}")),
        }
    };
    report.check(name, result.await);
    if let Err(why) = interface.fast() {
        report.check("transmit queue as before", Err(why));
    }
}

/// An interface that goes down is noticed by a link that has nothing to send.
pub(crate) async fn down_while_silent(interface: &Interface, report: &mut Report) {
    let result = async {
        let mut probe = Probe::start(interface.name(), 16)?;
        probe.opened().await?;
        interface.down()?;
        let begin = Instant::now();
        match probe.next().await? {
            What::Closed(words) if words.contains("down") => {
                Ok(format!("Closed \"{words}\" after {} ms", begin.elapsed().as_millis()))
            }
            other => Err(format!("expected Closed with \"down\", got {other:?}")),
        }
    };
    report.check("down while silent", result.await);
    if let Err(why) = interface.up() {
        report.check("interface up", Err(why));
    }
}

/// How many frames the kernel keeps while the station reads nothing. Those after them are lost without a
/// word: CAN has no flow control.
pub(crate) async fn nobody_reads(interface: &Interface, report: &mut Report) {
    const FRAMES: u16 = 5_000;
    let result = async {
        let mut probe = Probe::start(interface.name(), 1)?;
        probe.opened().await?;
        let mut peer = CanSocket::open(interface.name()).map_err(|error| error.to_string())?;
        for place in 0..FRAMES {
            let mut record = numbered(0);
            record[8..10].copy_from_slice(&place.to_le_bytes());
            peer.write_all(&record).await.map_err(|error| error.to_string())?;
        }
        sleep(Duration::from_millis(100)).await;
        let mut kept = 0;
        while let Ok(Some(event)) = timeout(Duration::from_millis(300), probe.events.recv()).await {
            let What::Received(bytes) = event.what else {
                return Err(format!("expected a frame, got {:?}", event.what));
            };
            if bytes[8..10] != u16::to_le_bytes(kept) {
                return Err(format!("frame {kept} is {bytes:02X?}"));
            }
            kept += 1;
        }
        note(&format!("{kept} of {FRAMES} frames were kept while nobody read"));
        if kept >= 100 {
            Ok(format!("the first {kept} in order"))
        } else {
            Err(format!("only {kept} kept"))
        }
    };
    report.check("nobody reads", result.await);
}

async fn read(peer: &mut CanSocket) -> Result<[u8; RECORD_LEN], String> {
    let mut record = [0; RECORD_LEN];
    match timeout(PATIENCE, peer.read_exact(&mut record)).await {
        Ok(Ok(_)) => Ok(record),
        Ok(Err(error)) => Err(error.to_string()),
        Err(_) => Err(format!("no frame for {PATIENCE:?}")),
    }
}

/// A standard frame that carries its number.
pub(crate) fn numbered(place: u8) -> [u8; RECORD_LEN] {
    let mut record = [0; RECORD_LEN];
    record[..5].copy_from_slice(&[0x85, 0x01, 0, 0, 8]);
    record[8] = place;
    record
}

/// `struct can_frame` of <linux/can.h>: identifier with CAN_EFF_FLAG (bit 31) and CAN_RTR_FLAG (bit 30) in
/// the byte order of the host, length, three bytes of padding, eight bytes of data.
fn records() -> Vec<[u8; RECORD_LEN]> {
    const EXTENDED: u32 = 1 << 31;
    const REMOTE: u32 = 1 << 30;
    let mut all = Vec::new();
    for identifier in [0, 0x185, 0x7FF, EXTENDED, EXTENDED | 0x185, EXTENDED | 0x1FFF_FFFF] {
        for len in 0..=8_u8 {
            let mut record = [0; RECORD_LEN];
            record[4] = len;
            record[..4].copy_from_slice(&(identifier | REMOTE).to_ne_bytes());
            all.push(record);
            record[..4].copy_from_slice(&identifier.to_ne_bytes());
            record[8..8 + usize::from(len)].fill(0xA5);
            all.push(record);
        }
    }
    all
}

/// A virtual machine under emulation is slow, and so is a shared processor.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);
