//! A line scan that memory has no room for: time, memory, and what went through a file.

use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use asphera_mesh::{PagedMesh, Shelf, ShelfError, ShelfFailure};

use crate::Options;
use crate::clock::timed;
use crate::memory::vm_hwm_bytes;
use crate::orders::{Order, Scan};

type Long = PagedMesh<FileShelf>;

/// Meshes the scan, counts its triangles one by one, and prints what it took.
///
/// A failure is told on standard output and by the exit code.
pub(crate) fn measure(count: usize, options: &Options) -> ExitCode {
    let folder = options.shelf.clone().unwrap_or_else(std::env::temp_dir);
    let path = folder.join(format!("asphera-peers-{}.chunks", std::process::id()));
    let scan = Scan { order: Order::LineScanner, count, seed: options.seed };
    let long = FileShelf::create(&path).map_err(Failure::File).and_then(|shelf| {
        let mesh = Long::new(shelf, options.memory_mb.get() * 1_000_000);
        mesh_and_count(mesh, scan, options.batch.get()).map_err(Failure::Mesh)
    });
    match long {
        Ok(long) => long.print(scan),
        Err(failure) => print_line(&format!("{failure:?}")),
    }
}

/// Why there are no figures.
#[derive(Debug)]
enum Failure {
    #[expect(dead_code, reason = "it is printed")]
    File(std::io::Error),
    #[expect(dead_code, reason = "it is printed")]
    Mesh(ShelfError),
}

struct Measured {
    mesh: Long,
    insert_s: f64,
    /// The slowest batch.
    batch_s: f64,
    /// Text read back while points were inserted.
    read_back: u64,
    read_s: f64,
    triangles: u64,
    points: u64,
}

fn mesh_and_count(mut mesh: Long, scan: Scan, batch: usize) -> Result<Measured, ShelfError> {
    let (mut insert_s, mut batch_s, mut result) = (0.0, 0.0_f64, Ok(()));
    scan.for_each_batch(batch, |points| {
        if result.is_ok() {
            let (inserted, seconds) = timed(|| mesh.insert(points));
            (insert_s, batch_s, result) = (insert_s + seconds, batch_s.max(seconds), inserted);
        }
    });
    result?;
    let read_back = mesh.paging().read_bytes;
    let (mut triangles, mut points) = (0, 0);
    let (read, read_s) = timed(|| {
        mesh.for_each_triangle(|_| triangles += 1)?;
        mesh.for_each_points(|_, some| points += some.len() as u64)
    });
    read?;
    Ok(Measured { mesh, insert_s, batch_s, read_back, read_s, triangles, points })
}

impl Measured {
    #[expect(clippy::print_stdout, reason = "the figures are what this program is for")]
    fn print(&self, scan: Scan) -> ExitCode {
        let (counts, paging) = (self.mesh.counts(), self.mesh.paging());
        let mega = |bytes: u64| bytes as f64 / 1e6;
        println!("line scan of {} points", scan.count);
        println!("insertion       {:.1} s", self.insert_s);
        println!("rate            {:.0} points/s", scan.count as f64 / self.insert_s);
        println!("slowest batch   {:.1} ms", 1e3 * self.batch_s);
        println!("reading it all  {:.1} s", self.read_s);
        println!("budget          {:.0} MB", mega(paging.budget_bytes as u64));
        println!("mesh in memory  {:.0} MB", mega(paging.resident_bytes as u64));
        if let Some(peak) = vm_hwm_bytes() {
            println!("process at peak {:.0} MB", mega(peak));
        }
        println!("written         {:.0} MB", mega(paging.written_bytes));
        println!("read back       {:.0} MB", mega(self.read_back));
        println!("vertices        {} counted, {} read", counts.vertices, self.points);
        println!("triangles       {} counted, {} read", counts.triangles, self.triangles);
        // Every triangle has three edges; only those of the hull belong to one triangle alone.
        let edges = (3 * self.triangles + counts.hull) / 2;
        let euler = (self.points + self.triangles) as i64 - edges as i64;
        println!("Euler           {euler} = vertices - edges + triangles, of what was read");
        let agree = counts.vertices == self.points && counts.triangles == self.triangles;
        if agree && euler == 1 && paging.failed_puts == 0 {
            ExitCode::SUCCESS
        } else {
            println!("WRONG");
            ExitCode::FAILURE
        }
    }
}

#[expect(clippy::print_stdout, reason = "the figures are what this program is for")]
fn print_line(line: &str) -> ExitCode {
    println!("{line}");
    ExitCode::FAILURE
}

/// A file with each chunk at its number times its length. It is deleted at the end.
struct FileShelf {
    file: File,
    path: PathBuf,
}

impl FileShelf {
    fn create(path: &Path) -> std::io::Result<FileShelf> {
        let file = File::options().read(true).write(true).create_new(true).open(path)?;
        Ok(FileShelf { file, path: path.to_owned() })
    }

    fn seek(&mut self, chunk: u32) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(u64::from(chunk) * Long::CHUNK_BYTES as u64)).map(|_| ())
    }
}

impl Shelf for FileShelf {
    fn put(&mut self, chunk: u32, bytes: &[u8]) -> Result<(), ShelfFailure> {
        self.seek(chunk)?;
        Ok(self.file.write_all(bytes)?)
    }

    fn get(&mut self, chunk: u32, bytes: &mut [u8]) -> Result<(), ShelfFailure> {
        self.seek(chunk)?;
        Ok(self.file.read_exact(bytes)?)
    }
}

impl Drop for FileShelf {
    fn drop(&mut self) {
        // Nothing is left to do about a file that cannot be deleted.
        drop(fs::remove_file(&self.path));
    }
}
