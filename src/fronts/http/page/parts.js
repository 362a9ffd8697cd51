// The parts of the session: fetched when there are newer ones, a table of what each is, and their boxes on the map.

import { byId, setRows, setText } from "./dom.js";
import { DASH, count, counted, fixed, known, significant } from "./format.js";
import { Frames } from "./frames.js";
import { askStation } from "./token.js";

export class Parts {
  #token;
  #snapshot = null;
  #key = null; // Session and state of what is shown.
  #busy = false;
  #found = null; // As the station tells it, in the measured frame.
  /** Called when something else is to be drawn. */
  onChange = () => {};

  constructor(token) {
    this.#token = token;
    byId("show-parts").onchange = () => this.onChange();
  }

  /** Boxes of the parts in the part frame, with number and answer; none where they are not wanted. */
  get shown() {
    if (!this.#found || this.#snapshot.mesh?.projection || !byId("show-parts").checked) return [];
    const frames = Frames.of(this.#snapshot);
    return this.#found.parts.map((part, index) => {
      const [low, high] = part.box_mm;
      const corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
      return { number: index + 1, word: wordOf(part), corners: corners.map((place) => frames.measuredToPart(place)) };
    });
  }

  update(snapshot) {
    this.#snapshot = snapshot;
    if (!snapshot.parts && this.#found) this.#take(null, null);
    this.#say();
    this.#fetch();
  }

  #take(key, found) {
    this.#key = key;
    this.#found = found;
    this.#fill();
    this.#say();
    this.onChange();
  }

  async #fetch() {
    const offered = this.#snapshot.parts;
    if (this.#busy || !offered) return;
    // Points that are new change no part: only ends and answers do.
    const key = `${this.#snapshot.session?.id} ${this.#snapshot.state} ${offered.ended} ${offered.waiting}`;
    if (key === this.#key) return;
    this.#busy = true;
    const found = await askStation("/api/v1/parts", this.#token);
    this.#busy = false;
    if (found !== undefined) this.#take(key, found);
  }

  #say() {
    const offered = this.#snapshot?.parts;
    byId("parts-frame").hidden = !offered;
    byId("show-parts-label").hidden = !this.#found?.parts.length;
    setText(byId("parts-note"), offered ? this.#words(offered) : "");
  }

  #words({ ended, open, waiting }) {
    const words = [counted(ended, "part")];
    if (open > 0) words.push(`${count(open)} under the scan now`);
    if (waiting > 0) words.push(`${count(waiting)} being measured`);
    const { islands = 0, island_points: points = 0, late = 0, outside = 0 } = this.#found ?? {};
    if (islands > 0) words.push(`${counted(islands, "island")} of ${counted(points, "point")} ${islands === 1 ? "is no part" : "are no parts"}`);
    if (late + outside > 0) words.push(`${count(late + outside)} points came too late or lie too far away, and are in no part`);
    return `${words.join("; ")}.`;
  }

  #fill() {
    setRows(byId("parts"), (this.#found?.parts ?? []).map((part, index) => {
      const { form, match, centre_mm: centre, loops, points, open } = { ...part, open: part.is_open };
      const nm = (value, u) => (known(value) ? { text: significant(value), small: known(u) ? `± ${significant(u)}` : "", className: "num" } : DASH);
      return {
        key: String(index + 1),
        className: wordOf(part).toLowerCase(),
        cells: [
          String(index + 1),
          { text: match?.name ?? DASH, small: match?.reason ?? (open ? "may be cut off by the end of the scan" : "") },
          wordOf(part),
          nm(form?.pv_nm, form?.u_pv_nm),
          nm(form?.rms_nm, form?.u_rms_nm),
          { text: centre.slice(0, 2).map((mm) => fixed(mm, 2)).join(", "), className: "num" },
          { text: count(loops), className: "num" },
          { text: count(points), className: "num" },
        ],
      };
    }));
  }
}

/** The answer on a part: its verdict where its fit confirms what it is. */
export function wordOf({ match, form }) {
  if (!match) return DASH;
  if (match.verdict === "unknown") return "unknown";
  if (!form) return "not measured";
  return { pass: "PASS", fail: "FAIL", undecided: "UNDECIDED" }[form.verdict.status] ?? "no limits";
}
