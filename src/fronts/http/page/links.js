// The table of links. Ages go on between snapshots; a word and a shape say the state, not colour alone.

import { byId, setRows } from "./dom.js";
import { DASH, count, duration, known, rate } from "./format.js";

const OLD_S = 10;

/** Keeps the links of the last snapshot and draws them at the time it is asked. */
export class Links {
  #links = [];
  #at = 0;
  #measuring = false;
  #ended = false;

  update(snapshot) {
    this.#links = snapshot.links;
    this.#measuring = snapshot.state === "measuring";
    this.#ended = ["finishing", "complete", "failed"].includes(snapshot.state);
    this.#at = performance.now();
  }

  draw(live) {
    const passed = (performance.now() - this.#at) / 1000;
    byId("links-empty").hidden = this.#links.length > 0;
    byId("links").hidden = this.#links.length === 0;
    setRows(byId("links"), this.#links.map((link) => row(link, passed, live, this.#measuring, this.#ended)));
  }
}

function row(link, passed, live, measuring, ended) {
  const age = known(link.age_s) ? link.age_s + passed : null;
  const silent = measuring && link.state === "connected" && known(age) && age > OLD_S;
  // After its session a link has nothing to say: that is no fault of its.
  const over = ended && link.state === "stale";
  const state = silent ? "stale" : over ? "ended" : link.state;
  const old = !live || state === "stale" || state === "closed";
  const number = (text, className = "") => ({ text, className: `num ${className}`.trim() });
  return {
    key: link.name,
    className: old ? "old" : over ? "over" : "",
    cells: [
      { text: link.name, small: `${link.kind} · ${link.address}` },
      link.devices.join(", ") || DASH,
      live
        ? { text: state, icon: state === "ended" ? "closed" : state, className: `state ${state}` }
        : { text: `was ${state}`, icon: "stale", className: "state unknown" },
      number(live ? rate(link.rate_hz) : DASH),
      number(count(link.readings)),
      number(count(link.errors), link.errors > 0 ? "bad" : ""),
      number(count(link.lost), link.lost > 0 ? "bad" : ""),
      number(count(link.reconnects), link.reconnects > 0 ? "warn" : ""),
      { text: duration(age), icon: old && known(age) ? "stale" : undefined, className: "num age" },
      { text: link.last_error ?? DASH, className: "error" },
    ],
  };
}
