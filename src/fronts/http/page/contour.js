// The contour of the session: fetched when there is a newer one, drawn over the map, and said in words.

import { byId, setText } from "./dom.js";
import { count, fixed, known, significant } from "./format.js";
import { Frames } from "./frames.js";
import { knots } from "./knots.js";
import { askStation } from "./token.js";

export class Contour {
  #token;
  #snapshot = null;
  #key = null; // Session and points of what is shown.
  #busy = false;
  #found = null; // As the station tells it, in the measured frame.
  /** Called when something else is to be drawn. */
  onChange = () => {};

  constructor(token) {
    this.#token = token;
    byId("show-contour").onchange = () => this.onChange();
  }

  /** Lines, ends and junctions in the part frame; null where there are none, or they are not wanted. */
  get shown() {
    if (!this.#found || !this.#fits() || !byId("show-contour").checked) return null;
    const frames = Frames.of(this.#snapshot);
    const toPart = (place) => frames.measuredToPart(place);
    const { chains } = this.#found.contour;
    const { ends, junctions } = knots(chains);
    return {
      lines: chains.map(({ closed, points_mm }) => ({ closed, places: points_mm.map(toPart) })),
      ends: ends.map(toPart),
      junctions: junctions.map(toPart),
    };
  }

  update(snapshot) {
    this.#snapshot = snapshot;
    if (!snapshot.contour && this.#found) this.#take(null, null);
    this.#say();
    this.#fetch();
  }

  /** Whether its places are x and y of the map. */
  #fits() {
    return this.#found.in_xy && !this.#snapshot.mesh?.projection;
  }

  #take(key, found) {
    this.#key = key;
    this.#found = found;
    this.#say();
    this.onChange();
  }

  async #fetch() {
    const offered = this.#snapshot.contour;
    if (this.#busy || !offered) return;
    const key = `${this.#snapshot.session?.id} ${offered.as_of_points}`;
    if (key === this.#key) return;
    this.#busy = true;
    const found = await askStation("/api/v1/contour", this.#token);
    this.#busy = false;
    if (found !== undefined) this.#take(key, found);
  }

  #say() {
    byId("show-contour-label").hidden = !this.#found?.contour.chains.length;
    setText(byId("contour-note"), this.#found ? this.#words() : "");
  }

  #words() {
    const { as_of_points: asOf, contour } = this.#found;
    const newer = Math.max(this.#snapshot.points.received - asOf, 0);
    const when = `As of ${count(asOf)} points${newer > 0 ? `, ${count(newer)} newer ones not seen yet` : ""}.`;
    const why = contour.unknown.find((text) => text.startsWith("contour: "));
    if (why) return `No contour: ${why.slice("contour: ".length)}. ${when}`;
    const closed = contour.chains.filter((chain) => chain.closed).length;
    const length = contour.chains.reduce((sum, chain) => sum + chain.length_mm, 0);
    const { ends, junctions } = knots(contour.chains);
    const parts = [
      `Contour (${contour.method}): ${count(closed)} closed and ${count(contour.chains.length - closed)} open lines, ${significant(length)} mm`,
      `${count(ends.length)} ends ○ and ${count(junctions.length)} junctions ■`,
    ];
    if (known(contour.area_mm2)) parts.push(`area ${significant(contour.area_mm2)} mm²`);
    if (contour.circle) parts.push(`diameter ${fixed(contour.circle.diameter_mm, 4)} mm, roundness ${significant(contour.circle.roundness_mm)} mm`);
    if (contour.deviation) parts.push(`deviation ${significant(contour.deviation.least_mm)} to ${significant(contour.deviation.largest_mm)} mm`);
    const elsewhere = this.#fits() ? "" : " It lies in another plane than the map, and is not drawn there.";
    return `${parts.join("; ")}. ${when}${elsewhere}`;
  }
}
