//! Form deviations and their figures.

use rayon::prelude::*;

use crate::fit::model::Model;
use crate::fit::triangle::CHUNK;
use crate::{Aperture, Nominal, PointMm, Pose};

/// Deviation of every point in mm, in the order of the points: measured minus nominal along the normal of
/// the nominal, positive on the +z side. NaN for a point that is not finite or stands over no place of the
/// nominal. `O(n)`.
pub fn deviations(points: &[PointMm], nominal: &Nominal, pose: &Pose) -> Vec<f64> {
    let model = Model::new(nominal, pose, &[]);
    let deviation = |&point: &PointMm| model.distance_mm(point).unwrap_or(f64::NAN);
    points.par_iter().with_min_len(CHUNK).map(deviation).collect()
}

/// Figures of the form deviation over an aperture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Range, peak to valley, in nm.
    pub pv_nm: f64,
    /// Root of the mean square about the nominal, with divisor `count`, in nm.
    pub rms_nm: f64,
    /// Largest deviation in nm.
    pub max_nm: f64,
    /// Smallest deviation in nm.
    pub min_nm: f64,
    /// The measured point of the largest deviation, part frame, mm; of equal ones the first.
    pub at_max_mm: PointMm,
    /// The measured point of the smallest deviation, part frame, mm; of equal ones the first.
    pub at_min_mm: PointMm,
    /// Points the figures are over.
    pub count: usize,
}

impl Figures {
    /// Figures of `deviations_mm`, one a point, over the points in the aperture; points without a
    /// deviation (NaN) do not count. `None` if no point counts. `O(n)`.
    ///
    /// Points and deviations beyond the shorter of the two lists are not looked at.
    pub fn new(
        points: &[PointMm],
        deviations_mm: &[f64],
        pose: &Pose,
        aperture: &Aperture,
    ) -> Option<Figures> {
        let motion = pose.motion();
        let mut extremes: Option<(Extreme, Extreme)> = None;
        let (mut count, mut square) = (0_usize, 0.0);
        for (&point, &deviation_mm) in points.iter().zip(deviations_mm) {
            let at_mm = motion.to_part(point);
            if deviation_mm.is_nan() || !aperture.contains(at_mm[0], at_mm[1]) {
                continue;
            }
            count += 1;
            square += deviation_mm * deviation_mm;
            let here = Extreme { deviation_mm, at_mm };
            let (low, high) = extremes.get_or_insert((here, here));
            if deviation_mm < low.deviation_mm {
                *low = here;
            }
            if deviation_mm > high.deviation_mm {
                *high = here;
            }
        }
        let (low, high) = extremes?;
        Some(Figures {
            pv_nm: (high.deviation_mm - low.deviation_mm) * NM_PER_MM,
            rms_nm: (square / count as f64).sqrt() * NM_PER_MM,
            max_nm: high.deviation_mm * NM_PER_MM,
            min_nm: low.deviation_mm * NM_PER_MM,
            at_max_mm: high.at_mm,
            at_min_mm: low.at_mm,
            count,
        })
    }
}

#[derive(Clone, Copy)]
struct Extreme {
    deviation_mm: f64,
    at_mm: PointMm,
}

/// Nanometres a millimetre.
pub const NM_PER_MM: f64 = 1e6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_four_points_and_a_gap() {
        let points =
            [[0., 0., 1e-6], [1., 0., 3e-6], [0., 1., 3e-6], [9., 0., 1.0], [0., 0., f64::NAN]];
        let found = deviations(&points, &Nominal::Plane, &Pose::default());
        assert_eq!(found[..4], [1e-6, 3e-6, 3e-6, 1.0]);
        assert!(found[4].is_nan());
        let aperture = Aperture::Circle { radius_mm: 2.0 };
        let figures = Figures::new(&points, &found, &Pose::default(), &aperture).unwrap();
        assert_eq!(figures.count, 3);
        assert_eq!((figures.max_nm, figures.min_nm), (3.0, 1.0));
        assert!((figures.pv_nm - 2.0).abs() < 1e-14);
        assert!((figures.rms_nm - (19.0_f64 / 3.0).sqrt()).abs() < 1e-14);
        assert_eq!((figures.at_max_mm, figures.at_min_mm), (points[1], points[0]));
        assert_eq!(Figures::new(&points[3..], &found[3..], &Pose::default(), &aperture), None);
        assert_eq!(Figures::new(&[], &[], &Pose::default(), &Aperture::None), None);
    }
}
