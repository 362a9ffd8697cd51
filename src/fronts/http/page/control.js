// Start, stop and the files of the session shown: the requests of the page.

import { byId, setText } from "./dom.js";
import { Files } from "./files.js";
import { forgetToken, headersWith } from "./token.js";

const SURE_MS = 4000;
const SAID_MS = 8000;

export class Control {
  #token;
  #sure = null;
  #said = null;
  #files;
  #shown = null;
  #state = null;

  constructor(token) {
    this.#token = token;
    this.#files = new Files(token, (text, bad) => this.say(text, bad));
    byId("start").onclick = () => this.#command("start", this.#label());
    byId("stop").onclick = () => this.#stop();
    byId("get-report").onclick = () => this.#files.open(`sessions/${this.#shown}/report.html`);
    byId("get-figures").onclick = () => this.#files.save("report");
    byId("get-mesh").onclick = () => this.#files.save("mesh.ply");
    this.#showRole();
  }

  update(snapshot) {
    const running = snapshot.state === "measuring";
    // What was accepted has been done: the state says so itself.
    if (this.#state !== snapshot.state && byId("control-message").className !== "bad") byId("control-message").hidden = true;
    this.#state = snapshot.state;
    byId("start").disabled = running || snapshot.state === "finishing";
    byId("stop").disabled = !running;
    byId("label").disabled = byId("start").disabled;
    byId("get-figures").disabled = snapshot.state !== "complete";
    byId("get-report").disabled = !snapshot.outputs?.files.includes("report.html");
    this.#shown = snapshot.session?.id ?? null;
    byId("get-mesh").disabled = snapshot.mesh.vertices === 0;
    if (!running) this.#ask(false);
  }

  #showRole() {
    const may = this.#token !== null;
    byId("start").hidden = !may;
    byId("stop").hidden = !may;
    byId("label").hidden = !may;
    byId("read-only").hidden = may;
  }

  /** A measurement is not ended by one slip of the hand. */
  #stop() {
    if (this.#sure === null) this.#ask(true);
    else {
      this.#ask(false);
      this.#command("stop");
    }
  }

  #ask(on) {
    clearTimeout(this.#sure);
    this.#sure = on ? setTimeout(() => this.#ask(false), SURE_MS) : null;
    setText(byId("stop"), on ? "Press again to stop" : "Stop session");
  }

  /** What is on the machine, as far as it was entered. */
  #label() {
    const entry = (name) => byId(`label-${name}`).value.trim() || undefined;
    return { part: entry("part"), serial: entry("serial"), operator: entry("operator") };
  }

  async #command(name, body) {
    const headers = headersWith(this.#token);
    try {
      const answer = await fetch(`/api/v1/session/${name}`, { method: "POST", headers, body: body && JSON.stringify(body) });
      if (answer.ok) return this.say(`${name} accepted`);
      const problem = await answer.json();
      if (answer.status === 403) this.#lose();
      this.say([problem.error, problem.hint].filter(Boolean).join("; "), true);
    } catch (error) {
      this.say(`no answer from the station: ${error.message}`, true);
    }
  }

  #lose() {
    forgetToken();
    this.#token = null;
    this.#showRole();
  }

  /** Tells the reader what became of a request. */
  say(text, bad = false) {
    const line = byId("control-message");
    setText(line, text);
    line.className = bad ? "bad" : "";
    line.hidden = false;
    clearTimeout(this.#said);
    // What went wrong stays until something else is said.
    if (!bad) this.#said = setTimeout(() => { line.hidden = true; }, SAID_MS);
  }
}
