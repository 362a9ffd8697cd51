//! The form of the face that `--nominal` describes: that of `asphera measure`, without the files.

use asphera_formats::volume::Volume;
use asphera_measure::Part;
use asphera_report::FormFigures;

use super::super::face::{self, FaceArgs};
use super::super::progress::Progress;
use super::figures::VolumeReport;
use super::{Part as Chosen, VolumeArgs};

/// Adds the form to a report with what it must be read with, or why there is none.
pub(super) fn add(
    report: &mut VolumeReport,
    args: &VolumeArgs,
    (part, volume): (&Part, Option<Volume>),
    progress: &Progress,
) {
    match of(report, args, (part, volume), progress) {
        Ok((form, notes)) => {
            report.form = Some(form);
            report.reasons.extend(notes.into_iter().map(|note| format!("face: {note}")));
        }
        Err(why) => report.reasons.push(format!("no form of the face: {why}")),
    }
}

fn of(
    report: &VolumeReport,
    args: &VolumeArgs,
    (part, volume): (&Part, Option<Volume>),
    progress: &Progress,
) -> Result<(FormFigures, Vec<String>), String> {
    let Some(volume) = volume else {
        let count: u64 = report.volume.size.iter().map(|&side| side as u64).product();
        return Err(format!(
            "{count} samples are read by slices, and the face needs all at once; use asphera measure"
        ));
    };
    let of_face = FaceArgs::of_face(args.threshold, args.spacing);
    let found = face::measured_in(&args.file, volume, &of_face, part, progress)
        .map_err(|error| error.to_string())?
        .report;
    let form = found.form.ok_or_else(|| found.verdict.reasons.join("; "))?;
    let mut notes = Vec::new();
    if args.part != Chosen::All {
        notes.push("it is looked for in the whole volume, whatever --part says".to_owned());
    }
    if let Some(face) = found.volume {
        notes.push(format!("its threshold is {}", face.threshold));
        notes.extend(face.reasons);
    }
    notes.extend(found.verdict.reasons);
    Ok((form, notes))
}
