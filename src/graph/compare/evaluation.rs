//! How well distances find shapes of the same class: each shape asks for all others.

/// Mean figures over all shapes that have others of their class (P. Shilane and others, Shape Modeling International 2004,
/// 167-178, section 4). 1 is best.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Share of shapes whose nearest one is of their class.
    pub nearest_neighbour: f64,
    /// Share of the class among the first as many as it has.
    pub first_tier: f64,
    /// Share among twice as many.
    pub second_tier: f64,
    /// Discounted cumulative gain over the best possible one.
    pub dcg: f64,
    /// Mean of the precision at each shape of the class.
    pub mean_average_precision: f64,
    /// The largest precision at or beyond the recalls 0, 0.1 … 1.
    pub precision: [f64; RECALLS],
    /// Shapes that asked.
    pub queries: usize,
}

/// The figures of shapes with a class each, by a distance between any two. Of equal distances the earlier shape comes first.
/// `None` where no class has two shapes. n²·log n time.
pub fn evaluation(classes: &[usize], distance: impl Fn(usize, usize) -> f64) -> Option<Evaluation> {
    let mut sum = Evaluation {
        nearest_neighbour: 0.0,
        first_tier: 0.0,
        second_tier: 0.0,
        dcg: 0.0,
        mean_average_precision: 0.0,
        precision: [0.0; RECALLS],
        queries: 0,
    };
    for (query, class) in classes.iter().enumerate() {
        let alike = classes.iter().filter(|other| *other == class).count() - 1;
        if alike == 0 {
            continue;
        }
        let mut others: Vec<(f64, usize)> = (0..classes.len())
            .filter(|&other| other != query)
            .map(|other| (distance(query, other), other))
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let hits: Vec<bool> = others.iter().map(|&(_, other)| classes[other] == *class).collect();
        sum.add(&hits, alike);
    }
    sum.mean()
}

impl Evaluation {
    fn add(&mut self, hits: &[bool], alike: usize) {
        let among = |first: usize| {
            hits.iter().take(first).filter(|hit| **hit).count() as f64 / alike as f64
        };
        self.nearest_neighbour += f64::from(u8::from(hits[0]));
        self.first_tier += among(alike);
        self.second_tier += among(2 * alike);
        let gain = |rank: usize| if rank == 0 { 1.0 } else { 1.0 / ((rank + 1) as f64).log2() };
        let gained: f64 =
            hits.iter().enumerate().filter(|(_, hit)| **hit).map(|(rank, _)| gain(rank)).sum();
        self.dcg += gained / (0..alike).map(gain).sum::<f64>();
        // Recall and precision at each shape of the class.
        let mut points = Vec::new();
        for (rank, _) in hits.iter().enumerate().filter(|(_, hit)| **hit) {
            let found = points.len() + 1;
            points.push((found as f64 / alike as f64, found as f64 / (rank + 1) as f64));
        }
        self.mean_average_precision +=
            points.iter().map(|(_, precision)| precision).sum::<f64>() / alike as f64;
        for (at, sum) in self.precision.iter_mut().enumerate() {
            let recall = at as f64 / (RECALLS - 1) as f64;
            let beyond = points.iter().filter(|(reached, _)| *reached >= recall - 1e-12);
            *sum += beyond.map(|(_, precision)| *precision).fold(0.0, f64::max);
        }
        self.queries += 1;
    }

    fn mean(mut self) -> Option<Evaluation> {
        let queries = self.queries as f64;
        let figures = [
            &mut self.nearest_neighbour,
            &mut self.first_tier,
            &mut self.second_tier,
            &mut self.dcg,
            &mut self.mean_average_precision,
        ];
        figures.into_iter().chain(&mut self.precision).for_each(|figure| *figure /= queries);
        (self.queries > 0).then_some(self)
    }
}

/// Recalls at which a precision is given.
pub const RECALLS: usize = 11;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_ranking_worked_out_by_hand() {
        // Places on a line: class 0 at 0, 1, 2.5; class 1 at 1.6 and 9.
        let places: [f64; 5] = [0.0, 1.0, 2.5, 1.6, 9.0];
        let classes = [0, 0, 0, 1, 1];
        let found = evaluation(&classes, |a, b| (places[a] - places[b]).abs()).unwrap();
        assert_eq!(found.queries, 5);
        // Nearest of each: 1, 3, 3, 1, 2.
        assert!((found.nearest_neighbour - 1.0 / 5.0).abs() < 1e-15);
        // Of 0: 1 3 2 4. Of 1: 3 0 2 4. Of 2: 3 1 0 4. Of 3: 1 2 0 4. Of 4: 2 3 1 0.
        assert!((found.first_tier - (0.5 + 0.5 + 0.5 + 0.0 + 0.0) / 5.0).abs() < 1e-15);
        assert!((found.second_tier - (1.0 + 1.0 + 1.0 + 0.0 + 1.0) / 5.0).abs() < 1e-15);
        let average =
            [(1.0 + 2.0 / 3.0) / 2.0, (0.5 + 2.0 / 3.0) / 2.0, (0.5 + 2.0 / 3.0) / 2.0, 0.25, 0.5];
        let mean = average.iter().sum::<f64>() / 5.0;
        assert!((found.mean_average_precision - mean).abs() < 1e-15);
        let third = 1.0 / 3.0_f64.log2();
        let dcg = [(1.0 + third) / 2.0, (1.0 + third) / 2.0, (1.0 + third) / 2.0, 0.5, 1.0];
        assert!((found.dcg - dcg.iter().sum::<f64>() / 5.0).abs() < 1e-15, "{found:?}");
        assert!(found.precision[0] >= found.precision[RECALLS - 1]);
    }

    #[test]
    fn a_perfect_distance_has_all_figures_1_and_single_shapes_none() {
        let classes = [0, 1, 0, 1, 2];
        let found =
            evaluation(&classes, |a, b| f64::from(u8::from(classes[a] != classes[b]))).unwrap();
        assert_eq!(found.queries, 4);
        let all =
            [found.nearest_neighbour, found.first_tier, found.dcg, found.mean_average_precision];
        assert_eq!((all, found.precision), ([1.0; 4], [1.0; RECALLS]));
        assert_eq!(evaluation(&[0, 1, 2], |_, _| 1.0), None);
        assert_eq!(evaluation(&[], |_, _| 1.0), None);
    }
}
