//! Thick layers made thin: places of a noisy surface put onto the middle of their surroundings, before loops are counted.
//!
//! Noise of several spacings makes a layer in which every place has neighbours above and below it. Then τ follows the thickness, and
//! loops shorter than that vanish. Where discs are wide enough the layer is flat, and its middle is the surface: a polynomial of the
//! second degree along the disc (moving least squares: M. Alexa and others, Visualization 2001, 21-28; weights are 1 here, and a plane
//! would draw bent surfaces inwards each time). Walls thinner than the discs are lost.

use std::borrow::Cow;

use asphera_geometry::vector::dot;
use nalgebra::{Matrix6, Matrix6x2, RowVector2, Vector6};
use rayon::prelude::*;

use crate::cloud::{Cloud, CloudError, PlaceId};
use crate::functions::eigen;

/// A cloud whose places lie on the middle of the layer that they were.
#[derive(Clone, Debug)]
pub(crate) struct Thinned<const D: usize> {
    pub(crate) cloud: Cloud<D>,
    /// The function there, by place: as it changes along the discs.
    pub(crate) values: Vec<f64>,
    /// The place of the layer that each place was.
    pub(crate) original: Vec<PlaceId>,
    /// The radius of the discs in mm.
    pub(crate) radius_mm: f64,
}

/// How the places about one lie.
struct Disc {
    places: u64,
    /// Variances along the axes, the largest first, and these, mm².
    variances: [f64; 3],
    axes: [[f64; 3]; 3],
}

impl Disc {
    /// `None` of too few places.
    fn about<const D: usize>(cloud: &Cloud<D>, at: &[f64; D], radius_mm: f64) -> Option<Disc> {
        let (mut places, mut sum, mut moments) = (0_u64, [0.0; 3], [[0.0; 3]; 3]);
        cloud.visit_about(at, radius_mm, |other, _| {
            let way = way(at, &cloud.places()[other as usize]);
            places += 1;
            for row in 0..3 {
                sum[row] += way[row];
                (0..3).for_each(|column| moments[row][column] += way[row] * way[column]);
            }
        });
        if places < LEAST_PLACES {
            return None;
        }
        let mean_mm = sum.map(|value| value / places as f64);
        for row in 0..3 {
            for column in 0..3 {
                let product = mean_mm[row] * mean_mm[column];
                moments[row][column] = moments[row][column] / places as f64 - product;
            }
        }
        let (variances, axes) = eigen(moments);
        Some(Disc { places, variances, axes })
    }

    /// The share of the variance that lies across the disc: ⅓ of a ball, 0 of a plane.
    fn across(&self) -> f64 {
        self.variances[2].max(0.0) / self.variances.iter().sum::<f64>()
    }

    /// The variance across the disc, as a share of that along its narrow side: 0 of a plane, 1 of a curve, as thick one way as the other.
    fn round(&self) -> f64 {
        self.variances[2].max(0.0) / self.variances[1]
    }

    /// A place put onto the middle of the layer, across the disc, and the function there: both as polynomials of the second degree along
    /// the disc, by least squares. `None` where these are not determined.
    fn onto_middle<const D: usize>(
        &self,
        layer: &Layer<'_, D>,
        at: &[f64; D],
        radius_mm: f64,
    ) -> Option<([f64; D], f64)> {
        let mut normal = Matrix6::zeros();
        let mut sides = Matrix6x2::zeros();
        layer.cloud.visit_about(at, radius_mm, |other, _| {
            let way = way(at, &layer.cloud.places()[other as usize]);
            let [u, v, off] = self.axes.map(|axis| dot(axis, way) / radius_mm);
            let terms = Vector6::from([1.0, u, v, u * u, u * v, v * v]);
            normal.ger(1.0, &terms, &terms, 1.0);
            sides += terms * RowVector2::from([off * radius_mm, layer.values[other as usize]]);
        });
        let found = normal.cholesky()?.solve(&sides);
        let (off_mm, value) = (found[(0, 0)], found[(0, 1)]);
        let onto = std::array::from_fn(|axis| at[axis] + off_mm * self.axes[2][axis]);
        (off_mm.abs() <= radius_mm).then_some((onto, value))
    }
}

/// Places of which middles are taken, with the function there.
struct Layer<'a, const D: usize> {
    cloud: Cow<'a, Cloud<D>>,
    values: Cow<'a, [f64]>,
}

impl<'a, const D: usize> Layer<'a, D> {
    /// Each `step`-th place: they are numbered so that these are spread as all are.
    fn of(cloud: &'a Cloud<D>, values: &'a [f64], step: usize) -> Result<Self, CloudError> {
        if step == 1 {
            return Ok(Layer { cloud: Cow::Borrowed(cloud), values: Cow::Borrowed(values) });
        }
        let some: Vec<[f64; D]> = cloud.places().iter().step_by(step).copied().collect();
        let of_row: Vec<f64> = values.iter().step_by(step).copied().collect();
        let cloud = Cloud::new(&some)?;
        let values = cloud.by_place(&of_row);
        Ok(Layer { cloud: Cow::Owned(cloud), values: Cow::Owned(values) })
    }
}

