//! `[calibration]`: errors of the machine, by the file that `asphera calibrate` wrote.

use std::path::Path;

use asphera_settings::Section;

use super::attached::{embedded, text_of};
use crate::calibration::CalibrationFile;
use crate::station::Kinematics;

/// Reads the table; `None` where it is absent or cannot be used. `folder` is that of the configuration, where the file is
/// found. Gives the text of the configuration with that of the file in it, so that a recording holds what its points were
/// corrected by.
pub(super) fn read(
    table: &Section<'_>,
    folder: &Path,
    kinematics: Option<&Kinematics>,
    text: &str,
) -> (Option<CalibrationFile>, String) {
    if !table.is_present() {
        return (None, text.to_owned());
    }
    let found = text_of(table, "file", folder, "a text file in UTF-8");
    if !table.has("file") {
        table.problem("file", "the name of a calibration file", "nothing");
    }
    table.finish();
    let Some((name, content)) = found else { return (None, text.to_owned()) };
    let calibration = match CalibrationFile::parse(&name, &content) {
        Ok(calibration) => calibration,
        Err(problems) => {
            for problem in problems.0 {
                table.problem("file", "a file as `asphera calibrate` writes it", problem);
            }
            return (None, text.to_owned());
        }
    };
    let calibrated = calibration.correction().machine();
    let machine = kinematics.map(Kinematics::machine);
    if let Some(machine) = machine.filter(|machine| *machine != calibrated) {
        let expected =
            format!("a calibration of a {} machine, as kinematics.kind says", machine.word());
        table.problem("file", expected, format!("{name}, of a {} one", calibrated.word()));
        return (None, text.to_owned());
    }
    let has_map = calibration.correction().map().is_some();
    if has_map && kinematics.is_some_and(|kinematics| !kinematics.measures_along_z()) {
        let expected =
            "a calibration without a map, which is of errors along z: these heights lie across it";
        table.problem("file", expected, format!("{name}, with one"));
        return (None, text.to_owned());
    }
    (Some(calibration), embedded(text, "calibration", "file", &content))
}
