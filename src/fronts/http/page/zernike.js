// The deviation in Zernike terms, as bars and as a table.

import { barChart } from "./bars.js";
import { byId, colour, setRows, setText } from "./dom.js";
import { count, known, nm, signedNm } from "./format.js";
import { largest, listed, ofSource, termBars } from "./series.js";

const HEIGHT = 230;
const NAMED = 3;

export class Zernike {
  #chart = null;
  #found = null; // The figures, and why there are none.
  #removed = new Set(); // Numbers of terms that are removed from what is shown.

  update(form) {
    const found = form?.zernike ?? null;
    const why = form?.zernike_unknown;
    setText(byId("zernike-empty"), why ? `Not known: ${why}.` : "No fit yet.");
    // The final figures stay the same from snapshot to snapshot.
    if (JSON.stringify(found) === JSON.stringify(this.#found)) return;
    this.#found = found;
    this.#draw();
  }

  /** Takes the deviation without terms, or null for that as fitted. */
  setView(view) {
    const removed = new Set(view?.terms.map((term) => term.index) ?? []);
    if ([...removed].join() === [...this.#removed].join()) return;
    this.#removed = removed;
    this.#draw();
  }

  recolour() {
    this.#chart?.redraw(false, true);
  }

  #draw() {
    const found = this.#found;
    for (const id of ["zernike", "zernike-all"]) byId(id).hidden = found === null;
    byId("zernike-empty").hidden = found !== null;
    byId("zernike").dataset.terms = found?.terms.length ?? 0;
    setText(byId("zernike-of"), found ? `${found.scheme}, nm of surface, ${found.normalisation}; as fitted, ${ofSource(found.source)}` : "");
    if (found) {
      this.#chart ??= this.#build();
      this.#chart.setData(termBars(found.terms, this.#removed));
      setRows(byId("zernike-terms"), found.terms.map((term) => ({
        key: term.index,
        cells: [
          count(term.index),
          this.#removed.has(term.index) ? { text: term.name, small: "removed from what is shown" } : term.name,
          { text: `${term.n}, ${String(term.m).replace("-", "−")}`, className: "num" },
          { text: signedNm(term.value_nm), className: "num" },
        ],
      })));
    }
    this.#tell(null);
  }

  #tell(at) {
    const found = this.#found;
    const term = known(at) ? found?.terms[at] : null;
    setText(byId("zernike-readout"), !found ? "" : term ? this.#say(term) : this.#summary());
  }

  #say({ index, name, n, m, value_nm: value }) {
    const removed = this.#removed.has(index) ? ", removed from what is shown" : "";
    return `${index}: ${name} (n ${n}, m ${String(m).replace("-", "−")}): ${signedNm(value)} nm${removed}`;
  }

  #summary() {
    const { terms, radius_mm: radius, residual_rms_nm: residual, indeterminate } = this.#found;
    const named = largest(terms, NAMED).map((term) => `${term.name} ${signedNm(term.value_nm)} nm`);
    const lost = indeterminate.length ? `; ${count(indeterminate.length)} not told apart by the places` : "";
    return `Largest: ${listed(named)}. RMS beyond them all ${nm(residual)} nm; disc of ${Number(radius.toPrecision(5))} mm radius${lost}.`;
  }

  #build() {
    return barChart(byId("zernike"), {
      height: HEIGHT,
      share: 0.72,
      series: [
        { fill: () => colour("above"), line: () => colour("above") },
        { fill: () => colour("below"), line: () => colour("below") },
        { fill: () => "transparent", line: () => colour("edge") },
      ],
      x: { label: "number of the term", incrs: [1, 2, 5, 10] },
      y: { label: "coefficient in nm" },
      moved: (at) => this.#tell(at),
      xRange: () => {
        const terms = this.#found?.terms ?? [];
        return terms.length ? [terms[0].index - 0.6, terms.at(-1).index + 0.6] : [0, 1];
      },
    });
  }
}
