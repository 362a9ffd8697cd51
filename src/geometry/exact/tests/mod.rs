//! Tests of the predicates against integers, against another implementation, and at their limits.

mod balls;
mod lengths;
mod limbs;
mod radius;
mod signs;
mod space;
mod sphere;
mod ties;

use std::cmp::Ordering;

use crate::exact::Place;

/// Places with whole coordinates.
type Whole<const N: usize> = [[i64; 2]; N];

fn near_place(place: [i64; 2]) -> Place {
    place.map(|count| count as f64)
}

fn integer_orientation(places: Whole<3>) -> Ordering {
    let [a, b, c] = places.map(|place| place.map(i128::from));
    ((a[0] - c[0]) * (b[1] - c[1])).cmp(&((a[1] - c[1]) * (b[0] - c[0])))
}
