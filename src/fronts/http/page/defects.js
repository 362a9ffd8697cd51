// Defects: marks for the map, a table of what each is, and which way the surface bends.

import { byId, setRows, setText } from "./dom.js";
import { DASH, count, fixed, known, percent, signedNm, significant } from "./format.js";

/** How near to a mark a press chooses it, in shares of the map's width. */
const NEAR = 0.02;

export class Defects {
  #defects = [];
  #chosen = null;
  /** Called when another defect is chosen, with its place in the part frame, or null. */
  onChoice = () => {};

  constructor() {
    byId("defects").onclick = ({ target }) => this.#toggle(target.closest("tbody tr")?.rowIndex - 1);
    byId("defects").onkeydown = (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      this.#toggle(event.target.closest("tbody tr")?.rowIndex - 1);
    };
    byId("show-defects").onchange = () => this.onChoice(null);
  }

  /** What the map draws, in the part frame. */
  get shown() {
    return byId("show-defects").checked ? this.#defects : [];
  }

  /** Index of the chosen one, or null. */
  get chosen() {
    return this.#chosen;
  }

  /** Takes what a snapshot says; there is nothing to say before the session ended. */
  update(snapshot, frames) {
    this.#defects = (snapshot.defects ?? []).map((defect) => {
      const at = frames.measuredToPart(defect.at_mm);
      return { defect, at, line: lineOf(defect, at, frames) };
    });
    if (this.#chosen >= this.#defects.length) this.#chosen = null;
    byId("defects-frame").hidden = this.#defects.length === 0;
    byId("show-defects-label").hidden = this.#defects.length === 0;
    setText(byId("defects-note"), noteOf(snapshot));
    setText(byId("bends"), bendsOf(snapshot));
    this.#fill();
  }

  /** The defect at a place of the part frame, in words; null without one. */
  at(spot, wide_mm) {
    const index = this.#find(spot, wide_mm);
    if (index < 0) return null;
    const { defect } = this.#defects[index];
    return `defect ${index + 1}: ${defect.kind}, ${signedNm(defect.height_nm)} nm, ${sizeOf(defect)}`;
  }

  /** Chooses the defect at a place of the part frame; says whether there is one. */
  choose(spot, wide_mm) {
    const index = this.#find(spot, wide_mm);
    if (index >= 0) this.#toggle(index);
    return index >= 0;
  }

  #find([x, y], wide_mm) {
    const away = this.shown.map(({ at }) => Math.hypot(at[0] - x, at[1] - y));
    const nearest = away.indexOf(Math.min(...away));
    return nearest >= 0 && away[nearest] <= NEAR * wide_mm ? nearest : -1;
  }

  #toggle(index) {
    if (!(index >= 0)) return;
    this.#chosen = this.#chosen === index ? null : index;
    this.#fill();
    this.onChoice(this.#chosen === null ? null : this.#defects[index].at);
  }

  #fill() {
    setRows(byId("defects"), this.#defects.map(({ defect, at }, index) => ({
      key: String(index + 1),
      className: index === this.#chosen ? "chosen" : "",
      cells: [
        String(index + 1),
        { text: defect.kind, small: defect.on_border ? "cut off" : "" },
        ...[signedNm(defect.height_nm), sizeOf(defect).replace(/ mm$/, ""), at.map((mm) => fixed(mm, 2)).join(", "), fixed(defect.significance, 0)]
          .map((text) => ({ text, className: "num" })),
      ],
    })));
    for (const row of byId("defects").tBodies[0].rows) row.tabIndex = 0;
  }
}

/** Both ends of what is long, in the part frame; null of what is not. */
function lineOf({ shape, length_mm, orientation_deg }, at, frames) {
  if (shape !== "straight" || !known(length_mm) || !known(orientation_deg)) return null;
  const [u, v] = frames.toMesh(at);
  const turn = (orientation_deg * Math.PI) / 180;
  const half = [Math.cos(turn), Math.sin(turn)].map((part) => (part * length_mm) / 2);
  return [-1, 1].map((end) => frames.toPart([u + end * half[0], v + end * half[1]]));
}

function sizeOf({ area_mm2, length_mm, width_mm }) {
  if (known(length_mm) && known(width_mm)) return `${significant(length_mm)} × ${significant(width_mm)} mm`;
  if (known(length_mm)) return `${significant(length_mm)} mm`;
  return known(area_mm2) ? `${significant(area_mm2)} mm²` : DASH;
}

function noteOf({ state, defects, defects_more, defects_search, defects_unknown }) {
  if (state !== "complete") return state === "measuring" ? "Defects are looked for when the last point has landed." : "";
  if (defects_unknown) return `Defects not looked for: ${defects_unknown}.`;
  if (!defects) return "";
  const { threshold_sigmas, sigma_nm, largest_mm } = defects_search ?? {};
  const all = defects.length + defects_more;
  const limits = `beyond ${significant(threshold_sigmas, 2)} σ of ${significant(sigma_nm)} nm, up to ${significant(largest_mm)} mm wide`;
  const listed = defects_more > 0 ? ` The ${count(defects.length)} clearest are listed.` : "";
  return `${all === 0 ? "No defects" : all === 1 ? "1 defect" : `${count(all)} defects`} ${limits}.${listed}`;
}

function bendsOf({ state, partition, partition_unknown }) {
  if (state !== "complete") return "";
  if (partition_unknown) return `How it bends is not known: ${partition_unknown}.`;
  if (!partition) return "";
  const shares = Object.entries(partition.shares).sort(([, a], [, b]) => b - a);
  const text = shares.map(([name, share]) => `${name} ${percent(share)}`).join(", ");
  return `Bends, over squares of ${significant(partition.patch_mm)} mm: ${text}.`;
}
