//! A report as people read it: chapters of facts, tables and notes, with rounded numbers and units.
//!
//! It is made once, here. The terminal, the page and the paper draw it, each in its own way, and add their pictures.
//! So a figure that is added to the report has one place where its words are chosen.

mod contour;
mod deviation;
mod face;
mod features;
mod figures;
mod fit;
mod links;
mod parts;
mod points;
mod profile;
mod reconstruction;
mod reliability;
mod sampling;
mod verdict;

pub(crate) use figures::{definition, known_of};
pub use points::columns;
pub(crate) use reliability::of_draws;
use serde::Serialize;

use crate::contour::ContourReport;
use crate::parts::SessionParts;
use crate::standards::Standard;
use crate::{
    FaceFigures, FeatureFigures, FormFigures, LinkFigures, MeshFigures, Points, ProfileFigures,
    ReadingFigures, Report, SamplingFigures, SessionFigures, Snapshot, Verdict,
};

/// A report in words.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct View {
    /// The few figures that are read first: PV, RMS, coverage.
    pub headline: Vec<Fact>,
    /// All else, in the order in which it is read. A chapter without content is absent.
    pub chapters: Vec<Chapter>,
}

/// Figures that belong together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Chapter {
    /// Its identity: fronts put their pictures by it.
    pub id: ChapterId,
    /// Chapter under which a front shows it that has no place for it alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placed_under: Option<ChapterId>,
    /// Its heading.
    pub title: &'static str,
    /// The lines of a short summary; none where the summary does not mention it.
    pub brief: Vec<String>,
    /// All of it.
    pub blocks: Vec<Block>,
}

/// Chapters that there may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChapterId {
    /// Form deviation: PV, RMS, their uncertainty, what was not measured.
    Deviation,
    /// Figures by standards and optical shops.
    Figures,
    /// Fit of the nominal.
    Fit,
    /// Zernike terms.
    Zernike,
    /// Figures of a profile.
    Profile,
    /// Sampling, and what to measure next.
    Sampling,
    /// Defects, and which way the surface bends.
    Defects,
    /// Volume and the face that was measured of it.
    Volume,
    /// Contour of the points.
    Contour,
    /// Parts of the scene.
    Parts,
    /// Points and what became of them.
    Points,
    /// Mesh and its plane.
    Mesh,
    /// Links and devices.
    Links,
    /// Session, part, operator.
    Session,
    /// Verdict and its checks.
    Verdict,
    /// A figure of standards.
    #[serde(untagged)]
    Standard(Standard),
}

impl ChapterId {
    /// Its word in a short summary.
    pub fn word(self) -> &'static str {
        match self {
            ChapterId::Deviation => "deviation",
            ChapterId::Figures => "figures",
            ChapterId::Fit => "fit",
            ChapterId::Zernike => "zernike",
            ChapterId::Profile => "profile",
            ChapterId::Sampling => "sampling",
            ChapterId::Defects => "defects",
            ChapterId::Volume => "volume",
            ChapterId::Contour => "contour",
            ChapterId::Parts => "parts",
            ChapterId::Points => "points",
            ChapterId::Mesh => "mesh",
            ChapterId::Links => "links",
            ChapterId::Session => "session",
            ChapterId::Verdict => "verdict",
            ChapterId::Standard(figure) => figure.word(),
        }
    }
}

/// A piece of a chapter.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Block {
    /// Names with their values.
    Facts {
        /// In the order in which they are read.
        facts: Vec<Fact>,
    },
    /// Rows of cells.
    Table(Table),
    /// A sentence or two.
    Note {
        /// With its full stop.
        text: String,
    },
    /// A sentence that must not be passed over.
    Caution {
        /// With its full stop.
        text: String,
    },
}

/// A name with its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fact {
    /// Its name.
    pub name: String,
    /// Its value, with unit.
    pub value: String,
    /// What must be known to read it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Whether it tells of something wrong.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub bad: bool,
}

/// Rows of cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Table {
    /// Its heading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Its columns.
    pub columns: Vec<Column>,
    /// As many cells as columns in each row.
    pub rows: Vec<Vec<String>>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// Its heading; may be empty.
    pub title: String,
    /// Layout of its cells.
    pub layout: Layout,
}

/// Layout of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// Heading of its row.
    Head,
    /// Words.
    Text,
    /// Number with unit.
    Number,
    /// Long words that explain, in small letters.
    Fine,
}

/// Figures that a view is made from: those of a report or of a snapshot.
struct Shown<'a> {
    reading: Option<&'a ReadingFigures>,
    face: Option<&'a FaceFigures>,
    points: &'a Points,
    mesh: &'a MeshFigures,
    sampling: &'a SamplingFigures,
    features: &'a FeatureFigures,
    form: Option<&'a FormFigures>,
    profile: Option<&'a ProfileFigures>,
    contour: Option<&'a ContourReport>,
    parts: Option<&'a SessionParts>,
    verdict: &'a Verdict,
    links: &'a [LinkFigures],
    session: Option<&'a SessionFigures>,
    /// Longest time for which recorded points waited to be processed, s.
    most_behind_s: f64,
}

