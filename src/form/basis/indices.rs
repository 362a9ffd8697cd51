//! The orders of counting Zernike terms: Fringe, Noll, and ANSI.
//!
//! A term is known without doubt by its radial order n and azimuthal order m (m ≥ 0 goes with cos mθ,
//! m < 0 with sin |m|θ); a single index means nothing until the order of counting is said.
//!
//! Three traps. Wyant counts the terms of the Fringe list from 0, so that his Z8 (primary spherical
//! aberration) is Fringe Z9. His tables (Wyant & Creath, Applied Optics and Optical Engineering XI (1992) 1)
//! call n what is (n + |m|)/2 here, so a normalisation such as √(n + 1) taken with his n is wrong (prysm,
//! issue 35, where it looked so for m = 0). And the 37th and last term of the University of Arizona's set, as
//! lens design programs have it, is (12, 0); counting on by the rule gives (6, 6), and (12, 0) is 49th.

/// How a single index counts the terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Counting {
    /// From 1, by (n + |m|)/2, then falling |m|, cosine before sine: the rule of the University of Arizona's
    /// list, continued beyond its 36th term. See [`Zernike::fringe_37`](super::Zernike::fringe_37).
    Fringe,
    /// From 1, by n, then |m|; cosines have even numbers. R. J. Noll, J. Opt. Soc. Am. 66 (1976) 207.
    Noll,
    /// From 0, by n, then m. ANSI Z80.28 and ISO 24157.
    Ansi,
}

impl Counting {
    /// The smallest index.
    pub fn first(self) -> u32 {
        match self {
            Counting::Fringe | Counting::Noll => 1,
            Counting::Ansi => 0,
        }
    }

    /// Radial and azimuthal order of a term. `None` below [`Counting::first`] and above [`LARGEST_INDEX`].
    ///
    /// # Examples
    ///
    /// ```
    /// use asphera_form::basis::Counting;
    ///
    /// // Primary spherical aberration has three numbers.
    /// assert_eq!(Counting::Fringe.orders(9), Some((4, 0)));
    /// assert_eq!(Counting::Noll.orders(11), Some((4, 0)));
    /// assert_eq!(Counting::Ansi.orders(12), Some((4, 0)));
    /// ```
    pub fn orders(self, index: u32) -> Option<(u32, i32)> {
        if index < self.first() || index > LARGEST_INDEX {
            return None;
        }
        let offset = index - self.first();
        match self {
            Counting::Fringe => {
                // (n + |m|)/2 is the same throughout a group, and groups begin at the squares.
                let group = offset.isqrt();
                let within = offset - group * group;
                let m = group - within / 2;
                Some((2 * group - m, signed(m, within.is_multiple_of(2))))
            }
            Counting::Noll => {
                let n = triangular(offset);
                let within = offset - n * (n + 1) / 2;
                // |m| takes every second value; all but 0 come twice.
                let m =
                    if n.is_multiple_of(2) { 2 * within.div_ceil(2) } else { within / 2 * 2 + 1 };
                Some((n, signed(m, index.is_multiple_of(2))))
            }
            Counting::Ansi => {
                let n = triangular(offset);
                let within = offset - n * (n + 1) / 2;
                Some((n, 2 * within.cast_signed() - n.cast_signed()))
            }
        }
    }

    /// The index of the term of radial order n and azimuthal order m; `None` where there is no such term
    /// (|m| > n, or n − m odd) or its index is above [`LARGEST_INDEX`].
    pub fn index(self, n: u32, m: i32) -> Option<u32> {
        let a = m.unsigned_abs();
        if a > n || !(n - a).is_multiple_of(2) || n > LARGEST_INDEX {
            return None;
        }
        let (n, a) = (u64::from(n), u64::from(a));
        let below = n * (n + 1) / 2;
        let index = match self {
            Counting::Fringe => {
                let group = (n + a) / 2;
                group * group + 2 * (group - a) + u64::from(m < 0) + 1
            }
            Counting::Noll if m == 0 => below + 1,
            Counting::Noll => {
                // The two numbers of |m| are below + |m| and the next; the cosine has the even one.
                let lower = below + a;
                lower + u64::from(lower.is_multiple_of(2) == (m < 0))
            }
            Counting::Ansi if m < 0 => below + (n - a) / 2,
            Counting::Ansi => below + n.midpoint(a),
        };
        u32::try_from(index).ok().filter(|&index| index <= LARGEST_INDEX)
    }
}

