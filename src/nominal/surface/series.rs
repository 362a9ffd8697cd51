//! Surfaces that are a base and a series of polynomials: Zernike, 2-D-Q, Chebyshev, Legendre, XY.
//!
//! The terms stand in an array of tables, each with what names the term and its coefficient in mm. What a term means depends on how terms
//! are counted and normalised, so neither has a default.

use std::collections::BTreeMap;
use std::fmt::{Debug, Display};
use std::sync::Arc;

use asphera_form::Nominal;
use asphera_form::basis::{Basis, Counting, Normalisation, Product, Q2d, Scale, Zernike};
use asphera_form::shape::{Conic, ConicSection, Series};
use asphera_settings::Section;

use super::base::{base, even_powers, is_flat, on_base, sum};
use super::told;

/// `kind = "zernike"`.
pub(super) fn zernike(surface: &Section<'_>) -> Option<Nominal> {
    let counting = surface.required_word(
        "indices",
        &[
            ("fringe", Some(Counting::Fringe)),
            ("noll", Some(Counting::Noll)),
            ("ansi", Some(Counting::Ansi)),
            ("orders", None),
        ],
    );
    let normalisation = surface.required_word(
        "normalisation",
        &[("unit-height", Normalisation::UnitHeight), ("unit-rms", Normalisation::UnitRms)],
    );
    let scale = round(surface);
    let (base, powers) = (base(surface), even_powers(surface));
    // The terms are not read until it is known how they are counted, yet they are no unknown key.
    surface.has("terms");
    let (zernike, coefficients_mm) = match counting? {
        Some(counting) => {
            let terms = terms(surface, |term| {
                let index: u32 = term.required("index")?;
                let (first, last) = (counting.first(), last_index(counting));
                if !(first..=last).contains(&index) {
                    term.problem("index", format!("{first} to {last}"), index);
                    return None;
                }
                Some(index)
            })?;
            dense(counting, normalisation?, &terms)?
        }
        None => {
            let terms = terms(surface, |term| {
                let (n, m): (Option<u32>, Option<i64>) = (term.required("n"), term.required("m"));
                Some((n?, order(term, m?)?))
            })?;
            let orders: Vec<(u32, i32)> = terms.keys().copied().collect();
            let made = Zernike::of_orders(&orders, normalisation?);
            (told(surface, "terms", made)?, terms.into_values().collect())
        }
    };
    over(surface, base?, &powers, zernike, scale?, &coefficients_mm)
}

/// `kind = "q-2d"`: over a sphere or a plane.
pub(super) fn q2d(surface: &Section<'_>) -> Option<Nominal> {
    let scale = round(surface);
    let base = if is_flat(surface) {
        Some(ConicSection::FLAT)
    } else {
        let radius_mm = surface.required("radius_mm");
        radius_mm
            .and_then(|radius_mm| told(surface, "radius_mm", ConicSection::new(radius_mm, 0.0)))
    };
    let terms = terms(surface, |term| {
        let (n, m): (Option<u32>, Option<i64>) = (term.required("n"), term.required("m"));
        Some((n?, order(term, m?)?))
    })?;
    let (base, scale) = (base?, scale?);
    let orders: Vec<(u32, i32)> = terms.keys().copied().collect();
    let bend = scale.half_x_mm() / base.radius_mm();
    let basis = told(surface, "normalisation_radius_mm", Q2d::new(&orders, bend))?;
    let coefficients_mm: Vec<f64> = terms.into_values().collect();
    let series = told(surface, "terms", Series::new(basis, scale, &coefficients_mm))?;
    if base.is_flat() {
        return Some(Nominal::Freeform(Arc::new(series)));
    }
    // A sphere without a conic constant: the terms are made for that base alone.
    let sphere = told(surface, "radius_mm", Conic::sphere(base.radius_mm()))?;
    sum(surface, Arc::new(sphere), Arc::new(series))
}

/// `kind = "chebyshev"`.
pub(super) fn chebyshev(surface: &Section<'_>) -> Option<Nominal> {
    product(surface, rectangle(surface), Product::chebyshev)
}

/// `kind = "legendre"`.
pub(super) fn legendre(surface: &Section<'_>) -> Option<Nominal> {
    product(surface, rectangle(surface), Product::legendre)
}

