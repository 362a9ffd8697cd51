//! The surface of a volume, made at once or band by band, written and measured.

use std::fs::{File, OpenOptions};
use std::ops::Range;
use std::path::{Path, PathBuf};

use asphera_formats::volume::{Frame, SliceReader, Values};
use asphera_formats::{ply, stl};
use asphera_volume::{
    Ambiguity, Bands, Grey as GreyValues, GreySlices, Method, Middles, Surface, SurfaceBand,
    SurfaceFigures, SurfaceTally, reconstruct, trilinear_surface,
};
use rayon::prelude::*;

use super::super::output::{Failure, cannot_write};
use super::super::usage::misused;
use super::VolumeArgs;
use super::opened::{Grey, Opened, moved};
use super::sliced::{SlicedFile, next};
use crate::whole_file::{WholeFile, write_whole};

/// The formats that surfaces are written in.
enum MeshKind {
    Ply,
    Stl,
}

fn mesh_kind(path: &Path) -> Result<MeshKind, Failure> {
    match path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).as_deref() {
        Some("ply") => Ok(MeshKind::Ply),
        Some("stl") => Ok(MeshKind::Stl),
        _ => {
            Err(misused(format!("{}: expected a name that ends with .ply or .stl", path.display())))
        }
    }
}

/// Whether surfaces can be written under these names.
pub(super) fn check_names(paths: &[PathBuf]) -> Result<(), Failure> {
    paths.iter().try_for_each(|path| mesh_kind(path).map(|_| ()))
}

/// A surface, measured.
pub(super) struct Meshed {
    pub(super) figures: SurfaceFigures,
    /// Areas of marching cubes with their vertices at the threshold moved down, at it and moved up, by 1 % of the contrast; of grey
    /// values only.
    pub(super) moved_areas: Option<[f64; 3]>,
}

/// Makes the surface of a volume in mm of the file's frame, writes it into files and measures it.
pub(super) fn of(args: &VolumeArgs, opened: &Opened, files: &[PathBuf]) -> Result<Meshed, Failure> {
    match &opened.values {
        Grey::Whole(values) => {
            let figures = whole(args, opened, values.as_deref(), files)?;
            let moved_areas = values.as_ref().and_then(|values| {
                let bands = bands(opened);
                let mut areas = MovedAreas::new(opened)?;
                areas.add(&bands, 0..bands.slices(), values, 0);
                Some(areas.sums)
            });
            Ok(Meshed { figures, moved_areas })
        }
        Grey::Sliced(file) => {
            let reader = file.as_ref().map(SlicedFile::again).transpose()?;
            by_bands(args, opened, reader, files)
        }
    }
}

fn whole(
    args: &VolumeArgs,
    opened: &Opened,
    values: Option<&[f32]>,
    files: &[PathBuf],
) -> Result<SurfaceFigures, Failure> {
    let Opened { samples, frame, .. } = opened;
    let method = args.method()?;
    let surface = match values {
        Some(values) => {
            let size = samples.size();
            let grey = GreyValues { values, size, threshold: opened.threshold as f32 };
            match method {
                Method::Trilinear { .. } => trilinear_surface(samples, &grey),
                _ => reconstruct(samples, &method, &grey)?,
            }
        }
        None => reconstruct(samples, &method, &Middles)?,
    };
    let gaps = opened.gaps();
    let surface = if gaps.is_any() { surface.without_gaps(samples.size(), gaps) } else { surface };
    let surface = surface.moved(|vertex| frame.place_mm(vertex), frame.is_mirror());
    files.iter().try_for_each(|path| write_mesh(path, &surface))?;
    Ok(surface.figures())
}

fn write_mesh(path: &Path, surface: &Surface) -> Result<(), Failure> {
    let (vertices, triangles) = (&surface.vertices, &surface.triangles);
    let kind = mesh_kind(path)?;
    write_whole(path, |file| {
        let written = match kind {
            MeshKind::Ply => ply::write_mesh(file, vertices, triangles, None, &["lengths in mm"]),
            MeshKind::Stl => stl::write_mesh(file, vertices, triangles),
        };
        written.map_err(cannot_write(path))
    })
}

