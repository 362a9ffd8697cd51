//! Whether loops hold: counted again with other τ and strips, and along other heights.

use crate::cloud::Cloud;
use crate::extract::{Choices, ExtractError, Extraction, Pieces, StripChoice, counts, is_fine};
use crate::fine_loops::{FineLoop, is_one_run};
use crate::functions::{Field, height, principal_axes};
use crate::graph::PointGraph;
use crate::grown::grown_graph;
use crate::links::Links;
use crate::loop_places::{LoopPlaces, thin_strips};
use crate::strips::{Strips, StripsError};

/// The number of loops where τ, strips and the function change.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability<const D: usize> {
    /// τ in mm, strips and loops of each trial.
    pub trials: Vec<(f64, usize, usize)>,
    /// All trials have as many loops as the graph.
    pub is_stable: bool,
    /// The most loops that the points have along some function. Of a closed body in space these are its handles, for every height
    /// has as many (K. Cole-McLaughlin and others, Discrete & Computational Geometry 32 (2004) 231-244), though some are open too
    /// briefly to count.
    pub most: MostLoops<D>,
}

/// The most loops along the function of the graph and heights near the principal axes.
#[derive(Clone, Debug, PartialEq)]
pub struct MostLoops<const D: usize> {
    /// How many.
    pub loops: usize,
    /// The direction of the height, of length 1; `None` where the graph's own function has as many, and these hold as well.
    pub along: Option<[f64; D]>,
    /// As many are found there with other τ and strips.
    pub is_stable: bool,
}

impl<const D: usize> Extraction<D> {
    /// Counts the loops again with τ times 0.8 and 1.25, and with 0.7 and 1.4 times as many strips. Where τ and strips are automatic
    /// and pieces exact, then along heights near the principal axes too. Up to five times the time of the graph.
    ///
    /// # Errors
    ///
    /// Errors as of [`extract`](crate::extract()).
    pub fn stability(
        &self,
        cloud: &Cloud<D>,
        field: &Field,
        choices: &Choices,
    ) -> Result<Stability<D>, ExtractError> {
        let tries_heights = choices.tau_mm.is_none()
            && choices.strips == StripChoice::Auto
            && choices.pieces == Pieces::Exact;
        let of_loops = self.thinned.as_ref().map_or(cloud, |thinned| &thinned.cloud);
        let links = ((tries_heights || is_fine(choices, field)) && is_one_run(of_loops))
            .then(|| Links::new(of_loops));
        let places = match &self.thinned {
            Some(thinned) => LoopPlaces::thinned(thinned, links.as_ref()),
            None => LoopPlaces::of_graph(cloud, &field.values, links.as_ref(), self.tau_mm),
        };
        let mut trials = Vec::new();
        for change in CHANGES {
            trials.extend(if is_fine(choices, field) {
                Some(self.fine_trial(&places, field, choices.min_loop, change)?)
            } else {
                self.trial(cloud, field, choices, change)?
            });
        }
        let is_stable = trials.iter().all(|&(_, _, loops)| loops == self.loops.len());
        let own = MostLoops { loops: self.loops.len(), along: None, is_stable };
        let min_loop_mm = if field.is_length { choices.min_loop } else { 0.0 };
        let most = match tries_heights {
            true => self.most_loops(own, &places, min_loop_mm)?,
            false => own,
        };
        Ok(Stability { trials, is_stable, most })
    }

    /// τ in mm, strips and loops, where these are counted between thin strips.
    fn fine_trial(
        &self,
        places: &LoopPlaces<'_, D>,
        field: &Field,
        min_loop: f64,
        (of_tau, of_strips): (f64, f64),
    ) -> Result<(f64, usize, usize), ExtractError> {
        let strips = (self.graph.strips.count() as f64 * of_strips).round().max(1.0);
        let thin = thin_strips(&self.graph.strips, field, places.tau_mm, of_strips)?;
        let tau_mm = places.tau_mm * of_tau;
        let found = places.loops(field.is_length, &self.graph, (&thin, of_strips), tau_mm)?;
        let is_loop = |one: &&FineLoop| {
            let extent = places.loop_of_graph(one, &self.graph, &thin).extent();
            one.is_no_gap && extent >= min_loop
        };
        let loops = found.iter().filter(is_loop).count();
        Ok((self.tau_mm * of_tau, strips as usize, loops))
    }

