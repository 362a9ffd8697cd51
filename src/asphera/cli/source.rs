//! The points that commands work on, whatever holds them: a file, a folder of results, a recorded session.

mod recorded;

use std::path::{Path, PathBuf};

use asphera_formats::xyz::TextOptions;
use asphera_formats::{Cloud, Format, KINDS, Source as Origin, Topography, VOLUME_KINDS};
use asphera_geometry::PointMm;
pub(super) use recorded::Recorded;

use asphera_report::{ReadingFigures, ResultFile, columns, error_chain};

use super::files::read;
use super::output::{Failure, say};
use super::progress::Progress;
use super::text::{TextArgs, reading};
use super::usage::misused;
use asphera_measure::Along;
use asphera_measure::Part;

/// The points of a file or of a recorded session.
pub(super) struct Source {
    path: PathBuf,
    /// The file or session that holds the points; the same as `path`, unless that is a folder of results.
    file: PathBuf,
    content: Content,
}

/// What holds the points.
pub(super) enum Content {
    /// A file of points.
    File(Box<Topography>),
    /// A recording that was played to its end.
    Session(Box<Recorded>),
}

/// What a path leads to.
#[derive(Debug, PartialEq)]
enum Place {
    File(PathBuf),
    /// A session's folder, or a segment of one.
    Session(PathBuf),
}

impl Source {
    /// Reads the points at `path`: a file, a session's folder or one of its segments, or a folder as `--out` writes it: the
    /// session in it, or `mesh.ply`. A session is played to its end.
    pub(super) fn open(
        path: &Path,
        text: &TextArgs,
        progress: &Progress,
    ) -> Result<Source, Failure> {
        Source::open_with(path, text, &text.options(), progress)
    }

    /// The same where x and y will do.
    pub(super) fn open_in_plane(
        path: &Path,
        text: &TextArgs,
        progress: &Progress,
    ) -> Result<Source, Failure> {
        let options = TextOptions { in_plane: true, ..text.options() };
        Source::open_with(path, text, &options, progress)
    }

    fn open_with(
        path: &Path,
        text: &TextArgs,
        options: &TextOptions,
        progress: &Progress,
    ) -> Result<Source, Failure> {
        let (file, content) = match place(path)? {
            Place::File(file) => {
                progress.stage("reading");
                let topography = topography(&file, options)?;
                (file, Content::File(Box::new(topography)))
            }
            Place::Session(session) => {
                if text.is_given() {
                    return Err(misused(format!(
                        "{} is a recording, which states its columns and units itself: leave out `--columns`, \
                         `--unit`, `--skip-lines`, `--pitch` and `--keep-marks`",
                        path.display()
                    )));
                }
                let recorded = Recorded::play(&session, progress)?;
                (session, Content::Session(Box::new(recorded)))
            }
        };
        Ok(Source { path: path.to_owned(), file, content })
    }

    /// Points that were made of what lies at `path`.
    pub(super) fn of_points(path: &Path, points_mm: Vec<PointMm>, format: Format) -> Source {
        Source::of_cloud(path, Cloud { points_mm, ..Cloud::default() }, format)
    }

    /// The same with what is known of the points.
    pub(super) fn of_cloud(path: &Path, cloud: Cloud, format: Format) -> Source {
        let origin = Origin { format, instrument: None, date: None, comment: None, taken: None };
        let content = Content::File(Box::new(Topography::Cloud(cloud, origin)));
        Source { path: path.to_owned(), file: path.to_owned(), content }
    }

    /// The path as it was given.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The file that holds the points: of a folder of results `mesh.ply`; of a session its folder or segment.
    pub(super) fn file(&self) -> &Path {
        &self.file
    }

    /// What holds the points.
    pub(super) fn content(&self) -> &Content {
        &self.content
    }

    /// The nominal of the command line, or else the one in the recording; `None` for a file without `--nominal`.
    pub(super) fn part(&self, given: Option<Part>) -> Option<Part> {
        given.or_else(|| match &self.content {
            Content::Session(session) => Some(session.part().clone()),
            Content::File(_) => None,
        })
    }

    /// The same where a nominal is needed.
    pub(super) fn needed_part(&self, given: Option<Part>) -> Result<Part, Failure> {
        self.part(given).ok_or_else(|| {
            let path = self.path.display();
            misused(format!(
                "{path} is a file of points: --nominal FILE says what the part should be"
            ))
        })
    }