/// The way from a place in space to another.
fn way<const D: usize>(from: &[f64; D], to: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|axis| to[axis] - from[axis])
}

impl<const D: usize> Thinned<D> {
    /// The places of a thick layer in space made thin; `None` of points that lie on surfaces already, and of those that no disc makes
    /// flat, as of solids and curves. n·log n time, some 50 µs a place.
    ///
    /// # Errors
    ///
    /// Those of a cloud.
    pub(crate) fn of(
        cloud: &Cloud<D>,
        values: &[f64],
        spacing_mm: f64,
    ) -> Result<Option<Thinned<D>>, CloudError> {
        if D != 3 {
            return Ok(None);
        }
        let Some((radius_mm, places)) = flat_discs(cloud, spacing_mm) else { return Ok(None) };
        let step = (places / ENOUGH_PLACES).max(1) as usize;
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
                (low.min(value), high.max(value))
            });
        let mut thinned = Thinned {
            cloud: cloud.clone(),
            values: values.to_vec(),
            original: (0..cloud.len() as PlaceId).collect(),
            radius_mm,
        };
        for _ in 0..ROUNDS {
            let Thinned { cloud, values, original, .. } = &thinned;
            let layer = Layer::of(cloud, values, step)?;
            let moved = (0..cloud.len()).into_par_iter().map(|place| {
                let at = &cloud.places()[place];
                let onto = Disc::about(&layer.cloud, at, radius_mm)
                    .and_then(|disc| disc.onto_middle(&layer, at, radius_mm));
                let (onto, value) = onto.unwrap_or_else(|| (*at, values[place]));
                (onto, value.clamp(low, high))
            });
            let (places, of_row): (Vec<[f64; D]>, Vec<f64>) = moved.unzip();
            let onto = Cloud::new(&places)?;
            let mut of_place = vec![PlaceId::MAX; onto.len()];
            for (&place, &original) in onto.places_of_rows().iter().zip(original) {
                let first = &mut of_place[place as usize];
                *first = (*first).min(original);
            }
            thinned.values = onto.by_place(&of_row);
            (thinned.cloud, thinned.original) = (onto, of_place);
        }
        Ok(Some(thinned))
    }
}

/// The radius of discs that make a layer flat, in mm, and the places of one; `None` of a surface, and where there is none.
fn flat_discs<const D: usize>(cloud: &Cloud<D>, spacing_mm: f64) -> Option<(f64, u64)> {
    let small = Discs::of(cloud, SMALL * spacing_mm)?;
    if small.across <= SURFACE {
        return None;
    }
    let (mut radius_mm, mut before) = (LEAST * spacing_mm, 1.0);
    while radius_mm <= cloud.diagonal_mm() / 8.0 {
        let discs = Discs::of(cloud, radius_mm)?;
        // Where discs no longer become flatter, their surroundings are bent or have another layer.
        if discs.across > before && before < OUTSIDE && discs.places > MANY_PLACES {
            return None;
        }
        if discs.across <= FLAT {
            return (discs.round <= CURVE).then_some((radius_mm, discs.places));
        }
        before = discs.across;
        radius_mm *= WIDER;
    }
    None
}

/// Medians of discs about some places.
struct Discs {
    across: f64,
    round: f64,
    places: u64,
}

impl Discs {
    /// `None` where no disc has places enough.
    fn of<const D: usize>(cloud: &Cloud<D>, radius_mm: f64) -> Option<Discs> {
        let step = (cloud.len() / SOME).max(1);
        let some = cloud.places().par_iter().step_by(step);
        let discs: Vec<Disc> = some.filter_map(|at| Disc::about(cloud, at, radius_mm)).collect();
        if discs.is_empty() {
            return None;
        }
        let median = |of: &dyn Fn(&Disc) -> f64| {
            let mut sorted: Vec<f64> = discs.iter().map(of).collect();
            sorted.sort_unstable_by(f64::total_cmp);
            sorted[sorted.len() / 2]
        };
        let places = median(&|disc| disc.places as f64) as u64;
        Some(Discs { across: median(&Disc::across), round: median(&Disc::round), places })
    }
}