/// Slices of a band: the vertices and sides of two bands stay in memory.
const BAND: usize = 5;

/// The surface by modified marching cubes, some bands at a time.
fn by_bands(
    args: &VolumeArgs,
    opened: &Opened,
    reader: Option<SliceReader>,
    files: &[PathBuf],
) -> Result<Meshed, Failure> {
    let bands = bands(opened);
    let mut growing = files
        .iter()
        .map(|path| GrowingFile::new(path, bands.vertices()))
        .collect::<Result<Vec<_>, _>>()?;
    let name = args.file.display().to_string();
    let mut window = reader.map(|reader| Window::new(name, reader, opened));
    let mut moved = window.as_ref().and_then(|_| MovedAreas::new(opened));
    let mut tally = SurfaceTally::new();
    let (slices, together) = (bands.slices(), BAND * rayon::current_num_threads());
    for start in (0..slices).step_by(together) {
        let end = (start + together).min(slices);
        if let Some(window) = &mut window {
            window.move_to(start.saturating_sub(1), end)?;
            if let Some(moved) = &mut moved {
                moved.add(&bands, start..end, &window.values, window.first);
            }
        }
        let crossings = window.as_ref().map(Window::crossings);
        let parts: Vec<usize> = (start..end).step_by(BAND).collect();
        let made: Vec<SurfaceBand> = parts
            .into_par_iter()
            .map(|start| {
                let slices = start..(start + BAND).min(end);
                let band = match &crossings {
                    None => bands.band(slices, &Middles),
                    Some(crossings) => bands.band(slices, crossings),
                };
                placed(band, &opened.frame)
            })
            .collect();
        for band in &made {
            let mut result = Ok(());
            growing.iter_mut().try_for_each(|file| file.add_band(band))?;
            tally.add(band, |corners| add_corners(&mut growing, corners, &mut result));
            result?;
        }
    }
    let mut result = Ok(());
    let figures = tally.finish(|corners| add_corners(&mut growing, corners, &mut result));
    result?;
    growing.into_iter().try_for_each(GrowingFile::finish)?;
    Ok(Meshed { figures, moved_areas: moved.map(|moved| moved.sums) })
}

/// The surface by modified marching cubes, up to the gaps.
fn bands(opened: &Opened) -> Bands<'_> {
    Bands::with_gaps(&opened.samples, opened.gaps(), Ambiguity::Paired)
}

/// Areas of marching cubes at three thresholds, with the triangles of the middle one.
struct MovedAreas<'a> {
    frame: &'a Frame,
    size: [usize; 3],
    thresholds: [f64; 3],
    sums: [f64; 3],
}

impl MovedAreas<'_> {
    /// None where there are two values only.
    fn new(opened: &Opened) -> Option<MovedAreas<'_>> {
        let [less, more] = moved(opened.threshold, &opened.levels)?;
        let thresholds = [less, opened.threshold, more];
        let size = opened.samples.size();
        Some(MovedAreas { frame: &opened.frame, size, thresholds, sums: [0.0; 3] })
    }

    /// Adds the areas between some slices and the next ones. `values` are those of slices from `first_slice` on.
    fn add(&mut self, bands: &Bands<'_>, slices: Range<usize>, values: &[f32], first_slice: usize) {
        let [columns, rows, _] = self.size;
        let size = [columns, rows, values.len() / (columns * rows)];
        for (sum, threshold) in self.sums.iter_mut().zip(self.thresholds) {
            let grey = GreyValues { values, size, threshold: threshold as f32 };
            let crossings = GreySlices { grey, first_slice };
            let areas = bands.areas(slices.clone(), &crossings, |at| self.frame.place_mm(at));
            // One by one, so that it does not count how many come at a time.
            areas.iter().for_each(|area| *sum += area);
        }
    }
}

