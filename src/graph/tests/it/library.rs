//! Parts of simulated trays are recognised: the truth is what was laid there.

use asphera_graph::library::{
    Facing, LibraryEntry, Outcome, Piece, recognise, recognise_any_size, recognise_touching,
};
use asphera_graph::{Choices, Cloud, auto_min_points, auto_tau_mm, extract, functions, parts};

use crate::bodies::{Place, Random};
use crate::tray::{KINDS, Kind, Spot, Tray, lay, tray};

fn library() -> Vec<LibraryEntry> {
    KINDS.map(Kind::entry).into()
}

/// The parts of a scene with their answers.
fn answers(points: &[Place], library: &[LibraryEntry]) -> Vec<Piece> {
    let cloud = Cloud::new(points).unwrap();
    let tau_mm = auto_tau_mm(&cloud).unwrap();
    let found = parts(&cloud, tau_mm, auto_min_points(&cloud, tau_mm).unwrap()).unwrap();
    let pieces = found.parts.iter().flat_map(|part| {
        let places = part.places.iter().map(|&place| cloud.places()[place as usize]);
        recognise_touching(&places.collect::<Vec<_>>(), library, None)
    });
    pieces.collect()
}

/// Counts of a tray: parts right, and what was wrong.
fn judged(tray: &Tray, library: &[LibraryEntry]) -> (usize, Vec<String>) {
    let found = answers(&tray.points, library);
    let mut wrong = Vec::new();
    if found.len() != tray.truth.len() {
        wrong.push(format!("{} parts of {}", found.len(), tray.truth.len()));
    }
    let mut right = 0;
    for truth in &tray.truth {
        let distance = |places: &[Place]| {
            let mean = |axis: usize| {
                places.iter().map(|place| place[axis]).sum::<f64>() / places.len() as f64
            };
            (mean(0) - truth.centre_mm[0]).hypot(mean(1) - truth.centre_mm[1])
        };
        let near = found
            .iter()
            .min_by(|a, b| distance(&a.points).total_cmp(&distance(&b.points)))
            .unwrap();
        let first = near.recognition.candidates.first();
        let kind = first.map(|first| KINDS[first.entry]);
        let facing = first.map(|first| first.pose.facing());
        let is_side_free = truth.kind == Kind::Ring;
        if near.recognition.outcome == Outcome::Match
            && kind == Some(truth.kind)
            && (is_side_free || facing == Some(truth.facing))
            && holes(&near.points) == truth.holes
        {
            right += 1;
        } else {
            wrong.push(format!(
                "{:?} {:?}: {:?} {kind:?} {facing:?} {:?} of {:.4}, margin {:.2}, apart {:.2}, holes {}",
                truth.kind,
                truth.facing,
                near.recognition.outcome,
                first.map(|first| first.difference_mm),
                near.recognition.limit_mm,
                near.recognition.margin(),
                distance(&near.points),
                holes(&near.points)
            ));
        }
    }
    (right, wrong)
}

/// Holes of a part, by the graph along its longest axis.
fn holes(points: &[Place]) -> usize {
    let cloud = Cloud::new(points).unwrap();
    let height = functions::principal_height(&cloud, 1).unwrap();
    extract(&cloud, &height, &Choices::default()).unwrap().loops.len()
}

/// `ASPHERA_TRAYS=500 cargo test --release -p asphera-graph --test it trays_are -- --nocapture` looks at more of them;
/// `ASPHERA_TRAYS=109,133,` at some.
#[test]
fn trays_are_recognised() {
    let library = library();
    let asked = std::env::var("ASPHERA_TRAYS").ok();
    let seeds: Vec<u64> = match &asked {
        Some(words) if words.contains(',') => {
            words.split(',').filter_map(|word| word.parse().ok()).collect()
        }
        Some(count) => (0..count.parse().unwrap()).collect(),
        None => (0..3).collect(),
    };
    for seed in seeds {
        let tray = tray(seed, 0.16);
        let (right, wrong) = judged(&tray, &library);
        println!("tray {seed}: {right} of {}, {wrong:?}", tray.truth.len());
        assert!(asked.is_some() || (right, &wrong[..]) == (8, &[][..]));
    }
}

