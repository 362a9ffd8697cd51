//! Paths against the shortest of all orders, and the laws they keep.

use proptest::prelude::*;

use super::*;

/// Even numbers in 0 to 1 by SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn places(&mut self, count: usize) -> Vec<[f64; 2]> {
        (0..count).map(|_| [10.0 * self.next(), 10.0 * self.next()]).collect()
    }
}

fn length(from: [f64; 2], places: &[[f64; 2]], order: &[usize]) -> f64 {
    path_length_mm(from, order.iter().map(|&index| places[index]))
}

/// The shortest of all orders, by trying each.
fn brute_force(from: [f64; 2], places: &[[f64; 2]]) -> f64 {
    fn go(at: [f64; 2], open: &mut Vec<[f64; 2]>, so_far: f64, best: &mut f64) {
        if so_far >= *best {
            return;
        }
        if open.is_empty() {
            *best = so_far;
            return;
        }
        for index in 0..open.len() {
            let next = open.swap_remove(index);
            go(next, open, so_far + distance_mm(at, next), best);
            open.push(next);
            let last = open.len() - 1;
            open.swap(index, last);
        }
    }
    let mut best = f64::INFINITY;
    go(from, &mut places.to_vec(), 0.0, &mut best);
    best
}

fn heuristic(from: [f64; 2], places: &[[f64; 2]]) -> Vec<usize> {
    let ruler = Ruler::new(from, places);
    improve::shortened(&ruler, grid::nearest_first(&ruler), &grid::neighbours(&ruler))
}

#[test]
fn few_places_have_the_shortest_of_all_orders() {
    let mut random = Random(7);
    for trial in 0..60 {
        let places = random.places(1 + trial % 9);
        let from = [10.0 * random.next(), 10.0 * random.next()];
        let found = length(from, &places, &short_order(from, &places).unwrap());
        let best = brute_force(from, &places);
        assert!((found - best).abs() < 1e-9, "{trial}: {found} {best}");
    }
}

/// The steps alone, which more places need, against the shortest path of up to twelve.
#[test]
fn steps_come_close_to_the_shortest_path() {
    let mut random = Random(11);
    let (mut sum, mut worst, trials) = (0.0, 0.0_f64, 300);
    for trial in 0..trials {
        let mut places = random.places(8 + trial % 5);
        places.sort_by(|p, q| p[0].total_cmp(&q[0]));
        let from = [10.0 * random.next(), 10.0 * random.next()];
        let ruler = Ruler::new(from, &places);
        let of =
            |order: &[usize]| path_length_mm(from, order.iter().map(|&node| ruler.nodes[node]));
        let order = heuristic(from, &places);
        let mut all = order.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(1..=places.len()));
        let excess = of(&order) / of(&exact::shortest(&ruler)) - 1.0;
        assert!(excess > -1e-9);
        sum += excess;
        worst = worst.max(excess);
    }
    let mean = sum / trials as f64;
    assert!(mean < 0.02 && worst < 0.25, "mean {mean:.4}, worst {worst:.4}");
}

/// A path through n places of a square of area A is near 0.7124·√(n·A) (Johnson, McGeoch 1997) where it is the shortest.
#[test]
fn many_places_have_a_path_near_the_known_length() {
    let mut random = Random(3);
    let places = random.places(4000);
    let order = short_order([0.0, 0.0], &places).unwrap();
    let found = length([0.0, 0.0], &places, &order);
    let expected = 0.7124 * (4000.0_f64 * 100.0).sqrt();
    assert!((0.99..1.09).contains(&(found / expected)), "{}", found / expected);
}

#[test]
fn a_lattice_is_gone_through_without_a_jump() {
    let places: Vec<[f64; 2]> = (0..400).map(|k| [f64::from(k % 20), f64::from(k / 20)]).collect();
    let order = short_order([-1.0, 0.0], &places).unwrap();
    let found = length([-1.0, 0.0], &places, &order);
    assert!((400.0..416.0).contains(&found), "{found}");
}

#[test]
fn few_and_equal_places_and_places_on_a_line_have_a_path() {
    assert_eq!(short_order([0.0, 0.0], &[]).unwrap(), Vec::<usize>::new());
    assert_eq!(short_order([5.0, 5.0], &[[1.0, 1.0]]).unwrap(), [0]);
    let same = vec![[2.0, 2.0]; 100];
    assert_eq!(short_order([2.0, 2.0], &same).unwrap(), (0..100).collect::<Vec<_>>());
    let line: Vec<[f64; 2]> = (0..50).map(|k| [f64::from((k * 7) % 50), 0.0]).collect();
    let order = short_order([-1.0, 0.0], &line).unwrap();
    assert!((length([-1.0, 0.0], &line, &order) - 50.0).abs() < 1e-9);
    let zeros = [[0.0, -0.0], [-0.0, 0.0], [1.0, 0.0]];
    assert_eq!(short_order([0.0, 0.0], &zeros).unwrap(), [0, 1, 2]);
    for bad in [f64::NAN, f64::INFINITY] {
        let error = short_order([0.0, 0.0], &[[1.0, 1.0], [bad, 0.0]]).unwrap_err();
        assert!(error.to_string().contains("as place 2"), "{error}");
        assert!(short_order([bad, 0.0], &[]).unwrap_err().to_string().contains("the beginning"));
    }
    let many = vec![[0.0, 0.0]; MOST_PLACES + 1];
    assert!(short_order([0.0, 0.0], &many).unwrap_err().to_string().contains("at most 50000"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Places on a coarse raster, so that ties are common: whatever their order, the path is the same.
    #[test]
    fn the_order_of_places_does_not_matter(
        grid in prop::collection::vec([0_i32..12, 0_i32..12], 0..120),
        seed in any::<u64>(),
    ) {
        let places: Vec<[f64; 2]> = grid.iter().map(|place| place.map(f64::from)).collect();
        let mut random = Random(seed);
        let mut shuffled = places.clone();
        for last in (1..shuffled.len()).rev() {
            shuffled.swap(last, (random.next() * (last + 1) as f64) as usize);
        }
        let from = [3.5, -1.0];
        let path = |places: &[[f64; 2]]| -> Vec<[f64; 2]> {
            short_order(from, places).unwrap().into_iter().map(|index| places[index]).collect()
        };
        prop_assert_eq!(path(&places), path(&shuffled));
    }

    /// A quarter turn, a mirror and a scale by a power of two change no length: where no two are equal, neither the path.
    #[test]
    fn turned_and_scaled_places_have_the_same_path(seed in any::<u64>(), count in 13_usize..80) {
        let mut random = Random(seed);
        let places = random.places(count);
        let from = [10.0 * random.next(), 10.0 * random.next()];
        let order = short_order(from, &places).unwrap();
        let changes: [fn([f64; 2]) -> [f64; 2]; 4] =
            [|[x, y]| [-y, x], |[x, y]| [-x, -y], |[x, y]| [y, x], |[x, y]| [8.0 * x, 8.0 * y]];
        for change in changes {
            let changed: Vec<[f64; 2]> = places.iter().map(|&place| change(place)).collect();
            prop_assert_eq!(&short_order(change(from), &changed).unwrap(), &order);
        }
    }
}
