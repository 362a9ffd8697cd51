// The stream of snapshots: connects, notices silence, reconnects, counts what was missed.

import { headersWith } from "./token.js";

const ALIVE_MS = 5000; // The server says something at least every 2 s.
const FRESH_MS = 5000; // While measuring, a snapshot older than this is old.
const FIRST_DELAY_MS = 500;
const LAST_DELAY_MS = 10000;
const EXPLAIN_MS = 3000;
const LOST = "the connection to the station is lost, trying again";

/** Calls `onSnapshot(snapshot, skipped)` and `onState({ name, since, why })`. */
export class Stream {
  #token;
  #onSnapshot;
  #onState;
  #socket = null;
  #attempts = 0;
  #heardAt = performance.now();
  #snapshotAt = null;
  #lastGood = null; // Date of the last sign of life, for people.
  #sequence = null;
  #state = null;
  #why = "";
  #stationState = null;
  skipped = 0;

  constructor(token, onSnapshot, onState) {
    this.#token = token;
    this.#onSnapshot = onSnapshot;
    this.#onState = onState;
  }

  start() {
    this.#connect();
    setInterval(() => this.#watch(), 500);
    addEventListener("online", () => this.#socket ?? this.#connect());
  }

  #connect() {
    const url = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/v1/stream`;
    const protocols = ["asphera.snapshot.v1"];
    if (this.#token) protocols.push(`asphera.token.${this.#token}`);
    const socket = new WebSocket(url, protocols);
    this.#socket = socket;
    this.#heardAt = performance.now();
    let opened = false;
    socket.onopen = () => { opened = true; };
    socket.onmessage = (event) => this.#hear(JSON.parse(event.data));
    socket.onclose = async () => {
      const why = opened ? LOST : await this.#explain();
      if (this.#socket === socket) this.#retry(why);
    };
  }

  /** A browser does not tell a page why a WebSocket was refused; a plain request does. */
  async #explain() {
    const headers = headersWith(this.#token);
    const signal = AbortSignal.timeout(EXPLAIN_MS);
    try {
      const answer = await fetch("/api/v1/snapshot", { headers, signal });
      return answer.ok ? "the station takes no further page, trying again" : (await answer.json()).error;
    } catch {
      return LOST;
    }
  }

  #retry(why) {
    const socket = this.#socket;
    this.#socket = null;
    socket?.close();
    this.#show(this.#lastGood ? "stale" : "connecting", why);
    const delay = Math.min(FIRST_DELAY_MS * 2 ** this.#attempts, LAST_DELAY_MS);
    this.#attempts += 1;
    // Spread out, so that many pages do not come back in one moment.
    setTimeout(() => this.#socket ?? this.#connect(), delay * (0.75 + Math.random() / 2));
  }

  #hear(message) {
    this.#heardAt = performance.now();
    this.#attempts = 0;
    if (message.format === "asphera.snapshot/1") {
      // A smaller number means that the daemon was started anew.
      if (this.#sequence !== null && message.sequence > this.#sequence) {
        this.skipped += message.sequence - this.#sequence - 1;
      }
      this.#sequence = message.sequence;
      this.#stationState = message.state;
      this.#snapshotAt = this.#heardAt;
      this.#lastGood = new Date();
      this.#show("live", "");
      this.#onSnapshot(message);
    } else if (message.format !== "asphera.alive/1") {
      this.#show("stale", `the station speaks ${message.format}: reload this page`);
    } else if (this.#fresh()) {
      this.#lastGood = new Date();
      this.#show("live", "");
    }
  }

  #watch() {
    const silence = performance.now() - this.#heardAt;
    if (this.#socket && silence > ALIVE_MS) this.#retry("the station does not answer, trying again");
    else if (this.#socket && this.#state === "live" && !this.#fresh()) {
      this.#show("stale", "the station answers but sends no new figures");
    }
  }

  /** An idle station has nothing new to say; a measuring one has. */
  #fresh() {
    if (this.#snapshotAt === null) return false;
    const active = this.#stationState === "measuring";
    return !active || performance.now() - this.#snapshotAt < FRESH_MS;
  }

  #show(name, why) {
    if (name === this.#state && why === this.#why) return;
    this.#state = name;
    this.#why = why;
    this.#onState({ name, why, since: this.#lastGood });
  }
}
