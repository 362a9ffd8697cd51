//! The spectra: power spectral density of the map, slope spectrum of the rotational part.

use std::num::NonZeroU8;

use asphera_figures::{
    Band, FrequencyRing, HeightGrid, Sample, Term, Unknown, Window, map_psd, remove,
};
use asphera_form::Aperture;
use asphera_report::standards::{PsdFigures, QFigures};
use asphera_uncertainty::coverage_factor;

use super::Measured;
use crate::details::FormDetails;
use crate::deviation_map::{DeviationMap, MapSource};
use crate::uncertainties::COVERAGE;

/// Adds the power spectral density of the map.
pub(super) fn add_psd(measured: &Measured<'_>, details: &mut FormDetails) {
    let Measured { part, map, noise_nm, areas_mm2, .. } = *measured;
    if !part.figures.psd {
        return;
    }
    let map = map.ok_or("there is no map of the deviation".to_owned());
    let found = map.and_then(|map| {
        let noise = noise_nm.map(|nm| noise_nm2_mm2(nm, map, areas_mm2));
        psd(map, noise).map_err(|why| why.to_string())
    });
    details.standards.psd = details.known("PSD", found);
}

/// The radial average of the density of the map, without what would smear it most: piston, tilt and power. `noise_nm2_mm2`
/// is what [`noise_nm2_mm2`] gives. `O(n log n)` for n nodes.
fn psd(map: &DeviationMap, noise_nm2_mm2: Option<f64>) -> Result<PsdFigures, Unknown> {
    let grid = &map.grid;
    let places_mm: Vec<[f64; 2]> = (0..grid.nx * grid.ny)
        .map(|node| {
            let (column, row) = ((node % grid.nx) as f64, (node / grid.nx) as f64);
            let middle = [0.5 * (grid.nx - 1) as f64, 0.5 * (grid.ny - 1) as f64];
            [(column - middle[0]) * grid.dx_mm, (row - middle[1]) * grid.dy_mm]
        })
        .collect();
    let mut values_mm: Vec<f64> = map.values_nm.iter().map(|nm| nm * 1e-6).collect();
    let bridged_nm = match &map.source {
        MapSource::Raster { bridged_nm, .. } => &bridged_nm[..],
        MapSource::Scattered { .. } => &[],
    };
    // A single empty node would spread the power of the longest waves over all frequencies.
    bridged_nm.iter().for_each(|(node, nm)| values_mm[*node] = nm * 1e-6);
    let sample = Sample::new(&places_mm, &values_mm, None, &Aperture::None)
        .map_err(|_| Unknown::NoPoints)?;
    let removed = remove(&sample, &REMOVED)?;
    let mut left_nm = vec![f64::NAN; values_mm.len()];
    for (&node, &nm) in removed.sample.indices().iter().zip(removed.sample.values_nm()) {
        left_nm[node] = nm;
    }
    let spacing_mm = [grid.dx_mm, grid.dy_mm];
    let heights = HeightGrid::new(&left_nm, grid.ny, grid.nx, spacing_mm)
        .expect("the map has a height for each node, and its nodes a distance");
    let psd = map_psd(&heights, Window::Hann)?;
    let (psd, source) = match &map.source {
        MapSource::Raster { strays: 0, .. } => (psd, AS_MEASURED.to_owned()),
        MapSource::Raster { strays, .. } => {
            (psd, format!("{AS_MEASURED}; points beside its nodes, which are left out: {strays}"))
        }
        MapSource::Scattered { interpolation } => {
            (psd.without(interpolation), INTERPOLATED.to_owned())
        }
    };
    let nyquist = 0.5 / grid.dx_mm.max(grid.dy_mm);
    let all = Band::of_frequencies(None, None).expect("from zero to infinity");
    let (frequency_per_mm, density_nm2_mm2) = merged(&psd.rings()).into_iter().unzip();
    let removed: Vec<String> = REMOVED.iter().map(ToString::to_string).collect();
    Ok(PsdFigures {
        definition: "mean over rings of equal frequency of |Σ w·z·exp(−2πi·f·x)|²·dx·dy/Σ w², two-sided, of \
                     the deviation map; gaps are 0 and have no weight"
            .to_owned(),
        removed: removed.join(", "),
        window: "Hann".to_owned(),
        source,
        spacing_mm,
        up_to_per_mm: psd.up_to_per_mm.min(nyquist),
        bridged: bridged_nm.len() as u64,
        measured: psd.measured,
        noise_nm2_mm2,
        rms_nm: psd.band_rms_nm(&all),
        frequency_per_mm,
        density_nm2_mm2,
    })
}

