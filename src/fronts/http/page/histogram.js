// How many points have which deviation.

import { line } from "./axes.js";
import { barChart } from "./bars.js";
import { byId, colour, setText } from "./dom.js";
import { DASH, count, known, percent, signedNm } from "./format.js";
import { bins, listed, ofSource } from "./series.js";

const HEIGHT = 220;

export class Histogram {
  #chart = null;
  #form = null;
  #view = null;
  #shown = null; // The figures that are drawn.
  #bins = null;

  update(form) {
    this.#form = form;
    this.#draw();
  }

  /** Takes the deviation without terms, or null for that as fitted. */
  setView(view) {
    this.#view = view;
    this.#draw();
  }

  recolour() {
    this.#chart?.redraw(false, true);
  }

  #draw() {
    const found = this.#form ? (this.#view ?? this.#form).histogram ?? null : null;
    byId("histogram").hidden = found === null;
    byId("histogram-empty").hidden = found !== null;
    const removed = this.#view?.removed ?? [];
    const of = found ? `${ofSource(found.source)}, ${removed.length ? `less ${listed(removed)}` : "as fitted"}` : "";
    setText(byId("histogram-of"), of);
    byId("histogram").dataset.bins = found?.counts.length ?? 0;
    if (found === this.#shown) return;
    this.#shown = found;
    this.#bins = found && bins(found);
    if (found) {
      this.#chart ??= this.#build();
      this.#chart.setData([this.#bins.middles, found.counts]);
    }
    this.#tell(null);
  }

  #tell(at) {
    if (!this.#bins) {
      setText(byId("histogram-readout"), "");
      return;
    }
    const [{ ends }, { counts }] = [this.#bins, this.#shown];
    const all = counts.reduce((sum, points) => sum + points, 0);
    if (!known(at) || at >= counts.length) {
      setText(byId("histogram-readout"), `${count(all)} points in ${count(counts.length)} bins of ${Number(this.#shown.width_nm.toPrecision(6))} nm`);
      return;
    }
    const [from, to] = ends[at].map(signedNm);
    setText(byId("histogram-readout"), `${from} to ${to} nm: ${count(counts[at])} points, ${all > 0 ? percent(counts[at] / all) : DASH}`);
  }

  #build() {
    return barChart(byId("histogram"), {
      height: HEIGHT,
      share: 1,
      series: [{ fill: () => colour("bar"), line: () => colour("card") }],
      x: { label: "deviation in nm" },
      y: { label: "points" },
      moved: (at) => this.#tell(at),
      drawn: drawZero,
      // Whole bins at both ends.
      xRange: () => {
        const ends = this.#bins?.ends ?? [];
        return ends.length ? [ends[0][0], ends.at(-1)[1]] : [0, 1];
      },
    });
  }
}

/** The nominal. */
function drawZero(self) {
  const { ctx, bbox, scales } = self;
  if (!(scales.x.min < 0 && scales.x.max > 0)) return;
  const x = Math.round(self.valToPos(0, "x", true));
  ctx.save();
  ctx.strokeStyle = colour("ink");
  ctx.lineWidth = 1;
  ctx.setLineDash([5, 4]);
  line(ctx, x, bbox.top, x, bbox.top + bbox.height);
  ctx.restore();
}
