//! Links, devices and the session in words.

use std::collections::BTreeMap;

use super::{Chapter, ChapterId, Fact, Layout, Table};
use crate::words::{count, counted, short};
use crate::{DeviceFigures, LinkFigures, SessionFigures, ThermalFigures};

/// Readings of each device and bytes of each link, delivered and lost. The summary has only what was lost.
pub(super) fn chapter(links: &[LinkFigures]) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Links, "Links and devices");
    let mut devices = Table::new(&[
        ("device", Layout::Head),
        ("link", Layout::Text),
        ("readings", Layout::Number),
        ("lost", Layout::Number),
        ("unjoined", Layout::Number),
        ("flags and faults", Layout::Text),
        ("channels: mean (smallest to largest)", Layout::Fine),
    ]);
    let mut clocks = Vec::new();
    let mut bytes = Table::new(&[
        ("link", Layout::Head),
        ("received", Layout::Number),
        ("discarded", Layout::Number),
        ("opened", Layout::Number),
        ("closed", Layout::Number),
    ]);
    for link in links {
        for device in &link.devices {
            chapter.brief.extend(losses(device, link));
            devices.rows.push(row(device, link));
            clocks.extend(clock(device));
        }
        if link.discarded_bytes > 0 || link.closed > 0 {
            chapter.brief.push(format!(
                "{}: {} discarded, opened {}, closed {}",
                link.name,
                counted(link.discarded_bytes, "byte"),
                counted(link.opened, "time"),
                counted(link.closed, "time")
            ));
        }
        bytes.rows.push(vec![
            link.name.clone(),
            counted(link.received_bytes, "byte"),
            counted(link.discarded_bytes, "byte"),
            counted(link.opened, "time"),
            counted(link.closed, "time"),
        ]);
    }
    chapter.table(devices);
    clocks.into_iter().for_each(|words| chapter.note(words));
    if links.iter().any(|link| link.discarded_bytes > 0 || link.closed > 0) {
        chapter.table(bytes);
    } else if !links.is_empty() {
        chapter.note("No byte was discarded, and no link was lost.");
    }
    chapter
}

/// The clock of a device, once it is known.
fn clock(device: &DeviceFigures) -> Option<String> {
    let of = device.clock.as_ref()?;
    let (drift, u_drift) = (of.drift_ppm?, of.u_drift_ppm?);
    let mut words = format!(
        "The clock of {} gains {} ppm (u {} ppm). On the host's clock its times have u {} µs; readings arrive with a jitter of {} µs.",
        device.name,
        short(drift),
        short(u_drift),
        short(of.u_us?),
        short(of.jitter_us?)
    );
    if of.jumps > 0 {
        words += &format!(" It jumped {}.", counted(of.jumps, "time"));
    }
    Some(words)
}

fn row(device: &DeviceFigures, link: &LinkFigures) -> Vec<String> {
    let flags = [named(&device.flagged), named(&device.faults)].concat();
    let channels = device.channels.iter().map(|(name, channel)| {
        format!(
            "{name} {} {} ({} to {})",
            short(channel.mean),
            channel.unit,
            short(channel.min),
            short(channel.max)
        )
    });
    vec![
        device.name.clone(),
        link.name.clone(),
        count(device.readings),
        count(device.lost),
        count(device.unjoined),
        if flags.is_empty() { "none".to_owned() } else { flags.join(", ") },
        channels.collect::<Vec<_>>().join("; "),
    ]
}

/// What a device lost, and its faults; nothing of a device without.
fn losses(device: &DeviceFigures, link: &LinkFigures) -> Option<String> {
    let counts =
        [(device.lost, "lost"), (device.unjoined, "unjoined"), (device.ambiguous, "ambiguous")];
    let lost = counts.iter().filter(|(number, _)| *number > 0);
    let lost = lost.map(|(number, what)| format!("{} {what}", count(*number)));
    let faults =
        device.faults.iter().map(|(kind, number)| counted(*number, &format!("{kind} fault")));
    let said: Vec<String> = lost.chain(faults).collect();
    (!said.is_empty()).then(|| {
        format!(
            "{}: {} on {}, {}",
            device.name,
            counted(device.readings, "reading"),
            link.name,
            said.join(", ")
        )
    })
}

fn named(counts: &BTreeMap<String, u64>) -> Vec<String> {
    let words =
        |(name, number): (&String, &u64)| format!("{} {}", count(*number), name.replace('_', " "));
    counts.iter().map(words).collect()
}