/// The points of a part as it lies on a tray.
fn part(kind: Kind, is_down: bool, seed: u64) -> Vec<Place> {
    let mut tray = Tray { points: Vec::new(), truth: Vec::new() };
    let mut random = Random::new(seed);
    let spot = Spot { middle_mm: [30.0, -20.0], is_down, most_tilt_rad: 0.035 };
    lay(&mut tray, kind, spot, 0.25, &mut random);
    tray.points
}

#[test]
fn a_part_that_the_library_lacks_is_unknown() {
    for (at, kind) in KINDS.into_iter().enumerate() {
        let mut others = library();
        others.remove(at);
        let found = recognise(&part(kind, false, 3), &others, None);
        assert_eq!(found.outcome, Outcome::NoneFits, "{kind:?}: {:?}", found.candidates.first());
    }
}

#[test]
fn two_equal_entries_are_no_answer() {
    let mut twice = library();
    twice.push(Kind::Concave.entry());
    let found = recognise(&part(Kind::Concave, false, 5), &twice, None);
    assert_eq!(found.outcome, Outcome::Ambiguous);
    assert!(found.margin() < 1e-9, "{}", found.margin());
    assert_eq!([found.candidates[0].entry, found.candidates[1].entry], [2, 5]);
}

#[test]
fn a_library_of_one_entry_has_the_margin_one_and_an_empty_one_knows_nothing() {
    let points = part(Kind::Biconvex, true, 7);
    let one = [Kind::Biconvex.entry()];
    let found = recognise(&points, &one, None);
    assert_eq!((found.outcome, found.margin()), (Outcome::Match, 1.0));
    let first = &found.candidates[0];
    assert_eq!((first.pose.facing(), first.is_side_known), (Facing::Down, true));
    // The middle of the part lies where it was laid.
    let [x, y, _] = first.pose.to_entry([30.0, -20.0, 6.0]);
    assert!(x.hypot(y) < 0.3, "{x} {y}");
    let found = recognise(&points, &[], None);
    assert_eq!((found.outcome, found.candidates.len()), (Outcome::NoneFits, 0));
    assert_eq!(recognise_touching(&points, &[], None).len(), 1);
}

#[test]
fn both_sides_of_a_ring_fit() {
    let found = recognise(&part(Kind::Ring, false, 9), &library(), None);
    assert_eq!(found.outcome, Outcome::Match);
    assert!(!found.candidates[0].is_side_known);
}

#[test]
fn earlier_scans_are_entries_as_well_as_grids() {
    let scans: Vec<LibraryEntry> = KINDS
        .iter()
        .map(|&kind| LibraryEntry::face("scan", &part(kind, false, 21)).unwrap())
        .collect();
    for seed in 22..26 {
        for (at, kind) in KINDS.into_iter().enumerate() {
            let found = recognise(&part(kind, false, seed), &scans, None);
            let first = &found.candidates[0];
            assert_eq!((found.outcome, first.entry), (Outcome::Match, at), "{kind:?} {first:?}");
            let mut others = scans.clone();
            others.remove(at);
            let found = recognise(&part(kind, false, seed), &others, None);
            assert_eq!(found.outcome, Outcome::NoneFits, "{kind:?}");
        }
    }
}

#[test]
fn a_face_from_behind_counts_where_no_other_face_fits() {
    // The concave face turned over bulges.
    let turned: Vec<Place> =
        part(Kind::Concave, false, 11).into_iter().map(|[x, y, z]| [x, -y, -z]).collect();
    let found = recognise(&turned, &library(), None);
    let first = &found.candidates[0];
    assert_eq!((found.outcome, first.entry), (Outcome::Match, 2));
    assert_eq!(first.pose.facing(), Facing::Down);
    let mut with_its_like = library();
    with_its_like.push(LibraryEntry::face("bulge", &turned).unwrap());
    let found = recognise(&turned, &with_its_like, None);
    assert_eq!((found.outcome, found.candidates[0].entry), (Outcome::Match, 5));
}

