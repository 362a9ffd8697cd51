// The power spectral density of the final deviation over two logarithmic axes, by uPlot.

import { byId, colour, setText } from "./dom.js";
import { known, nm, percent, significant } from "./format.js";
import { axis } from "./plots.js";
import { densityColumns, powerOfTen } from "./series.js";

const HEIGHT = 230;

export class Spectrum {
  #chart = null;
  #found = null;

  /** Takes the form of a snapshot; only the final one has a spectrum. */
  update(form) {
    const found = form?.psd ?? null;
    byId("psd-card").hidden = found === null;
    // The final figures stay the same from snapshot to snapshot.
    if (found === null || JSON.stringify(found) === JSON.stringify(this.#found)) return;
    this.#found = found;
    this.#chart ??= this.#build();
    this.#chart.setData(densityColumns(found));
    this.#tell(null);
  }

  recolour() {
    this.#chart?.redraw(false, true);
  }

  #tell(at) {
    const { removed, window, measured, rms_nm: rms, up_to_per_mm: end } = this.#found;
    const [frequencies, densities] = densityColumns(this.#found);
    setText(byId("psd-readout"), known(at)
      ? `${significant(frequencies[at])} /mm, a wavelength of ${significant(1 / frequencies[at])} mm: ${significant(densities[at])} nm²·mm²`
      : `Less ${removed}; ${window} window; ${percent(measured)} of the rectangle of the map is measured. Given up to ${significant(end)} /mm; RMS ${nm(rms)} nm.`);
  }

  #build() {
    const place = byId("psd");
    const size = () => ({ width: place.clientWidth, height: HEIGHT });
    const values = (_, ticks) => ticks.map((tick) => (known(tick) ? powerOfTen(tick) : ""));
    const chart = new uPlot({
      ...size(),
      padding: [8, 14, 0, 0],
      scales: { x: { time: false, distr: 3 }, y: { distr: 3 } },
      axes: [
        { ...axis, label: "spatial frequency in 1/mm", size: 30, values },
        { ...axis, label: "density in nm²·mm²", size: 62, values },
      ],
      series: [
        { label: "frequency" },
        { label: "density", stroke: () => colour("series-rms"), width: 2, points: { show: false } },
      ],
      legend: { show: false },
      hooks: { setCursor: [(self) => this.#tell(self.cursor.idx)] },
      cursor: { y: false, drag: { x: false, y: false } },
    }, [[], []], place);
    new ResizeObserver(() => place.clientWidth > 0 && chart.setSize(size())).observe(place);
    return chart;
  }
}
