//! Faces of volumes, from files.

use asphera_formats::volume::{Frame, UnitKnown, write_nrrd};
use asphera_rig::CtScene;

use super::super::demo::ct::lay_out;
use super::*;

/// The scene `ct` at half its size: voxels of 20 µm, blur of one of them, noise of 2 %. Form within 5 % of the truth, centre thickness
/// within 1 µm; what is aimed at, 2 % and 0.3 µm, is kept too, the RMS without noise. The thickness within three of its u.
#[test]
fn a_lens_in_a_scanner_has_its_form_and_thickness() {
    let dir = tempfile::tempdir().unwrap();
    let laid = lay_out(dir.path(), &CtScene::lens(0.5)).unwrap();
    let faces = laid.measured(&Progress::start("test")).unwrap();
    let second = faces.second.unwrap();
    for (measured, truth_nm) in [&faces.first, &second].into_iter().zip(laid.truth.rms_nm) {
        let form = measured.report.form.as_ref().unwrap();
        let known = form.deviation.uncertainty.as_ref().unwrap();
        let all = form.deviation.rms_nm / truth_nm - 1.0;
        assert!(all.abs() < 0.05, "{} of {truth_nm}", form.deviation.rms_nm);
        let form_alone = known.rms_without_noise_nm / truth_nm - 1.0;
        assert!(form_alone.abs() < 0.02, "{known:?} {truth_nm}");
        // Its u of some nm does not count what blur takes of form as narrow as the ring: 1.6 % here, where that has 13 spacings.
    }
    let face = faces.first.report.volume.as_ref().unwrap();
    assert!((face.blur_um / 20.0 - (2.0_f64 + 1.0 / 12.0).sqrt()).abs() < 0.03, "{face:?}");
    let lies = face.second.as_ref().unwrap().lies.as_ref().unwrap();
    let within = |of: &asphera_report::ParameterFigures, truth: f64| {
        ((of.value - truth) / of.u.unwrap()).abs()
    };
    let off_um = 1e3 * (lies.centre_thickness.value - laid.truth.centre_thickness_mm);
    assert!(off_um.abs() < 0.3, "{off_um} µm");
    assert!(within(&lies.centre_thickness, laid.truth.centre_thickness_mm) < 3.0, "{lies:?}");
    // Their u counts errors of the scan. Form of 0.85 µm on so small a lens moves its axes by more, and no u counts that.
    let off = |of: &Option<asphera_report::ParameterFigures>, truth: f64| {
        (of.as_ref().unwrap().value - truth).abs()
    };
    assert!(off(&lies.wedge, laid.truth.wedge_arcmin) < 3.0, "{lies:?} {:?}", laid.truth);
    assert!(off(&lies.tilt, laid.truth.tilt_arcmin) < 2.0, "{lies:?} {:?}", laid.truth);
    assert!(off(&lies.decentre, laid.truth.decentre_um) < 4.0, "{lies:?} {:?}", laid.truth);
}

fn none(second: Option<PathBuf>) -> FaceArgs {
    FaceArgs { second, ..FaceArgs::of_pair(PathBuf::new()) }
}

#[test]
fn volumes_are_told_from_points() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let frame = Frame::aligned([0.1; 3], UnitKnown::Stated);
    let mut bytes = Vec::new();
    write_nrrd(&mut bytes, [4, 4, 4], &[7; 64], &frame).unwrap();
    std::fs::write(path("a.nrrd"), bytes).unwrap();
    std::fs::write(path("a.xyz"), "0 0 0\n1 0 0\n0 1 0\n").unwrap();
    std::fs::create_dir(path("slices")).unwrap();
    std::fs::write(path("slices/0001.tif"), "").unwrap();
    assert!(is_volume(&path("a.nrrd")).unwrap() && is_volume(&path("slices")).unwrap());
    assert!(!is_volume(&path("a.xyz")).unwrap() && !is_volume(dir.path()).unwrap());
    let progress = Progress::start("test");
    let said = |given: Option<Part>, along: Option<Along>| {
        let found = measured(&path("a.nrrd"), &none(None), given, along, None, &progress);
        found.err().unwrap().to_string()
    };
    assert!(said(None, None).contains("--nominal FILE says which face"));
    let plane = || Some(Part::new(asphera_form::Nominal::Plane));
    assert!(said(plane(), None).contains("found one value all over"));
    assert!(said(plane(), Some("fitted".parse().unwrap())).contains("found fitted"));
    let refused = none(Some(path("b.toml"))).refuse(&path("a.xyz")).unwrap_err().to_string();
    assert!(refused.contains("expected a volume for --second, found points"), "{refused}");
    assert!(none(None).refuse(&path("a.xyz")).is_ok());
}