/// The density of independent noise of a point in nm: σ² times the area a point stands for, where areas differ times
/// their mean square over their mean.
fn noise_nm2_mm2(noise_nm: f64, map: &DeviationMap, areas_mm2: &[f64]) -> f64 {
    let area_mm2 = match map.source {
        MapSource::Raster { .. } => map.grid.dx_mm * map.grid.dy_mm,
        MapSource::Scattered { .. } => {
            let squares: f64 = areas_mm2.iter().map(|area| area * area).sum();
            squares / areas_mm2.iter().sum::<f64>()
        }
    };
    noise_nm * noise_nm * area_mm2
}

/// Rings of at least a fortieth of a decade: those of high frequencies say little each, and are many.
fn merged(rings: &[FrequencyRing]) -> Vec<(f64, f64)> {
    let step = |ring: &FrequencyRing| (RINGS_A_DECADE * ring.frequency_per_mm.log10()).floor();
    rings
        .chunk_by(|a, b| step(a) == step(b))
        .map(|rings| {
            let count: f64 = rings.iter().map(|ring| ring.count as f64).sum();
            let mean = |of: fn(&FrequencyRing) -> f64| {
                rings.iter().map(|ring| ring.count as f64 * of(ring)).sum::<f64>() / count
            };
            (mean(|ring| ring.frequency_per_mm), mean(|ring| ring.density_nm2_mm2))
        })
        .collect()
}

/// The slope spectrum of the rotational part of a deviation, by independent noise of a point, where it is known; and of
/// terms that are not given why.
pub(crate) fn q_spectrum(
    sample: &Sample,
    terms: NonZeroU8,
    noise_nm: Option<f64>,
) -> Result<(QFigures, Option<String>), Unknown> {
    let found = asphera_figures::q_spectrum(sample, terms, noise_nm)?;
    let given = found.coefficients_nm.len();
    let errors = if found.noise_of_residuals {
        format!("the {:.3} nm that the series leaves", found.noise_nm)
    } else {
        format!("noise of {:.3} nm", found.noise_nm)
    };
    let lost: Vec<String> = (0..given)
        .filter(|term| !found.is_determined(*term))
        .map(|term| format!("a{term}"))
        .collect();
    let why = (!lost.is_empty()).then(|| {
        format!(
            "by {errors} {} are less certain than the deviation is large, and so is the RMS slope of the series. Measure nearer to the rim, or set a smaller q_terms in the table [figures] of the nominal",
            lost.join(", ")
        )
    });
    let note = (given < found.asked).then(|| {
        format!(
            "The terms from a{given} to a{} do not stand out of {errors}: they are not given, and taken to be 0",
            found.asked - 1
        )
    });
    let coefficients = found.coefficients_nm.iter().enumerate();
    let known = lost.is_empty();
    let figures = QFigures {
        definition: "coefficients of Forbes' slope-orthogonal polynomials u²·(1 − u²)·Qbfs(u²), u = r/radius, fitted \
                     together with piston, tilt and power (Opt. Express 15 (2007) 5218)"
            .to_owned(),
        radius_mm: found.radius_mm,
        power_nm: found.power_nm,
        asked: found.asked as u64,
        note,
        ends: found.ends(),
        coefficients_nm: coefficients
            .map(|(term, nm)| found.is_determined(term).then_some(*nm))
            .collect(),
        u_nm: found.u_nm.clone(),
        noise_nm: found.noise_nm,
        noise_of_residuals: found.noise_of_residuals,
        slope_rms_urad: known.then_some(found.slope.form_urad),
        slope_noise_urad: found.slope.noise_urad,
        slope_95_urad: known.then(|| found.slope.interval_urad(coverage_factor(COVERAGE, f64::INFINITY))),
    };
    Ok((figures, why))
}

