//! Choice of a method by the points: border or area, outliers, noise.

use crate::bridges::{SHOWN_TURN, far_edges, turn_over};
use crate::curves::{connect2d, hnn_crust, lee, lee_reach_mm, stretch_denoise, voronoi_labelling};
use crate::graphs::spanning_by_length;
use crate::triangulation::{circumcentre_mm, distance_mm};
use crate::{Chain, CurveSampling, Graph, Method, PlaceMm, SampleId, Samples, Triangulation};

/// What points are samples of, and the method that suits them.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Whether they lie all over an area.
    pub is_area: bool,
    /// Share of the samples that lie within an area as dense as most: what decides that.
    pub inner_share: f64,
    /// Samples far from all others, and from their neighbours' spacing: left out. None of an area.
    pub outliers: Vec<SampleId>,
    /// Share of the turns of the curve, as far as it is joined, that go the other way than the turn before: 0 of a smooth curve, 0.73 of
    /// noise. None of an area.
    pub zigzag: Option<f64>,
    /// Median size of the turns of one closed curve through all samples but outliers, in radians, where noise or corners ask for it and
    /// such a curve exists: 0.2 or less of noise below a tenth of the spacing.
    pub closed_turn_rad: Option<f64>,
    /// Ratio of the lengths of that curve's edges that nine in ten and one in ten do not exceed.
    pub closed_spread: Option<f64>,
    /// Share of the samples but outliers that end a curve or are joined to none.
    pub loose_share: f64,
    /// The method.
    pub method: Method,
}

/// A curve that was found: its edges, and where it goes if not through its samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundCurve {
    /// The edges.
    pub graph: Graph,
    /// The place of every sample on the curve, if it does not go through them, mm.
    pub places_mm: Option<Vec<PlaceMm>>,
    /// The standard deviation of the samples to it in mm, where noise was taken away.
    pub sigma_mm: Option<f64>,
}

impl FoundCurve {
    /// How well the places of the curve show it; samples without an edge do not count.
    pub fn sampling(&self, triangulation: &Triangulation) -> CurveSampling {
        let Some(places_mm) = &self.places_mm else {
            return CurveSampling::new(triangulation, &self.graph);
        };
        let degrees = self.graph.degrees(triangulation.len());
        let used: Vec<usize> = (0..degrees.len()).filter(|&sample| degrees[sample] > 0).collect();
        let places: Vec<PlaceMm> = used.iter().map(|&sample| places_mm[sample]).collect();
        // Places fitted to admitted ones lie beside them.
        let Ok(samples) = Samples::new(&places) else {
            return CurveSampling::new(triangulation, &Graph::default());
        };
        let number = |sample: SampleId| {
            samples.of_row(used.partition_point(|&other| other < sample as usize))
        };
        let graph = Graph::new(self.graph.edges().iter().map(|edge| edge.map(number)));
        CurveSampling::new(&Triangulation::new(samples), &graph)
    }
}