/// What opticians call the term (n, m): `piston`, `tilt x`, `primary coma y`, `secondary astigmatism 45°`.
/// `None` where there is no such term.
///
/// Terms of one |m| are counted from the first that is not piston, tilt or defocus. Odd orders point along
/// x (cosine) or y (sine), even ones to 0° or to 90°/|m|.
pub fn aberration(n: u32, m: i32) -> Option<String> {
    let a = m.unsigned_abs();
    if a > n || !(n - a).is_multiple_of(2) {
        return None;
    }
    let (kind, rank) = match (a, n) {
        (0, 0) => return Some("piston".to_owned()),
        (0, 2) => return Some("defocus".to_owned()),
        (0, _) => ("spherical aberration".to_owned(), n / 2 - 1),
        (1, 1) => ("tilt".to_owned(), 0),
        (1, _) => ("coma".to_owned(), (n - 1) / 2),
        (2, _) => ("astigmatism".to_owned(), n / 2),
        (3..=6, _) => (FOILS[a as usize - 3].to_owned(), (n - a) / 2 + 1),
        _ => (format!("{a}-foil"), (n - a) / 2 + 1),
    };
    let rank = match rank {
        0 => String::new(),
        1..=5 => format!("{} ", RANKS[rank as usize - 1]),
        _ => format!("{rank}th "),
    };
    let direction = match (a, m < 0) {
        (0, _) => String::new(),
        (a, sine) if !a.is_multiple_of(2) => if sine { " y" } else { " x" }.to_owned(),
        (_, false) => " 0°".to_owned(),
        (a, true) => format!(" {}°", 90.0 / f64::from(a)),
    };
    Some(format!("{rank}{kind}{direction}"))
}

const FOILS: [&str; 4] = ["trefoil", "quadrafoil", "pentafoil", "hexafoil"];
const RANKS: [&str; 5] = ["primary", "secondary", "tertiary", "quaternary", "quinary"];

/// The largest index looked at: beyond any use, and far from overflow.
pub const LARGEST_INDEX: u32 = 1_000_000;

/// The largest n of which n·(n + 1)/2 is not above `offset`.
fn triangular(offset: u32) -> u32 {
    ((8 * u64::from(offset) + 1).isqrt() as u32 - 1) / 2
}

