//! Areal surface texture of the deviation.

use asphera_figures::texture::{
    Datum, Filtered, Mesh, Order, ScaleKind, Support, Threshold, Unknown, core_parameters,
    height_parameters, hybrid_parameters, spatial_parameters,
};
use asphera_figures::{Definition, Figure};
use asphera_report::standards::TextureFigures;
use asphera_uncertainty::Simulated;

use super::Measured;
use crate::TextureSettings;
use crate::details::{FormDetails, places_mm};
use crate::naming;

/// The parameters of a surface between two scales.
struct Found {
    /// The scale-limited surface they are of.
    surface: Mesh,
    figures: Vec<Figure>,
    /// Why others are not known.
    unknown: Vec<String>,
    kind: &'static str,
    filters: Vec<String>,
    support: Support,
}

/// Adds the parameters.
pub(super) fn add(measured: &Measured<'_>, details: &mut FormDetails) {
    let Some(settings) = &measured.part.figures.texture else { return };
    let found = found(measured, settings).map_err(|why| why.to_string());
    let Some(found) = details.known("texture", found) else { return };
    details.unknown.extend(found.unknown.iter().cloned());
    let simulated = details.simulated(measured, "texture", |of| {
        of.uncertainty.texture(&found.surface, &settings.scale, settings.f_operation, &of.draws)
    });
    let definitions: Vec<Definition> = found.figures.iter().map(|of| of.definition).collect();
    let texture = figures(measured, settings, found, &simulated.unwrap_or_default());
    for (definition, figure) in definitions.into_iter().zip(&texture.figures) {
        details.add_limited(definition, figure, None);
    }
    details.standards.texture = Some(texture);
}

/// The parameters, and the surface they are of.
fn found(measured: &Measured<'_>, settings: &TextureSettings) -> Result<Found, Unknown> {
    let TextureSettings { f_operation, scale } = settings;
    let Measured { fit, points, deviations_mm, triangles, covered, .. } = *measured;
    let heights = places_mm(&fit.pose, points).into_iter().zip(deviations_mm);
    let heights: Vec<[f64; 3]> = heights.map(|([x, y], &deviation)| [x, y, deviation]).collect();
    let good =
        triangles.iter().zip(covered).filter_map(|(&corners, &good)| good.then_some(corners));
    let good: Vec<[u32; 3]> = good.collect();
    let mesh = Mesh::new(&heights, &good).expect("triangles of a mesh have vertices");
    let limited = scale.of_dense_mesh(&mesh, *f_operation);
    // Filters leave heights about the long waves; parameters are about a datum of their own.
    let datum = if *f_operation == Datum::AsGiven { Datum::AsGiven } else { Datum::Mean };
    let surface = limited.surface.levelled(datum);
    let heights = height_parameters((&surface).into())?;
    let mut figures = heights.figures();
    let mut unknown = Vec::new();
    let mut lacks = |name: &str, why: Unknown| unknown.push(format!("{name}: {why}"));
    match hybrid_parameters((&surface).into()) {
        Ok(found) => figures.extend(found.figures()),
        Err(why) => lacks("Sdq and Sdr", why),
    }
    match spatial_parameters((&surface).into(), Threshold::DEFAULT) {
        Ok(found) => {
            figures.extend(found.figures());
            if let Err(why) = found.slowest {
                lacks("Str", why);
            }
        }
        Err(why) => lacks("Sal and Str", why),
    }
    match core_parameters((&surface).into()) {
        Ok(found) => figures.extend(found.figures()),
        Err(why) => lacks("Sk, Spk, Svk, Smrk1 and Smrk2", why),
    }
    let kind = match limited.kind {
        ScaleKind::Unlimited => "all wavelengths measured",
        ScaleKind::SF => "S-F",
        ScaleKind::SL => "S-L",
    };
    // What a point stands for on the average.
    let spacing_mm = (mesh.areas_mm2().iter().sum::<f64>() / heights.support.points as f64).sqrt();
    let s = limited.s.as_ref().map(|s| filter("S-filter", s, spacing_mm));
    let l = limited.l.as_ref().map(|l| filter("L-filter", l, spacing_mm));
    let filters = s.into_iter().chain(l).collect();
    Ok(Found { surface, figures, unknown, kind, filters, support: heights.support })
}

/// The parameters as reports write them.
fn figures(
    measured: &Measured<'_>,
    settings: &TextureSettings,
    found: Found,
    simulated: &[(Definition, Simulated)],
) -> TextureFigures {
    let TextureSettings { f_operation, scale } = settings;
    let Found { figures, kind, filters, support, .. } = found;
    let figure = |figure: Figure| {
        let own = simulated.iter().find(|(definition, _)| *definition == figure.definition);
        let own = own.map(|(_, simulated)| simulated);
        let definition = figure.definition;
        measured.with_uncertainty(definition, naming::figure(figure, kind.to_owned()), own)
    };
    TextureFigures {
        surface: kind.to_owned(),
        f_operation: match f_operation {
            Datum::AsGiven => "nothing more",
            Datum::Mean => "its mean",
            Datum::MeanPlane => "its mean plane",
        }
        .to_owned(),
        s_mm: scale.s_mm(),
        l_mm: scale.l_mm(),
        filters,
        points: support.points as u64,
        measured: support.measured,
        figures: figures.into_iter().map(figure).collect(),
    }
}

/// A filter in words, with what it had to do without.
fn filter(name: &str, filtered: &Filtered<Mesh>, spacing_mm: f64) -> String {
    let Filtered { filter, nodes_mm, undetermined, lowered, robust, .. } = filtered;
    let order = match filter.order() {
        Order::Zero => 0,
        Order::Two => 2,
    };
    let cutoff_mm = filter.cutoff_mm();
    let standard = if robust.is_some() {
        "robust Gaussian regression of ISO 16610-71:2014"
    } else {
        "Gaussian regression of ISO 16610-61:2015"
    };
    let mut words = format!("{name}: {standard}, order {order}, nesting index {cutoff_mm} mm");
    if let Some(nodes_mm) = nodes_mm {
        words.push_str(&format!(", on nodes {} mm apart", (nodes_mm * 1e6).round() / 1e6));
    }
    if cutoff_mm < LEAST_SPACINGS * spacing_mm {
        let spacings = (10.0 * cutoff_mm / spacing_mm).round() / 10.0;
        words.push_str(&format!(
            "; that is {spacings} distances of the points, too few for its weights"
        ));
    }
    if let Some(robust) = robust {
        let ended = if robust.converged { "settled" } else { "not settled" };
        let (outliers, iterations) = (robust.outliers, robust.iterations);
        words.push_str(&format!(", {ended} after {iterations} steps, {outliers} outliers"));
    }
    for (count, what) in [
        (*undetermined, "points without any neighbour left out"),
        (*lowered, "points with too few neighbours for the order"),
    ] {
        if count > 0 {
            words.push_str(&format!("; {count} {what}"));
        }
    }
    words
}

/// With fewer distances of points a cut-off more passes than the filter states.
const LEAST_SPACINGS: f64 = 4.0;
