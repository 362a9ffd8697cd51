// The page's numbers and colours, without a browser: `node --test` in this folder.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";

/** A module of the page that imports nothing; read as text, since it belongs to no package. */
async function load(name) {
  const file = new URL(`../../src/fronts/http/page/${name}`, import.meta.url);
  return import(`data:text/javascript,${encodeURIComponent(await readFile(file, "utf8"))}`);
}
const format = await load("format.js");
const { diverging, sequential } = await load("colours.js");
const { Frames, rings, within } = await load("frames.js");
const { columns, gaps, lengthOf } = await load("pieces.js");
const { knots } = await load("knots.js");
const { areAlong, areRight, placeMm } = await load("lattice.js");
const series = await load("series.js");
const plain = (text) => text.replaceAll("\u202f", " ").replaceAll("−", "-");

test("lines of a contour end alone, or meet", () => {
  const line = (points, closed = false) => ({ closed, points_mm: points });
  assert.deepEqual(knots([line([[0, 0], [1, 0], [1, 1]], true), line([])]), { ends: [], junctions: [] });
  const cross = [[1, 0], [0, 1], [-1, 0]].map((end) => line([[0, 0], [end[0] / 2, end[1] / 2], end]));
  assert.deepEqual(knots(cross), { ends: [[1, 0], [0, 1], [-1, 0]], junctions: [[0, 0]] });
});

test("a slice of a turned or slanted grid has no one coordinate", () => {
  const along = [[0.1, 0, 0], [0, -0.1, 0], [0, 0, 0.2]];
  const turned = [[0, 0.1, 0], [0.1, 0, 0], [0, 0, 0.2]];
  const slanted = [[0.1, 0, 0], [0.05, 0.1, 0], [0, 0, 0.2]];
  assert.deepEqual([along, turned, slanted].map(areAlong), [true, false, false]);
  assert.deepEqual([along, turned, slanted].map(areRight), [true, true, false]);
  assert.deepEqual(placeMm([1, 2, 3], slanted, [10, 20, 5]), [3, 4, 4]);
});

test("what is absent is a dash, never a zero", () => {
  const { nm, signedNm, count, percent, significant, rate, duration, place } = format;
  for (const show of [nm, signedNm, count, percent, significant, rate, duration]) {
    for (const absent of [null, undefined, NaN, Infinity]) assert.equal(show(absent), "–", show.name);
  }
  assert.equal(place(null), "–");
});

test("a logarithmic axis has what it can show, and short names", () => {
  const psd = { frequency_per_mm: [0.1, 0.2, 0.4], density_nm2_mm2: [5, 0, 2e-7] };
  assert.deepEqual(series.densityColumns(psd), [[0.1, 0.4], [5, 2e-7]]);
  assert.deepEqual([0.05, 1, 20000, 1e-6, 2e7, 1e10].map(series.powerOfTen), ["0.05", "1", "20000", "10⁻⁶", "2·10⁷", "10¹⁰"]);
});

test("numbers are rounded, grouped and signed", () => {
  assert.equal(plain(format.count(2782224)), "2 782 224");
  assert.equal(plain(format.count(9999)), "9999");
  assert.equal(plain(format.nm(-12345.67)), "-12 345.7");
  assert.equal(plain(format.nm(-0.04)), "0.0");
  assert.equal(format.signedNm(3.25), "+3.3");
  assert.equal(format.signedNm(0), "0.0");
  assert.equal(format.significant(0.0021149), "0.00211");
  assert.equal(plain(format.significant(123456)), "123 456");
  assert.equal(format.rate(1998.2), "1998");
  assert.equal(format.rate(0.9981), "0.998");
});

test("a share is 100 % only where nothing is missing", () => {
  assert.equal(plain(format.percent(0.99999)), "99.9 %");
  assert.equal(plain(format.percent(1)), "100.0 %");
  assert.equal(plain(format.percent(0)), "0.0 %");
});

test("durations name their units", () => {
  const shown = [0, 9.96, 59.4, 59.6, 185, 3599.6, 3725].map(format.duration);
  assert.deepEqual(shown, ["0.0 s", "10.0 s", "59 s", "1 min 00 s", "3 min 05 s", "1 h 00 min", "1 h 02 min"]);
});

