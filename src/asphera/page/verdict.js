// The answer in letters that are read from across the room, and what it rests on.

import { byId, make, setAttribute, setRows, setText } from "./dom.js";
import { DASH, count, nameAndUnit, nm, significant } from "./format.js";

const WORDS = {
  none: ["idle", DASH, "Waiting for the station."],
  idle: ["idle", "IDLE", "No session runs."],
  measuring: ["measuring", "MEASURING", ""],
  finishing: ["measuring", "FINISHING", "The last point has landed; the final fit is being made."],
  pass: ["pass", "PASS", "Every limit holds."],
  fail: ["fail", "FAIL", "A limit is broken."],
  undecided: ["undecided", "UNDECIDED", "There is no answer."],
};

/** What is shown: the answer once there is one, until then what the station does. */
export const kindOf = ({ state, verdict }) =>
  state === "complete" || state === "failed" ? verdict.status : state;

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
  byId("provisional").hidden = !form?.provisional;
  document.title = `${word === DASH ? "" : `${word} – `}${snapshot.station} – asphera`;
  showChecks(verdict.checks);
  byId("reasons").replaceChildren(
    ...verdict.reasons.map((reason) => make("li", "", reason)),
  );
}

function noteOf({ state, points, session }, note) {
  if (state === "measuring") return `${count(points.received)} points received`;
  if (state === "failed") return "The session ended without a report.";
  const ended = session?.ended;
  if (state === "complete" && ended && ended !== "complete") return `${note} The session was ended early: ${ended}.`;
  return note;
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
    const [name, unit] = nameAndUnit(check.name);
    const shown = (value) => (unit === "nm" ? nm(value) : significant(value, 4));
    return {
      key: check.name,
      cells: [
        unit ? `${name} (${unit})` : name,
        { text: shown(check.value), className: "num" },
        { text: `≤ ${shown(check.limit)}`, className: "num" },
        held(check),
      ],
    };
  }));
}