impl Choice {
    /// The choice for samples; n·log n time.
    ///
    /// An area has at least 0.62 of its samples off the hull with no triangle about them of a circle wider than 2.2 times the median edge
    /// of the minimum spanning tree. Of a border, outliers are samples whose second nearest sample is more than four times as far as that
    /// of one of their two nearest, looked for twice; then open runs of up to four samples, where others have thirty or more
    /// and less than a quarter of the samples is in such runs. None is left out if one closed curve joins all with no edge longer than 1.5
    /// times the longest of the [`hnn_crust`] of the rest, nor than four times the longer one beside it. That is noisy if more than 0.4 of its turns change their
    /// direction, or more than a quarter of it is loose. Then [`lee`] is chosen, with two exceptions where one closed curve joins all. Noise is small where
    /// its median turn is at most 0.2; where no such curve joins all, that of the [`hnn_crust`], which is the choice then. Where nothing is loose and its spacing varies by a factor of 2.5, [`stretch_denoise`] is chosen. Of small noise, and of samples without noise of which something is loose, [`connect2d`] is the
    /// choice where it closes: corners. Otherwise [`hnn_crust`] is. Where outliers are left out of that, [`voronoi_labelling`] of all samples
    /// takes its place if it is closed curves alone through nine in ten of the rest, with no edge longer than 1.5 times its longest, and passes
    /// other samples by: those near the curve, too. A gap that a method bridges is opened again where no outliers are left out. All figures are ours, from points made for each case.
    pub fn new(triangulation: &Triangulation) -> Choice {
        let inner_share = inner_share(triangulation);
        let is_area = inner_share >= AREA;
        if is_area {
            return Choice {
                is_area,
                inner_share,
                outliers: Vec::new(),
                zigzag: None,
                closed_turn_rad: None,
                closed_spread: None,
                loose_share: 0.0,
                method: Method::Auto,
            };
        }
        let outliers = outliers(triangulation);
        let rest = Rest::new(triangulation, &outliers);
        let curve = hnn_crust(rest.triangulation().samples());
        // What closes a curve may be no longer than edges that bridge no gap.
        let places_mm = rest.triangulation().samples().places();
        let open = without_bridges(&curve, places_mm, SHOWN_TURN);
        let most_mm = longest_mm(rest.triangulation(), &open);
        if !outliers.is_empty() {
            // Tips of corners look like short runs: one closed curve joins them without a long edge.
            let all =
                Choice::of_border(triangulation, &hnn_crust(triangulation.samples()), most_mm);
            if all.method == Method::Connect2d {
                return Choice { inner_share, ..all };
            }
        }
        let found = Choice::of_border(rest.triangulation(), &curve, most_mm);
        if found.method == Method::HnnCrust
            && !outliers.is_empty()
            && let passing_mm = JOINS * longest_mm(rest.triangulation(), &curve)
            && let Some(passed) = passed_by(triangulation, rest.kept.len(), passing_mm)
            && passed != outliers
        {
            let method = Method::VoronoiLabelling;
            return Choice { inner_share, outliers: passed, method, ..found };
        }
        Choice { inner_share, outliers, ..found }
    }

    /// The choice for samples of a border without outliers, their [`hnn_crust`] and the longest edge of it.
    fn of_border(triangulation: &Triangulation, curve: &Graph, most_mm: f64) -> Choice {
        let zigzag = zigzag(triangulation, curve);
        let count = triangulation.len();
        let loose = curve.ends(count).len() + curve.alone(count).len();
        let loose_share = loose as f64 / count.max(1) as f64;
        let is_noisy = zigzag > ZIGZAG || loose_share > LOOSE;
        let closed = (loose > 0 || is_noisy).then(|| closing(triangulation, most_mm)).flatten();
        let closed_turn_rad = closed.as_ref().map(|closed| median_turn_rad(triangulation, closed));
        let closed_spread = closed.as_ref().map(|closed| spread(triangulation, closed));
        // Noise that every sample's order along the curve survives, and spacing that follows the features: so may the noise.
        let follows = loose == 0 && closed_spread.is_some_and(|spread| spread >= UNEVEN);
        let method = match closed_turn_rad {
            Some(turn_rad) if !is_noisy || turn_rad <= SLIGHT_RAD => Method::Connect2d,
            Some(_) if follows => Method::StretchDenoise,
            // The turn is one against the spacing of each place.
            _ if is_noisy && median_turn_rad(triangulation, curve) > SLIGHT_RAD => Method::Lee,
            _ => Method::HnnCrust,
        };
        let zigzag = Some(zigzag);
        let outliers = Vec::new();
        Choice {
            is_area: false,
            inner_share: 0.0,
            outliers,
            zigzag,
            closed_turn_rad,
            closed_spread,
            loose_share,
            method,
        }
    }

    /// The curve by the method chosen, without the outliers; none of an area.
    pub fn curve(&self, triangulation: &Triangulation) -> Option<FoundCurve> {
        if self.is_area {
            return None;
        }
        let rest = Rest::new(triangulation, &self.outliers);
        let moved = match self.method {
            Method::Lee => lee_reach_mm(rest.triangulation()).map(|h| lee(rest.triangulation(), h)),
            Method::StretchDenoise => Some(stretch_denoise(rest.triangulation(), 0.0)),
            _ => None,
        };
        let Some(moved) = moved else {
            if self.method == Method::VoronoiLabelling {
                let graph = voronoi_labelling(triangulation);
                return Some(FoundCurve { graph, ..FoundCurve::default() });
            }
            let graph = match self.method {
                Method::Connect2d => connect2d(rest.triangulation()),
                _ => {
                    let samples = rest.triangulation().samples();
                    let curve = hnn_crust(samples);
                    // What was left out may have lain in a gap.
                    match self.outliers.is_empty() {
                        true => without_bridges(&curve, samples.places(), SHOWN_TURN),
                        false => curve,
                    }
                }
            };
            let graph = rest.back(&graph);
            return Some(FoundCurve { graph, ..FoundCurve::default() });
        };
        let mut places_mm = triangulation.samples().places().to_vec();
        for (&sample, &place) in rest.kept.iter().zip(&moved.places_mm) {
            places_mm[sample as usize] = place;
        }
        let graph = without_bridges(&moved.graph, &moved.places_mm, NOISY_TURN);
        Some(FoundCurve {
            graph: rest.back(&graph),
            places_mm: Some(places_mm),
            sigma_mm: Some(moved.sigma_mm),
        })
    }

