// Looks at defects: marks on the map, the table, and that a row leads the map's cursor there.

/** Defects as a finished session tells them, in the measured frame: a pit, a scratch of 45°, one without a size. */
const DEFECTS = [
  { kind: "pit", shape: "round", at_mm: [2, 1, 0.2], height_nm: -231.4, area_mm2: 0.0314, length_mm: 0.2, width_mm: 0.2, orientation_deg: 10, on_border: false, significance: 61.2 },
  { kind: "scratch", shape: "straight", at_mm: [-3, -2, 0.4], height_nm: -80, area_mm2: 0.2, length_mm: 4, width_mm: 0.05, orientation_deg: 45, on_border: true, significance: 30 },
  { kind: "spike", shape: "point", at_mm: [0, 5, 0.9], height_nm: 512.04, on_border: false, significance: 9.4 },
];
const FEATURES = {
  defects: DEFECTS,
  defects_more: 2,
  defects_search: { threshold_sigmas: 5.52, sigma_nm: 9.87, largest_mm: 0.412 },
  partition: { shares: { concave: 0.98, unknown: 0.02 }, patch_mm: 0.21 },
};

/** Adds defects to the snapshots of a session that ended: a good part has none. */
export function addDefects(message) {
  if (message.state === "complete") Object.assign(message, FEATURES, { defects_unknown: undefined, partition_unknown: undefined });
}

/** Looks at them; gives what was wrong. */
export async function lookAtDefects(page) {
  const failures = [];
  const check = (holds, text) => holds || failures.push(text);
  const text = (id) => page.innerText(`#${id}`);
  const rows = await page.evaluate(() => [...document.querySelectorAll("#defects tbody tr")].map((row) => row.innerText));
  check(rows.length === 3, `${rows.length} defects in the table`);
  check(/pit.*−231\.4.*0\.200 × 0\.200.*1\.\d\d, 1\.\d\d.*61/s.test(rows[0] ?? ""), `defect 1: "${rows[0]}"`);
  check(/scratch\s+cut off.*4\.00 × 0\.0500/s.test(rows[1] ?? ""), `defect 2: "${rows[1]}"`);
  check(/spike.*\+512\.0.*–/s.test(rows[2] ?? ""), `a size that is not known is no dash: "${rows[2]}"`);
  check(/^5 defects beyond 5\.5 σ of 9\.87 nm, up to 0\.412 mm wide\. The 3 clearest/.test(await text("defects-note")), `note "${await text("defects-note")}"`);
  check(/0\.210 mm: concave 98\.0.%, unknown 2\.0.%/.test(await text("bends")), `bends "${await text("bends")}"`);
  const marked = () => page.evaluate(() => document.getElementById("map").dataset.defects);
  check((await marked()) === "3", `${await marked()} defects on the map`);
  for (const [index, name] of [[1, "pit"], [2, "scratch"]]) {
    await page.click(`#defects tbody tr:nth-child(${index})`);
    const chosen = await page.evaluate(() => [...document.querySelectorAll("#defects tbody tr")].map((row) => row.className).join());
    check(chosen.split(",").indexOf("chosen") === index - 1, `chosen: ${chosen}`);
    const told = await text("map-readout");
    check(told.includes(`defect ${index}: ${name}`), `after a click on row ${index} the map says "${told}"`);
    const [x] = DEFECTS[index - 1].at_mm;
    const at = Number(/x ([−\d.]+) mm/.exec(told)?.[1].replace("−", "-"));
    check(Math.abs(at - x) < 0.5, `the cursor is at x ${at}, the ${name} at ${x}`);
  }
  await page.uncheck("#show-defects");
  check((await marked()) === "0", "defects that are not wanted are drawn");
  await page.check("#show-defects");
  return failures;
}