#[test]
fn motion_order_and_threads_change_no_answer() {
    let points = part(Kind::Convex, false, 13);
    let library = library();
    let found = recognise(&points, &library, None);
    assert_eq!((found.outcome, found.candidates[0].entry), (Outcome::Match, 0));

    let mut shuffled = points.clone();
    Random::new(1).shuffle(&mut shuffled);
    assert_eq!(recognise(&shuffled, &library, None), found);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| recognise(&points, &library, None)), found);
    let reversed: Vec<LibraryEntry> = library.iter().rev().cloned().collect();
    let again = recognise(&points, &reversed, None);
    assert_eq!(again.candidates[0].entry, 4);
    assert_eq!(again.candidates[0].pose, found.candidates[0].pose);

    for (turn, shift) in [(1.0_f64, [0.0; 3]), (2.5, [1e4, -2e4, 300.0]), (-0.7, [0.1, 0.2, 0.3])] {
        let (sin, cos) = turn.sin_cos();
        let moved = |&[x, y, z]: &Place| {
            [cos * x - sin * y + shift[0], sin * x + cos * y + shift[1], z + shift[2]]
        };
        let again = recognise(&points.iter().map(moved).collect::<Vec<_>>(), &library, None);
        let (first, second) = (&found.candidates[0], &again.candidates[0]);
        assert_eq!((again.outcome, second.entry), (Outcome::Match, first.entry));
        assert!((first.difference_mm - second.difference_mm).abs() < 1e-3);
        assert!((first.pose.tilt_rad() - second.pose.tilt_rad()).abs() < 3e-3);
    }
}

#[test]
fn too_few_points_and_lines_are_refused() {
    let library = [Kind::Flat.entry()];
    let line: Vec<Place> =
        (0..50).map(|step| [f64::from(step), 2.0 * f64::from(step), 1.0]).collect();
    let nan = vec![[f64::NAN; 3]; 20];
    for points in [vec![], vec![[1.0; 3]], vec![[1.0; 3]; 40], line, nan] {
        let found = recognise(&points, &library, None);
        assert_eq!((found.outcome, found.score()), (Outcome::TooSmall, 0.0));
        assert_eq!(recognise_touching(&points, &library, None).len(), 1);
        let refused = LibraryEntry::face("small", &points).unwrap_err().to_string();
        assert!(refused.contains("expected 12 different ones at least"), "{refused}");
        let normals = vec![[0.0, 0.0, 1.0]; points.len()];
        assert!(LibraryEntry::body("small", &points, &normals).is_err());
    }
}

/// A part of another size is its entry at that scale, and unknown where sizes count.
#[test]
fn parts_of_any_size_are_their_entries_at_a_scale() {
    let library = library();
    for (entry, kind) in KINDS.into_iter().enumerate() {
        let scale = [0.4, 3.0][entry % 2];
        let own = part(kind, false, 11);
        let points: Vec<Place> = own.iter().map(|at| at.map(|mm| scale * mm)).collect();
        let found = recognise_any_size(&points, &library, None);
        let first = &found.candidates[0];
        let answer = (found.outcome, first.entry);
        assert_eq!(answer, (Outcome::Match, entry), "{kind:?} {scale}: {found:?}");
        assert!((first.scale / scale - 1.0).abs() < 0.015, "{kind:?} {scale}: {}", first.scale);
        assert_eq!(recognise(&points, &library, None).outcome, Outcome::NoneFits);
        // The order of the points changes no bit.
        if kind == Kind::Ring {
            let mut reversed = points.clone();
            reversed.reverse();
            assert_eq!(recognise_any_size(&reversed, &library, None), found);
        }
    }
    // A shape that the library lacks stays unknown.
    let (flat, ring) = (part(Kind::Flat, false, 12), [Kind::Ring.entry()]);
    assert_eq!(recognise_any_size(&flat, &ring, None).outcome, Outcome::NoneFits);
}

/// Two sizes of one shape are no answer where sizes are free.
#[test]
fn two_sizes_of_a_shape_are_equal_entries() {
    let [large, own] = [1.7, 1.0].map(|scale: f64| {
        let points = part(Kind::Convex, false, 14);
        let points: Vec<Place> = points.iter().map(|at| at.map(|mm| scale * mm)).collect();
        LibraryEntry::face("convex", &points).unwrap()
    });
    let found = recognise_any_size(&part(Kind::Convex, false, 13), &[large, own], None);
    assert_eq!(found.outcome, Outcome::Ambiguous, "{found:?}");
    let points = part(Kind::Convex, false, 13);
    assert_eq!(recognise_any_size(&points, &[], None).outcome, Outcome::NoneFits);
}
