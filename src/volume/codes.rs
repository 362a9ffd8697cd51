//! The 256 codes of a cell: classes, cases, critical configurations.
//!
//! Source: Stelldinger, Latecki, Siqueira, Topological equivalence between a 3D object and the reconstruction of its digital
//! image, IEEE PAMI 29 (2007): figure 5 (cases), figure 2 (C1, C2), theorems 12 to 14 (which cases may occur).

use std::sync::OnceLock;

use crate::cell::{FACES, symmetries};

/// The cases of the source, as far as its theorems tell them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Case {
    /// All corners alike: case 1.
    Uniform,
    /// One disc parts the corners: cases 2 to 7.
    Simple,
    /// Two corners on a face diagonal against six: case 8. It may occur, but only in pairs.
    Paired,
    /// Cases 9 to 14: no r-regular solid has such a cell where h < r / √3.
    Forbidden,
}

/// Data known of one code. Bit x + 2y + 4z of a code is the corner (x, y, z); 1 is foreground.
#[derive(Clone, Copy, Debug)]
pub struct CodeFacts {
    /// The smallest code that a symmetry of the cube makes of it: 22 classes.
    pub class: u8,
    /// The case of the source.
    pub case: Case,
    /// Faces whose two foreground corners are diagonal (C1): bit f for face f, in the order x = 0, x = 1, y = 0, ….
    pub c1_faces: u8,
    /// Whether two corners on a space diagonal stand against six (C2).
    pub is_c2: bool,
}

/// Data known of every code.
pub fn facts() -> &'static [CodeFacts; 256] {
    static FACTS: OnceLock<[CodeFacts; 256]> = OnceLock::new();
    FACTS.get_or_init(|| {
        let symmetries = symmetries();
        std::array::from_fn(|code| {
            let code = code as u8;
            let images = symmetries.iter().map(|symmetry| symmetry.code(code));
            let c1_faces = c1_faces(code);
            CodeFacts {
                class: images.min().unwrap_or(code),
                case: case(code, c1_faces),
                c1_faces,
                is_c2: is_c2(code),
            }
        })
    })
}

fn c1_faces(code: u8) -> u8 {
    FACES.iter().enumerate().fold(0, |faces, (index, corners)| {
        let [a, b, c, d] = corners.map(|corner| code >> corner & 1);
        faces | u8::from(a == c && b == d && a != b) << index
    })
}

fn is_c2(code: u8) -> bool {
    let of_two = |code: u8| (0..4).any(|low| code == 1 << low | 1 << (7 - low));
    of_two(code) || of_two(!code)
}

fn case(code: u8, c1_faces: u8) -> Case {
    let is_critical = c1_faces != 0 || is_c2(code);
    match code.count_ones() {
        0 | 8 => Case::Uniform,
        _ if !is_critical => Case::Simple,
        2 | 6 if c1_faces.count_ones() == 1 => Case::Paired,
        _ => Case::Forbidden,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// The numbers of the source: 22 classes, 14 with complement; 128 codes well-composed, 24 of case 8, 104 forbidden.
    #[test]
    fn classes_and_cases_are_as_many_as_the_source_says() {
        let facts = facts();
        let mut classes = BTreeMap::<u8, usize>::new();
        facts.iter().for_each(|code| *classes.entry(code.class).or_default() += 1);
        assert_eq!(classes.len(), 22);
        let complement = |class: u8| facts[usize::from(!class)].class;
        let with_complement: std::collections::BTreeSet<u8> =
            classes.keys().map(|&class| class.min(complement(class))).collect();
        assert_eq!(with_complement.len(), 14);
        let count = |case| facts.iter().filter(|code| code.case == case).count();
        assert_eq!(count(Case::Uniform) + count(Case::Simple), 128);
        assert_eq!(count(Case::Paired), 24);
        assert_eq!(count(Case::Forbidden), 104);
        // The guide's table, class by class: representative, codes with complement, C1 faces.
        for (class, codes, c1) in [
            (0b0000_0000_u8, 2, 0),
            (0b0000_0001, 16, 0),
            (0b0000_0011, 24, 0),
            (0b0000_0111, 48, 0),
            (0b0000_1111, 6, 0),
            (0b0001_0111, 8, 0),
            (0b0001_1011, 24, 0),
            (0b0000_0110, 24, 1),
            (0b0001_1000, 8, 0),
            (0b0001_0110, 16, 3),
            (0b0001_1001, 48, 1),
            (0b0001_1110, 24, 2),
            (0b0011_1100, 6, 2),
            (0b0110_1001, 2, 6),
        ] {
            let own = facts[usize::from(class)].class;
            let other = complement(own);
            let found: usize =
                classes.iter().filter(|&(&c, _)| c == own || c == other).map(|(_, n)| n).sum();
            let faces = facts[usize::from(class)].c1_faces.count_ones();
            assert_eq!((found, faces), (codes, c1), "{class:08b}");
        }
    }

    #[test]
    fn symmetries_and_complement_keep_case_and_c2() {
        for symmetry in symmetries() {
            for code in 0..=255_u8 {
                let (here, there) =
                    (facts()[usize::from(code)], facts()[usize::from(symmetry.code(code))]);
                assert_eq!(
                    (here.case, here.is_c2, here.class),
                    (there.case, there.is_c2, there.class)
                );
                let other = facts()[usize::from(!code)];
                assert_eq!(
                    (here.case, here.is_c2, here.c1_faces),
                    (other.case, other.is_c2, other.c1_faces)
                );
            }
        }
    }
}
