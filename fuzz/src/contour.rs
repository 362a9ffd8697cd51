//! Drawings a fuzzer can write, and what must hold for every contour of them.

use arbitrary::Arbitrary;
use asphera_contour::strokes::{Hint, Strokes, beziers_of};
use asphera_contour::{Graph, Method, MethodError, Parameters, PlaceMm, Samples, Triangulation};

/// Points, a method with its parameters, and hints.
#[derive(Arbitrary, Debug)]
pub struct Drawing {
    points: Vec<Place>,
    method: u8,
    values: [u8; 3],
    hints: Vec<(Place, u8)>,
    shift: u8,
}

/// A place on a lattice, on a circle, or anywhere.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Place {
    Lattice(i8, i8),
    Circle(u8),
    Anywhere(f32, f32),
}

impl Place {
    fn at_mm(self) -> PlaceMm {
        match self {
            Place::Lattice(x, y) => [f64::from(x % 8), f64::from(y % 8)],
            Place::Circle(step) => {
                let (sin, cos) = (f64::from(step) * std::f64::consts::TAU / 64.0).sin_cos();
                [5.0 * cos, 5.0 * sin]
            }
            Place::Anywhere(x, y) => [x, y].map(|value| f64::from(value) % 1e9),
        }
    }
}

impl Drawing {
    /// At most 64 points, each place once.
    fn places_mm(&self) -> Vec<PlaceMm> {
        let far_mm = [0.0, 1e6, 3e11][usize::from(self.shift % 3)];
        let mut places: Vec<PlaceMm> = self
            .points
            .iter()
            .take(64)
            .map(|it| it.at_mm())
            .map(|[x, y]| [x + far_mm, y])
            .collect();
        // What no method takes is refused with its row; the rest is taken.
        if let Err(refused) = Samples::new(&places) {
            assert!(is_short(&refused.to_string()));
            places.retain(|place| place.iter().all(|value| value.is_finite()));
        }
        places.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
        places.dedup();
        places
    }

    /// Values from below the range of each parameter to the middle of what is usual.
    fn parameters(&self, method: Method) -> Parameters {
        let values = method.parameters().iter().zip(self.values);
        values.fold(Parameters::new(), |parameters, (parameter, value)| match value {
            0 => parameters,
            1 => parameters.with(parameter.name, parameter.low),
            2 => parameters.with(parameter.name, parameter.high),
            3 => parameters.with(parameter.name, parameter.low - 1.0),
            _ => parameters.with(parameter.name, f64::from(value) / 32.0),
        })
    }

    fn hints(&self) -> Vec<Hint> {
        let hints = self.hints.iter().take(4);
        let label = |number: u8| ["a", "b", "c"][usize::from(number % 3)].to_owned();
        hints.map(|&(place, number)| Hint { at_mm: place.at_mm(), label: label(number) }).collect()
    }
}

/// The method answers in finite numbers or in words, and whatever the order of the points the answer is the same.
pub fn hold(drawing: &Drawing) {
    let places = drawing.places_mm();
    let method = Method::ALL[usize::from(drawing.method) % Method::ALL.len()];
    let parameters = drawing.parameters(method);
    let Ok(samples) = Samples::new(&places) else { return };
    let set = Triangulation::new(samples);
    let found = method.curve(&set, &parameters);
    let mut backwards = places.clone();
    backwards.reverse();
    let other = Samples::new(&backwards).map(Triangulation::new).expect("the same places");
    assert_eq!(found, method.curve(&other, &parameters), "{}", method.name());
    match found {
        Ok(curve) => {
            graph(&curve.graph, set.len());
            for place in curve.places_mm.iter().flatten() {
                assert!(place.iter().all(|value| value.is_finite()), "{}", method.name());
            }
            assert!(curve.places_mm.is_none_or(|it| it.len() == set.len()));
            assert!(curve.sigma_mm.is_none_or(|it| it.is_finite() && it >= 0.0));
        }
        Err(refused) => words(&refused),
    }
    if let Ok(Some(region)) = method.region(&set, &parameters) {
        let area_mm2 = region.area_mm2(set.samples());
        assert!(area_mm2.is_finite(), "{} of {places:?}: {area_mm2}", method.name());
        assert!(region.parts().iter().all(|part| part.outline.len() > 2 && part.label > 0));
    }
    match method.strokes(&set, &parameters, &drawing.hints()) {
        Ok(Some(found)) => strokes(&found, &set),
        Ok(None) => {}
        Err(refused) => words(&refused),
    }
}

fn graph(graph: &Graph, samples: usize) {
    assert!(graph.edges().is_sorted());
    assert!(graph.edges().iter().all(|&[p, q]| p < q && (q as usize) < samples));
    let joined: usize = graph
        .chains(samples)
        .iter()
        .map(|chain| chain.samples.len() - usize::from(!chain.closed))
        .sum();
    assert_eq!(joined, graph.edges().len(), "chains are not all edges once");
}

fn strokes(found: &Strokes, set: &Triangulation) {
    let labels = found.labels.len();
    assert!(found.region.parts().iter().all(|part| (part.label as usize) <= labels));
    for line in &found.lines {
        assert!(line.places_mm.len() > 1);
        for curve in beziers_of(line, 0.1) {
            assert!(curve.as_flattened().iter().all(|value| value.is_finite()));
        }
    }
    // No part lies over another: together they are no larger than the hull.
    let all = Method::Delaunay.run(set, &Parameters::new()).map(|it| it.edges().len()).unwrap_or(0);
    assert!(found.gaps.len() <= all);
    let corners = |it: [u32; 3]| it.map(|corner| set.place(corner));
    let doubled =
        |[a, b, c]: [PlaceMm; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let hull_mm2: f64 = set.triangles().iter().map(|&it| 0.5 * doubled(corners(it))).sum();
    let area_mm2 = found.region.area_mm2(set.samples());
    assert!(area_mm2 <= hull_mm2 * (1.0 + 1e-6) + 1e-6, "{area_mm2} of {hull_mm2}");
}

fn words(refused: &MethodError) {
    assert!(is_short(&refused.to_string()), "{refused}");
}

fn is_short(words: &str) -> bool {
    (10..1000).contains(&words.len()) && !words.contains(char::is_control)
}
