//! Entries as MCAP messages: which channel, which bytes.

use std::borrow::Cow;
use std::time::Duration;

use asphera_link::{Command, Nanos};
use asphera_plan::Ending;
use serde::{Deserialize, Serialize};

use super::format::ChannelId;
use super::{LinkInfo, PointCloud, ResultsJson, What};
use crate::station::{ScanDecision, ScanOrder, Stroke};

/// JSON on the channel `/events`. Links are named, so that a person can read it.
#[derive(Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "lowercase")]
enum Event<'a> {
    Opened {
        link: Cow<'a, str>,
    },
    Closed {
        link: Cow<'a, str>,
        reason: Cow<'a, str>,
    },
    Command {
        command: CommandName,
    },
    #[serde(rename = "held up")]
    HeldUp {
        until_ns: u64,
        #[serde(default, skip_serializing_if = "is_zero")]
        suspended_ns: u64,
    },
    Scan {
        order: ScanWord,
        /// Of a pass: first place, last place and spacing of each piece, nm.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        strokes_nm: Vec<[i64; 5]>,
    },
    Finish {
        reason: Cow<'a, str>,
    },
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ScanWord {
    Arm,
    Halt,
    Measure,
    Reached,
    FailCertain,
    BudgetSpent,
    NothingToGain,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum CommandName {
    Start,
    Stop,
}

/// The channel and the bytes of an entry. Its link must be one of `links`.
pub(super) fn encode<'a>(what: &'a What, links: &[LinkInfo]) -> (ChannelId, Cow<'a, [u8]>) {
    let name = |link: usize| Cow::Borrowed(links[link].name.as_str());
    let event = match what {
        What::Received { link, bytes } => return (ChannelId::Raw(*link), bytes.into()),
        What::Sent { link, bytes } => return (ChannelId::Sent(*link), bytes.into()),
        What::Points(points) => return (ChannelId::Points, points.as_bytes().into()),
        What::Results(results) => return (ChannelId::Results, results.as_str().as_bytes().into()),
        What::Opened { link } => Event::Opened { link: name(*link) },
        What::Closed { link, reason } => Event::Closed { link: name(*link), reason: reason.into() },
        What::Command(Command::Start) => Event::Command { command: CommandName::Start },
        What::Command(Command::Stop) => Event::Command { command: CommandName::Stop },
        What::Scan(order) => scan(order),
        What::HeldUp { until, suspended } => Event::HeldUp {
            until_ns: until.as_nanos(),
            suspended_ns: u64::try_from(suspended.as_nanos()).unwrap_or(u64::MAX),
        },
        What::Finish { reason } => Event::Finish { reason: reason.into() },
    };
    let json = serde_json::to_vec(&event).expect("an event is a map of strings");
    (ChannelId::Events, json.into())
}

/// The entry of a message; `None` for what this version of the format does not know.
pub(super) fn decode(channel: u16, data: &[u8], links: &[LinkInfo]) -> Option<What> {
    let find = |name: &str| links.iter().position(|link| link.name == name);
    Some(match ChannelId::from_number(channel, links.len())? {
        ChannelId::Raw(link) => What::Received { link, bytes: data.to_vec() },
        ChannelId::Sent(link) => What::Sent { link, bytes: data.to_vec() },
        ChannelId::Points => What::Points(PointCloud::read(data)?),
        ChannelId::Results => {
            What::Results(ResultsJson::new(String::from_utf8(data.to_vec()).ok()?).ok()?)
        }
        ChannelId::Events => match serde_json::from_slice(data).ok()? {
            Event::Opened { link } => What::Opened { link: find(&link)? },
            Event::Closed { link, reason } => {
                What::Closed { link: find(&link)?, reason: reason.into_owned() }
            }
            Event::Command { command: CommandName::Start } => What::Command(Command::Start),
            Event::Command { command: CommandName::Stop } => What::Command(Command::Stop),
            Event::Scan { order, strokes_nm } => What::Scan(scan_order(order, &strokes_nm)),
            Event::HeldUp { until_ns, suspended_ns } => What::HeldUp {
                until: Nanos::from_nanos(until_ns),
                suspended: Duration::from_nanos(suspended_ns),
            },
            Event::Finish { reason } => What::Finish { reason: reason.into_owned() },
        },
    })
}

