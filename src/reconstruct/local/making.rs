//! Planes and stars of points in doubt, made by all threads, and what follows from those that changed.
//!
//! Threads put the planes and stars of new points where they will lie. Those of earlier points are compared with what was there.

use rayon::prelude::*;

use super::growing::{Doubts, LocalSurface};
use super::holes::Borders;
use super::mend::Surface;
use super::normals::{self, Fit, Places as _, TangentPlane};
use super::place_tree::Sight;
use super::ring::Ring;
use super::star::{Maker, Room, Star};
use super::stars::{Exchange, sort};
use crate::geometry::squared;

/// Points whose planes changed, and points whose stars may have, both in ascending order.
pub(super) struct Changed {
    planes: Vec<u32>,
    stars: Vec<u32>,
    first_new: u32,
}

/// A star whose point asked for planes, or did before.
struct Asking {
    at: u32,
    /// The square of the distance of the farthest, mm²; below 0 where there is none.
    asked_mm2: f64,
    asked: Vec<u32>,
}

/// New stars of some points but for their rings.
#[derive(Default)]
struct Made {
    sights_mm2: Vec<f64>,
    asking: Vec<Asking>,
}

impl Made {
    fn take(&mut self, at: u32, star: Star) -> Ring {
        let Star { ring, sight_mm2, asked_mm2, asked } = star;
        self.sights_mm2.push(sight_mm2);
        if !asked.is_empty() {
            self.asking.push(Asking { at, asked_mm2, asked });
        }
        ring
    }
}

impl LocalSurface {
    /// Fits the planes in doubt.
    pub(super) fn fit_planes(&mut self, doubts: Doubts) -> Changed {
        let Doubts { first_new, planes: doubtful, mut stars, .. } = doubts;
        let mut changed = Vec::new();
        for points in doubtful.chunks(POINTS_HELD) {
            let (tree, near) = (&self.tree, &self.near);
            let fit = |points: &[u32]| {
                let mut fits = Vec::with_capacity(points.len());
                let take = |_, fit| fits.push(fit);
                normals::fit_all(tree, points.iter().copied(), |at| near.of(at), take);
                fits
            };
            let fits: Vec<Vec<Fit>> = points.par_chunks(POINTS_AT_ONCE).map(fit).collect();
            let fits = || points.iter().zip(fits.iter().flatten());
            for (&at, fit) in fits() {
                let own = &mut self.planes[at as usize];
                if *own != fit.plane {
                    *own = fit.plane;
                    changed.push(at);
                }
            }
            let sights = fits().map(|(&at, fit)| (at, fit.sight_mm2));
            self.tree.set_sights(Sight::Plane, sights);
        }
        self.fit_new(first_new);
        let new = first_new..self.tree.len() as u32;
        changed.extend(new.filter(|&at| self.planes[at as usize].is_some()));
        for &at in changed.iter().filter(|&&at| self.is_asked[at as usize]) {
            let place = self.tree.points_mm()[at as usize];
            let strangers = self.strangers.remove(&at).unwrap_or_default();
            let listening = self.near.of(at).iter().copied().chain(strangers);
            let asking = listening.filter(|&other| {
                let square = squared(place, self.tree.points_mm()[other as usize]);
                square <= self.asked_mm2[other as usize]
            });
            self.listed.add(&mut stars, asking);
        }
        self.listed.add(&mut stars, changed.iter().copied());
        sort(&mut stars);
        changed.sort_unstable();
        Changed { planes: changed, stars, first_new }
    }

    /// Fits the planes of new points.
    fn fit_new(&mut self, first: u32) {
        let (tree, near) = (&self.tree, &self.near);
        let fit = |(part, planes): (usize, &mut [Option<TangentPlane>])| {
            let from = first + (part * POINTS_AT_ONCE) as u32;
            let mut sights_mm2 = Vec::with_capacity(planes.len());
            let points = from..from + planes.len() as u32;
            normals::fit_all(
                tree,
                points,
                |at| near.of(at),
                |at, fit| {
                    planes[(at - from) as usize] = fit.plane;
                    sights_mm2.push(fit.sight_mm2);
                },
            );
            sights_mm2
        };
        let new = &mut self.planes[first as usize..];
        let parts = new.par_chunks_mut(POINTS_AT_ONCE).enumerate();
        let sights_mm2: Vec<Vec<f64>> = parts.map(fit).collect();
        self.tree.set_sights(Sight::Plane, (first..).zip(sights_mm2.into_iter().flatten()));
    }

