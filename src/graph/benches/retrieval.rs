//! How well descriptors find shapes of their class: seven classes made here, in random poses and proportions. Seeds are fixed.
//!
//! `cargo bench -p asphera-graph --bench retrieval -- THREADS [MEMBERS]`; `MEMBERS` of each class, 20.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it found")]
#![expect(clippy::unwrap_used, reason = "a benchmark ends where something is not as it must be")]

#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/it/bodies.rs"]
mod bodies;
#[path = "../tests/it/classes.rs"]
mod classes;

use asphera_graph::compare::{
    Evaluation, GraphFeatures, Size, evaluation, graph_features, shape_descriptor,
};
use asphera_graph::{Choices, Cloud, StripChoice, extract, functions};
use bodies::{Place, Random};
use classes::{CLASSES, member};
use rayon::prelude::*;

const POINTS: usize = 5_000;

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|word| word.parse::<usize>().ok());
    let threads = numbers.next().unwrap_or(1);
    let members = numbers.next().unwrap_or(20);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| run(members));
}

fn run(members: usize) {
    println!("  {} classes of {members}, {POINTS} points each", CLASSES.len());
    let all: Vec<(usize, usize)> =
        (0..CLASSES.len()).flat_map(|class| (0..members).map(move |one| (class, one))).collect();
    let classes: Vec<usize> = all.iter().map(|&(class, _)| class).collect();
    let clouds: Vec<Cloud<3>> = all.par_iter().map(|&(class, one)| cloud(class, one)).collect();
    let shapes: Vec<_> =
        clouds.par_iter().map(|cloud| shape_descriptor(cloud, Size::Free).unwrap()).collect();
    print("default", &evaluation(&classes, |a, b| shapes[a].distance(&shapes[b])).unwrap());
    let graphs: Vec<GraphFeatures> = clouds.par_iter().map(features).collect();
    print("seed, pca:1", &evaluation(&classes, |a, b| graphs[a].distance(&graphs[b])).unwrap());
}

/// A member of a class, turned at random.
fn cloud(class: usize, one: usize) -> Cloud<3> {
    let mut random = Random::new((1000 * class + one) as u64);
    let points = member(class, &mut random).sample(POINTS, &mut random);
    let scale = random.between(0.5, 2.0);
    let x = random.direction();
    let other = random.direction();
    let z = unit(cross(x, other));
    let axes = [x, cross(z, x), z];
    let turned = |p: &Place| -> Place {
        axes.map(|axis| scale * (0..3).map(|at| axis[at] * p[at]).sum::<f64>())
    };
    Cloud::new(&points.iter().map(turned).collect::<Vec<Place>>()).unwrap()
}

fn features(cloud: &Cloud<3>) -> GraphFeatures {
    let field = functions::principal_height(cloud, 1).unwrap();
    let choices = Choices { strips: StripChoice::Uniform(30), ..Choices::default() };
    graph_features(&extract(cloud, &field, &choices).unwrap().graph)
}

fn print(name: &str, found: &Evaluation) {
    println!(
        "    {name}: nearest neighbour {:.3}, tiers {:.3} {:.3}, DCG {:.3}, mAP {:.3}",
        found.nearest_neighbour,
        found.first_tier,
        found.second_tier,
        found.dcg,
        found.mean_average_precision
    );
}

fn cross(u: Place, v: Place) -> Place {
    let at = |i: usize| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    [at(0), at(1), at(2)]
}

fn unit(p: Place) -> Place {
    let length = bodies::norm(p);
    p.map(|side| side / length)
}
