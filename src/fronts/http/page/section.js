// The section that is looked at: chosen by numbers or by dragging, asked for while it changes.

import { byId, setText } from "./dom.js";
import { Frames } from "./frames.js";
import { Profile } from "./profile.js";
import { headersWith } from "./token.js";

const ASK_MS = 500;
const FIELDS = {
  line: ["x1", "y1", "x2", "y2"],
  radius: ["angle"],
  circle: ["r"],
  plane: ["nx", "ny", "nz", "px", "py", "pz"],
};
const CIRCLE_STEPS = 180;

export class SectionView {
  #token;
  #map;
  #profile;
  #frames = new Frames(null, null);
  #snapshot = null;
  #kind = "line";
  #inSpace = false; // A surface in space is cut by planes alone, and others by paths.
  #chosen = false; // Whether a person chose the path; until then it goes across the map.
  #asked = null; // What was asked for and of how much, to ask again only for something new.
  #busy = false;

  constructor(token, map) {
    this.#token = token;
    this.#map = map;
    this.#profile = new Profile((place) => this.#draw(place));
    for (const input of document.querySelectorAll("#section-kind input")) {
      input.onchange = () => this.#choose(input.value);
      if (input.checked) this.#kind = input.value;
    }
    for (const input of document.querySelectorAll("#section-fields input")) {
      input.oninput = () => {
        this.#chosen = true;
        this.#changed();
      };
    }
    map.onLine = (from, to) => this.#drag(from, to);
    this.#showFields();
    setInterval(() => this.#ask(), ASK_MS);
  }

  recolour() {
    this.#profile.recolour();
  }

  update(snapshot) {
    // A new session has a new part in it, which may lie elsewhere.
    if (snapshot.session?.id !== this.#snapshot?.session?.id) this.#profile.show(null);
    this.#snapshot = snapshot;
    this.#frames = Frames.of(snapshot);
    setText(byId("section-frame"), this.#frames.name);
    this.#showKinds(Boolean(snapshot.mesh.reconstruction));
    if (!this.#chosen) this.#acrossMap();
  }

  #choose(kind) {
    this.#kind = kind;
    this.#chosen = true;
    document.querySelector(`#section-kind input[value=${kind}]`).checked = true;
    this.#showFields();
    this.#changed();
  }

  /** Offers planes in space, and paths elsewhere. */
  #showKinds(inSpace) {
    if (inSpace === this.#inSpace) return;
    this.#inSpace = inSpace;
    this.#map.takesLines = !inSpace;
    setText(byId("section-how"), inSpace ? "as fitted; give a plane" : "as fitted; drag over the map, or choose");
    for (const input of document.querySelectorAll("#section-kind input")) {
      input.closest("label").hidden = (input.value === "plane") !== inSpace;
    }
    this.#choose(inSpace ? "plane" : "line");
    this.#chosen = false;
  }

  #drag(from, to) {
    if (this.#inSpace) return;
    const ends = [from, to].flatMap((place) => this.#frames.toMesh(place));
    this.#fill("line", ends);
    this.#choose("line");
  }

  /** Across the middle of the map, and a radius and a circle that fit. */
  #acrossMap() {
    if (this.#inSpace) {
      const place = this.#snapshot.form?.origin?.at_mm ?? [0, 0, 0];
      this.#fill("plane", [0, 0, 1, ...place]);
      return;
    }
    const chart = this.#map.chart;
    if (!chart) return;
    const [x, width] = [chart.x0_mm - chart.dx_mm / 2, chart.nx * chart.dx_mm];
    const [y, height] = [chart.y0_mm - chart.dy_mm / 2, chart.ny * chart.dy_mm];
    const ends = [x, x + width].flatMap((end) => this.#frames.toMesh([end, y + height / 2]));
    this.#fill("line", ends);
    this.#fill("circle", [width / 4]);
    this.#draw(null);
  }

  #fill(kind, values) {
    FIELDS[kind].forEach((name, index) => {
      const input = byId(`section-${name}`);
      if (document.activeElement !== input) input.value = String(Number(values[index].toFixed(4)));
    });
  }

  #showFields() {
    for (const [kind, names] of Object.entries(FIELDS)) {
      for (const name of names) byId(`section-${name}`).closest("label").hidden = kind !== this.#kind;
    }
  }

  #changed() {
    this.#draw(null);
    this.#ask();
  }

  /** The numbers of the chosen path; null while one of them is missing. */
  #numbers() {
    const values = FIELDS[this.#kind].map((name) => byId(`section-${name}`).valueAsNumber);
    return values.every(Number.isFinite) ? values : null;
  }

  /** The centre of the nominal in the frame of the mesh. */
  #centre() {
    return this.#frames.toMesh([0, 0]);
  }

  #query() {
    const numbers = this.#numbers();
    if (!numbers) return null;
    if (this.#kind === "plane") {
      const [a, b, c, x, y, z] = numbers;
      return `plane=${[a, b, c, a * x + b * y + c * z].join(",")}`;
    }
    const about = this.#kind === "circle" ? [...this.#centre(), ...numbers] : numbers;
    return `${this.#kind}=${about.join(",")}`;
  }

  async #ask() {
    const snapshot = this.#snapshot;
    if (this.#busy || !(snapshot?.mesh.triangles > 0)) return;
    const query = this.#query();
    if (!query) {
      setText(byId("section-message"), "A number is missing.");
      return;
    }
    const state = [snapshot.session?.id, snapshot.state, snapshot.mesh.vertices, snapshot.form?.provisional];
    // The centre of a circle moves with the running fit: what is new is what the operator chose.
    const key = [this.#kind, this.#numbers(), ...state].join(" ");
    if (key === this.#asked) return;
    this.#busy = true;
    const kind = this.#kind;
    const answer = await this.#fetch(query);
    this.#busy = false;
    if (!answer) return;
    this.#asked = key;
    this.#profile.show(answer.ok ? answer.found : null);
    byId("section-card").dataset.path = kind;
    const { error, expected } = answer.found;
    setText(byId("section-message"), answer.ok ? "" : [error, expected].filter(Boolean).join("; expected "));
  }

  /** Null where the station is gone, as the stream tells; there is another try soon. */
  async #fetch(query) {
    const headers = headersWith(this.#token);
    try {
      const answer = await fetch(`/api/v1/section?${query}`, { headers });
      return { ok: answer.ok, found: await answer.json() };
    } catch {
      return null;
    }
  }

  /** Draws the path on the map, with a ring where the cursor stands in the profile. */
  #draw(place) {
    const toPart = (one) => this.#frames.toPart(one);
    const onMap = !this.#inSpace;
    this.#map.setSection({ lines: onMap ? [this.#path().map(toPart)] : [], cursor: onMap && place ? toPart(place) : null });
  }

  /** The chosen path as places of the mesh's frame. */
  #path() {
    const numbers = this.#numbers();
    if (!numbers) return [];
    const [x, y] = this.#centre();
    if (this.#kind === "line") return [numbers.slice(0, 2), numbers.slice(2)];
    const around = (radius, angle) => [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
    if (this.#kind === "circle") {
      const step = (2 * Math.PI) / CIRCLE_STEPS;
      return Array.from({ length: CIRCLE_STEPS + 1 }, (_, k) => around(numbers[0], k * step));
    }
    const chart = this.#map.chart;
    const reach = chart ? Math.hypot(chart.nx * chart.dx_mm, chart.ny * chart.dy_mm) : 0;
    return [[x, y], around(reach, (numbers[0] * Math.PI) / 180)];
  }
}
