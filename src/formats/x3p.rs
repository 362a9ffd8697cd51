//! X3P: ISO 25178-72:2017 and Amd 1:2020, before that ISO 5436-2:2000.
//!
//! A zip archive of `main.xml`, its MD5 checksum, and most often the coordinates as binary files.
//! `main.xml` says in `Record1` what the axes are, in `Record2` where the data come from, and in
//! `Record3` how many there are and where. Elements are known by their names alone, because every
//! edition of the standard uses the same names under differing name spaces.
//!
//! - An incremental axis gives the position of column or row `u`, counted from 1, as
//!   `(u − 1) · I` (Amd 1:2020), an absolute axis stores a value for every point.
//! - A point is `R · (I · stored) + O` metres with the increments I, the rotation R and the offsets
//!   O of `Record1`.
//! - A surface with incremental x and y and no rotation is a [`HeightMap`]. With absolute x or y, or
//!   with a rotation, its points are on no grid of the frame: it is a [`Cloud`], and so is a point
//!   cloud (`PCL`).
//! - A height that is NaN, an empty `Datum`, or a zero bit of the validity file is missing. Bits are
//!   counted from the least significant one, as in the sample files of the openGPS library; the
//!   standard does not say.
//! - Every checksum that the file states is verified.
//!
//! Profiles (`PRF`) and surfaces of several layers are not supported.
//!
//! [`HeightMap`]: crate::HeightMap
//! [`Cloud`]: crate::Cloud

mod archive;
mod document;
mod points;
mod write;
mod xml;

pub use write::{Metadata, Probing, write_cloud, write_map, write_turned_map};

use archive::Archive;
use document::Document;

use crate::{ReadError, Topography};

/// Reads an X3P file.
///
/// # Errors
///
/// The zip entry or XML element that breaks the format; a checksum that does not fit; profiles,
/// several layers; more than [`crate::MAX_POINTS`] points; a `main.xml` of more than 64 MiB.
pub fn read(bytes: &[u8]) -> Result<Topography, ReadError> {
    let mut archive = Archive::open(bytes)?;
    let main = archive.main_xml()?;
    let document = Document::parse(&main)?;
    archive.verify_main(&main, &document.checksum_file)?;
    points::topography(document, &mut archive)
}

/// First bytes of a zip archive that is not empty.
pub(crate) const MAGIC: &[u8] = b"PK\x03\x04";

/// Name of the XML file in the archive.
const MAIN_XML: &str = "main.xml";

/// Name of the checksum file in the archive, where `Record4` gives no other.
const CHECKSUM_FILE: &str = "md5checksum.hex";

#[cfg(test)]
mod tests;
