//! `[parts]`: the parts that are found in the points of every session.

use std::path::Path;
use std::str::FromStr as _;

use asphera_graph::RunningSettings;
use asphera_measure::Weights;
use asphera_nominal::{bytes_of, text_of};
use asphera_settings::Section;
use toml_edit::DocumentMut;

use crate::parts::{Library, PartsPlan, files_in};

/// Reads the table; `None` where it is absent or cannot be used. `folder` is that of the configuration, from which the library is
/// found. Gives the text of the configuration with those of the library in it, so that a recording is replayed with the same.
pub(super) fn read(table: &Section<'_>, folder: &Path, text: &str) -> (Option<PartsPlan>, String) {
    if !table.is_present() {
        return (None, text.to_owned());
    }
    let axis = table.required_word("axis", &AXES);
    let tau_mm = table.has("tau_mm").then(|| table.within("tau_mm", 1.0, 1e-6..=1e4));
    if tau_mm.is_none() {
        table.problem(
            "tau_mm",
            "a length in mm: some six times the distance of the points",
            "nothing",
        );
    }
    let strip_mm = tau_mm.map(|tau_mm| table.within("strip_mm", 2.0 * tau_mm, tau_mm..=1e5));
    let min_points = table.within("min_points", 20, 1..=1_000_000_000_u64);
    let within_mm = table.has("within_mm").then(|| table.within("within_mm", 1.0, 1e-9..=1e4));
    let name: Option<String> = table.has("library").then(|| table.get("library")).flatten();
    let recorded = table.section(TEXTS);
    let texts = name.as_ref().map(|name| texts(table, &recorded, &folder.join(name)));
    if within_mm.is_some() && name.is_none() {
        table.problem("within_mm", "no such key, or library = \"DIR\"", "`within_mm`");
    }
    table.finish();
    let texts = match texts {
        Some(None) => return (None, text.to_owned()),
        Some(Some(texts)) => Some(texts),
        None => None,
    };
    let library = match (&name, &texts) {
        (Some(name), Some(texts)) => match library(table, &folder.join(name), texts) {
            Some(library) => Some(library),
            None => return (None, text.to_owned()),
        },
        _ => None,
    };
    let text = texts.map_or_else(|| text.to_owned(), |texts| embedded(text, &texts));
    let plan = (|| {
        let ((axis, is_reversed), tau_mm, strip_mm) = (axis?, tau_mm?, strip_mm?);
        let settings = RunningSettings { axis, is_reversed, tau_mm, strip_mm, keeps_points: true };
        Some(PartsPlan { settings, min_points, library, within_mm, has_no_whole: false })
    })();
    (plan, text)
}

/// The texts of the library: those that a recording holds, or else those of the folder.
fn texts(
    table: &Section<'_>,
    recorded: &Section<'_>,
    folder: &Path,
) -> Option<Vec<(String, String)>> {
    if recorded.is_present() {
        let kept: Vec<[String; 2]> = recorded
            .get::<Vec<Vec<String>>>("files")?
            .into_iter()
            .filter_map(|pair| <[String; 2]>::try_from(pair).ok())
            .collect();
        recorded.finish();
        return Some(kept.into_iter().map(|[name, text]| (name, text)).collect());
    }
    let files = match files_in(folder) {
        Ok(files) => files,
        Err(problem) => {
            table.problem("library", "a folder of nominals", problem);
            return None;
        }
    };
    let mut texts = Vec::new();
    let mut is_whole = true;
    for path in files {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let read = bytes_of(&path).map_err(|error| error.to_string());
        match read.and_then(|bytes| text_of(&name, bytes)) {
            Ok(text) => texts.push((name, text)),
            Err(found) => {
                let expected = "nominals (.toml) and lens files (.zmx) alone: a station measures each part; take it out";
                table.problem("library", expected, format!("{name}: {found}"));
                is_whole = false;
            }
        }
    }
    if texts.is_empty() && is_whole {
        table.problem(
            "library",
            "one nominal (.toml) or lens file (.zmx) at least",
            "an empty folder",
        );
        return None;
    }
    is_whole.then_some(texts)
}

fn library(table: &Section<'_>, folder: &Path, texts: &[(String, String)]) -> Option<Library> {
    let library = match Library::of_texts(folder, texts) {
        Ok(library) => library,
        Err(problems) => {
            for problem in problems {
                table.problem("library", "nominals that a part can be held against", problem);
            }
            return None;
        }
    };
    let weighs = |part: &&asphera_measure::Part| part.criterion.weights == Weights::Uncertainty;
    if library.nominals.iter().flatten().any(|part| weighs(&part)) {
        let expected = "nominals without weights = \"uncertainty\": points of parts have none";
        table.problem("library", expected, "such a nominal");
        return None;
    }
    Some(library)
}