    /// The reason in words.
    pub fn reason(&self) -> String {
        let share = |share: f64| format!("{:.0} %", 100.0 * share);
        let Some(zigzag) = self.zigzag else {
            return format!(
                "area: {} of the points lie within an area as dense as most ({} or more needed)",
                share(self.inner_share),
                share(AREA)
            );
        };
        let kind = format!(
            "border: {} of the points lie within an area as dense as most ({} would make an area)",
            share(self.inner_share),
            share(AREA)
        );
        let outliers = match self.outliers.len() {
            0 => String::new(),
            count => format!("; {count} outliers left out"),
        };
        let is_noisy = zigzag > ZIGZAG || self.loose_share > LOOSE;
        let noise = match (self.method, is_noisy) {
            (Method::Lee, _) => "noise",
            (Method::StretchDenoise, _) => {
                "noise below the spacing, which follows the curve's features"
            }
            (_, true) => "little noise against the spacing",
            (_, false) => "no noise",
        };
        let corners = match (self.method == Method::Connect2d, is_noisy) {
            (true, true) => "; one closed curve joins all, corners too",
            (true, false) => "; corners: one closed curve joins what is loose",
            _ => "",
        };
        format!(
            "{kind}{outliers}; {noise}: {} of its turns change direction, {} of its points are loose{corners}",
            share(zigzag),
            share(self.loose_share)
        )
    }
}

/// A graph without edges that are far longer than those about them and over which its chains turn more than an angle in radians: what lies
/// there no point shows. Places are those of its samples.
fn without_bridges(graph: &Graph, places_mm: &[PlaceMm], most_turn: f64) -> Graph {
    let mut bridges = Vec::new();
    for chain in graph.chains(places_mm.len()) {
        let places: Vec<PlaceMm> =
            chain.samples.iter().map(|&sample| places_mm[sample as usize]).collect();
        let mut far = far_edges(&places, chain.closed);
        far.retain(|&from| turn_over(&places, chain.closed, from) > most_turn);
        let end = |at: usize| chain.samples[at % chain.samples.len()];
        bridges.extend(far.into_iter().map(|from| [end(from), end(from + 1)]));
    }
    if bridges.is_empty() {
        return graph.clone();
    }
    let bridges = Graph::new(bridges);
    let kept = graph.edges().iter().copied();
    Graph::new(kept.filter(|&[p, q]| !bridges.joins(p, q)))
}

/// Share of the samples off the hull whose triangles all have small circles.
fn inner_share(triangulation: &Triangulation) -> f64 {
    let tree = spanning_by_length(triangulation);
    let Some(&median) = tree.get(tree.len() / 2) else { return 0.0 };
    let most_mm = WIDEST * triangulation.length_mm(median);
    let mut is_inner = vec![!triangulation.triangles().is_empty(); triangulation.len()];
    for corners in triangulation.triangles() {
        let places = corners.map(|corner| triangulation.place(corner));
        let radius_mm = distance_mm(circumcentre_mm(places), places[0]);
        // NaN of a flat triangle is wide, too.
        if radius_mm.is_nan() || radius_mm > most_mm {
            corners.iter().for_each(|&corner| is_inner[corner as usize] = false);
        }
    }
    for edge in triangulation.edges().iter().filter(|edge| edge.triangles().contains(&None)) {
        edge.ends.iter().for_each(|&end| is_inner[end as usize] = false);
    }
    let inner = is_inner.iter().filter(|is_inner| **is_inner).count();
    inner as f64 / triangulation.len().max(1) as f64
}

