//! Segments read by an independent implementation of MCAP: the Python package `mcap`.

use std::env;
use std::process::Command;

use asphera_link::Nanos;

use super::super::format::ChannelId;
use super::super::{ResultsJson, Settings, message};
use super::{create, entries, header, settings};

#[test]
fn python_reads_the_same_messages() {
    let python = env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Command::new(&python).args(["-c", "import mcap"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: {python} with the package mcap not found");
        return;
    }
    let parent = tempfile::tempdir().unwrap();
    let mut recorder = create(parent.path(), Settings { segment_s: 1, ..settings() });
    let entries = entries(2500);
    entries.iter().for_each(|entry| recorder.append(entry).unwrap());
    let results = ResultsJson::new(r#"{"pv_nm":31.4}"#).unwrap();
    let folder =
        recorder.finish(Nanos::from_millis(2500), "complete", Some(&results)).unwrap().folder;

    let header = header();
    let topic = |channel| match channel {
        ChannelId::Events => "/events".to_owned(),
        ChannelId::Results => "/results".to_owned(),
        ChannelId::Points => "/points".to_owned(),
        ChannelId::Raw(link) => format!("/raw/{}", header.links[link].name),
        ChannelId::Sent(link) => format!("/sent/{}", header.links[link].name),
    };
    let hex = |data: &[u8]| data.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let line = |sequence: usize, at: Nanos, topic: &str, data: &[u8]| {
        format!("{sequence} {} {topic} {}\n", at.as_nanos(), hex(data))
    };
    let mut expected = String::new();
    for (sequence, entry) in entries.iter().enumerate() {
        let (channel, data) = message::encode(&entry.what, &header.links);
        expected += &line(sequence, entry.at, &topic(channel), &data);
    }
    let end = Nanos::from_millis(2500);
    expected += &line(2500, end, "/events", br#"{"event":"finish","reason":"complete"}"#);
    expected += &line(2501, end, "/results", br#"{"pv_nm":31.4}"#);

    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/session/tests/read_with_mcap.py");
    let output = Command::new(&python).arg(script).arg(&folder).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    assert_eq!(errors, "", "the reader complained");
    let read = String::from_utf8(output.stdout).unwrap();
    let (about, messages) = read.split_once('\n').unwrap();
    assert_eq!(about, format!("3 {} 0badcafe", hex(header.config_toml.as_bytes())));
    assert!(messages == expected, "{messages}");
}