test("a figure with a limit has sign, scope and the digits of its unit", () => {
  const rms = { symbol: "RMS", scope: "from 0-4.5 mm", unit: "nm" };
  assert.equal(format.figureWords(rms), "RMS from 0-4.5 mm");
  assert.equal(format.figureWords({ symbol: "PV" }), "PV");
  assert.equal(format.figureValue(rms, 12.345), "12.3");
  assert.equal(format.figureValue({ symbol: "slope max", unit: "µrad" }, 12.3456), "12.35");
  assert.equal(format.sentence("pass is certain"), "Pass is certain");
});

/** CIE L*a*b* (D65) of sRGB, by IEC 61966-2-1 and CIE 15. */
function lab(rgb) {
  const [r, g, b] = rgb.map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
  const f = (t) => (t > 216 / 24389 ? Math.cbrt(t) : (24389 / 27 * t + 16) / 116);
  const x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047);
  const y = f(0.2126 * r + 0.7152 * g + 0.0722 * b);
  const z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

test("both arms of the map darken alike and differ for every kind of colour vision", () => {
  const table = diverging(false);
  let last = 101;
  for (let t = 0; t <= 1.0001; t += 0.05) {
    const [below, above] = [lab(table(-t)), lab(table(t))];
    assert.ok(Math.abs(below[0] - above[0]) < 8, `lightness at ${t}: ${below[0]} and ${above[0]}`);
    assert.ok(below[0] < last, `lightness rises at ${t}`);
    last = below[0];
    if (t < 0.25) continue;
    // b*, blue to yellow, is what red-green blindness leaves; a*, green to red, what blue-yellow blindness does.
    assert.ok(above[2] - below[2] > 30, `b* at ${t}`);
    assert.ok(above[1] - below[1] > 10, `a* at ${t}`);
  }
});

test("flipping swaps the signs and the ends are clamped", () => {
  const [plain, flipped] = [diverging(false), diverging(true)];
  for (const t of [-1, -0.4, 0, 0.7, 1]) assert.deepEqual(plain(t), flipped(-t));
  assert.deepEqual(plain(5), plain(1));
});

test("what is never negative darkens all the way", () => {
  const table = sequential();
  let last = 101;
  for (let t = 0; t <= 1.0001; t += 0.05) {
    const [lightness] = lab(table(t));
    assert.ok(lightness < last, `lightness at ${t}`);
    last = lightness;
  }
  assert.deepEqual(table(-1), table(0));
  assert.deepEqual(table(7), table(1));
});

test("places go from the part into the mesh and back", () => {
  const close = (found, wanted) =>
    found.forEach((v, i) => assert.ok(Math.abs(v - wanted[i]) < 1e-12, `${found}, not ${wanted}`));
  const straight = new Frames(null, null);
  close(straight.toMesh([1, 2]), [1, 2]);
  const pose = { tx_mm: 1, ty_mm: -2, tz_mm: 9, rx_rad: 0, ry_rad: 0, rz_rad: Math.PI / 2 };
  const turned = new Frames(pose, null);
  // A quarter turn takes x to y, and y to the other side of x.
  close(turned.toMesh([3, 0]), [1, 1]);
  close(turned.toMesh([0, 3]), [-2, -2]);
  close(turned.toPart([1, 1]), [3, 0]);
  close(turned.measuredToPart([1, 1, 50]), [3, 0]);
  const tilted = new Frames({ ...pose, rx_rad: 0.1, ry_rad: -0.2, rz_rad: 0.3 }, null);
  close(tilted.toPart(tilted.toMesh([0.7, -0.4])), [0.7, -0.4]);
  // An upright part, seen along y: u is x and v is z of the measured frame.
  const plane = { u: [1, 0, 0], v: [0, 0, 1], normal: [0, -1, 0], origin_mm: [0, 0, 0] };
  const upright = new Frames({ tx_mm: 5, ty_mm: 6, tz_mm: 7, rx_rad: Math.PI / 2, ry_rad: 0, rz_rad: 0 }, plane);
  close(upright.toMesh([1, 2]), [6, 9]);
  close(upright.measuredToPart([6, 6, 9]), [1, 2]);
  // Places of a section stand beside a map of the part frame, and their own frame was not named.
  assert.equal(turned.name, "measured frame");
  assert.equal(upright.name, "plane of projection");
});

