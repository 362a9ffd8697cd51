// The scan that the station drives: its state, where the probe is, what follows, and a stop.

import { byId, setRows, setText } from "./dom.js";
import { DASH, count, duration, known } from "./format.js";
import { headersWith } from "./token.js";

export class Scan {
  #token;
  #say;

  constructor(token, say) {
    this.#token = token;
    this.#say = say;
    byId("arm-scan").onclick = () => this.#command("arm", "scan armed: the machine moves");
    byId("halt-scan").onclick = () => this.#command("stop", "scan stopped");
  }

  update({ scan, state }) {
    byId("scan-card").hidden = !scan;
    if (!scan) return;
    const may = this.#token !== null;
    byId("arm-scan").hidden = !may;
    byId("halt-scan").hidden = !may;
    byId("arm-scan").disabled = state !== "measuring" || scan.state !== "disarmed";
    const word = byId("scan-state");
    setText(word, scan.state);
    word.dataset.scan = scan.state;
    setText(byId("scan-text"), scan.text);
    const bar = byId("scan-progress");
    bar.max = Math.max(scan.pieces, 1);
    bar.value = scan.pieces_done;
    const row = (key, name, text) => ({ key, cells: [name, { text, className: "num" }] });
    setRows(byId("scan-table"), [
      row("place", "Probe at", place(scan.place_mm)),
      row("next", "Goes to", place(scan.next_mm)),
      row("pass", "Pass", count(scan.pass)),
      row("pieces", "Lines and stops", `${count(scan.pieces_done)} of ${count(scan.pieces)}`),
      row("points", "Points of the plan", count(scan.points)),
      row("spent", "Time", known(scan.time_limit_s) ? `${duration(scan.spent_s)} of ${duration(scan.time_limit_s)}` : duration(scan.spent_s)),
    ]);
  }

  async #command(name, done) {
    const headers = headersWith(this.#token);
    try {
      const answer = await fetch(`/api/v1/scan/${name}`, { method: "POST", headers });
      if (answer.ok) return this.#say(done);
      const problem = await answer.json();
      this.#say([problem.error, problem.hint].filter(Boolean).join("; "), true);
    } catch (error) {
      this.#say(`no answer from the station: ${error.message}`, true);
    }
  }
}

const place = (place_mm) => (place_mm ? `x ${place_mm[0].toFixed(3)}, y ${place_mm[1].toFixed(3)} mm` : DASH);