/// An instant (RFC 3339) without its fraction of a second.
fn to_the_second(instant: &str) -> String {
    match instant.split_once('.') {
        Some((whole, fraction)) => {
            format!("{whole}{}", fraction.trim_start_matches(|digit: char| digit.is_ascii_digit()))
        }
        None => instant.to_owned(),
    }
}

/// Change of lengths, temperatures and uncertainty of the thermal expansion.
fn at_20(thermal: &ThermalFigures) -> String {
    let range = |[low, high]: [f64; 2]| match (short(low), short(high)) {
        (low, high) if low == high => low,
        (low, high) => format!("{low} to {high}"),
    };
    let body = |name: &str, degc: Option<[f64; 2]>| {
        degc.map(|degc| format!(", {name} at {} °C", range(degc))).unwrap_or_default()
    };
    format!(
        "changed by {} µm/m{}{}; u {} µm/m",
        range(thermal.lengths_um_per_m),
        body("part", thermal.part_degc),
        body("scales", thermal.scales_degc),
        short(thermal.u_um_per_m)
    )
}

/// Session, part and operator, and whether processing was behind its recording.
pub(super) fn session(session: &SessionFigures, most_behind_s: f64) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Session, "Session");
    chapter.brief.push(format!("{} ({})", session.id, session.ended));
    let mut facts = vec![
        Fact::new("Session", session.id.clone()),
        Fact::new("Station", session.station.clone()),
    ];
    facts.extend(session.label.entries().map(|(name, entry)| Fact::new(name, entry)));
    facts.extend([
        Fact::new("Began", to_the_second(&session.started)),
        Fact::new("Ended", session.ended.clone()),
        Fact::new("Recorded by", format!("asphera {}", session.version)),
    ]);
    facts.extend(session.calibration.as_ref().map(|calibration| {
        let [made, until] =
            [&calibration.date, &calibration.valid_until].map(|time| to_the_second(time));
        Fact::new("Calibration", format!("of {made}, valid until {until}"))
    }));
    let tables = &session.error_tables;
    facts.extend((!tables.is_empty()).then(|| Fact::new("Axis errors", tables.join(", "))));
    facts.extend(session.places.map(|places| {
        let words =
            format!("u up to {} µm, RMS {} µm", short(places.largest_um), short(places.rms_um));
        Fact::new("Places joined by time", words)
    }));
    facts.extend(
        session.thermal.as_ref().map(|thermal| Fact::new("Lengths at 20 °C", at_20(thermal))),
    );
    facts.extend(behind(most_behind_s).map(|words| Fact::new("Processing", words)));
    chapter.facts(facts);
    chapter
}

/// How far processing was behind, in words; `None` where that is not worth one.
fn behind(most_behind_s: f64) -> Option<String> {
    let words = || {
        let seconds = short(most_behind_s);
        format!("up to {seconds} s behind the recording; every recorded point is in the figures")
    };
    (most_behind_s >= WORTH_SAYING_S).then(words)
}

/// Shorter delays of the processing are not worth a word, s.
const WORTH_SAYING_S: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_of_the_processing_is_said_where_it_was_long() {
        let session = SessionFigures::default();
        let words = |most_behind_s: f64| format!("{:?}", super::session(&session, most_behind_s));
        assert!(!words(1.9).contains("behind"));
        assert!(words(12.25).contains("up to 12.25 s behind the recording"), "{}", words(12.25));
    }

    #[test]
    fn the_change_of_lengths_has_its_temperatures_and_its_u() {
        let thermal = ThermalFigures {
            part_degc: Some([21.0, 21.25]),
            scales_degc: None,
            lengths_um_per_m: [-8.875, -7.1],
            u_um_per_m: 0.5,
        };
        let expected = "changed by −8.875 to −7.100 µm/m, part at 21.00 to 21.25 °C; u 0.5000 µm/m";
        assert_eq!(at_20(&thermal), expected);
        let steady = ThermalFigures {
            part_degc: Some([21.0; 2]),
            scales_degc: Some([20.5; 2]),
            lengths_um_per_m: [-3.1; 2],
            u_um_per_m: 0.5,
        };
        let expected =
            "changed by −3.100 µm/m, part at 21.00 °C, scales at 20.50 °C; u 0.5000 µm/m";
        assert_eq!(at_20(&steady), expected);
    }
}
