//! Times of frames: those at which the kernel took them.

use std::time::Duration;

use asphera_transport::What;
use socketcan::tokio::CanSocket;
use tokio::io::AsyncWriteExt as _;
use tokio::time::{Instant, sleep, timeout};

use crate::frames::{PATIENCE, Probe, numbered};
use crate::interface::Interface;
use crate::report::Report;

/// Frames that nobody read for long have the times at which they came.
pub(crate) async fn late_reader(interface: &Interface, report: &mut Report) {
    const FRAMES: u8 = 10;
    const APART: Duration = Duration::from_millis(50);
    let result = async {
        let mut probe = Probe::start(interface.name(), 1)?;
        probe.opened().await?;
        let mut peer = CanSocket::open(interface.name()).map_err(|error| error.to_string())?;
        let mut sent = Vec::new();
        for place in 0..FRAMES {
            sent.push(Instant::now());
            peer.write_all(&numbered(place)).await.map_err(|error| error.to_string())?;
            sleep(APART).await;
        }
        let (begin, mut worst) = (Instant::now(), Duration::ZERO);
        for sent in sent {
            let event = timeout(PATIENCE, probe.events.recv()).await.ok().flatten();
            let Some(event) = event else { return Err("the link ended or is silent".to_owned()) };
            let What::Received(_) = event.what else { return Err(format!("got {:?}", event.what)) };
            if event.at >= begin {
                return Err("a frame has the time at which it was read".to_owned());
            }
            // The wall clock and the monotonic one are read one after the other.
            let off = event.at.max(sent) - event.at.min(sent);
            worst = worst.max(off);
        }
        match worst < APART / 2 {
            true => Ok(format!(
                "{FRAMES} frames read up to {} ms late have their own times within {worst:?}",
                50 * u32::from(FRAMES)
            )),
            false => Err(format!("a time is wrong by {worst:?}")),
        }
    };
    report.check("times of the kernel", result.await);
}

/// An interface whose controller stamps nothing, as a virtual one, is closed with the cure where its times were asked for; without that its
/// frames come.
pub(crate) async fn no_controller(interface: &Interface, report: &mut Report) {
    let result = async {
        let mut probe = Probe::with_times(interface.name(), 1, true)?;
        probe.opened().await?;
        let mut peer = CanSocket::open(interface.name()).map_err(|error| error.to_string())?;
        for place in 0..10 {
            peer.write_all(&numbered(place)).await.map_err(|error| error.to_string())?;
        }
        let mut frames = 0;
        loop {
            match probe.next().await? {
                What::Received(_) => frames += 1,
                What::Closed(why) if why.contains("set timestamps = false") && frames < 10 => {
                    return Ok(format!("{frames} frames, then {why:?}"));
                }
                other => return Err(format!("{frames} frames, then {other:?}")),
            }
        }
    };
    report.check("times of a controller that has none", result.await);
}
