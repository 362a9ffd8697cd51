// PV and RMS against points with the band of their uncertainty, by uPlot.

import { byId, colour, setText } from "./dom.js";
import { count, known, nm, significant } from "./format.js";
import { COVERAGE, band, sayBands } from "./series.js";

/** The size of a chart as wide as its place. */
const sizeOf = (place) => ({
  width: place.clientWidth,
  height: Math.min(Math.max(Math.round(place.clientWidth * 0.48), 190), 270),
});

export class Plots {
  #charts = [];
  #data = null;

  /** Draws the columns of a snapshot's convergence. */
  update(convergence) {
    const { points, pv_nm, rms_nm, pv_u_nm, rms_u_nm } = convergence;
    const empty = points.length === 0;
    byId("plots-empty").hidden = !empty;
    for (const id of ["plot-pv", "plot-rms", "plot-readout", "plot-bands"]) byId(id).hidden = empty;
    if (empty) {
      this.#data = null;
      return;
    }
    if (this.#charts.length === 0) this.#build();
    const last = points.length - 1;
    const same = this.#data && this.#data[0].length === points.length
      && this.#data[0][last] === points[last] && this.#data[1][last] === pv_nm[last];
    if (same) return;
    this.#data = [points, pv_nm, rms_nm, pv_u_nm, rms_u_nm];
    this.#charts[0].setData([points, pv_nm, ...band(pv_nm, pv_u_nm)]);
    this.#charts[1].setData([points, rms_nm, ...band(rms_nm, rms_u_nm)]);
    setText(byId("plot-bands"), sayBands(convergence));
    this.#tell();
  }

  /** Draws anew in the colours of the present scheme. */
  recolour() {
    for (const chart of this.#charts) chart.redraw(false, true);
  }

  /** The figures under the cursor, or the last ones. */
  #tell() {
    if (!this.#data) return;
    const [points, pv, rms, uPv, uRms] = this.#data;
    const under = this.#charts.map((one) => one.cursor.idx).find(known);
    const at = Math.min(under ?? points.length - 1, points.length - 1);
    const about = (value, u) => (known(u) ? `${nm(value)} ± ${significant(COVERAGE * u, 2)} nm` : `${nm(value)} nm`);
    setText(byId("plot-readout"), `${count(points[at])} points: PV ${about(pv[at], uPv[at])}, RMS ${about(rms[at], uRms[at])}`);
  }

  #build() {
    this.#charts = [
      chart(byId("plot-pv"), "PV", "series-pv", [], () => this.#tell()),
      chart(byId("plot-rms"), "RMS", "series-rms", [6, 3], () => this.#tell()),
    ];
    new ResizeObserver(() => {
      for (const one of this.#charts) {
        one.setSize(sizeOf(one.root.parentElement));
      }
    }).observe(byId("plot-pv"));
  }
}

/** What the axes of all charts have in common. */
export const axis = {
  stroke: () => colour("quiet"),
  grid: { stroke: () => colour("line"), width: 1 },
  ticks: { stroke: () => colour("line"), width: 1 },
  font: "12px system-ui, sans-serif",
  labelFont: "12px system-ui, sans-serif",
  labelSize: 18,
  labelGap: 2,
};

function chart(parent, name, series, dash, moved) {
  return new uPlot({
    ...sizeOf(parent),
    padding: [8, 14, 0, 0],
    scales: { x: { time: false }, y: { range: (_, low, high) => range(low, high) } },
    axes: [
      { ...axis, label: "points", size: 30, space: 80, values: (_, ticks) => ticks.map(short) },
      { ...axis, label: `${name} in nm`, size: 48, values: (_, ticks) => ticks.map((v) => String(Number(v.toPrecision(4)))) },
    ],
    series: [
      { label: "points" },
      {
        label: name,
        stroke: () => colour(series),
        width: 2,
        dash,
        points: { show: (self) => self.data[0].length < 3 },
      },
      { label: "lower", width: 0, points: { show: false } },
      { label: "upper", width: 0, points: { show: false } },
    ],
    bands: [{ series: [3, 2], fill: () => colour(`${series}-band`) }],
    legend: { show: false },
    hooks: { setCursor: [moved] },
    cursor: { y: false, sync: { key: "convergence" }, drag: { x: false, y: false } },
  }, [[], [], [], []], parent);
}

/** From zero, so that a small change does not look large; a flat line stands in the middle. */
function range(low, high) {
  if (!known(high) || high <= 0) return [0, 1];
  return low > 0.7 * high ? [low - 0.5 * (high - low) - 0.05 * high, high + 0.05 * high] : [0, high * 1.08];
}

/** 1200000 as 1.2M: ticks are round. */
function short(value) {
  if (value >= 1e6) return `${Number((value / 1e6).toFixed(2))}M`;
  return value >= 1e4 ? `${Number((value / 1e3).toFixed(1))}k` : String(value);
}
