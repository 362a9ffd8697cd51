//! A folder of nominals, meshes and scans as the library that parts are held against.

use std::path::{Path, PathBuf};

use asphera_formats::{read_triangles, zemax};
use asphera_geometry::PointMm;
use asphera_graph::Cloud;
use asphera_graph::library::LibraryEntry;
use asphera_measure::Part;
use rayon::prelude::*;

use asphera_formats::xyz::TextOptions;
use asphera_nominal::{bytes_of, text_of};

use super::shape::{entry_of, places_of};
use crate::lens;

/// The entries of a library, and the nominals of those that have one.
#[derive(Clone, Debug)]
pub(crate) struct Library {
    pub(crate) entries: Vec<LibraryEntry>,
    pub(crate) nominals: Vec<Option<Part>>,
}

/// The points of an earlier scan, or why they cannot be read.
pub(crate) type ReadScan<'a> = dyn Fn(&Path) -> Result<Vec<PointMm>, String> + Sync + 'a;

/// An entry with its nominal, if it has one.
type Entry = (LibraryEntry, Option<Part>);

impl Library {
    /// Reads every file of a folder, in the order of their names; `scan` reads earlier scans. Hidden files, and those that a nominal of the folder names, are
    /// no entries.
    ///
    /// # Errors
    ///
    /// A folder without entries; all files that can be none, each with the cure.
    pub(crate) fn open(folder: &Path, scan: &ReadScan<'_>) -> Result<Library, String> {
        let files = files_in(folder)?;
        let found: Vec<Result<Vec<Entry>, String>> =
            files.par_iter().map(|path| entries_of(path, scan)).collect();
        let problems: Vec<&str> =
            found.iter().filter_map(|found| found.as_ref().err().map(String::as_str)).collect();
        if !problems.is_empty() {
            return Err(problems.join("\n"));
        }
        let (entries, nominals): (Vec<_>, Vec<_>) = found.into_iter().flatten().flatten().unzip();
        match entries.is_empty() {
            true => Err(format!(
                "{}: expected a library with one file at least, found none; put nominals (.toml), lens files (.zmx), meshes or \
                 scans there",
                folder.display()
            )),
            false => Ok(Library { entries, nominals }),
        }
    }

    /// The nominals and lens files of a folder, as a station takes them, by their names and texts. `folder` is where nominals find
    /// files that they name.
    ///
    /// # Errors
    ///
    /// No entry; all files that can be none, each with the cure.
    pub(crate) fn of_texts(
        folder: &Path,
        texts: &[(String, String)],
    ) -> Result<Library, Vec<String>> {
        let found: Vec<Result<Vec<Entry>, String>> = texts
            .par_iter()
            .map(|(name, text)| {
                entries_of_text(&folder.join(name), name, text.clone().into_bytes())
            })
            .collect();
        let problems: Vec<String> =
            found.iter().filter_map(|found| found.as_ref().err().cloned()).collect();
        if !problems.is_empty() {
            return Err(problems);
        }
        let (entries, nominals): (Vec<_>, Vec<_>) = found.into_iter().flatten().flatten().unzip();
        Ok(Library { entries, nominals })
    }

    /// The name of an entry.
    pub(crate) fn name(&self, entry: usize) -> &str {
        self.entries[entry].name()
    }
}

