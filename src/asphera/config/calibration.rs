//! `[calibration]`: errors of the machine, by the file that `asphera calibrate` wrote.

use std::path::Path;
use std::str::FromStr as _;

use asphera_calibrate::Machine;
use asphera_nominal::bytes_of;
use asphera_settings::Section;
use toml_edit::DocumentMut;

use crate::calibration::CalibrationFile;

/// Reads the table; `None` where it is absent or cannot be used. `folder` is that of the configuration, where the file is
/// found. Gives the text of the configuration with that of the file in it, so that a recording holds what its points were
/// corrected by.
pub(super) fn read(
    table: &Section<'_>,
    folder: &Path,
    machine: Option<Machine>,
    text: &str,
) -> (Option<CalibrationFile>, String) {
    if !table.is_present() {
        return (None, text.to_owned());
    }
    let recorded: Option<String> = table.get("file_text");
    let name: Option<String> = table.required("file");
    table.finish();
    let Some(name) = name else { return (None, text.to_owned()) };
    let content = match recorded {
        Some(content) => content,
        None => match bytes_of(&folder.join(&name)).map(String::from_utf8) {
            Ok(Ok(content)) => content,
            Ok(Err(_)) => {
                table.problem("file", "a text file in UTF-8", "other bytes");
                return (None, text.to_owned());
            }
            Err(error) => {
                table.problem("file", "a file that can be read", format!("{name}: {error}"));
                return (None, text.to_owned());
            }
        },
    };
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
    if let Some(machine) = machine.filter(|machine| *machine != calibrated) {
        let expected =
            format!("a calibration of a {} machine, as kinematics.kind says", machine.word());
        table.problem("file", expected, format!("{name}, of a {} one", calibrated.word()));
        return (None, text.to_owned());
    }
    (Some(calibration), embedded(text, &content))
}

/// The configuration with the text of the file beside its name.
fn embedded(text: &str, content: &str) -> String {
    let Ok(mut document) = DocumentMut::from_str(text) else { return text.to_owned() };
    let table = document.get_mut("calibration").and_then(|table| table.as_table_like_mut());
    if let Some(table) = table {
        table.insert("file_text", toml_edit::value(content));
    }
    document.to_string()
}