fn scan(order: &ScanOrder) -> Event<'static> {
    let (order, strokes) = match order {
        ScanOrder::Arm => (ScanWord::Arm, [].as_slice()),
        ScanOrder::Halt => (ScanWord::Halt, [].as_slice()),
        ScanOrder::Decide(ScanDecision::Measure(strokes)) => {
            (ScanWord::Measure, strokes.as_slice())
        }
        ScanOrder::Decide(ScanDecision::End(ending)) => {
            let word = match ending {
                Ending::Reached => ScanWord::Reached,
                Ending::FailCertain => ScanWord::FailCertain,
                Ending::BudgetSpent => ScanWord::BudgetSpent,
                Ending::NothingToGain => ScanWord::NothingToGain,
            };
            (word, [].as_slice())
        }
    };
    let numbers = |stroke: &Stroke| {
        let Stroke { from_nm: [x0, y0], to_nm: [x1, y1], spacing_nm } = *stroke;
        [x0, y0, x1, y1, spacing_nm]
    };
    Event::Scan { order, strokes_nm: strokes.iter().map(numbers).collect() }
}

fn scan_order(order: ScanWord, strokes_nm: &[[i64; 5]]) -> ScanOrder {
    let stroke = |&[x0, y0, x1, y1, spacing_nm]: &[i64; 5]| Stroke {
        from_nm: [x0, y0],
        to_nm: [x1, y1],
        spacing_nm,
    };
    let end = |ending| ScanOrder::Decide(ScanDecision::End(ending));
    match order {
        ScanWord::Arm => ScanOrder::Arm,
        ScanWord::Halt => ScanOrder::Halt,
        ScanWord::Measure => {
            ScanOrder::Decide(ScanDecision::Measure(strokes_nm.iter().map(stroke).collect()))
        }
        ScanWord::Reached => end(Ending::Reached),
        ScanWord::FailCertain => end(Ending::FailCertain),
        ScanWord::BudgetSpent => end(Ending::BudgetSpent),
        ScanWord::NothingToGain => end(Ending::NothingToGain),
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde gives a reference")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn links() -> Vec<LinkInfo> {
        ["probe", "stage"]
            .map(|name| LinkInfo {
                name: name.to_owned(),
                kind: "tcp".to_owned(),
                address: String::new(),
            })
            .into()
    }

    #[test]
    fn events_are_readable_json() {
        let links = links();
        let cases = [
            (What::Opened { link: 1 }, r#"{"event":"opened","link":"stage"}"#),
            (
                What::Closed { link: 0, reason: "a \"b\"\n".to_owned() },
                r#"{"event":"closed","link":"probe","reason":"a \"b\"\n"}"#,
            ),
            (What::Command(Command::Start), r#"{"event":"command","command":"start"}"#),
            (What::Command(Command::Stop), r#"{"event":"command","command":"stop"}"#),
            (
                What::HeldUp { until: Nanos::from_millis(3), suspended: Duration::ZERO },
                r#"{"event":"held up","until_ns":3000000}"#,
            ),
            (
                What::HeldUp { until: Nanos::from_millis(3), suspended: Duration::from_millis(2) },
                r#"{"event":"held up","until_ns":3000000,"suspended_ns":2000000}"#,
            ),
            (What::Scan(ScanOrder::Arm), r#"{"event":"scan","order":"arm"}"#),
            (
                What::Scan(ScanOrder::Decide(ScanDecision::Measure(vec![Stroke {
                    from_nm: [-1, 2],
                    to_nm: [3, 4],
                    spacing_nm: 5,
                }]))),
                r#"{"event":"scan","order":"measure","strokes_nm":[[-1,2,3,4,5]]}"#,
            ),
            (
                What::Scan(ScanOrder::Decide(ScanDecision::End(Ending::FailCertain))),
                r#"{"event":"scan","order":"fail-certain"}"#,
            ),
            (What::Finish { reason: "ü".to_owned() }, r#"{"event":"finish","reason":"ü"}"#),
        ];
        for (what, json) in cases {
            let (channel, data) = encode(&what, &links);
            assert_eq!((channel, &*data), (ChannelId::Events, json.as_bytes()));
            assert_eq!(decode(channel.number(), &data, &links), Some(what));
        }
    }

    #[test]
    fn what_is_not_known_is_nothing() {
        let links = links();
        for (channel, data) in [
            (0, &b""[..]),
            (7, b"received on a third link"),
            (1, b"no json"),
            (1, br#"{"event":"opened","link":"camera"}"#),
            (1, br#"{"event":"paused"}"#),
            (2, b"{"),
            (2, b"\"\xff\""),
        ] {
            assert_eq!(decode(channel, data, &links), None);
        }
    }
}
