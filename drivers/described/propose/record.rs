//! Devices that send bytes.

use asphera_link::{Capture, Proposal, Unit};

use super::{poll, write};
use crate::checksum::{Algorithm, Checksum, Digits};
use crate::field::{Field, Place};
use crate::framing::Framing;
use crate::number::{ByteOrder, Form};
use crate::settings::{Layout, Settings};

/// Records that are needed before anything is proposed.
const LEAST_RECORDS: usize = 8;

/// Longest record looked for, bytes.
const LONGEST: usize = 64;

/// Bytes looked at: enough to be sure, few enough to try all lengths and beginnings.
const LOOKED_AT: usize = 4096;

/// Records of one length, from a byte of the capture on.
struct Records<'a> {
    records: Vec<&'a [u8]>,
    length: usize,
}

impl<'a> Records<'a> {
    fn cut(bytes: &'a [u8], phase: usize, length: usize) -> Option<Records<'a>> {
        let records: Vec<&[u8]> = bytes.get(phase..)?.chunks_exact(length).collect();
        (records.len() >= LEAST_RECORDS).then_some(Records { records, length })
    }

    fn is_constant(&self, at: usize) -> bool {
        self.records.iter().all(|record| record[at] == self.records[0][at])
    }

    /// Constant bytes at the beginning.
    fn begin(&self) -> &'a [u8] {
        let len = (0..self.length).take_while(|at| self.is_constant(*at)).count();
        &self.records[0][..len]
    }

    /// Different bytes at a place.
    fn variety(&self, at: usize) -> usize {
        let mut seen = [false; 256];
        self.records.iter().for_each(|record| seen[usize::from(record[at])] = true);
        seen.iter().filter(|seen| **seen).count()
    }
}

pub(super) fn propose(capture: &Capture, bytes: &[u8]) -> Proposal {
    let looked_at = &bytes[..bytes.len().min(LOOKED_AT)];
    let mut remarks = vec![format!("{} bytes that are no text", bytes.len())];
    let found = guarded(looked_at).or_else(|| begun(looked_at).map(|records| (records, None)));
    let Some((records, checksum)) = found else {
        remarks.push(
            "no length of records fits: listen longer, or try another baud rate and parity"
                .to_owned(),
        );
        return Proposal { settings: None, remarks };
    };
    let begin = records.begin().to_vec();
    let last = records.length - checksum.map_or(0, |check: Checksum| check.bytes());
    let (fields, more) = fields(&records, begin.len(), last);
    remarks.push(format!("records of {} bytes", records.length));
    remarks.extend(more);
    let settings = Settings {
        framing: Framing::Records { begin, length: records.length },
        checksum,
        layout: Layout::Bytes,
        fields,
        poll: poll(capture),
        ..Settings::default()
    };
    let usable = settings.problems().is_empty();
    if !usable {
        remarks.push("only the check varies, or no byte marks the begin of a record".to_owned());
    }
    Proposal { settings: usable.then(|| write::toml(&settings)), remarks }
}

/// The shortest records that all have a check at their end, and something that varies.
fn guarded(bytes: &[u8]) -> Option<(Records<'_>, Option<Checksum>)> {
    for length in 3..=LONGEST {
        for phase in 0..length {
            let Some(records) = Records::cut(bytes, phase, length) else { continue };
            for (_, algorithm) in Algorithm::ALL {
                for order in [ByteOrder::Big, ByteOrder::Little] {
                    let digits = Digits::Binary(order);
                    let check = Checksum { algorithm, digits, skip_first: 0, skip_last: 0 };
                    let holds = records.records.iter().all(|record| check.body(record).is_some());
                    let varies = (0..length).any(|at| !records.is_constant(at));
                    if holds && varies {
                        return Some((records, Some(check)));
                    }
                }
            }
        }
    }
    None
}

/// The shortest records that begin with two constant bytes, which stand nowhere else, and end with one that varies.
fn begun(bytes: &[u8]) -> Option<Records<'_>> {
    for length in 3..=LONGEST {
        for phase in 0..length {
            let Some(records) = Records::cut(bytes, phase, length) else { continue };
            let begin = records.begin();
            let alone = || {
                records
                    .records
                    .iter()
                    .all(|record| record[1..].windows(begin.len()).all(|window| window != begin))
            };
            if begin.len() >= 2
                && begin.len() < length
                && !records.is_constant(length - 1)
                && alone()
            {
                return Some(records);
            }
        }
    }
    None
}

/// A number of each run of bytes that vary. The byte that varies most is its lowest.
fn fields(records: &Records<'_>, from: usize, to: usize) -> (Vec<Field>, Vec<String>) {
    let (mut fields, mut remarks) = (Vec::new(), Vec::new());
    let mut at = from;
    while at < to {
        let run = (at..to).take_while(|at| !records.is_constant(*at)).count();
        if run == 0 {
            at += 1;
            continue;
        }
        let width = run.min(4);
        let little = records.variety(at) > records.variety(at + width - 1);
        let order = if little { ByteOrder::Little } else { ByteOrder::Big };
        let name = format!("value{}", fields.len() + 1);
        let form = Form::Signed(width as u8, order);
        fields.push(Field { form, ..Field::channel(&name, Place::At(at), Unit::One) });
        let end = at + width - 1;
        remarks.push(format!(
            "bytes {at} to {end} vary, and are read as one signed whole number. They may be several numbers, or a float. Compare with the display, then set form, scale and unit"
        ));
        at += width;
    }
    (fields, remarks)
}
