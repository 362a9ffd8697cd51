//! The files a measurement leaves, by name.

/// A file a measurement leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultFile {
    /// All figures as JSON.
    Report,
    /// The report to read and to print.
    Html,
    /// QIF 3.
    Qif,
    /// The mesh.
    Mesh,
    /// The mesh with the deviation of its points.
    DeviationMesh,
    /// The deviation on a grid; needs a fit.
    DeviationMap,
}

impl ResultFile {
    /// Every one.
    pub const ALL: [ResultFile; 6] = [
        ResultFile::Report,
        ResultFile::Html,
        ResultFile::Qif,
        ResultFile::Mesh,
        ResultFile::DeviationMesh,
        ResultFile::DeviationMap,
    ];

    /// Files that `--out` writes.
    pub const OUT: [ResultFile; 4] =
        [ResultFile::Report, ResultFile::Mesh, ResultFile::DeviationMesh, ResultFile::DeviationMap];

    /// Its name in a folder.
    pub const fn name(self) -> &'static str {
        match self {
            ResultFile::Report => "report.json",
            ResultFile::Html => "report.html",
            ResultFile::Qif => "qif.xml",
            ResultFile::Mesh => "mesh.ply",
            ResultFile::DeviationMesh => "deviation.ply",
            ResultFile::DeviationMap => "deviation.x3p",
        }
    }

    /// Whether it states where it comes from: with the checksums of its sources.
    pub const fn is_paper(self) -> bool {
        matches!(self, ResultFile::Html | ResultFile::Qif)
    }

    /// The file of this name.
    pub fn named(name: &str) -> Option<ResultFile> {
        ResultFile::ALL.into_iter().find(|file| file.name() == name)
    }
}
