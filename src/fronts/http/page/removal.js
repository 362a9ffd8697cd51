// Zernike terms taken out of what is shown: chosen here, removed by the station, never of the verdict.

import { byId, setText } from "./dom.js";
import { count, nm } from "./format.js";
import { listed } from "./series.js";
import { headersWith } from "./token.js";

const ASK_MS = 500;

/**
 * Asks for the deviation without the chosen terms whenever it changed. What is shown says itself what was
 * removed, so that no figure stands beside a switch that it does not know of.
 */
export class Removal {
  #token;
  #onView;
  #snapshot = null;
  #asked = null; // The choice and the state that was answered last.
  #askedAt = 0;
  #busy = false;
  #view = null;

  /** Calls `onView(view or null)`; null means as fitted. */
  constructor(token, onView) {
    this.#token = token;
    this.#onView = onView;
    for (const input of this.#inputs()) {
      input.onchange = () => {
        this.#askedAt = 0;
        this.#ask();
      };
    }
    setInterval(() => this.#ask(), ASK_MS / 2);
  }

  update(snapshot) {
    const another = snapshot.session?.id !== this.#snapshot?.session?.id;
    this.#snapshot = snapshot;
    // Nothing of another part, nor of one without a fit, may stand under the switches.
    if (another || !snapshot.form) this.#show(null, "");
    this.#ask();
  }

  #inputs() {
    return [...document.querySelectorAll("#remove input")];
  }

  async #ask() {
    const snapshot = this.#snapshot;
    if (this.#busy || !snapshot?.form) return;
    const chosen = this.#inputs().filter((input) => input.checked).map((input) => input.value);
    const key = [snapshot.session?.id, snapshot.state, snapshot.points.used, ...chosen].join(" ");
    if (key === this.#asked || performance.now() - this.#askedAt < ASK_MS) return;
    if (chosen.length === 0) {
      this.#asked = key;
      this.#show(null, "");
      return;
    }
    this.#busy = true;
    this.#askedAt = performance.now();
    const answer = await this.#fetch(chosen);
    this.#busy = false;
    // A session that began meanwhile is asked about anew.
    if (!answer || this.#snapshot.session?.id !== snapshot.session?.id) return;
    this.#asked = key;
    if (answer.ok) this.#show(answer.found, "");
    else this.#show(null, `${listed(chosen)} cannot be removed: ${answer.found.error}`);
  }

  /** Null where the station is gone, as the stream tells; there is another try soon. */
  async #fetch(chosen) {
    const headers = headersWith(this.#token);
    try {
      const answer = await fetch(`/api/v1/form?remove=${chosen.join(",")}`, { headers });
      return { ok: answer.ok, found: await answer.json() };
    } catch {
      return null;
    }
  }

  #show(view, trouble) {
    byId("removed").hidden = view === null;
    setText(byId("removed-message"), trouble);
    if (view) {
      const what = view.source === "points" ? "" : " of the means of cells";
      setText(byId("removed-terms"), `Less ${listed(view.removed)}:`);
      setText(byId("removed-figures"), `PV ${nm(view.pv_nm)} nm, RMS ${nm(view.rms_nm)} nm${what}`);
      setText(byId("removed-of"), `at ${count(view.as_of_points)} points${view.provisional ? ", provisional" : ""}. The verdict is of the deviation as fitted.`);
    }
    if (view === this.#view) return;
    this.#view = view;
    this.#onView(view);
  }
}