/// The configuration with the texts of the library in it.
fn embedded(text: &str, texts: &[(String, String)]) -> String {
    let Ok(mut document) = DocumentMut::from_str(text) else { return text.to_owned() };
    let pairs: toml_edit::Array = texts
        .iter()
        .map(|(name, text)| toml_edit::Array::from_iter([name.as_str(), text.as_str()]))
        .collect();
    if let Some(table) = document.get_mut("parts").and_then(|table| table.as_table_like_mut()) {
        let mut kept = toml_edit::Table::new();
        kept.insert("files", toml_edit::value(pairs));
        table.insert(TEXTS, toml_edit::Item::Table(kept));
    }
    document.to_string()
}

/// The table in which a recording keeps the library.
const TEXTS: &str = "library_text";

const AXES: [(&str, (usize, bool)); 6] = [
    ("x", (0, false)),
    ("y", (1, false)),
    ("z", (2, false)),
    ("-x", (0, true)),
    ("-y", (1, true)),
    ("-z", (2, true)),
];

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use crate::config::Config;

    const FLAT: &str =
        "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 5\n";

    /// A folder with the flat station of the examples, and a library.
    fn station(parts: &str, library: &[(&str, &str)]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let examples = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../config/examples");
        fs::copy(examples.join("flat.toml"), folder.path().join("flat.toml")).unwrap();
        let text = fs::read_to_string(examples.join("line-scanner.toml")).unwrap();
        let path = folder.path().join("station.toml");
        fs::write(&path, format!("{text}\n[parts]\n{parts}")).unwrap();
        fs::create_dir(folder.path().join("library")).unwrap();
        for (name, text) in library {
            fs::write(folder.path().join("library").join(name), text).unwrap();
        }
        (folder, path)
    }

    /// The table of the reference, as it is shown there.
    fn shown() -> String {
        let reference = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../config/asphera.toml");
        let text = fs::read_to_string(reference).unwrap();
        let table = &text[text.find("# [parts]").unwrap()..];
        let table = &table[..table.find("\n\n").unwrap()];
        let keys = table.lines().filter_map(|line| line.strip_prefix("# "));
        keys.filter(|line| {
            line.split_once(" = ").is_some_and(|(key, _)| {
                key.chars().all(|letter| letter.is_ascii_lowercase() || letter == '_')
            })
        })
        .map(|line| format!("{line}\n"))
        .collect()
    }

    #[test]
    fn the_table_of_the_reference_is_known_and_its_library_stays_in_the_text() {
        let (folder, path) = station(&shown(), &[("flat.toml", FLAT)]);
        let config = Config::load(&path).unwrap();
        let plan = config.parts.as_ref().unwrap();
        let settings = plan.settings;
        assert_eq!((settings.axis, settings.is_reversed), (1, false));
        assert_eq!((settings.tau_mm, settings.strip_mm, plan.min_points), (1.5, 3.0, 20));
        assert_eq!(plan.within_mm, Some(0.05));
        assert_eq!(plan.library.as_ref().unwrap().name(0), "flat.toml");
        // A recording is replayed where the library is gone.
        fs::remove_dir_all(folder.path().join("library")).unwrap();
        fs::write(&path, &config.text).unwrap();
        let again = Config::load(&path).unwrap();
        assert_eq!(again.parts.unwrap().library.unwrap().name(0), "flat.toml");
        assert_eq!(again.text, config.text);
    }

    #[test]
    fn mistakes_are_named_with_their_keys() {
        let error = |parts: &str, library: &[(&str, &str)]| {
            let (_folder, path) = station(parts, library);
            Config::load(&path).unwrap_err().to_string()
        };
        let found = error("axis = \"w\"\nstrip = 3\n", &[]);
        for expected in ["parts.axis: expected \"x\"", "parts.tau_mm: expected a length", "strip"] {
            assert!(found.contains(expected), "{expected}: {found}");
        }
        let narrow = error("axis = \"x\"\ntau_mm = 2\nstrip_mm = 1\n", &[]);
        assert!(narrow.contains("parts.strip_mm"), "{narrow}");
        let alone = error("axis = \"x\"\ntau_mm = 2\nwithin_mm = 1\n", &[]);
        assert!(alone.contains("library = \"DIR\""), "{alone}");
        let with = |library: &[(&str, &str)]| {
            error("axis = \"-z\"\ntau_mm = 1\nlibrary = \"library\"\n", library)
        };
        assert!(with(&[]).contains("one nominal (.toml) or lens file (.zmx) at least"));
        let open = "[surface]\nkind = \"plane\"\n";
        assert!(with(&[("a.toml", open)]).contains("a.toml: a nominal without an aperture"));
        let weighing = format!("{FLAT}[fit]\nweights = \"uncertainty\"\n");
        assert!(with(&[("a.toml", &weighing)]).contains("without weights"));
    }
}
