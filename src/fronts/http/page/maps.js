// The maps of the sampling: fetched only where they are looked at, and only when they changed.

import { askStation } from "./token.js";

/** Calls `onMaps(maps or null)`. */
export class Maps {
  #token;
  #onMaps;
  #wanted = false;
  #snapshot = null;
  #key = null; // Session and version of what is shown.
  #busy = false;

  constructor(token, onMaps) {
    this.#token = token;
    this.#onMaps = onMaps;
  }

  /** Whether anybody looks at them. */
  want(wanted) {
    this.#wanted = wanted;
    this.#fetch();
  }

  update(snapshot) {
    this.#snapshot = snapshot;
    if (!snapshot.maps && this.#key !== null) {
      this.#key = null;
      this.#onMaps(null);
    }
    this.#fetch();
  }

  async #fetch() {
    const offered = this.#snapshot?.maps;
    if (!this.#wanted || this.#busy || !offered) return;
    const key = `${this.#snapshot.session?.id} ${offered.version}`;
    if (key === this.#key) return;
    this.#busy = true;
    const maps = await askStation("/api/v1/maps", this.#token);
    this.#busy = false;
    if (maps === undefined) return;
    this.#key = key;
    this.#onMaps(maps);
  }
}
