//! False defects on clean parts, and how many real ones are found.
//!
//! A small study runs always. The whole one, 50 parts of each kind of 20,000 to 1,000,000 points, takes some hours of a
//! processor: `ASPHERA_DEFECT_STUDY=50 cargo test --release -p asphera-surface --lib study -- --nocapture`, where the
//! number is that of the parts of each kind and size. `ASPHERA_DEFECT_SIZES=20000,100000` takes other sizes,
//! `ASPHERA_DEFECT_KINDS=White,Edges` only some kinds of clean parts.

mod ladder;
mod parts;

use self::parts::{KINDS, Kind, Part};

/// False defects of so many parts of each kind and size; all of one kind.
fn false_ones(kinds: &[Kind], parts: u64, sizes: &[usize]) -> Vec<Vec<usize>> {
    kinds
        .iter()
        .map(|&kind| {
            let of = |&size: &usize| {
                let mut found = 0;
                for seed in 0..parts {
                    let search = Part::clean(kind, size, seed).search();
                    for defect in &search.defects {
                        let [x, y, _] = defect.centre_mm;
                        eprintln!(
                            "  {kind:?} {size} seed {seed}: {:?} at {x:.2}, {y:.2}, r {:.2} h {:.1} nm, {:?} x {:?}, {} points, {:.1}{}",
                            defect.kind,
                            x.hypot(y),
                            1e6 * defect.height_mm,
                            defect.length_mm,
                            defect.width_mm,
                            defect.vertices,
                            defect.significance,
                            if defect.on_border { ", on the border" } else { "" }
                        );
                    }
                    found += search.defects.len();
                }
                let share = found as f64 / parts as f64;
                eprintln!("{kind:?} {size}: {found} on {parts} parts, {share:.2} a part");
                found
            };
            sizes.iter().map(of).collect()
        })
        .collect()
}

/// Parts of each kind and size, and the sizes.
fn wanted() -> (u64, Vec<usize>) {
    let number = |name: &str| std::env::var(name).ok();
    let parts = number("ASPHERA_DEFECT_STUDY").and_then(|text| text.parse().ok());
    let sizes = number("ASPHERA_DEFECT_SIZES")
        .map(|text| text.split(',').map(|size| size.parse().unwrap()).collect());
    match parts {
        Some(parts) => (parts, sizes.unwrap_or(vec![20_000, 100_000, 300_000, 1_000_000])),
        None => (2, sizes.unwrap_or(vec![20_000])),
    }
}

/// The kinds of clean parts that are looked at.
fn wanted_kinds() -> Vec<Kind> {
    let Ok(names) = std::env::var("ASPHERA_DEFECT_KINDS") else { return KINDS.to_vec() };
    let of = |name: &str| KINDS.into_iter().find(|kind| format!("{kind:?}") == name);
    names.split(',').map(|name| of(name).unwrap_or_else(|| panic!("no kind {name}"))).collect()
}

/// At most 0.1 a part are stated.
#[test]
fn clean_parts_have_no_defects() {
    let (parts, sizes) = wanted();
    let kinds = wanted_kinds();
    let found = false_ones(&kinds, parts, &sizes);
    for (kind, found) in kinds.iter().zip(found) {
        let most = 0.1 * parts as f64 * sizes.len() as f64;
        let found: usize = found.iter().sum();
        assert!(found as f64 <= most, "{kind:?}: {found}, {most} are expected at most");
    }
}

/// It had 7 scratches and a ridge of 28 to 133 standard deviations at 100,000 points.
#[test]
fn the_ring_of_the_demo_is_form() {
    for (size, seed) in [(20_000, 1), (20_000, 2), (100_000, 3)] {
        assert_eq!(Part::of_demo(size, seed).search().defects, [], "{size}");
    }
}