/// Places of which a middle is taken.
const LEAST_PLACES: u64 = 12;
/// Places of a disc that are enough for its middle: where there are more, some of them are taken.
const ENOUGH_PLACES: u64 = 400;
/// Places about which discs are tried.
const SOME: usize = 500;
/// The radius of discs that tell a layer from a surface, in spacings: some twelve places of a surface.
const SMALL: f64 = 4.0;
/// The share of the variance across such discs on a surface, at most. On a ball of 50 places it is 0.01.
const SURFACE: f64 = 0.03;
/// The least radius of discs, in spacings.
const LEAST: f64 = 5.0;
/// The share of the variance across discs that reach out of the layer, at most: ⅓ of the inside, but less of few places.
const OUTSIDE: f64 = 0.25;
/// Places of which that share is sure: of so many of the inside it is 0.26.
const MANY_PLACES: u64 = 200;
/// Each radius tried, in the one before.
const WIDER: f64 = 1.2;
/// The share of the variance across a flat disc, at most: the noise is a third of its radius.
const FLAT: f64 = 0.17;
/// The variance across flat discs, as a share of that along their narrow side, at most: of flat ones it is 0.4, of thick curves 0.8.
const CURVE: f64 = 0.6;
/// So often places are put onto the middle: outer ones have a disc of which they see one side. After two, gaps are left between them.
const ROUNDS: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions;

    /// Numbers between −1 and 1, about as normal ones lie (sums of four).
    fn noise(state: &mut u64) -> f64 {
        let mut sum = 0.0;
        for _ in 0..4 {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
        }
        sum / 4.0
    }

    /// Points about a ball of radius 1, along a spiral; the noise is that of each coordinate, at most.
    fn ball(count: u32, most: f64) -> Vec<[f64; 3]> {
        let mut state = 5;
        (0..count)
            .map(|at| {
                let z = 1.0 - (2.0 * f64::from(at) + 1.0) / f64::from(count);
                let turn = f64::from(at) * 2.399_963_229_728_653;
                let across = (1.0 - z * z).sqrt();
                let place = [across * turn.cos(), across * turn.sin(), z];
                place.map(|mm| mm + most * noise(&mut state))
            })
            .collect()
    }

    fn thinned<const D: usize>(points: &[[f64; D]]) -> Option<Thinned<D>> {
        let cloud = Cloud::new(points).unwrap();
        let mut direction = [0.25; D];
        direction[0] = -0.5;
        let field = functions::height(&cloud, direction).unwrap();
        Thinned::of(&cloud, &field.values, cloud.spacing_mm().unwrap()).unwrap()
    }

    #[test]
    fn a_thick_layer_becomes_thin_and_a_surface_stays() {
        let off = |places: &[[f64; 3]]| {
            let square = |place: &[f64; 3]| {
                (place.iter().map(|mm| mm * mm).sum::<f64>().sqrt() - 1.0).powi(2)
            };
            (places.iter().map(square).sum::<f64>() / places.len() as f64).sqrt()
        };
        let points = ball(20_000, 0.1);
        let found = thinned(&points).unwrap();
        assert!(
            off(&points) > 0.025 && off(found.cloud.places()) < 0.008,
            "{}",
            off(found.cloud.places())
        );
        assert_eq!(found.cloud.len(), found.values.len());
        // Heights go along: they are those of the places, but for the ends of the range.
        let size = (0.25_f64 + 2.0 * 0.0625).sqrt();
        let exact = found.cloud.places().iter().zip(&found.values).filter(|([x, y, z], value)| {
            ((-0.5 * x + 0.25 * y + 0.25 * z) / size - **value).abs() < 1e-9
        });
        assert!(exact.count() > found.values.len() - 20);
        for count in [60, 1_000, 20_000] {
            assert!(thinned(&ball(count, 0.0)).is_none(), "{count}");
        }
        // Noise of a third of the spacing is none of a layer.
        assert!(thinned(&ball(1_000, 0.03)).is_none());
    }

    #[test]
    fn discs_inside_a_thick_layer_come_before_those_that_reach_out_of_it() {
        let mut state = 3;
        let mut size = |mm: f64| mm * noise(&mut state).abs().sqrt();
        let layer: Vec<[f64; 3]> =
            (0..120_000).map(|_| [size(2.0), size(2.0), size(0.2)]).collect();
        let cloud = Cloud::new(&layer).unwrap();
        let (radius_mm, places) = flat_discs(&cloud, cloud.spacing_mm().unwrap()).unwrap();
        assert!((0.1..0.3).contains(&radius_mm) && places > 1_000, "{radius_mm} {places}");
    }

    #[test]
    fn what_no_disc_makes_flat_stays() {
        let mut state = 9;
        let solid: Vec<[f64; 3]> =
            (0..20_000).map(|_| [(); 3].map(|()| noise(&mut state))).collect();
        assert!(thinned(&solid).is_none());
        let curve: Vec<[f64; 3]> = (0..3_000)
            .map(|at| {
                let turn = f64::from(at) * 2e-3;
                [turn.cos(), turn.sin(), 0.0].map(|mm| mm + 0.05 * noise(&mut state))
            })
            .collect();
        assert!(thinned(&curve).is_none());
        let plane: Vec<[f64; 2]> = solid.iter().map(|&[x, y, _]| [x, y]).collect();
        assert!(thinned(&plane).is_none());
        assert!(thinned(&[[1.0, 2.0, 3.0], [1.0, 2.0, 4.0]]).is_none());
    }
}