/// Samples far from all others, measured by the spacing of the samples nearest to them.
fn outliers(triangulation: &Triangulation) -> Vec<SampleId> {
    let mut out = Vec::new();
    for _ in 0..2 {
        let rest = Rest::new(triangulation, &out);
        let set = rest.triangulation();
        if set.len() < 8 {
            break;
        }
        let nearest: Vec<[(SampleId, f64); 2]> = (0..set.len() as SampleId)
            .map(|sample| {
                let mut nearby = set.nearby(sample);
                [(); 2].map(|()| {
                    let other = nearby.next().unwrap_or(sample);
                    (other, distance_mm(set.place(sample), set.place(other)))
                })
            })
            .collect();
        let found = nearest.iter().enumerate().filter(|(_, [first, second])| {
            let spacing = |other: SampleId| nearest[other as usize][1].1;
            second.1 > FAR * spacing(first.0).min(spacing(second.0))
        });
        let found: Vec<SampleId> = found.map(|(index, _)| rest.kept[index]).collect();
        if found.is_empty() {
            break;
        }
        out.extend(found);
        out.sort_unstable();
    }
    let rest = Rest::new(triangulation, &out);
    let curve = hnn_crust(rest.triangulation().samples());
    let chains = curve.chains(rest.kept.len());
    if chains.iter().any(|chain| chain.samples.len() >= LONG) {
        let short = chains.iter().filter(|chain| !chain.closed && chain.samples.len() <= SHORT);
        let ends = short.flat_map(|chain| &chain.samples).copied();
        let apart: Vec<SampleId> = ends.chain(curve.alone(rest.kept.len())).collect();
        // Where much is in short runs, noise broke the curve.
        let is_noise = apart.len() as f64 > LOOSE * rest.kept.len() as f64;
        out.extend(
            apart.into_iter().filter(|_| !is_noise).map(|sample| rest.kept[sample as usize]),
        );
        out.sort_unstable();
        out.dedup();
    }
    out
}

/// Share of the turns that go the other way than the one before.
fn zigzag(triangulation: &Triangulation, curve: &Graph) -> f64 {
    let (mut changes, mut pairs) = (0_usize, 0_usize);
    for chain in curve.chains(triangulation.len()) {
        let places = chain.places_mm(triangulation.samples());
        let count = places.len();
        let turns = if chain.closed { count } else { count.saturating_sub(2) };
        let turn = |index: usize| {
            let [a, b, c] = [0, 1, 2].map(|step| places[(index + step) % count]);
            let turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
            // On straight pieces rounding turns, not the curve.
            let is_straight = turn.abs() <= STRAIGHT * distance_mm(a, b) * distance_mm(b, c);
            if is_straight { 0.0 } else { turn }
        };
        let turns: Vec<f64> = (0..turns).map(turn).collect();
        for pair in turns.windows(2) {
            pairs += 1;
            changes += usize::from(pair[0] * pair[1] < 0.0);
        }
    }
    changes as f64 / pairs.max(1) as f64
}

/// The closed curve that joins all samples, if there is one with no edge longer than [`JOINS`] times a length, nor than [`GAP`] times the
/// longer of the two edges beside it.
fn closing(triangulation: &Triangulation, most_mm: f64) -> Option<Graph> {
    let curve = connect2d(triangulation);
    let joins = curve.alone(triangulation.len()).is_empty();
    let bridges = |chain: &Chain| {
        let places = chain.places_mm(triangulation.samples());
        let count = places.len();
        let length_mm =
            |index: usize| distance_mm(places[index % count], places[(index + 1) % count]);
        (0..count).any(|index| {
            let beside_mm = length_mm(index + count - 1).max(length_mm(index + 1));
            length_mm(index) > GAP * beside_mm
        })
    };
    let joins = joins && !curve.chains(triangulation.len()).iter().any(bridges);
    (joins && longest_mm(triangulation, &curve) <= JOINS * most_mm).then_some(curve)
}

/// Length of the longest edge in mm.
fn longest_mm(triangulation: &Triangulation, graph: &Graph) -> f64 {
    let edges = graph.edges().iter().map(|edge| edge.map(|end| triangulation.place(end)));
    edges.map(|[p, q]| distance_mm(p, q)).fold(0.0, f64::max)
}

/// The median size of the turns at samples with two edges, in radians; 0 without such samples.
fn median_turn_rad(triangulation: &Triangulation, curve: &Graph) -> f64 {
    let mut turns = Vec::new();
    for chain in curve.chains(triangulation.len()) {
        let places = chain.places_mm(triangulation.samples());
        let count = places.len();
        let corners = if chain.closed { count } else { count.saturating_sub(2) };
        turns.extend((0..corners).map(|index| {
            let [a, b, c] = [0, 1, 2].map(|step| places[(index + step) % count]);
            let [ux, uy, vx, vy] = [b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]];
            (ux * vy - uy * vx).abs().atan2(ux * vx + uy * vy)
        }));
    }
    turns.sort_by(f64::total_cmp);
    turns.get(turns.len() / 2).copied().unwrap_or(0.0)
}