test("regions are found whichever way their polygons are nested", () => {
  const ring = [[0, 0], [4, 0], [4, 4], [0, 4]];
  const hole = [[1, 1], [3, 1], [3, 3], [1, 3]];
  assert.deepEqual(rings(ring), [ring]);
  assert.deepEqual(rings([[ring, hole]]), [ring, hole]);
  assert.deepEqual(rings([{ outline: ring, holes: [hole] }]), [ring, hole]);
  assert.deepEqual(rings([{ outline: { places_mm: ring, open: [true, false] }, holes: [] }]), [ring]);
  assert.deepEqual(rings([]), []);
  assert.ok(within([ring, hole], [0.5, 2]) && !within([ring, hole], [2, 2]) && !within([ring], [5, 2]));
});

test("a broken profile has a gap where it is broken, and tells the missing stretches", () => {
  const section = {
    path: { kind: "line", from_mm: [0, 0], to_mm: [3, 4] },
    pieces: [{ from_s_mm: 1, to_s_mm: 2 }, { from_s_mm: 3, to_s_mm: 5 }],
    points: { piece: [0, 0, 1, 1], s_mm: [1, 2, 3, 5], z_mm: [1, 2, 3, 4], deviation_nm: [10, null, 30, 40] },
  };
  assert.deepEqual(columns(section), [[1, 2, 2.5, 3, 5], [10, null, null, 30, 40], [0, 1, null, 2, 3]]);
  assert.equal(lengthOf(section.path), 5);
  assert.deepEqual(gaps(section, 5), [[0, 1], [2, 3]]);
  assert.deepEqual(gaps(section, null), [[2, 3]], "where a radius ends is not a gap");
  const planar = { ...section, path: { kind: "plane" }, pieces: [{ from_s_mm: 0, to_s_mm: 2 }, { from_s_mm: 0, to_s_mm: 5 }] };
  assert.deepEqual(columns({ ...planar, points: { ...section.points, s_mm: [0, 2, 0, 5] } })[0], [0, 2, 2, 2, 7]);
  assert.deepEqual([gaps(planar, null), lengthOf(planar.path)], [[], null]);
  const heights = { ...section, height: { mean_mm: 2 }, points: { ...section.points, deviation_nm: undefined } };
  assert.deepEqual(columns(heights)[1], [-1000, 0, null, 1000, 2000], "µm about the mean");
});

test("a band is two standard uncertainties wide on each side, and absent where they are not known", () => {
  assert.deepEqual(series.band([10, 20], [1, null]), [[8, null], [12, null]]);
  const said = series.sayBands({ pv_u_nm: [null], rms_u_nm: [null, 0.5], pv_u_basis: "not known: why", rms_u_basis: "of the fit" });
  assert.equal(said, "PV: no band, u is not known: why. RMS: band of ±u, k = 2, of the fit.");
});

test("bins lie between their ends", () => {
  const { middles, ends } = series.bins({ low_nm: -2, width_nm: 2, counts: [3, 0, 1] });
  assert.deepEqual(middles, [-1, 1, 3]);
  assert.deepEqual(ends, [[-2, 0], [0, 2], [2, 4]]);
});

test("a Zernike term stands in one column: above, below or removed", () => {
  const terms = [{ index: 4, value_nm: -3 }, { index: 5, value_nm: 2 }, { index: 9, value_nm: -7 }];
  const bars = series.termBars(terms, new Set([9]));
  assert.deepEqual(bars, [[4, 5, 9], [null, 2, null], [-3, null, null], [null, null, -7]]);
  assert.deepEqual(series.largest(terms, 2).map((term) => term.index), [9, 4]);
});

test("names are listed, and what figures are of is told", () => {
  assert.equal(series.listed(["tilt"]), "tilt");
  assert.equal(series.listed(["piston", "tilt", "power"]), "piston, tilt and power");
  assert.equal(series.ofSource("points"), "of all points");
  assert.equal(series.ofSource("map of cells"), "of the map of cells");
});

test("only a link that should deliver is silent", () => {
  const link = (name, state, age_s) => ({ name, state, age_s });
  const links = [link("a", "connected", 0.1), link("b", "stale", 7), link("c", "opening", 9), link("d", "closed", 99), link("e", "waiting", null)];
  assert.deepEqual(series.silent({ state: "measuring", links }).map((one) => one.name), ["c", "b"]);
  assert.deepEqual(series.silent({ state: "complete", links }), []);
});
