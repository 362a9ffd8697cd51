//! Places of critical configurations, against a search of every face and cell by its samples.

use asphera_volume::{Critical, CriticalKind, GridCheck, Histogram, PLACES, Samples};

use crate::noise::Random;

/// By the definition: samples of one sign on a diagonal, of the other sign elsewhere.
fn searched(samples: &Samples) -> Vec<Critical> {
    let size = samples.size().map(|side| side as i64);
    let mut found = Vec::new();
    for z in -1..size[2] {
        for y in -1..size[1] {
            for x in -1..size[0] {
                let cell = [x, y, z];
                for axis in 0..3 {
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let at = |du: i64, dv: i64| {
                        let mut place = cell;
                        place[axis] += 1;
                        place[u] += du;
                        place[v] += dv;
                        samples.get(place)
                    };
                    if at(0, 0) == at(1, 1) && at(0, 1) == at(1, 0) && at(0, 0) != at(0, 1) {
                        let mut centre = cell.map(|side| side as f64 + 0.5);
                        centre[axis] += 0.5;
                        found.push(Critical { centre, kind: CriticalKind::C1 });
                    }
                }
                let corner = |index: i64| {
                    samples.get([x + (index & 1), y + (index >> 1 & 1), z + (index >> 2)])
                };
                let is_c2 = (0..4).any(|low| {
                    let own = corner(low);
                    (0..8).all(|index| (corner(index) == own) == (index == low || index == 7 - low))
                });
                if is_c2 {
                    let centre = cell.map(|side| side as f64 + 0.5);
                    found.push(Critical { centre, kind: CriticalKind::C2 });
                }
            }
        }
    }
    found
}

#[test]
fn critical_places_are_those_of_a_search() {
    let mut random = Random::new(77);
    let mut seen = [0_usize; 2];
    for round in 0..200 {
        let share = [0.03, 0.97, 0.1][round % 3];
        let samples = random.volume([5, 4, 6], share);
        let check = GridCheck::new(&samples, &Histogram::new(&samples));
        let searched = searched(&samples);
        let of = |kind| searched.iter().filter(|critical| critical.kind == kind).count();
        let counts = [of(CriticalKind::C1), of(CriticalKind::C2)];
        assert_eq!([check.c1, check.c2], counts.map(|count| count as u64), "{round}");
        assert_eq!(check.critical, searched[..searched.len().min(PLACES)], "{round}");
        (0..2).for_each(|kind| seen[kind] += counts[kind]);
    }
    assert!(seen.iter().all(|&count| count > 20), "{seen:?}");
}
