// How far the scan is and what became of the points.

import { byId, setRows, setText } from "./dom.js";
import { DASH, count, duration, known, percent, rate } from "./format.js";

export function showProgress({ progress, points, state }) {
  setText(byId("fraction"), percent(progress.fraction));
  const left = known(progress.eta_s) && state === "measuring" ? `${duration(progress.eta_s)} left` : "";
  setText(byId("eta"), left);
  const bar = byId("progress");
  // Without a value the bar would move for ever in a station that does nothing.
  bar.hidden = !known(progress.fraction) && state !== "measuring";
  if (known(progress.fraction)) bar.value = progress.fraction;
  else bar.removeAttribute("value");

  const flags = Object.entries(points.flagged);
  const number = (key, name, text, className = "") => ({ key, className, cells: [name, { text, className: "num" }] });
  setRows(byId("points"), [
    number("rate", "Rate", `${rate(progress.rate_hz)} points/s`),
    number("eta", "Time left by plan", state === "measuring" ? duration(progress.eta_s) : DASH),
    number("eta_coverage", "Time left by coverage", state === "measuring" ? duration(progress.eta_coverage_s) : DASH),
    number("expected", "Expected", count(progress.expected_points)),
    number("received", "Received", count(points.received)),
    number("used", "Used", count(points.used)),
    number("pending", "Not yet in the mesh", count(progress.pending_points)),
    ...(progress.backlog ? [number("backlog", "Waiting to be processed", `${count(progress.backlog.waiting_points)}, ${duration(progress.backlog.behind_s)} behind`, "bad")] : []),
    number("lost", "Lost", count(points.lost), points.lost > 0 ? "bad" : ""),
    ...(points.missing > 0 ? [number("missing", "Never came", count(points.missing), "bad")] : []),
    number("duplicates", "Duplicates", count(points.duplicates)),
    number("flagged", "Flagged, by reason", flags.length ? "" : "none"),
    ...flags.map(([reason, n]) => number(`flag-${reason}`, reason.replaceAll("_", " "), count(n), "sub")),
  ]);
}
