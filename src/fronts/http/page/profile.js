// The profile of a section by uPlot: deviation, or height without a fit, over the way along it; gaps as gaps.

import { noDataPattern } from "./axes.js";
import { byId, colour, setText } from "./dom.js";
import { count, fixed, known, nm, signedNm, significant } from "./format.js";
import { columns, gaps, lengthOf } from "./pieces.js";
import { axis } from "./plots.js";

const HEIGHT = 230;

export class Profile {
  #onCursor;
  #chart = null;
  #section = null;
  #length = null;
  #data = [[], [], []];
  #gaps = [];
  #cursor = null;

  /** `onCursor` gets the place of the mesh under the cursor, or null. */
  constructor(onCursor) {
    this.#onCursor = onCursor;
  }

  /** Draws a section's answer; null clears it. */
  show(section) {
    const there = section !== null && section.points.s_mm.length > 0;
    byId("profile").hidden = !there;
    byId("profile-empty").hidden = there;
    byId("section-card").dataset.points = there ? section.points.s_mm.length : 0;
    setText(byId("profile-empty"), section ? "The section meets no measured surface." : "No section yet.");
    this.#section = there ? section : null;
    if (!there) {
      setText(byId("profile-figures"), "");
      setText(byId("profile-readout"), "");
      return;
    }
    this.#length = lengthOf(section.path);
    this.#data = columns(section);
    this.#gaps = gaps(section, this.#length);
    this.#sayFigures();
    this.#chart ??= this.#build();
    this.#chart.setData(this.#data.slice(0, 2));
    this.#tell();
  }

  recolour() {
    this.#chart?.redraw(false, true);
  }

  #sayFigures() {
    const { deviation, height, pieces, length_mm: length } = this.#section;
    const missing = this.#gaps.reduce((sum, [from, to]) => sum + to - from, 0);
    const what = deviation
      ? `PV ${nm(deviation.pv_nm)} nm, RMS ${nm(deviation.rms_nm)} nm over ${fixed(deviation.length_mm, 2)} mm`
      : height
        ? `height: PV ${significant(height.pv_mm * 1e3, 4)} µm, RMS about the mean ${significant(height.rms_about_mean_mm * 1e3, 4)} µm over ${fixed(length, 2)} mm`
        : `${fixed(length, 2)} mm, no deviation`;
    const many = missing === 0 && pieces.length > 1 ? `; ${count(pieces.length)} pieces` : "";
    const broken = missing > 0 ? `; ${count(pieces.length)} ${pieces.length === 1 ? "piece" : "pieces"}, ${fixed(missing, 2)} mm without surface` : "";
    setText(byId("profile-figures"), what + broken + many);
  }

  #tell() {
    if (!this.#section) return;
    const at = this.#chart?.cursor.idx;
    const index = known(at) ? this.#data[2][at] : null;
    if (!known(index)) {
      setText(byId("profile-readout"), "Point at the profile to read it.");
      if (this.#cursor !== null) this.#onCursor(null);
      this.#cursor = null;
      return;
    }
    const { s_mm: s, x_mm: x, y_mm: y, z_mm: z, deviation_nm: deviation } = this.#section.points;
    const value = deviation ? `${signedNm(deviation[index])} nm` : `height ${fixed(z[index], 5)} mm`;
    setText(byId("profile-readout"), `at ${fixed(s[index], 3)} mm, x ${fixed(x[index], 3)} mm, y ${fixed(y[index], 3)} mm${this.#section.height ? "" : `, z ${fixed(z[index], 3)} mm`}: ${value}`);
    this.#cursor = [x[index], y[index]];
    this.#onCursor(this.#cursor);
  }

  #build() {
    const place = byId("profile");
    const size = () => ({ width: place.clientWidth, height: HEIGHT });
    const plain = (_, ticks) => ticks.map((tick) => String(Number(tick.toPrecision(6))));
    const chart = new uPlot({
      ...size(),
      padding: [8, 14, 0, 0],
      scales: { x: { time: false, range: (_, low, high) => (known(this.#length) ? [0, this.#length] : [low, high]) } },
      axes: [
        { ...axis, label: "way along the section in mm", size: 30, space: 80, values: plain },
        { ...axis, label: () => (this.#section?.points.deviation_nm ? "deviation in nm" : "height about the mean in µm"), size: 62, values: plain },
      ],
      series: [
        { label: "way" },
        { label: "profile", stroke: () => colour("series-pv"), width: 1.5, points: { show: false } },
      ],
      legend: { show: false },
      hooks: { setCursor: [() => this.#tell()], drawClear: [(self) => this.#drawGaps(self)] },
      cursor: { y: false, drag: { x: false, y: false } },
    }, [[], []], place);
    new ResizeObserver(() => place.clientWidth > 0 && chart.setSize(size())).observe(place);
    return chart;
  }

  /** What is missing looks as on the map. */
  #drawGaps(self) {
    const { ctx, bbox } = self;
    ctx.save();
    ctx.fillStyle = noDataPattern(ctx);
    for (const [from, to] of this.#gaps) {
      const [left, right] = [from, to].map((s) => self.valToPos(s, "x", true));
      const [x, end] = [Math.max(left, bbox.left), Math.min(right, bbox.left + bbox.width)];
      if (end > x) ctx.fillRect(x, bbox.top, end - x, bbox.height);
    }
    ctx.restore();
  }
}
