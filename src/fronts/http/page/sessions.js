// The list of sessions: what was measured before stays reachable. Rows of a table with the files they left.

import { byId, icon, make, setText } from "./dom.js";
import { DASH, count, nm } from "./format.js";
import { Files } from "./files.js";

const WORDS = { pass: "PASS", fail: "FAIL", undecided: "UNDECIDED", none: "NO LIMITS" };
const ICONS = { pass: "pass", fail: "fail", undecided: "undecided", none: "idle" };
/** Listed at first; the rest on demand. */
const FEW = 8;

export class Sessions {
  #files;
  #key = null;
  #all = false;
  #found = [];
  /** The session that runs: it has no results yet. */
  #running = null;

  constructor(token, say) {
    this.#files = new Files(token, say);
    byId("sessions-all").onclick = () => {
      this.#all = true;
      this.#draw();
    };
  }

  /** Asks again when a session began or left its files. */
  update(snapshot) {
    this.#running = ["measuring", "finishing"].includes(snapshot.state) ? snapshot.session?.id : null;
    const key = `${snapshot.session?.id}|${snapshot.outputs?.files.join()}|${snapshot.state === "failed"}`;
    if (key === this.#key) return;
    this.#key = key;
    this.#ask();
  }

  async #ask() {
    const answer = await this.#files.request("sessions");
    if (!answer) return;
    this.#found = (await answer.json()).sessions;
    this.#draw();
  }

  #draw() {
    const ended = this.#found.filter(({ id }) => id !== this.#running);
    const shown = this.#all ? ended : ended.slice(0, FEW);
    byId("sessions-card").hidden = ended.length === 0;
    byId("sessions-all").hidden = shown.length === ended.length;
    setText(byId("sessions-all"), `All ${count(ended.length)}`);
    byId("sessions").tBodies[0].replaceChildren(...shown.map((session) => this.#row(session)));
  }

  #row(session) {
    const { id, started, label, verdict, ended } = session;
    const row = make("tr");
    const cell = (text, className = "") => row.append(make("td", className, text));
    const head = make("th", "", started ? new Date(started).toLocaleString("en-GB") : DASH);
    head.scope = "row";
    head.append(make("small", "", id));
    row.append(head);
    cell([label.part, label.serial].filter(Boolean).join(", no. ") || DASH);
    cell(label.operator ?? DASH);
    const word = make("td", `state verdict-${verdict ?? "unknown"}`, verdict ? WORDS[verdict] : "no report");
    if (verdict) word.prepend(icon(ICONS[verdict]));
    row.append(word);
    cell(ended ?? DASH);
    cell(count(session.points), "num");
    cell(nm(session.pv_nm), "num");
    cell(nm(session.rms_nm), "num");
    const files = make("td", "files");
    for (const [name, title] of [["report.html", "Report"], ["report.json", "Figures (JSON)"], ["qif.xml", "QIF"]]) {
      if (session.files.includes(name)) files.append(this.#button(id, name, title));
    }
    row.append(files);
    return row;
  }

  #button(id, name, title) {
    const button = make("button", "plain small", title);
    button.type = "button";
    button.setAttribute("aria-label", `${title} of ${id}`);
    button.onclick = () => this.#files.open(`sessions/${id}/${name}`);
    return button;
  }
}