/// `kind = "xy"`.
pub(super) fn xy(surface: &Section<'_>) -> Option<Nominal> {
    product(surface, round(surface), Product::powers)
}

fn product<E: Display>(
    surface: &Section<'_>,
    scale: Option<Scale>,
    made: impl Fn(&[(u32, u32)]) -> Result<Product, E>,
) -> Option<Nominal> {
    let (base, powers) = (base(surface), even_powers(surface));
    let terms = terms(surface, |term| {
        let (x, y) = (term.required("x"), term.required("y"));
        Some((x?, y?))
    })?;
    let orders: Vec<(u32, u32)> = terms.keys().copied().collect();
    let basis = told(surface, "terms", made(&orders))?;
    let coefficients_mm: Vec<f64> = terms.into_values().collect();
    over(surface, base?, &powers, basis, scale?, &coefficients_mm)
}

/// All terms up to the last that is given, so that each has the name its index gives it.
fn dense(
    counting: Counting,
    normalisation: Normalisation,
    terms: &BTreeMap<u32, f64>,
) -> Option<(Zernike, Vec<f64>)> {
    let first = counting.first();
    let last = *terms.keys().next_back()?;
    let coefficients_mm: Vec<f64> =
        (first..=last).map(|index| terms.get(&index).copied().unwrap_or(0.0)).collect();
    let zernike = if counting == Counting::Fringe && last == LAST_FRINGE {
        Zernike::fringe_37(normalisation)
    } else {
        // Indices were checked: their orders are below the largest.
        Zernike::first(counting, last - first + 1, normalisation).ok()?
    };
    Some((zernike, coefficients_mm))
}

/// The largest index that is read.
fn last_index(counting: Counting) -> u32 {
    match counting {
        Counting::Fringe => LAST_FRINGE,
        Counting::Noll | Counting::Ansi => LAST_INDEX,
    }
}

fn order(term: &Section<'_>, m: i64) -> Option<i32> {
    i32::try_from(m).map_err(|_| term.problem("m", "a whole number of at most n in size", m)).ok()
}

/// The coefficients in mm by what names their terms; each term at most once, at least one.
fn terms<K: Ord + Debug>(
    surface: &Section<'_>,
    name: impl Fn(&Section<'_>) -> Option<K>,
) -> Option<BTreeMap<K, f64>> {
    let listed = surface.array("terms");
    if listed.is_empty() {
        surface.problem("terms", "at least one table [[surface.terms]]", "none");
        return None;
    }
    let mut terms = BTreeMap::new();
    let mut is_complete = true;
    for term in listed {
        let (name, value_mm) = (name(&term), term.required::<f64>("mm"));
        term.finish();
        match (name, value_mm) {
            (Some(name), Some(_)) if terms.contains_key(&name) => {
                term.problem("mm", "each term once", format!("the term {name:?} twice"));
                is_complete = false;
            }
            (Some(name), Some(value_mm)) => {
                terms.insert(name, value_mm);
            }
            _ => is_complete = false,
        }
    }
    is_complete.then_some(terms)
}

/// The radius by which places are divided.
fn round(surface: &Section<'_>) -> Option<Scale> {
    let radius_mm = surface.required("normalisation_radius_mm")?;
    told(surface, "normalisation_radius_mm", Scale::round(radius_mm))
}

/// The half widths by which places are divided.
fn rectangle(surface: &Section<'_>) -> Option<Scale> {
    let (x_mm, y_mm) = (surface.required("half_x_mm"), surface.required("half_y_mm"));
    told(surface, "half_x_mm", Scale::rectangle(x_mm?, y_mm?))
}

/// The series over its base; alone where the base is flat and has no powers.
fn over<B: Basis + Debug + 'static>(
    surface: &Section<'_>,
    base: ConicSection,
    powers: &[(u8, f64)],
    basis: B,
    scale: Scale,
    coefficients_mm: &[f64],
) -> Option<Nominal> {
    let series = told(surface, "terms", Series::new(basis, scale, coefficients_mm))?;
    on_base(surface, base, powers, Arc::new(series))
}

/// The set of the University of Arizona ends here; how its counting goes on is not agreed on. Higher terms are given by their orders.
const LAST_FRINGE: u32 = 37;
/// Radial order 40. Zemax has 231 terms.
const LAST_INDEX: u32 = 860;