    /// The direction of projection: that of the command line, of the recording, or z.
    pub(super) fn along(&self, given: Option<Along>) -> Along {
        given.unwrap_or(match &self.content {
            Content::Session(session) => session.along(),
            Content::File(_) => Along::Z,
        })
    }

    /// The points that count, x, y, z in mm in the measured frame, in the order they were measured.
    pub(super) fn points(&self) -> Box<dyn Iterator<Item = PointMm> + '_> {
        match &self.content {
            Content::File(topography) => Box::new(topography.points()),
            Content::Session(session) => session.good_points(),
        }
    }

    /// How many points there are, gaps and flagged ones left out.
    pub(super) fn len(&self) -> u64 {
        self.points().count() as u64
    }

    /// How many places have no height: gaps of a file, flagged points of a session.
    pub(super) fn missing(&self) -> usize {
        match &self.content {
            Content::File(topography) => topography.missing(),
            Content::Session(session) => session.flagged(),
        }
    }

    /// The standard uncertainties of heights in mm that a file has, in the order of its points, and its format; none of a session.
    pub(super) fn uncertainties_mm(&self) -> (&[f64], Format) {
        match &self.content {
            Content::File(topography) => {
                (topography.uncertainties_mm(), topography.source().format)
            }
            Content::Session(_) => (&[], Format::Xyz),
        }
    }

    /// Where a file comes from; `None` for a session, whose report says so itself.
    pub(super) fn origin(&self) -> Option<&Origin> {
        match &self.content {
            Content::File(topography) => Some(topography.source()),
            Content::Session(_) => None,
        }
    }

    /// Columns and units as they were read of a text file.
    pub(super) fn reading(&self) -> Option<ReadingFigures> {
        match &self.content {
            Content::File(topography) => reading(topography),
            Content::Session(_) => None,
        }
    }

    /// Losses of a session and of its recording, in the words of its report; none of a file.
    pub(super) fn losses(&self) -> Vec<String> {
        match &self.content {
            Content::File(_) => Vec::new(),
            Content::Session(session) => session.losses(),
        }
    }

    /// Says on stderr how the points were read, where no report does.
    pub(super) fn say_reading(&self) {
        match &self.content {
            Content::File(_) => {
                if let Some(reading) = self.reading() {
                    say(&format!("columns    {}", columns(&reading)));
                    reading.cautions.iter().for_each(|words| say(&format!("  caution: {words}")));
                }
                if self.missing() > 0 {
                    say(&format!(
                        "missing    {} places without a height, left out",
                        self.missing()
                    ));
                }
            }
            Content::Session(session) => {
                say(&session.told());
                self.losses().iter().for_each(|loss| say(&format!("  {loss}")));
            }
        }
    }
}

/// What the help says of an argument that is a source of points.
pub(super) fn source_help() -> String {
    format!(
        "The points: {KINDS}; a recorded session (its folder session-…, or a segment .mcap); or a folder of --out: the \
         session in it, or {MESH}"
    )
}

/// The same where a face of a volume will do.
pub(super) fn source_or_volume_help() -> String {
    format!("{}; or a volume, of which the nominal says the face: {VOLUME_KINDS}", source_help())
}

/// What a path leads to. The one place that looks into a folder.
fn place(path: &Path) -> Result<Place, Failure> {
    if is_recording(path) {
        return Ok(Place::Session(path.to_owned()));
    }
    if !path.is_dir() {
        return Ok(Place::File(path.to_owned()));
    }
    let (mesh, sessions) = (path.join(MESH), sessions_in(path)?);
    let found = match (&sessions[..], reported_session(path)) {
        // The results are those of the session that their report names; a report without one is of a file.
        (_, Some(Some(id))) if sessions.contains(&path.join(&id)) => {
            return Ok(Place::Session(path.join(id)));
        }
        _ if mesh.is_file() => return Ok(Place::File(mesh)),
        ([], _) => "neither; give a file of points, or another folder".to_owned(),
        ([one], _) => return Ok(Place::Session(one.clone())),
        ([first, ..], _) => {
            format!("{} sessions inside: give one, as {}", sessions.len(), first.display())
        }
    };
    Err(format!(
        "{}: expected a folder session-… with a recording, or one with {MESH} as --out writes it, found {found}",
        path.display()
    )
    .into())
}