/// A band in mm of the file's frame.
fn placed(mut band: SurfaceBand, frame: &Frame) -> SurfaceBand {
    band.vertices.iter_mut().for_each(|vertex| *vertex = frame.place_mm(*vertex));
    if frame.is_mirror() {
        band.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    band
}

/// A file that is written while the surface is made.
struct GrowingFile {
    path: PathBuf,
    whole: WholeFile,
    pieces: Pieces,
}

enum Pieces {
    Ply(ply::MeshPieces<File>),
    Stl(stl::MeshPieces<File>),
}

impl GrowingFile {
    fn new(path: &Path, vertices: u32) -> Result<GrowingFile, Failure> {
        let whole = WholeFile::at(path);
        let file = whole.create()?;
        let pieces = match mesh_kind(path)? {
            MeshKind::Stl => stl::MeshPieces::new(file).map(Pieces::Stl),
            MeshKind::Ply => {
                // Opened once more, for it grows at two places.
                let other = OpenOptions::new().write(true).open(whole.place());
                let other = other.map_err(cannot_write(path))?;
                ply::MeshPieces::new(file, other, vertices).map(Pieces::Ply)
            }
        };
        let pieces = pieces.map_err(cannot_write(path))?;
        Ok(GrowingFile { path: path.to_owned(), whole, pieces })
    }

    fn add_band(&mut self, band: &SurfaceBand) -> Result<(), Failure> {
        match &mut self.pieces {
            Pieces::Ply(file) => file.add(&band.vertices, &band.triangles),
            Pieces::Stl(_) => Ok(()),
        }
        .map_err(cannot_write(&self.path))
    }

    fn finish(self) -> Result<(), Failure> {
        match self.pieces {
            Pieces::Ply(file) => file.finish(),
            Pieces::Stl(file) => file.finish(),
        }
        .map_err(cannot_write(&self.path))?;
        Ok(self.whole.finish()?)
    }
}

/// Adds a triangle to the files that hold corners; the first error is kept.
fn add_corners(
    files: &mut [GrowingFile],
    corners: [[f64; 3]; 3],
    result: &mut Result<(), Failure>,
) {
    for file in files {
        if let (Pieces::Stl(pieces), Ok(())) = (&mut file.pieces, &result) {
            *result = pieces.add(corners).map_err(cannot_write(&file.path));
        }
    }
}

/// The values of some slices in turn.
struct Window {
    name: String,
    reader: SliceReader,
    size: [usize; 3],
    threshold: f32,
    first: usize,
    values: Vec<f32>,
}

impl Window {
    fn new(name: String, reader: SliceReader, opened: &Opened) -> Window {
        let (size, threshold) = (opened.samples.size(), opened.threshold as f32);
        Window { name, reader, size, threshold, first: 0, values: Vec::new() }
    }

    /// Forgets the slices before `first`, and reads on up to `end` or the last one.
    fn move_to(&mut self, first: usize, end: usize) -> Result<(), Failure> {
        let slice = self.size[0] * self.size[1];
        self.values.drain(..((first - self.first) * slice).min(self.values.len()));
        self.first = first;
        while self.first + self.values.len() / slice < end.min(self.size[2]) {
            match next(&self.name, &mut self.reader)? {
                Some(Values::Bytes(bytes)) => self.values.extend(bytes.into_iter().map(f32::from)),
                Some(Values::Floats(floats)) => self.values.extend(floats),
                None => return Err(format!("{}: changed while it was read", self.name).into()),
            }
        }
        Ok(())
    }

    fn crossings(&self) -> GreySlices<'_> {
        let [columns, rows, _] = self.size;
        let slices = self.values.len() / (columns * rows);
        let size = [columns, rows, slices];
        let grey = GreyValues { values: &self.values, size, threshold: self.threshold };
        GreySlices { grey, first_slice: self.first }
    }
}