impl View {
    /// The view of a report. Time in proportion to what it says.
    pub fn of_report(report: &Report) -> View {
        View::new(&Shown {
            reading: report.reading.as_ref(),
            face: report.volume.as_ref(),
            points: &report.points,
            mesh: &report.mesh,
            sampling: &report.sampling,
            features: &report.features,
            form: report.form.as_ref(),
            profile: report.profile.as_ref(),
            contour: report.contour.as_ref(),
            parts: report.parts.as_ref(),
            verdict: &report.verdict,
            links: &report.links,
            session: report.session.as_ref(),
            most_behind_s: report.timing.most_behind_s,
        })
    }

    /// The view of a snapshot. Its links have a state of their own, which is no part of it.
    pub fn of_snapshot(snapshot: &Snapshot) -> View {
        View::new(&Shown {
            reading: None,
            face: snapshot.volume.as_ref().map(|volume| &*volume.face),
            points: &snapshot.points,
            mesh: &snapshot.mesh,
            sampling: &snapshot.sampling,
            features: &snapshot.features,
            form: snapshot.form.as_ref(),
            profile: None,
            contour: None,
            parts: None,
            verdict: &snapshot.verdict,
            links: &[],
            session: snapshot.session.as_ref(),
            most_behind_s: 0.0,
        })
    }

    /// The view of a sampling alone, with the features that were looked for.
    pub fn of_sampling(sampling: &SamplingFigures, features: &FeatureFigures) -> View {
        let chapters = vec![sampling::chapter(sampling), features::chapter(features)];
        View { headline: Vec::new(), chapters: with_content(chapters) }
    }

    /// A chapter, if there is one.
    pub fn chapter(&self, id: ChapterId) -> Option<&Chapter> {
        self.chapters.iter().find(|chapter| chapter.id == id)
    }

    fn new(shown: &Shown<'_>) -> View {
        let mut chapters = Vec::new();
        if let Some(form) = shown.form {
            chapters.push(deviation::chapter(form));
            chapters.push(figures::chapter(form));
            chapters.extend(form.standards.chapters(form));
            chapters.push(fit::chapter(form));
            chapters.extend(figures::zernike(form));
        }
        chapters.extend(shown.face.map(face::chapter));
        chapters.extend(shown.profile.map(profile::chapter));
        chapters.extend(shown.contour.map(contour::chapter));
        chapters.extend(shown.parts.map(parts::chapter));
        chapters.extend([
            sampling::chapter(shown.sampling),
            features::chapter(shown.features),
            points::chapter(shown.points, shown.reading),
            points::mesh(shown.mesh),
            links::chapter(shown.links),
        ]);
        let session = |session| links::session(session, shown.most_behind_s);
        chapters.extend(shown.session.map(session));
        chapters.push(verdict::chapter(shown.verdict));
        View {
            headline: match (shown.form, shown.parts) {
                (None, Some(found)) => parts::headline(found),
                (form, _) => deviation::headline(form, shown.sampling),
            },
            chapters: with_content(chapters),
        }
    }
}

fn with_content(chapters: Vec<Chapter>) -> Vec<Chapter> {
    let told = |chapter: &Chapter| !(chapter.brief.is_empty() && chapter.blocks.is_empty());
    chapters.into_iter().filter(told).collect()
}

impl Chapter {
    fn new(id: ChapterId, title: &'static str) -> Chapter {
        Chapter { id, placed_under: None, title, brief: Vec::new(), blocks: Vec::new() }
    }

    /// The chapter of a figure of standards.
    pub(crate) fn of_standard(figure: Standard, title: &'static str) -> Chapter {
        Chapter {
            placed_under: figure.placed_under(),
            ..Chapter::new(ChapterId::Standard(figure), title)
        }
    }

    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Note { text: text.into() });
    }

    fn facts(&mut self, facts: Vec<Fact>) {
        if !facts.is_empty() {
            self.blocks.push(Block::Facts { facts });
        }
    }

    pub(crate) fn table(&mut self, table: Table) {
        if !table.rows.is_empty() {
            self.blocks.push(Block::Table(table));
        }
    }
}

impl Fact {
    fn new(name: impl Into<String>, value: impl Into<String>) -> Fact {
        Fact { name: name.into(), value: value.into(), note: None, bad: false }
    }

    fn noted(self, note: impl Into<String>) -> Fact {
        Fact { note: Some(note.into()), ..self }
    }

    fn bad_if(self, bad: bool) -> Fact {
        Fact { bad, ..self }
    }
}

impl Table {
    pub(crate) fn new(columns: &[(&str, Layout)]) -> Table {
        let column = |&(title, layout): &(&str, Layout)| Column { title: title.to_owned(), layout };
        Table { title: None, columns: columns.iter().map(column).collect(), rows: Vec::new() }
    }

    fn titled(self, title: &str) -> Table {
        Table { title: Some(title.to_owned()), ..self }
    }
}