const AS_MEASURED: &str = "heights as measured, at the nodes of the raster that the points lie on";
const INTERPOLATED: &str = "heights interpolated linearly between the points; the density is divided by the share of the \
                            power that leaves to a wave, and ends where that is half";
const REMOVED: [Term; 3] = [Term::Piston, Term::Tilt, Term::Power];
const RINGS_A_DECADE: f64 = 40.0;

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use asphera_surface::Grid;

    use super::*;

    /// Over a disc of 5 mm, gaps elsewhere.
    fn map(nm: impl Fn(f64, f64) -> f64) -> DeviationMap {
        let grid = Grid { x0_mm: 3.0, y0_mm: -7.0, dx_mm: 0.05, dy_mm: 0.05, nx: 201, ny: 201 };
        let value = |node: usize| {
            let (x, y) = ((node % 201) as f64 * 0.05 - 5.0, (node / 201) as f64 * 0.05 - 5.0);
            if x.hypot(y) < 5.0 { nm(x, y) } else { f64::NAN }
        };
        DeviationMap {
            values_nm: (0..201 * 201).map(value).collect(),
            grid,
            turn_rad: 0.0,
            source: MapSource::Raster { bridged_nm: Vec::new(), strays: 0 },
        }
    }

    #[test]
    fn a_wave_stands_at_its_frequency_whatever_tilt_and_power_there_are() {
        let wave = |x: f64| 10.0 * (TAU * 2.0 * x).sin();
        let found =
            psd(&map(|x, y| wave(x) + 500.0 + 40.0 * x - 9.0 * y + 25.0 * (x * x + y * y)), None);
        let found = found.unwrap();
        let pairs = found.frequency_per_mm.iter().zip(&found.density_nm2_mm2);
        let highest = pairs.max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        assert!((highest.0 - 2.0).abs() < 0.1, "{highest:?}");
        // Under the window too, a sine has 1/√2 of its amplitude.
        assert!((found.rms_nm - 10.0 / 2f64.sqrt()).abs() < 0.2, "{}", found.rms_nm);
        assert!((found.measured - std::f64::consts::FRAC_PI_4).abs() < 0.02);
        assert!(found.frequency_per_mm.is_sorted() && found.frequency_per_mm.len() < 70);
        assert!(*found.frequency_per_mm.last().unwrap() <= 10.0);
    }

    #[test]
    fn a_series_that_is_too_short_is_told() {
        let places: Vec<[f64; 2]> = (0..3000)
            .map(|i| (4.0 * (f64::from(i) / 3000.0).sqrt(), 2.4 * f64::from(i)))
            .map(|(r, phi)| [r * phi.cos(), r * phi.sin()])
            .collect();
        let values: Vec<f64> =
            places.iter().map(|[x, y]| 1e-5 * (TAU * x.hypot(*y) * 5.0 / 4.0).cos()).collect();
        let sample = Sample::new(&places, &values, None, &Aperture::None).unwrap();
        let ends =
            |terms| q_spectrum(&sample, NonZeroU8::new(terms).unwrap(), None).unwrap().0.ends;
        // Five waves along the radius.
        assert!(!ends(9) && ends(30));
    }

    #[test]
    fn a_map_of_gaps_has_no_spectrum() {
        assert_eq!(psd(&map(|_, _| f64::NAN), None), Err(Unknown::NoPoints));
        let few = map(|x, y| if x.hypot(y) < 0.2 { x } else { f64::NAN });
        assert!(matches!(psd(&few, None), Err(Unknown::TooFewPoints { .. })));
    }
}
