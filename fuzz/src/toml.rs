//! Files that a person wrote: configurations, nominals and lens files, and what must hold for whatever is read of them.
//!
//! The first byte of an input says which of them it is; what follows is the file.

use asphera::config::{Config, Problem, Problems};
use asphera::lens;
use asphera_formats::zemax;
use asphera_measure::Part;
use asphera_nominal::flipped;

/// Reads an input and checks what came out of it.
///
/// # Panics
///
/// Where a law is broken.
pub fn hold(input: &[u8]) {
    let [which, file @ ..] = input else { return };
    match which % 4 {
        0 => configuration(&String::from_utf8_lossy(file)),
        1 => nominal(&String::from_utf8_lossy(file)),
        2 => turned(&String::from_utf8_lossy(file)),
        _ => lens(file),
    }
}

fn configuration(text: &str) {
    match Config::parse(NAME, text) {
        Ok(config) => {
            assert!(!config.name.chars().any(char::is_control), "{:?}", config.name);
            assert!(!config.links.is_empty() && !config.devices.is_empty());
            assert!(config.devices.iter().all(|device| device.link < config.links.len()));
            part_is_sound(&config.part);
            // A recording keeps the text: it must say the same again.
            let again = Config::parse(NAME, &config.text);
            let again = again.unwrap_or_else(|problems| panic!("its own text: {problems}"));
            assert_eq!(again.part.free, config.part.free);
        }
        Err(problems) => are_named(&problems, text),
    }
}

fn nominal(text: &str) {
    match asphera_nominal::parse(NAME, text) {
        Ok(part) => part_is_sound(&part),
        Err(problems) => are_named(&problems, text),
    }
}

/// A nominal that can be turned can be turned back, and is read before if it is read after.
fn turned(text: &str) {
    let Ok(once) = flipped(text) else { return };
    let twice = flipped(&once).unwrap_or_else(|error| panic!("turned back: {error}"));
    if asphera_nominal::parse(NAME, text).is_ok() {
        let part = asphera_nominal::parse(NAME, &once);
        part.unwrap_or_else(|problems| panic!("turned: {problems}"));
        let part = asphera_nominal::parse(NAME, &twice);
        part.unwrap_or_else(|problems| panic!("turned twice: {problems}"));
    }
}

fn lens(file: &[u8]) {
    let Ok(lens) = zemax::read(file) else { return };
    assert!(lens::list(&lens).lines().count() > lens.surfaces.len());
    for surface in lens.surfaces.iter().take(SURFACES) {
        match lens::nominal(&lens, surface.number, NAME, None) {
            Ok(text) => nominal(&text),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

/// Heights are numbers or there is none; sizes are positive; limits can be held.
fn part_is_sound(part: &Part) {
    assert!(!part.nominal.domain_mm().is_nan(), "the nominal ends nowhere");
    assert!(part.centre_mm.iter().all(|mm| mm.is_finite()));
    part.aperture.validate().unwrap_or_else(|error| panic!("the aperture: {error}"));
    for limit in part.limits().iter().map(|limit| limit.value) {
        assert!(limit.is_finite() && limit > 0.0, "a limit of {limit} nm");
    }
    for [x_mm, y_mm] in PLACES_MM {
        if let Some(z_mm) = part.nominal.height_mm(x_mm, y_mm) {
            assert!(!z_mm.is_nan(), "no number at {x_mm}, {y_mm} mm");
        }
        if let Some(jet) = part.nominal.jet(x_mm, y_mm) {
            let numbers = [jet.z_mm, jet.gradient[0], jet.gradient[1]];
            assert!(
                numbers.iter().all(|number| !number.is_nan()),
                "{numbers:?} at {x_mm}, {y_mm} mm"
            );
        }
    }
}

/// All problems have a place within the text, say what was expected and found, and are not longer than a person reads.
fn are_named(Problems(problems): &Problems, text: &str) {
    assert!(!problems.is_empty(), "refused without a problem");
    let lines = text.lines().count() + 1;
    for Problem { line, expected, found, .. } in problems {
        assert!((1..=lines).contains(line), "line {line} of {lines}");
        assert!(!expected.trim().is_empty() && !found.trim().is_empty(), "{expected:?} {found:?}");
    }
}

/// In a folder that is not there, so that no file which a nominal names is found.
const NAME: &str = "no such folder/file.toml";
/// Surfaces of a lens file that are made nominals of.
const SURFACES: usize = 4;
/// Places at which heights are asked: the vertex, near it, and far off.
const PLACES_MM: [[f64; 2]; 6] =
    [[0.0, 0.0], [1.0, 0.0], [-2.5, 3.0], [0.0, 1e-9], [40.0, -40.0], [1e6, 1e6]];
