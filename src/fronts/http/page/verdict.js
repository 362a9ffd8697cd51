// The answer in letters that are read from across the room, and what it rests on.

import { byId, make, setAttribute, setRows, setText } from "./dom.js";
import { DASH, count, figureValue, figureWords, known, nm, sentence, significant } from "./format.js";
import { COVERAGE } from "./series.js";

const WORDS = {
  none: ["idle", DASH, "Waiting for the station."],
  idle: ["idle", "IDLE", "No session runs."],
  waiting: ["idle", "WAITING", ""],
  measuring: ["measuring", "MEASURING", ""],
  finishing: ["measuring", "FINISHING", "The last point has landed; the final fit is being made."],
  pass: ["pass", "PASS", "Every limit holds."],
  fail: ["fail", "FAIL", "A limit is broken."],
  undecided: ["undecided", "UNDECIDED", "Neither pass nor fail is proven."],
  unlimited: ["idle", "NO LIMITS", "No limits are given: there is nothing to decide."],
};

/** What is shown: the answer once there is one, until then what the station does. */
export const kindOf = ({ state, verdict, progress }) => {
  if (state === "measuring" && progress.waiting) return "waiting";
  if (state !== "complete" && state !== "failed") return state;
  return verdict.status === "none" ? "unlimited" : verdict.status;
};

/** That in one word. */
export const wordOf = (kind) => (WORDS[kind] ?? WORDS.none)[1];

export function showVerdict(snapshot) {
  const { verdict, form } = snapshot;
  const kind = kindOf(snapshot);
  const [symbol, word, note] = WORDS[kind] ?? WORDS.none;
  setAttribute(byId("verdict"), "data-kind", kind);
  setAttribute(byId("verdict-icon"), "href", `#i-${symbol}`);
  setText(byId("verdict-text"), word);
  setText(byId("verdict-note"), noteOf(snapshot, note));
  setText(byId("pv"), nm(form?.deviation.pv_nm));
  setText(byId("rms"), nm(form?.deviation.rms_nm));
  showUncertainty(form?.deviation);
  showOutlook(verdict.outlook, kind);
  byId("provisional").hidden = !form?.provisional;
  document.title = `${word === DASH ? "" : `${word} – `}${snapshot.station} – asphera`;
  if (verdict.outlook) showLimits(verdict.outlook.limits);
  else showChecks(verdict.checks);
  const reasons = verdict.reasons.map((reason) => make("li", "", reason));
  const problem = snapshot.outputs?.problem;
  if (problem) reasons.push(make("li", "bad", `Result files: ${problem}`));
  byId("reasons").replaceChildren(...reasons);
}

/** What a session without a reading waits for. */
export function waitingFor({ for: what, links, ends_in_s: ends }) {
  const end = (without) => (known(ends) ? `: without ${without} the session ends in ${Math.ceil(Math.max(ends, 0))} s` : "");
  if (what === "devices") return `For ${links.length > 1 ? "the devices on links" : "the device on link"} ${links.join(", ")}${end("an answer")}.`;
  return `For the first trigger${end("one")}.`;
}

function noteOf({ state, points, session, progress }, note) {
  if (state === "measuring" && progress.waiting) return waitingFor(progress.waiting);
  if (state === "measuring") return `${count(points.received)} points received`;
  if (state === "failed") return "The session ended without a report.";
  const ended = session?.ended;
  if (state === "complete" && ended && ended !== "complete") return `${note} The session was ended early: ${ended}.`;
  return note;
}

/** ± of PV and RMS, k = 2, and what they are made of. */
function showUncertainty(deviation) {
  const about = deviation?.uncertainty;
  setText(byId("pv-u"), about ? `± ${significant(COVERAGE * about.u_pv_nm, 2)}` : "");
  setText(byId("rms-u"), about ? `± ${significant(COVERAGE * about.u_rms_nm, 2)}` : "");
  const most = about?.pv_at_most ? ". PV: an upper bound" : "";
  const covers = about?.rms_covers ? `. RMS: ${about.rms_covers}` : "";
  setText(byId("u-model"), about ? `± k = ${COVERAGE}, ${about.model}${most}${covers}` : "");
}

const OUTLOOKS = { fail_certain: "fail", pass_certain: "pass", pass_from: "pass_from", at_end: "at_end", open: "open" };

/** What can be said of the part while it is measured: the second line beside the word. */
function showOutlook(outlook, kind) {
  const shown = outlook && (kind === "measuring" || kind === "finishing");
  const line = byId("outlook");
  line.hidden = !shown;
  if (!shown) return;
  setAttribute(line, "data-outlook", OUTLOOKS[outlook.state] ?? "open");
  setText(line, sentence(outlook.text));
}

const LIMITS = {
  fail_certain: { text: "fails, certain", icon: "fail", className: "bad" },
  pass_certain: { text: "passes", icon: "pass", className: "good" },
  pass_from: { text: "open", icon: "undecided", className: "" },
  at_end: { text: "known at the end", icon: "undecided", className: "" },
  open: { text: "open", icon: "undecided", className: "" },
};

/** What can be said of each limit while it is measured. */
function showLimits(limits) {
  const table = byId("checks");
  table.hidden = limits.length === 0;
  setRows(table, limits.map((one) => {
    const { name, unit, value, limit, state, text } = one;
    const shown = (number) => figureValue(one, number);
    return {
      key: name,
      cells: [
        `${sentence(figureWords(one))} (${unit})`,
        { text: shown(value), className: "num" },
        { text: `≤ ${shown(limit)}`, className: "num" },
        { ...LIMITS[state] ?? LIMITS.open, small: text },
      ],
    };
  }));
}

/** Whether a limit holds; within a guard band neither that nor the contrary is proven. */
function held({ ok, value, limit, guard_band: band }) {
  if (ok) return { text: "yes", icon: "pass", className: "good" };
  if (value > limit + (band ?? 0)) return { text: "no", icon: "fail", className: "bad" };
  return { text: "not proven", icon: "undecided", className: "" };
}

function showChecks(checks) {
  const table = byId("checks");
  table.hidden = checks.length === 0;
  setRows(table, checks.map((check) => {
    const shown = (value) => figureValue(check, value);
    return {
      key: check.name,
      cells: [
        `${sentence(figureWords(check))} (${check.unit})`,
        { text: shown(check.value), className: "num", small: Number.isFinite(check.u) ? `u ${significant(check.u, 2)}` : "" },
        { text: `≤ ${shown(check.limit)}`, className: "num" },
        { ...held(check), small: check.doubt ?? "" },
      ],
    };
  }));
}
