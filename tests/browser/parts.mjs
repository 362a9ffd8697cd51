// Looks at the parts of a tray: in the table, as boxes on the map, and that the box takes them away.

/** Rows of the table of parts, and the boxes on the map. */
export function partsShown() {
  const rows = [...document.querySelectorAll("#parts tbody tr")].map((row) => [...row.cells].map((cell) => cell.innerText));
  return { rows, boxes: Number(document.getElementById("map").dataset.parts ?? 0), note: document.getElementById("parts-note").innerText };
}

/** Looks at them when the session has ended; gives what was wrong. `live` is the first that were seen while measuring. */
export async function lookAtParts(page, live) {
  const failures = [];
  const check = (holds, text) => holds || failures.push(text);
  await page.waitForFunction(() => document.querySelectorAll("#parts tbody tr").length === 8);
  const shown = await page.evaluate(partsShown);
  check(live && live.rows.length < 8, "no part was listed while the scan went on");
  const names = shown.rows.map((row) => row[1].split(".toml")[0]).sort();
  const expected = ["concave-sphere", "convex-asphere", "convex-asphere", "convex-asphere", "convex-sphere", "convex-sphere", "flat", "ring"];
  check(names.join() === expected.join(), `parts ${names.join()}`);
  check(shown.rows.every((row) => row[2] === "PASS"), `answers ${shown.rows.map((row) => row[2]).join()}`);
  check(shown.rows.every((row) => /^[\d\u202f.]+/.test(row[3]) && /^-?[−\d.]+, /.test(row[5])), `cells ${shown.rows[0].join(" | ")}`);
  check(/^8 parts; \d+ islands of \d+ points are no parts\.$/.test(shown.note), `note "${shown.note}"`);
  check(shown.boxes === 8, `${shown.boxes} boxes on the map`);
  const whole = await page.evaluate(() => ({
    pv: document.getElementById("pv").innerText,
    title: document.getElementById("map-title").dataset.title,
    next: Number(document.getElementById("map").dataset.regions),
    reasons: document.getElementById("reasons").innerText,
  }));
  check(whole.pv === "–" && whole.title.startsWith("Height over"), `a form of the whole: PV ${whole.pv}, map "${whole.title}"`);
  check(whole.next === 0, `${whole.next} regions to measure next between the parts`);
  check(/all 8 parts hold the limits of their nominals/.test(whole.reasons), `reasons "${whole.reasons}"`);
  await page.uncheck("#show-parts");
  check((await page.evaluate(partsShown)).boxes === 0, "parts that are not wanted are drawn");
  await page.check("#show-parts");
  return failures;
}
