// Figures of a snapshot as the columns of charts, and what the charts say of them. Imports nothing.

const known = (value) => Number.isFinite(value);

/** The coverage factor of the bands. */
export const COVERAGE = 2;

/** "tilt", "tilt and power", "tilt, power and coma". */
export const listed = (names) =>
  names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;

/** What a figure is of, in words. */
export const ofSource = (source) => (source === "points" ? "of all points" : "of the map of cells");

/** The lower and the upper edge of a band, null where the uncertainty is not known. */
export function band(values, uncertainties) {
  const edge = (sign) => values.map((value, at) => {
    const u = uncertainties[at];
    return known(u) ? value + sign * COVERAGE * u : null;
  });
  return [edge(-1), edge(1)];
}

/** What the bands are, and of what there is none. */
export function sayBands({ pv_u_nm, rms_u_nm, pv_u_basis, rms_u_basis }) {
  const say = (name, u, basis) =>
    (u.some(known) ? `${name}: band of ±u, k = ${COVERAGE}, ${basis}.` : `${name}: no band, u is ${basis}.`);
  return `${say("PV", pv_u_nm, pv_u_basis)} ${say("RMS", rms_u_nm, rms_u_basis)}`;
}

/** The middle and the ends of each bin of a histogram in nm. */
export function bins({ low_nm: low, width_nm: width, counts }) {
  const ends = counts.map((_, at) => [low + at * width, low + (at + 1) * width]);
  return { middles: ends.map(([from, to]) => (from + to) / 2), ends };
}

/** Zernike terms as bars: number, above zero, below zero, and those that are removed from what is shown. */
export function termBars(terms, removed) {
  const taken = (term) => removed.has(term.index);
  const bar = (holds) => terms.map((term) => (holds(term) ? term.value_nm : null));
  return [
    terms.map((term) => term.index),
    bar((term) => !taken(term) && term.value_nm >= 0),
    bar((term) => !taken(term) && term.value_nm < 0),
    bar(taken),
  ];
}

/** Frequencies and densities of a spectrum that a logarithmic axis can show. */
export function densityColumns({ frequency_per_mm: frequencies, density_nm2_mm2: densities }) {
  const shown = frequencies.map((_, at) => at).filter((at) => frequencies[at] > 0 && densities[at] > 0);
  return [shown.map((at) => frequencies[at]), shown.map((at) => densities[at])];
}

/** A mark of a logarithmic axis: 0.05, 200, 10⁻⁶, 2·10⁷. */
export function powerOfTen(value) {
  const [digits, exponent] = value.toExponential(0).split("e");
  const power = Number(exponent);
  if (power >= -3 && power <= 4) return String(Number(value.toPrecision(1)));
  const raised = [...String(power)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
  return `${digits === "1" ? "" : `${digits}·`}10${raised}`;
}

/** The terms that are largest, the largest first. */
export const largest = (terms, number) =>
  [...terms].sort((a, b) => Math.abs(b.value_nm) - Math.abs(a.value_nm)).slice(0, number);

/** Links that should deliver while a part is measured and do not, the longest silent first. */
export function silent({ state, links }) {
  if (state !== "measuring") return [];
  const quiet = links.filter((link) => known(link.age_s) && !["connected", "closed"].includes(link.state));
  return quiet.sort((a, b) => b.age_s - a.age_s);
}

/** What is counted by its reason and is in the mesh all the same, or in its account. */
const MESHED = ["conflict", "not_meshable", "outside_aperture", "outside_domain"];

/** How many points for the mesh came after `asOf` of them; some fewer where one has several flags. */
export function pointsSince({ received, flagged }, asOf) {
  const unmeshed = Object.entries(flagged).filter(([reason]) => !MESHED.includes(reason));
  return Math.max(received - unmeshed.reduce((sum, [, number]) => sum + number, 0) - asOf, 0);
}
