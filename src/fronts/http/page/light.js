// The verdict as a light that fills the screen: to be read from three metres, by colour, word and shape.

import { byId, setAttribute, setText } from "./dom.js";
import { DASH, duration, figureValue, figureWords, known, nm, percent, sentence, timeOfDay } from "./format.js";
import { silent } from "./series.js";
import { kindOf, waitingFor, wordOf } from "./verdict.js";

const SHAPES = { pass: "pass", fail: "fail", undecided: "undecided", measuring: "measuring", finishing: "measuring" };

export class Light {
  #dialog = byId("light");
  #snapshot = null;
  #stream = null;

  constructor() {
    byId("open-light").onclick = () => this.#toggle();
    byId("close-light").onclick = () => this.#close();
    this.#dialog.onclose = () => {
      // A browser without full screen shows the light in its window.
      if (document.fullscreenElement) document.exitFullscreen().catch(() => {});
    };
    addEventListener("keydown", (event) => this.#key(event));
    document.addEventListener("fullscreenchange", () => {
      if (!document.fullscreenElement) this.#close();
    });
  }

  update(snapshot) {
    this.#snapshot = snapshot;
    this.draw();
  }

  /** Takes the state of the stream: `{ name, since }`. */
  setStream(stream) {
    this.#stream = stream;
    this.draw();
  }

  /** Also between snapshots: the time without data goes on. */
  draw() {
    if (!this.#dialog.open) return;
    const { kind, word, note } = this.#say();
    setAttribute(this.#dialog, "data-kind", kind);
    setAttribute(byId("light-shape"), "href", `#l-${kind === "stale" ? "stale" : SHAPES[kind] ?? "idle"}`);
    setText(byId("light-word"), word);
    setText(byId("light-note"), note);
    setAttribute(this.#dialog, "data-outlook", kind === "measuring" ? this.#snapshot?.verdict.outlook?.state ?? null : null);
    const deviation = this.#snapshot?.form?.deviation;
    setText(byId("light-pv"), nm(deviation?.pv_nm));
    setText(byId("light-rms"), nm(deviation?.rms_nm));
    setText(byId("light-coverage"), percent(this.#snapshot?.sampling.coverage));
    const { station, session } = this.#snapshot ?? {};
    setText(byId("light-what"), [station, session?.id].filter(Boolean).join(" · "));
  }

  #say() {
    const [snapshot, stream] = [this.#snapshot, this.#stream];
    if (!snapshot) return { kind: "stale", word: "NO DATA", note: "nothing was received yet" };
    const kind = kindOf(snapshot);
    const word = wordOf(kind);
    if (stream && stream.name !== "live") {
      const old = stream.since ? `no data for ${whole((Date.now() - stream.since) / 1000)}, figures of ${timeOfDay(stream.since)}` : "no data";
      return { kind: "stale", word: "NO DATA", note: `${old}; was ${word}` };
    }
    const [quiet] = silent(snapshot);
    if (quiet) return { kind: "stale", word: "NO DATA", note: `no data for ${whole(quiet.age_s)} from ${quiet.name}; was ${word}` };
    return { kind, word, note: noteOf(snapshot, kind) };
  }

  #key(event) {
    const { key, target } = event;
    if (key !== "f" || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    // In a field of text an f is an f.
    if (target.closest?.("input:not([type=radio], [type=checkbox]), textarea, select")) return;
    event.preventDefault();
    this.#toggle();
  }

  #toggle() {
    if (this.#dialog.open) {
      this.#close();
      return;
    }
    // What is shown last lies on top: first the page fills the screen, then the light the page. Where it may not, the light comes all
    // the same.
    const show = () => {
      if (!this.#dialog.open) this.#dialog.showModal();
      this.draw();
    };
    const full = document.documentElement.requestFullscreen?.();
    if (full) full.then(show, show);
    else show();
  }

  #close() {
    if (this.#dialog.open) this.#dialog.close();
  }
}

function noteOf({ progress, verdict, state }, kind) {
  if (kind === "waiting") return waitingFor(progress.waiting);
  if (state === "measuring") {
    const left = known(progress.eta_s) ? `, ${duration(progress.eta_s)} left` : "";
    const done = known(progress.fraction) ? `, ${percent(progress.fraction)} of the points${left}` : "";
    // A recording in trouble, then what is certain of the part: it is read from afar.
    if (verdict.reasons.length > 0) return verdict.reasons[0];
    return verdict.outlook ? sentence(verdict.outlook.text) : `provisional figures${done}`;
  }
  if (kind === "fail") return verdict.checks.filter((check) => !check.ok).map(broken).join("; ");
  if (kind === "undecided") return verdict.reasons[0] ?? "";
  return "";
}

function broken(check) {
  const shown = (value) => `${figureValue(check, value)} ${check.unit}`;
  return `${sentence(figureWords(check))} ${shown(check.value)}, ${shown(check.limit)} allowed`;
}

/** A time without data, by whole seconds: it is looked at from afar. */
const whole = (seconds) => (known(seconds) && seconds < 60 ? `${Math.floor(Math.max(seconds, 0))} s` : known(seconds) ? duration(seconds) : DASH);