/// Length that nine in ten edges do not exceed over that of one in ten; 1 without edges.
fn spread(triangulation: &Triangulation, curve: &Graph) -> f64 {
    let edges = curve.edges().iter().map(|edge| edge.map(|end| triangulation.place(end)));
    let mut lengths_mm: Vec<f64> = edges.map(|[p, q]| distance_mm(p, q)).collect();
    lengths_mm.sort_by(f64::total_cmp);
    let at = |tenths: usize| lengths_mm.get(tenths * lengths_mm.len() / 10);
    at(9).zip(at(1)).map_or(1.0, |(high, low)| high / low)
}

/// The samples that the closed curves of [`voronoi_labelling`] pass by; `None` where it has an end or a crossing, a longer edge, or fewer than nine in
/// ten of so many samples.
fn passed_by(triangulation: &Triangulation, samples: usize, most_mm: f64) -> Option<Vec<SampleId>> {
    let curve = voronoi_labelling(triangulation);
    let degrees = curve.degrees(triangulation.len());
    let is_closed = degrees.iter().all(|degree| matches!(degree, 0 | 2));
    let joined = degrees.iter().filter(|degree| **degree == 2).count();
    if !is_closed || 10 * joined < 9 * samples || longest_mm(triangulation, &curve) > most_mm {
        return None;
    }
    Some((0..).zip(degrees).filter(|it| it.1 == 0).map(|it| it.0).collect())
}

/// The samples without some of them.
struct Rest<'a> {
    all: &'a Triangulation,
    /// The triangulation of the rest, if that is not all.
    thinned: Option<Triangulation>,
    /// The sample that each of the rest is.
    kept: Vec<SampleId>,
}

impl<'a> Rest<'a> {
    fn new(all: &'a Triangulation, without: &[SampleId]) -> Rest<'a> {
        let is_kept = |sample: &SampleId| without.binary_search(sample).is_err();
        let kept: Vec<SampleId> = (0..all.len() as SampleId).filter(is_kept).collect();
        // What takes longest is not done again where nothing is left out.
        let thinned = (!without.is_empty()).then(|| {
            let places: Vec<PlaceMm> = kept.iter().map(|&sample| all.place(sample)).collect();
            // Places of samples are admitted and sorted already: numbers are those of `kept`.
            let samples = Samples::new(&places).unwrap_or_else(|_| all.samples().clone());
            Triangulation::new(samples)
        });
        Rest { all, thinned, kept }
    }

    fn triangulation(&self) -> &Triangulation {
        self.thinned.as_ref().unwrap_or(self.all)
    }

    /// A graph of the rest as one of all samples.
    fn back(&self, graph: &Graph) -> Graph {
        Graph::new(graph.edges().iter().map(|edge| edge.map(|end| self.kept[end as usize])))
    }
}

/// Sine of a turn that counts as none.
const STRAIGHT: f64 = 1e-6;
/// Median turn of a closed curve up to which its noise is small against the spacing: it turns by √6·σ/s about, σ the noise, s the spacing.
const SLIGHT_RAD: f64 = 0.2;
/// Spread of the spacing from which on it follows the features of the curve.
const UNEVEN: f64 = 2.5;
/// Length of the edges that close a curve over that of the others.
const JOINS: f64 = 1.5;
/// Length of an edge over the longer one beside it from which on it bridges a gap.
const GAP: f64 = 4.0;
/// Share of inner samples from which on points are an area.
const AREA: f64 = 0.62;
/// Widest circle of a triangle within an area over the median edge of the spanning tree.
const WIDEST: f64 = 2.2;
/// Distance of an outlier to its second nearest sample over that of its neighbours.
const FAR: f64 = 4.0;
/// Open runs of so many samples or fewer are outliers,
const SHORT: usize = 4;
/// where a run has so many or more.
const LONG: usize = 30;
/// Turn over a gap of a curve without its noise from which on it stays open, radians. Few of its places are joined, so gaps are wide: ρ, which is
/// 2·sin(θ/4) of an arc of θ, must be below 0.9 as HNN-Crust asks.
const NOISY_TURN: f64 = 1.87;
/// Share of changes of direction that says noise.
const ZIGZAG: f64 = 0.4;
/// Share of loose samples that says noise.
const LOOSE: f64 = 0.25;
