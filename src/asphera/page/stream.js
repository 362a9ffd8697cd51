// The stream of snapshots: connects, notices silence, reconnects, counts what was missed.

const ALIVE_MS = 6000; // The server says something at least every 2 s.
const FRESH_MS = 6000; // While measuring, a snapshot older than this is old.
const FIRST_DELAY_MS = 500;
const LAST_DELAY_MS = 10000;

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
    socket.onmessage = (event) => this.#hear(JSON.parse(event.data));
    socket.onclose = () => {
      if (this.#socket === socket) this.#retry("the connection to the station is lost");
    };
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
    if (message.format?.startsWith("asphera.snapshot/1")) {
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
    } else if (this.#fresh()) {
      this.#lastGood = new Date();
      this.#show("live", "");
    }
  }

  #watch() {
    const silence = performance.now() - this.#heardAt;
    if (this.#socket && silence > ALIVE_MS) this.#retry("the station does not answer");
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
    if (name === this.#state) return;
    this.#state = name;
    this.#onState({ name, why, since: this.#lastGood });
  }
}
