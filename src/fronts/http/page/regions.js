// The regions to measure next: outlines for the map, and a table of what each needs.

import { byId, setRows } from "./dom.js";
import { DASH, known, significant } from "./format.js";
import { rings, within } from "./frames.js";

const withUnit = (value, unit) => (known(value) ? `${significant(value)} ${unit}` : DASH);

export class Regions {
  #regions = [];
  #chosen = null;
  /** Called when another region is chosen. */
  onChoice = () => {};

  constructor() {
    byId("regions").onclick = ({ target }) => this.#toggle(target.closest("tbody tr")?.rowIndex - 1);
    byId("show-regions").onchange = () => this.onChoice();
  }

  /** What the map draws, with lines in the part frame. */
  get shown() {
    return byId("show-regions").checked ? this.#regions : [];
  }

  /** Index of the chosen one, or null. */
  get chosen() {
    return this.#chosen;
  }

  /** Takes the regions of a snapshot, in the measured frame; a station may have none to tell. */
  update(next, frames) {
    this.#regions = (next ?? []).map((region) => {
      const lines = rings(region.polygons ?? region.polygon ?? [])
        .map((line) => line.map((place) => frames.measuredToPart(place)));
      const at = region.at_mm ? frames.measuredToPart(region.at_mm) : lines[0]?.[0];
      return { region, lines, at };
    }).filter(({ at }) => at);
    if (this.#chosen >= this.#regions.length) this.#chosen = null;
    byId("regions-frame").hidden = this.#regions.length === 0;
    byId("show-regions-label").hidden = this.#regions.length === 0;
    this.#fill();
  }

  /** The region at a place of the part frame, in words; null without one. */
  at(place) {
    const index = this.#find(place);
    if (index < 0) return null;
    const { area_mm2, epsilon_max, spacing_needed_mm } = this.#regions[index].region;
    return `region ${index + 1}: ${withUnit(area_mm2, "mm²")}, ε up to ${significant(epsilon_max)}, `
      + `needs a spacing of ${withUnit(spacing_needed_mm, "mm")}`;
  }

  /** Chooses the region at a place of the part frame, if there is one. */
  choose(place) {
    const index = this.#find(place);
    if (index >= 0) this.#toggle(index);
  }

  #find(place) {
    return this.shown.findIndex(({ lines }) => within(lines, place));
  }

  #toggle(index) {
    if (!(index >= 0)) return;
    this.#chosen = this.#chosen === index ? null : index;
    this.#fill();
    this.onChoice();
  }

  #fill() {
    setRows(byId("regions"), this.#regions.map(({ region }, index) => ({
      key: String(index + 1),
      className: index === this.#chosen ? "chosen" : "",
      cells: [
        String(index + 1),
        ...[
          withUnit(region.area_mm2, "mm²"),
          significant(region.epsilon_max),
          withUnit(region.gap_max_mm, "mm"),
          withUnit(region.spacing_needed_mm, "mm"),
        ].map((text) => ({ text, className: "num" })),
      ],
    })));
  }
}