    /// τ in mm, strips and loops of another graph; `None` where that has the strips of this one.
    fn trial(
        &self,
        cloud: &Cloud<D>,
        field: &Field,
        choices: &Choices,
        (of_tau, of_strips): (f64, f64),
    ) -> Result<Option<(f64, usize, usize)>, ExtractError> {
        let tau_mm = self.tau_mm * of_tau;
        let strips = self.changed_strips(field, &choices.strips, of_strips)?;
        let tried = strips.count();
        // A single strip has no loops, and that of a small cloud cannot be parted less.
        if of_strips != 1.0 && tried == self.graph.strips().count() {
            return Ok(None);
        }
        let graph = match choices.pieces {
            Pieces::Exact => PointGraph::new(cloud, &field.values, strips, tau_mm)?,
            Pieces::Grown(growth) => grown_graph(cloud, &field.values, strips, tau_mm, growth)?,
        };
        let loops = graph.loops();
        let loops = loops.iter().filter(|found| counts(found, choices.min_loop)).count();
        Ok(Some((tau_mm, tried, loops)))
    }

    /// The most loops: those of the graph, or of a height that has more.
    fn most_loops(
        &self,
        own: MostLoops<D>,
        places: &LoopPlaces<'_, D>,
        min_loop_mm: f64,
    ) -> Result<MostLoops<D>, ExtractError> {
        let Ok(axes) = principal_axes(places.cloud()) else { return Ok(own) };
        let mut most = own;
        for number in 0..D {
            let direction = turned(&axes.axes, number);
            let Ok(heights_mm) = height(places.cloud(), direction) else { continue };
            let count = |change| places.count_along(&heights_mm, &self.graph, min_loop_mm, change);
            let loops = count((1.0, 1.0))?;
            // A height along which as many hold is taken for one along which they do not.
            if loops < most.loops || (loops == most.loops && most.is_stable) {
                continue;
            }
            let mut is_stable = true;
            for change in CHANGES {
                is_stable &= count(change)? == loops;
            }
            if loops > most.loops || is_stable {
                most = MostLoops { loops, along: Some(direction), is_stable };
            }
        }
        Ok(most)
    }

    fn changed_strips(
        &self,
        field: &Field,
        choice: &StripChoice,
        share: f64,
    ) -> Result<Strips, StripsError> {
        let own = self.graph.strips();
        let (bounds, count) = (own.bounds(), own.count());
        let is_even = matches!(choice, StripChoice::Auto) && field.is_length;
        let changed = ((count as f64 * share).round() as usize).max(1);
        match choice {
            _ if share == 1.0 => Ok(own.clone()),
            StripChoice::EqualCount(_) => Strips::equal_count(&field.values, changed),
            StripChoice::Between(_) | StripChoice::Auto if !is_even => {
                // Given bounds are moved along: bound i of the new ones lies at i / share of the old.
                let at = |bound: usize| {
                    let place = bound as f64 * count as f64 / changed as f64;
                    let below = (place as usize).min(count - 1);
                    bounds[below] + (place - below as f64) * (bounds[below + 1] - bounds[below])
                };
                let inner: Vec<f64> = (1..changed).map(at).collect();
                Strips::between(bounds[0], bounds[count], &inner)
            }
            _ => Strips::uniform(bounds[0], bounds[count], changed),
        }
    }
}

/// A unit vector near a principal axis: faces across the axis then do not lie at one height as a whole.
fn turned<const D: usize>(axes: &[[f64; D]; D], number: usize) -> [f64; D] {
    let mut direction = axes[number];
    for (step, share) in (1..D).zip(TURN) {
        let other = &axes[(number + step) % D];
        (0..D).for_each(|at| direction[at] += share * other[at]);
    }
    let size = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
    direction.map(|value| value / size)
}

/// τ and the number of strips over the usual ones, of each trial.
const CHANGES: [(f64, f64); 4] = [(0.8, 1.0), (1.25, 1.0), (1.0, 0.7), (1.0, 1.4)];

/// Shares of the following axes.
const TURN: [f64; 3] = [0.1, 0.05, 0.02];
