//! The page of a measured volume in a real browser: slices, faces by their deviation, forbidden cells.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_rig::CtScene;
use asphera_tests::{Running, asphera};

use super::browser::browser;

/// A lens of half the size of the scene `ct`, with specks beside it: two voxels that touch by a corner, two that touch by an edge.
fn lay_out(folder: &Path) {
    let scene = CtScene { noise: 0.01, ..CtScene::lens(0.5) };
    let mut scan = scene.scan().unwrap();
    let [nx, ny, nz] = scan.size;
    for [x, y, z] in [[4, 4, 4], [5, 5, 5], [12, 4, 4], [13, 5, 4]] {
        scan.values[(z * ny + y) * nx + x] = 33_000;
    }
    let [ox, oy, oz] = scan.origin_mm;
    let h = scan.spacing_mm;
    let mut file = std::fs::File::create(folder.join("lens.nrrd")).unwrap();
    write!(
        file,
        "NRRD0004\ntype: uint16\ndimension: 3\nsizes: {nx} {ny} {nz}\nspace dimension: 3\nspace directions: ({h},0,0) (0,{h},0) (0,0,{h})\n\
         space origin: ({ox},{oy},{oz})\nspace units: \"mm\" \"mm\" \"mm\"\nendian: little\nencoding: raw\n\n"
    )
    .unwrap();
    let bytes: Vec<u8> = scan.values.iter().flat_map(|value| value.to_le_bytes()).collect();
    file.write_all(&bytes).unwrap();
    // The designs of the scene, halved.
    let designs = [("front", -4.5, -1.0, -0.016), ("back", -7.0, 0.0, 0.012)];
    for (name, radius_mm, conic, a4) in designs {
        let text = format!(
            "[surface]\nkind = \"asphere\"\nradius_mm = {radius_mm:?}\nconic = {conic:?}\nA4 = {a4:?}\n\n[aperture]\nshape = \"circle\"\n\
             radius_mm = 1.2\n\n[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\"]\n"
        );
        std::fs::write(folder.join(format!("{name}.toml")), text).unwrap();
    }
}

#[test]
fn the_page_shows_a_volume_with_its_slices_and_forbidden_cells() {
    let Some((folder, chromium)) = browser() else { return };
    let dir = tempfile::tempdir().unwrap();
    lay_out(dir.path());
    let mut daemon = Running::start(
        Command::new(asphera())
            .current_dir(dir.path())
            .args(["measure", "lens.nrrd", "--nominal", "front.toml", "--second", "back.toml"])
            // Specks of a voxel would be smoothed away.
            .args(["--smooth", "0", "--listen", "127.0.0.1:0"])
            .stdout(Stdio::null()),
    );
    let line = daemon.line("page:", Duration::from_secs(180));
    let url = line.split_once("page: ").unwrap().1;
    let mut check = Command::new("node");
    check.current_dir(&folder).args(["volume.mjs", url, "--chromium", chromium]);
    if let Some(shots) = std::env::var_os("ASPHERA_SCREENSHOTS") {
        check.arg("--screenshots").arg(Path::new(&shots).join("volume-"));
    }
    let output = check.stdin(Stdio::null()).output().unwrap();
    assert!(
        output.status.success(),
        "{}\n{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}
