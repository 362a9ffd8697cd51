//! The form of the face that `--nominal` describes: that of `asphera measure`, without the files.

use asphera_measure::Part;
use asphera_report::FormFigures;

use super::super::face::{self, FaceArgs};
use super::super::progress::Progress;
use super::figures::VolumeReport;
use super::{Part as Chosen, VolumeArgs, WHOLE};

/// Adds the form to a report with what it must be read with, or why there is none.
pub(super) fn add(report: &mut VolumeReport, args: &VolumeArgs, part: Part, progress: &Progress) {
    match of(report, args, part, progress) {
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
    part: Part,
    progress: &Progress,
) -> Result<(FormFigures, Vec<String>), String> {
    let count: u64 = report.volume.size.iter().map(|&side| side as u64).product();
    if count > WHOLE {
        return Err(format!(
            "{count} samples are read by slices, and the face needs all at once; use asphera measure"
        ));
    }
    let of_face = FaceArgs::of_face(args.threshold, args.spacing);
    let faces = face::measured(&args.file, &of_face, Some(part), None, None, progress)
        .map_err(|error| error.to_string())?;
    let found = faces.first.report;
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