fn signed(m: u32, cosine: bool) -> i32 {
    if cosine { m.cast_signed() } else { -m.cast_signed() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Counting; 3] = [Counting::Fringe, Counting::Noll, Counting::Ansi];

    #[test]
    fn indices_and_orders_are_inverse() {
        for counting in ALL {
            for index in counting.first()..3000 {
                let (n, m) = counting.orders(index).unwrap();
                assert_eq!(counting.index(n, m), Some(index), "{counting:?} {index}: {n} {m}");
            }
        }
    }

    /// prysm 0.21.1 (`fringe_to_nm`, `ansi_j_to_nm`, `noll_to_nm`) and, for Noll, POPPY 1.1
    /// (`zernike.noll_indices`), terms in sequence.
    const FRINGE: [(u32, i32); 37] = [
        (0, 0),
        (1, 1),
        (1, -1),
        (2, 0),
        (2, 2),
        (2, -2),
        (3, 1),
        (3, -1),
        (4, 0),
        (3, 3),
        (3, -3),
        (4, 2),
        (4, -2),
        (5, 1),
        (5, -1),
        (6, 0),
        (4, 4),
        (4, -4),
        (5, 3),
        (5, -3),
        (6, 2),
        (6, -2),
        (7, 1),
        (7, -1),
        (8, 0),
        (5, 5),
        (5, -5),
        (6, 4),
        (6, -4),
        (7, 3),
        (7, -3),
        (8, 2),
        (8, -2),
        (9, 1),
        (9, -1),
        (10, 0),
        (6, 6),
    ];

    const NOLL: [(u32, i32); 30] = [
        (0, 0),
        (1, 1),
        (1, -1),
        (2, 0),
        (2, -2),
        (2, 2),
        (3, -1),
        (3, 1),
        (3, -3),
        (3, 3),
        (4, 0),
        (4, 2),
        (4, -2),
        (4, 4),
        (4, -4),
        (5, 1),
        (5, -1),
        (5, 3),
        (5, -3),
        (5, 5),
        (5, -5),
        (6, 0),
        (6, -2),
        (6, 2),
        (6, -4),
        (6, 4),
        (6, -6),
        (6, 6),
        (7, -1),
        (7, 1),
    ];

    const ANSI: [(u32, i32); 16] = [
        (0, 0),
        (1, -1),
        (1, 1),
        (2, -2),
        (2, 0),
        (2, 2),
        (3, -3),
        (3, -1),
        (3, 1),
        (3, 3),
        (4, -4),
        (4, -2),
        (4, 0),
        (4, 2),
        (4, 4),
        (5, -5),
    ];

    #[test]
    fn first_terms_of_the_tables() {
        let tables: [&[(u32, i32)]; 3] = [&FRINGE, &NOLL, &ANSI];
        for (counting, table) in ALL.into_iter().zip(tables) {
            for (index, &orders) in (counting.first()..).zip(table) {
                assert_eq!(counting.orders(index), Some(orders), "{counting:?} {index}");
            }
        }
    }

    /// The names of prysm 0.21.1 (`nm_to_name`) but for case and for |m| above 3, where it counts (6, 4) with
    /// (4, 4).
    #[test]
    fn names_of_opticians() {
        let names = [
            ((0, 0), "piston"),
            ((1, 1), "tilt x"),
            ((1, -1), "tilt y"),
            ((2, 0), "defocus"),
            ((2, 2), "primary astigmatism 0°"),
            ((2, -2), "primary astigmatism 45°"),
            ((3, 1), "primary coma x"),
            ((3, -3), "primary trefoil y"),
            ((4, 0), "primary spherical aberration"),
            ((4, -2), "secondary astigmatism 45°"),
            ((4, -4), "primary quadrafoil 22.5°"),
            ((5, -1), "secondary coma y"),
            ((6, 4), "secondary quadrafoil 0°"),
            ((7, 3), "tertiary trefoil x"),
            ((9, 1), "quaternary coma x"),
            ((12, 0), "quinary spherical aberration"),
            ((15, -1), "7th coma y"),
            ((9, 9), "primary 9-foil x"),
        ];
        for ((n, m), name) in names {
            assert_eq!(aberration(n, m).as_deref(), Some(name));
        }
        assert_eq!((aberration(3, 2), aberration(1, 3)), (None, None));
        // No two terms share a name.
        let all: std::collections::BTreeSet<_> = (1..=500)
            .filter_map(|index| Counting::Noll.orders(index))
            .map(|(n, m)| aberration(n, m))
            .collect();
        assert_eq!(all.len(), 500);
    }

    #[test]
    fn no_term() {
        assert_eq!(Counting::Fringe.orders(0), None);
        assert_eq!(Counting::Ansi.orders(0), Some((0, 0)));
        assert_eq!(Counting::Noll.orders(u32::MAX), None);
        for counting in ALL {
            assert_eq!(counting.index(3, 2), None);
            assert_eq!(counting.index(2, 4), None);
            assert_eq!(counting.index(u32::MAX, 1), None);
            assert_eq!(counting.index(4, i32::MIN), None);
        }
    }
}