/// The files of a folder by name.
pub(crate) fn files_in(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let listed = std::fs::read_dir(folder).map_err(|error| {
        format!("{}: expected a folder as the library: {error}", folder.display())
    })?;
    let mut files = Vec::new();
    for entry in listed {
        let path =
            entry.map_err(|error| format!("cannot list {}: {error}", folder.display()))?.path();
        if !name_of(&path).starts_with('.') {
            files.push(path);
        }
    }
    files.sort();
    // Heights that a nominal of the folder stands on are part of it.
    let nominals: Vec<String> = files
        .iter()
        .filter(|path| is_toml(path))
        .filter_map(|path| std::fs::read_to_string(path).ok())
        .collect();
    let is_named = |path: &PathBuf| {
        let quoted = format!("\"{}\"", name_of(path));
        nominals.iter().any(|text| text.contains(&quoted))
    };
    files.retain(|path| !is_named(path));
    Ok(files)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The entries of a file; or why it has none, with its name and the cure.
fn entries_of(path: &Path, scan: &ReadScan<'_>) -> Result<Vec<Entry>, String> {
    let (name, file) = (name_of(path), path.display().to_string());
    if path.is_dir() {
        return of_scan(path, &name, scan).map(|entry| vec![(entry, None)]);
    }
    let bytes = bytes_of(path).map_err(|error| format!("cannot read {file}: {error}"))?;
    if zemax::is_zemax(&bytes) || is_toml(path) {
        return entries_of_text(path, &name, bytes);
    }
    // What is no mesh of faces is taken for a scan, whose reader says what is wrong with it.
    let mesh = read_triangles(&file, &bytes, &TextOptions::default());
    let entry = match mesh {
        Ok(Some(mesh)) => entry_of(&name, &mesh).map_err(|problem| format!("{file}: {problem}"))?,
        Ok(None) | Err(_) => of_scan(path, &name, scan)?,
    };
    Ok(vec![(entry, None)])
}

/// The entries of a nominal or a lens file.
fn entries_of_text(path: &Path, name: &str, bytes: Vec<u8>) -> Result<Vec<Entry>, String> {
    let file = path.display().to_string();
    let named = |problem: String| format!("{file}: {problem}");
    let of_nominal = |name: &str, part: Part| -> Result<Entry, String> {
        let places = places_of(&part).map_err(named)?;
        let entry = LibraryEntry::face(name, &places).map_err(|error| named(error.to_string()))?;
        Ok((entry, Some(part)))
    };
    if zemax::is_zemax(&bytes) {
        return nominals_of_lens(&file, &bytes)?
            .into_iter()
            .map(|(number, part)| of_nominal(&format!("{name} {number}"), part))
            .collect();
    }
    let text = text_of(&file, bytes)
        .map_err(|found| format!("{file}: expected a nominal in TOML, found {found}"))?;
    // The reader names the file.
    let part = asphera_nominal::parse(&file, &text).map_err(|error| error.to_string())?;
    of_nominal(name, part).map(|entry| vec![entry])
}

/// The surfaces of a lens that bend light, with their numbers.
fn nominals_of_lens(file: &str, bytes: &[u8]) -> Result<Vec<(u32, Part)>, String> {
    let lens = zemax::read(bytes).map_err(|error| format!("{file}: {error}"))?;
    let bends = |surface: &&zemax::LensSurface| {
        surface.curvature != 0.0 && (surface.semi_diameter > 0.0 || surface.aperture.is_some())
    };
    let mut nominals = Vec::new();
    for surface in lens.surfaces.iter().filter(bends) {
        let number = surface.number;
        let text =
            lens::nominal(&lens, number, file, None).map_err(|error| format!("{file}: {error}"))?;
        let part = asphera_nominal::parse(file, &text)
            .map_err(|problems| format!("{file}: surface {number} is no surface: {problems}"))?;
        nominals.push((number, part));
    }
    match nominals.is_empty() {
        true => Err(format!(
            "{file}: expected a lens with a curved surface that has a semi-diameter, found none; take the file out of the library"
        )),
        false => Ok(nominals),
    }
}

/// An earlier scan as it is, seen from its +z side.
fn of_scan(path: &Path, name: &str, scan: &ReadScan<'_>) -> Result<LibraryEntry, String> {
    let cure = "take it out of the library, or make it a nominal (.toml), a lens file, a mesh, or a scan whose columns have names";
    let points = scan(path).map_err(|error| format!("{error}; {cure}"))?;
    let named = |problem: String| format!("{}: {problem}; {cure}", path.display());
    let cloud = Cloud::new(&points).map_err(|error| named(error.to_string()))?;
    // The order of the places goes through space, so every so many of them are spread over all.
    let step = cloud.len().div_ceil(MOST_OF_SCAN).max(1);
    let some: Vec<PointMm> = cloud.places().iter().copied().step_by(step).collect();
    LibraryEntry::face(name, &some).map_err(|error| named(error.to_string()))
}

/// Places of a scan that an entry has at most.
const MOST_OF_SCAN: usize = 20_000;