/// The session at a path, where only a session will do: as [`Source::open`] finds it.
pub(super) fn session_at(path: &Path) -> Result<PathBuf, Failure> {
    match place(path)? {
        Place::Session(session) => Ok(session),
        // What it lacks is told by who opens it.
        Place::File(_) => Ok(path.to_owned()),
    }
}

/// The session that the report in a folder is of; `None` without a report that can be read.
fn reported_session(folder: &Path) -> Option<Option<String>> {
    #[derive(serde::Deserialize)]
    struct OfReport {
        session: Option<OfSession>,
    }
    #[derive(serde::Deserialize)]
    struct OfSession {
        id: String,
    }
    let bytes = std::fs::read(folder.join(ResultFile::Report.name())).ok()?;
    let report: OfReport = serde_json::from_slice(&bytes).ok()?;
    Some(report.session.map(|session| session.id))
}

/// Whether a path is a session's folder or a segment of one. A folder that is called so, too: opening it says what it lacks.
pub(super) fn is_recording(path: &Path) -> bool {
    let is_segment = |path: &Path| path.extension().is_some_and(|extension| extension == "mcap");
    if !path.is_dir() {
        return is_segment(path);
    }
    let holds_segment = std::fs::read_dir(path)
        .is_ok_and(|entries| entries.flatten().any(|entry| is_segment(&entry.path())));
    holds_segment || is_session_name(path)
}

/// The sessions that lie in a folder, by name.
fn sessions_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| format!("cannot list {}: {error}", folder.display()))?;
    let mut sessions: Vec<PathBuf> =
        entries.flatten().map(|entry| entry.path()).filter(|path| is_recording(path)).collect();
    sessions.sort();
    Ok(sessions)
}

fn is_session_name(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("session-"))
}

/// The points of a file.
fn topography(path: &Path, options: &TextOptions) -> Result<Topography, Failure> {
    let name = path.display().to_string();
    let bytes = read(path)?;
    asphera_formats::read_with(&name, &bytes, options).map_err(|error| match error.names_file() {
        true => error.to_string().into(),
        false => format!("{name}: {}", error_chain(&error)).into(),
    })
}

/// The file of a folder of results that holds its points.
const MESH: &str = "mesh.ply";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_told_apart_and_a_stranger_is_told_what_is_expected() {
        let dir = tempfile::tempdir().unwrap();
        let [session, results, empty, demo] =
            ["session-1", "results", "empty", "demo"].map(|name| dir.path().join(name));
        for folder in [&session, &results, &empty, &demo.join("session-2"), &dir.path().join("s")] {
            std::fs::create_dir_all(folder).unwrap();
        }
        std::fs::write(results.join(MESH), "ply\n").unwrap();
        std::fs::write(dir.path().join("s/0000.mcap"), "").unwrap();
        for path in [session, dir.path().join("s"), dir.path().join("s/0000.mcap")] {
            assert_eq!(place(&path).unwrap(), Place::Session(path));
        }
        assert_eq!(place(&results).unwrap(), Place::File(results.join(MESH)));
        assert_eq!(place(Path::new("a.xyz")).unwrap(), Place::File("a.xyz".into()));
        let said = place(&empty).unwrap_err().to_string();
        assert!(said.contains("expected a folder session-…") && said.contains("found neither"));
        // A folder as a station or a demo leaves it.
        assert_eq!(place(&demo).unwrap(), Place::Session(demo.join("session-2")));
        std::fs::create_dir(demo.join("session-3")).unwrap();
        let said = place(&demo).unwrap_err().to_string();
        assert!(said.contains("2 sessions inside: give one, as"), "{said}");
        std::fs::write(demo.join(MESH), "ply\n").unwrap();
        let report = |session: &str| {
            std::fs::write(demo.join("report.json"), format!("{{\"session\": {session}}}"))
                .unwrap();
        };
        report("{\"id\": \"session-3\", \"started\": \"\"}");
        assert_eq!(place(&demo).unwrap(), Place::Session(demo.join("session-3")));
        assert_eq!(session_at(&demo).unwrap(), demo.join("session-3"));
        // Results of a file that were written there since, or of a session that has gone.
        for other in ["null", "{\"id\": \"session-9\"}", "{\"id\": \"../demo/session-3\"}"] {
            report(other);
            assert_eq!(place(&demo).unwrap(), Place::File(demo.join(MESH)));
        }
    }
}
