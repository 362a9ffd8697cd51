// Start, stop and the files: the requests of the page.

import { byId, setText } from "./dom.js";
import { forgetToken } from "./token.js";

const SURE_MS = 4000;
const SAID_MS = 8000;

export class Control {
  #token;
  #sure = null;
  #said = null;

  constructor(token) {
    this.#token = token;
    byId("start").onclick = () => this.#command("start");
    byId("stop").onclick = () => this.#stop();
    byId("get-report").onclick = () => this.#download("report", "report.json");
    byId("get-mesh").onclick = () => this.#download("mesh.ply", "mesh.ply");
    this.#showRole();
  }

  update(snapshot) {
    const running = snapshot.state === "measuring";
    byId("start").disabled = running || snapshot.state === "finishing";
    byId("stop").disabled = !running;
    byId("get-report").disabled = snapshot.state !== "complete";
    byId("get-mesh").disabled = snapshot.mesh.vertices === 0;
    if (!running) this.#ask(false);
  }

  #showRole() {
    const may = this.#token !== null;
    byId("start").hidden = !may;
    byId("stop").hidden = !may;
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

  async #command(name) {
    const answer = await this.#request(`session/${name}`, "POST");
    if (answer) this.#say(`${name} accepted`);
  }

  async #download(path, fileName) {
    const answer = await this.#request(path, "GET");
    if (!answer) return;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await answer.blob());
    link.download = fileName;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    this.#say(`${fileName} saved`);
  }

  async #request(path, method) {
    const headers = this.#token === null ? {} : { Authorization: `Bearer ${this.#token}` };
    try {
      const answer = await fetch(`/api/v1/${path}`, { method, headers });
      if (answer.ok) return answer;
      const problem = await answer.json();
      if (method === "POST" && answer.status === 403) this.#lose();
      this.#say([problem.error, problem.hint].filter(Boolean).join("; "), true);
    } catch (error) {
      this.#say(`no answer from the station: ${error.message}`, true);
    }
    return null;
  }

  #lose() {
    forgetToken();
    this.#token = null;
    this.#showRole();
  }

  #say(text, bad = false) {
    const line = byId("control-message");
    setText(line, text);
    line.className = bad ? "bad" : "";
    line.hidden = false;
    clearTimeout(this.#said);
    // What went wrong stays until something else is said.
    if (!bad) this.#said = setTimeout(() => { line.hidden = true; }, SAID_MS);
  }
}