    /// Makes the stars in doubt, and settles facets and holes about what changed.
    pub(super) fn make_stars(&mut self, changed: Changed, asks: bool) -> Exchange {
        let Changed { planes: changed_planes, stars: doubtful, first_new } = changed;
        let count = doubtful.partition_point(|&at| at < first_new);
        let (earlier, new) = doubtful.split_at(count);
        let mut changed = Vec::new();
        let mut lost = Vec::new();
        for points in earlier.chunks(POINTS_HELD) {
            let maker = Maker { tree: &self.tree, near: &self.near, planes: &self.planes };
            let stars = &self.stars;
            let make = |points: &[u32]| {
                let (mut room, mut made) = (Room::default(), Made::default());
                let rings: Vec<Option<Ring>> = points
                    .iter()
                    .map(|&at| {
                        let ring = made.take(at, maker.star(at, maker.along(at), &mut room));
                        (!stars.has_ring(at, &ring)).then_some(ring)
                    })
                    .collect();
                (rings, made)
            };
            let parts: Vec<(Vec<Option<Ring>>, Made)> =
                points.par_chunks(POINTS_AT_ONCE).map(make).collect();
            for (points, (rings, made)) in points.chunks(POINTS_AT_ONCE).zip(parts) {
                points.iter().for_each(|&at| self.asked_mm2[at as usize] = -1.0);
                self.take_made(points.iter().copied(), made);
                for (&at, ring) in points.iter().zip(rings) {
                    if let Some(ring) = ring {
                        self.stars.replace(at, ring, &mut lost);
                        changed.push(at);
                    }
                }
            }
        }
        self.make_new(first_new);
        changed.extend(new.iter().filter(|&&at| self.stars.has_neighbours(at)));
        self.listed.begin(self.tree.len());
        changed.iter().for_each(|&at| self.listed.mark(at));
        // All corners of a first batch's facets are points whose planes changed: holes need no list of facets.
        let lists = asks || first_new > 0;
        let exchange = self.stars.agree(&changed, lost, |at| self.listed.has(at), lists);
        self.mend(changed_planes, exchange)
    }

    /// Makes the stars of new points.
    fn make_new(&mut self, first: u32) {
        let maker = Maker { tree: &self.tree, near: &self.near, planes: &self.planes };
        let make = |(part, rings): (usize, &mut [Ring])| {
            let (mut room, mut made) = (Room::default(), Made::default());
            let mut from = first + (part * NEW_AT_ONCE) as u32;
            for rings in rings.chunks_mut(TOGETHER) {
                // Ahead of the stars, which would wait for roots and divisions.
                let points: [u32; TOGETHER] = std::array::from_fn(|lane| from + lane as u32);
                let points = &points[..rings.len()];
                let mut along = [[0.0; 3]; TOGETHER];
                for (along, &at) in along.iter_mut().zip(points) {
                    *along = maker.along(at);
                }
                for ((ring, &at), along) in rings.iter_mut().zip(points).zip(along) {
                    *ring = made.take(at, maker.star(at, along, &mut room));
                }
                from += rings.len() as u32;
            }
            made
        };
        let parts = self.stars.rings_mut(first).par_chunks_mut(NEW_AT_ONCE).enumerate();
        let parts: Vec<Made> = parts.map(make).collect();
        for (made, part) in parts.into_iter().zip(0_u32..) {
            self.take_made(first + part * NEW_AT_ONCE as u32.., made);
        }
    }

    /// Takes what stars depend on.
    fn take_made(&mut self, points: impl Iterator<Item = u32>, made: Made) {
        self.tree.set_sights(Sight::Star, points.zip(made.sights_mm2));
        for Asking { at, asked_mm2, asked } in made.asking {
            self.asked_mm2[at as usize] = asked_mm2;
            for other in asked {
                self.is_asked[other as usize] = true;
                if !self.near.has(other, at) {
                    let listening = self.strangers.entry(other).or_default();
                    if !listening.contains(&at) {
                        listening.push(at);
                    }
                }
            }
        }
    }

    /// Settles holes about planes and facets that changed.
    fn mend(&mut self, changed_planes: Vec<u32>, exchange: Exchange) -> Exchange {
        let mut points = changed_planes;
        if points.len() < self.tree.len() {
            self.listed.begin(self.tree.len());
            points.iter().for_each(|&at| self.listed.mark(at));
            self.listed.add(&mut points, exchange.facets().flatten());
            sort(&mut points);
        }
        let borders =
            Borders { points_mm: self.tree.points_mm(), planes: &self.planes, stars: &self.stars };
        let surface = Surface { tree: &self.tree, borders };
        let repair = self.mending.settle(surface, &points, &exchange);
        let mended = self.mending.finish(&mut self.tree, repair);
        let Exchange { mut added, mut removed } = exchange;
        added.extend(mended.added);
        removed.extend(mended.removed);
        Exchange::of(added, removed)
    }
}

/// Points that a thread takes in turn.
const POINTS_AT_ONCE: usize = 256;
/// Points whose directions are computed together.
const TOGETHER: usize = 8;
/// New points whose stars a thread makes in turn: the more, the fewer answers of the rule are asked for again.
const NEW_AT_ONCE: usize = 1024;
/// Points whose new planes or stars are held beside those they replace.
const POINTS_HELD: usize = 1 << 16;
