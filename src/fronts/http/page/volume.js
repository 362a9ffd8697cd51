// The volume that was measured: three slices with sliders, its faces by their deviation, the cells at fault.

import { diverging } from "./colours.js";
import { byId, setRows, setText } from "./dom.js";
import { DASH, count, fixed, significant } from "./format.js";
import { areRight } from "./lattice.js";
import { LAYERS } from "./layers.js";
import { SliceView } from "./slice.js";
import { SolidView } from "./solid.js";
import { askStation } from "./token.js";

const AXES = ["x", "y", "z"];
const KINDS = {
  forbidden: ["forbidden cell", "cases 9 to 14"],
  unpaired: ["cell of case 8", "without its partner"],
  c1: ["C1", "two samples on the diagonal of a face"],
  c2: ["C2", "two samples on a space diagonal against six"],
};

export class Volume {
  #token;
  #key = null; // Session and state of what is shown.
  #busy = false;
  #view = null;
  #slices = [];
  #solid = new SolidView();
  #chosen = null;

  constructor(token) {
    this.#token = token;
    this.#slices = AXES.map((name, axis) => new SliceView(name, axis, token));
    for (const slice of this.#slices) {
      slice.onMove = () => this.#drawSolid();
      slice.onPick = (place) => this.#goTo(place);
    }
    for (const id of ["volume-contour", "volume-points", "volume-cells"]) byId(id).onchange = () => this.draw();
    for (const input of document.querySelectorAll("#volume-faces input")) input.onchange = () => this.#drawSolid();
    byId("flip").addEventListener("change", () => this.draw());
    const rows = byId("volume-table");
    rows.onclick = ({ target }) => this.#choose(target.closest("tbody tr")?.rowIndex - 1);
    rows.onkeydown = (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      this.#choose(event.target.closest("tbody tr")?.rowIndex - 1);
    };
  }

  update(snapshot) {
    this.#sayScale(snapshot);
    const key = snapshot.volume ? `${snapshot.session?.id} ${snapshot.state} ${snapshot.volume.size}` : null;
    byId("volume-card").hidden = key === null;
    if (key !== this.#key && !this.#busy) this.#fetch(key);
  }

  /** Draws all again: the colours, or what is wanted, may be others. */
  draw() {
    if (!this.#view) return;
    const shown = Object.fromEntries(["contour", "points", "cells"].map((what) => [what, byId(`volume-${what}`).checked]));
    const chosen = this.#chosen === null ? null : this.#view.grid.cells[this.#chosen];
    for (const slice of this.#slices) slice.show(this.#colours(), shown, chosen);
    this.#drawSolid();
  }

  async #fetch(key) {
    if (key === null) {
      this.#take(key, null);
      return;
    }
    this.#busy = true;
    const view = await askStation("/api/v1/volume", this.#token);
    this.#busy = false;
    if (view !== undefined) this.#take(key, view);
  }

  #take(key, view) {
    this.#key = key;
    this.#view = view;
    this.#chosen = null;
    setText(byId("volume-empty"), view ? "" : "The station has no volume to look at.");
    byId("volume-shown").hidden = !view;
    if (!view) return;
    for (const slice of this.#slices) slice.take(view);
    this.#solid.take(view);
    byId("volume-faces").hidden = view.faces.length < 2;
    this.#say(view);
    this.#fill(view.grid);
    this.draw();
  }

  /** The scale of the map, so that one colour means one deviation on the whole page. */
  #scale = 1;

  #sayScale(snapshot) {
    const scale = LAYERS.deviation.scale(snapshot.map?.values_nm ?? []);
    if (scale === this.#scale) return;
    this.#scale = scale;
    this.draw();
  }

  #colours() {
    return { table: diverging(byId("flip").checked), scale: this.#scale };
  }

  #drawSolid() {
    if (!this.#view) return;
    const wanted = document.querySelector("#volume-faces input:checked")?.value ?? "both";
    this.#solid.show({
      ...this.#colours(),
      faces: this.#view.faces.map((_, index) => wanted === "both" || wanted === String(index)),
      at: this.#slices.map((slice) => slice.index),
      cells: byId("volume-cells").checked,
      chosen: this.#chosen,
    });
  }

  #choose(index) {
    if (!(index >= 0)) return;
    this.#chosen = this.#chosen === index ? null : index;
    this.#fill(this.#view.grid);
    if (this.#chosen !== null) this.#goTo(this.#view.grid.cells[index].at);
    this.draw();
  }

  /** Moves all slices to a place, in samples. */
  #goTo(place) {
    this.#slices.forEach((slice, axis) => slice.move(Math.floor(place[axis])));
    this.#drawSolid();
  }

  #say(view) {
    const smoothed = view.smoothing_mm > 0 ? `grey values smoothed by ${significant(1000 * view.smoothing_mm)} µm` : "grey values as scanned";
    const faces = view.faces.map(({ points, gathered }, index) =>
      `${["first", "second"][index]} face ${count(points)} points${gathered > 1 ? `, in cubes of ${gathered} spacings` : ""}`);
    const [black, white] = view.shown_range.map((value) => significant(value, 4));
    const slanted = areRight(view.steps_mm) ? "" : " The axes of the grid are not at right angles: slices are drawn as if they were.";
    setText(byId("volume-note"), `${view.size.map(count).join(" × ")} samples, ${smoothed}, black ${black} to white ${white}; line at the threshold ${significant(view.threshold, 5)}; ${faces.join("; ") || "no face"}.${slanted}`);
    const { forbidden, case8_unpaired: unpaired, c1, c2, why, left_out: leftOut, near_missing: gaps } = view.grid;
    const found = `${count(forbidden)} forbidden cells, ${count(unpaired)} of case 8 without a partner, ${count(c1)} C1, ${count(c2)} C2`;
    const open = gaps > 0 ? ` Open: ${count(gaps)} cells of the surface lie beside samples without a value.` : "";
    const more = leftOut > 0 ? ` ${count(leftOut)} more are not listed.` : "";
    setText(byId("volume-grid"), `Grid: ${found}. ${why.charAt(0).toUpperCase()}${why.slice(1)}.${open}${more}`);
    byId("volume-grid").classList.toggle("bad", view.grid.contradicted);
  }

  #fill({ cells }) {
    byId("volume-table-frame").hidden = cells.length === 0;
    setRows(byId("volume-table"), cells.map(({ kind, at_mm: at, code }, index) => ({
      key: String(index + 1),
      className: index === this.#chosen ? "chosen" : "",
      cells: [
        String(index + 1),
        { text: KINDS[kind][0], small: KINDS[kind][1] },
        { text: at.map((mm) => fixed(mm, 3)).join(", "), className: "num" },
        { text: code === undefined ? DASH : code.toString(2).padStart(8, "0"), className: "num" },
      ],
    })));
    for (const row of byId("volume-table").tBodies[0].rows) row.tabIndex = 0;
  }
}
