//! False defects on clean parts, and how many real ones are found.
//!
//! A small study runs always. The whole one, 50 parts of each kind of 20,000, 100,000 and 1,000,000 points, takes
//! half an hour of a processor: `ASPHERA_LONG=1 cargo test --release -p asphera-surface --lib study -- --nocapture`.
//! `ASPHERA_DEFECT_STUDY=200` takes so many parts of each kind and size, `ASPHERA_DEFECT_SIZES=20000,300000` other sizes,
//! `ASPHERA_DEFECT_KINDS=White,Edges` only some kinds of clean parts. `ASPHERA_DEFECT_LADDER=50` puts real ones on so many
//! parts, not six. `ASPHERA_DEFECT_FALSE=0.1` puts up with so many false ones on a part; the bounds are those of 0.01.

mod heights;
mod ladder;
mod parts;
mod smooth;

use self::parts::{KINDS, Kind, Part};

/// False defects of parts of each kind and size; all of one kind.
fn false_ones(kinds: &[Kind], wanted: &[(usize, u64)]) -> Vec<Vec<usize>> {
    kinds
        .iter()
        .map(|&kind| {
            let of = |&(size, parts): &(usize, u64)| {
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
            wanted.iter().map(of).collect()
        })
        .collect()
}

/// Sizes, and how many parts of each kind there are of each.
fn wanted() -> Vec<(usize, u64)> {
    let text = |name: &str| std::env::var(name).ok();
    let parts = text("ASPHERA_DEFECT_STUDY").map(|text| text.parse::<u64>().unwrap());
    let sizes = text("ASPHERA_DEFECT_SIZES");
    let usual = match (text("ASPHERA_LONG"), parts) {
        (None, None) => vec![(20_000, 2)],
        _ => vec![(20_000, 50), (100_000, 50), (1_000_000, 50)],
    };
    let sizes: Vec<(usize, u64)> = match sizes {
        Some(sizes) => sizes.split(',').map(|size| (size.parse().unwrap(), usual[0].1)).collect(),
        None => usual,
    };
    sizes.into_iter().map(|(size, usual)| (size, parts.unwrap_or(usual))).collect()
}

/// The kinds of clean parts that are looked at.
fn wanted_kinds() -> Vec<Kind> {
    let Ok(names) = std::env::var("ASPHERA_DEFECT_KINDS") else { return KINDS.to_vec() };
    let of = |name: &str| KINDS.into_iter().find(|kind| format!("{kind:?}") == name);
    names.split(',').map(|name| of(name).unwrap_or_else(|| panic!("no kind {name}"))).collect()
}

/// At most 0.01 a part are stated. Of each kind chance alone makes it up to twice as many.
#[test]
fn clean_parts_have_no_defects() {
    let (wanted, kinds) = (wanted(), wanted_kinds());
    let most = 0.02 * wanted.iter().map(|(_, parts)| *parts as f64).sum::<f64>();
    for (kind, found) in kinds.iter().zip(false_ones(&kinds, &wanted)) {
        let found: usize = found.iter().sum();
        assert!(found as f64 <= most, "{kind:?}: {found}, {most} are expected at most");
    }
}

/// It had 7 scratches and a ridge of 28 to 133 standard deviations at 100,000 points, and a ridge of 127 at 20,000. Of 3,000
/// the ring is three of their spacings wide.
#[test]
fn the_ring_of_the_demo_is_form() {
    let sizes = [3_000, 5_000, 10_000, 15_000, 20_000, 30_000, 100_000];
    for (size, seed) in sizes.into_iter().flat_map(|size| [(size, 1), (size, 2)]) {
        assert_eq!(Part::of_demo(size, seed).search().defects, [], "{size}");
    }
}
