//! Laws of outlines: exact borders, any turn of the lines, whatever is none.

use super::*;

fn square(low: f64, high: f64) -> Vec<Place> {
    vec![[low, low], [high, low], [high, high], [low, high]]
}

#[test]
fn a_line_may_turn_either_way_and_be_closed_or_not() {
    for turned in [false, true] {
        let (mut outline, mut hole) = (square(0.0, 4.0), square(1.0, 3.0));
        if turned {
            outline.reverse();
            outline.push(outline[0]);
            hole.reverse();
        }
        let found = Outline::new(&outline, &[hole]).unwrap();
        assert_eq!((found.area_mm2(), found.perimeter_mm()), (12.0, 24.0));
        assert_eq!((found.bounds_mm(), found.filled().area_mm2()), ([[0.0; 2], [4.0; 2]], 16.0));
        for (place, inside) in [
            ([0.5, 2.0], true),
            ([2.0, 2.0], false),
            ([1.0, 2.0], true),
            ([4.0, 4.0], true),
            ([2.0, 4.0], true),
            ([2.0, 4.1], false),
            ([2.0, -1e9], false),
            ([f64::NAN, 1.0], false),
            ([1.0, f64::INFINITY], false),
        ] {
            assert_eq!(found.contains(place), inside, "{place:?}");
        }
        assert_eq!(found.pieces([-1.0, 2.0], [2.0, 0.0]), [[0.5, 1.0], [2.0, 2.5]]);
        assert_eq!(found.nearest_mm([9.0, 2.5]), [4.0, 2.5]);
        assert!(found.passes_within([2.0, 2.0], 1.0) && !found.passes_within([2.0, 2.0], 0.999));
    }
}

#[test]
fn what_is_no_outline() {
    let error = |outline: &[Place], holes: &[Vec<Place>]| {
        Outline::new(outline, holes).expect_err("it is none")
    };
    let two = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
    assert_eq!(error(&two, &[]), OutlineError::Places { line: 0, places: 2 });
    assert_eq!(error(&[], &[]), OutlineError::Places { line: 0, places: 0 });
    let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
    assert_eq!(error(&line, &[]), OutlineError::Empty { line: 0 });
    let infinite = [[0.0, 0.0], [1.0, f64::INFINITY], [2.0, 2.0]];
    assert!(matches!(error(&infinite, &[]), OutlineError::Place { .. }));
    let bow = [[0.0, 0.0], [2.0, 2.0], [3.0, 0.0], [0.0, 1.0]];
    assert!(matches!(error(&bow, &[]), OutlineError::Meet { lines: [0, 0], .. }));
    let spike = [[0.0, 0.0], [4.0, 0.0], [2.0, 0.0], [2.0, 3.0]];
    assert!(matches!(error(&spike, &[]), OutlineError::Meet { lines: [0, 0], .. }));
    let outline = square(0.0, 4.0);
    let crossing = error(&outline, &[square(3.0, 5.0)]);
    assert!(matches!(crossing, OutlineError::Meet { lines: [0, 1], .. }), "{crossing:?}");
    let touching = error(&outline, &[square(0.0, 1.0)]);
    assert!(matches!(touching, OutlineError::Meet { .. }));
    assert_eq!(error(&outline, &[square(5.0, 6.0)]), OutlineError::Hole { hole: 1 });
    let nested = error(&outline, &[square(1.0, 3.0), square(1.5, 2.5)]);
    assert_eq!(nested, OutlineError::Hole { hole: 2 });
    let message = error(&outline, &[square(5.0, 6.0)]).to_string();
    assert_eq!(message, "hole 1 does not lie inside the outline");
}

/// A star of many corners about a place: radius by angle, so that it never meets itself.
fn star(corners: u32, centre: Place, seed: u64) -> Vec<Place> {
    let numbers = crate::Numbers::new(seed, 0, 0);
    (0..corners)
        .map(|k| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(corners)).sin_cos();
            let radius = 1.0 + 4.0 * numbers.uniform(k as usize);
            [centre[0] + radius * cos, centre[1] + radius * sin]
        })
        .collect()
}

#[test]
fn strips_find_what_all_sides_say() {
    for (seed, corners) in [(1, 5), (2, 40), (3, 999)] {
        let places = star(corners, [3.0, -2.0], seed);
        let outline = Outline::new(&places, &[]).unwrap();
        let numbers = crate::Numbers::new(seed, 1, 0);
        let mut inside = 0;
        for k in 0..2_000 {
            let at = [2 * k, 2 * k + 1].map(|index| 12.0 * numbers.uniform(index) - 6.0);
            let at = [at[0] + 3.0, at[1] - 2.0];
            let expected = ring_contains(&places, at);
            inside += usize::from(expected);
            assert_eq!(outline.contains(at), expected, "{at:?}");
            let [x, y] = outline.nearest_mm(at);
            let apart = (x - at[0]).hypot(y - at[1]);
            assert!(outline.passes_within(at, apart * (1.0 + 1e-12)));
            assert!(!outline.passes_within(at, apart * (1.0 - 1e-12)));
        }
        assert!((200..1_800).contains(&inside));
        for &corner in &places {
            assert!(outline.contains(corner) && outline.nearest_mm(corner) == corner);
        }
    }
}

#[test]
fn pieces_add_up_to_the_area() {
    let places = star(77, [0.0, 0.0], 9);
    let outline = Outline::new(&places, &[square(-0.4, 0.4)]).unwrap();
    let step_mm = 1e-3;
    let (mut area_mm2, mut count) = (0.0, 0);
    for row in -6_000..6_000 {
        let y = (f64::from(row) + 0.5) * step_mm;
        let pieces = outline.pieces([-7.0, y], [1.0, 0.0]);
        area_mm2 += pieces.iter().map(|[a, b]| (b - a) * step_mm).sum::<f64>();
        count += pieces.len();
    }
    assert!((area_mm2 / outline.area_mm2() - 1.0).abs() < 1e-4, "{area_mm2}");
    assert!(count > 4_000);
}
