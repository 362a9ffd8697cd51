// Looks at the maps of the sampling, the regions to measure next, and a section, while a station measures.

import { addDefects } from "./defects.mjs";

const LAYERS = ["gap", "epsilon", "noise", "deviation"];
const PATIENCE_MS = 60000;

/** Regions in the measured frame, as a station tells them: one with a hole, one without heights. */
const REGIONS = [
  {
    polygons: [{ outline: [[-3, -3, 0], [2, -3, 0], [2, 1, 0], [-3, 1, 0]], holes: [[[-1, -2, 0], [0, -2, 0], [0, -1, 0]]] }],
    area_mm2: 19.5, epsilon_max: 0.31, gap_max_mm: 0.8, spacing_needed_mm: 0.12, at_mm: [1, 0, 0],
  },
  { polygons: [{ outline: [[3, 3], [4, 3], [4, 5]], holes: [] }], area_mm2: 1, epsilon_max: null, gap_max_mm: 0.8, spacing_needed_mm: null, at_mm: [3.6, 3.5, 0] },
];

/** Adds regions to every snapshot, and defects to those at the end: what a scan leaves out and a part lacks depends on them.
 * Before the page is opened. */
export async function addFindings(page) {
  await page.routeWebSocket(/\/api\/v1\/stream$/, (socket) => {
    const server = socket.connectToServer();
    server.onMessage((text) => {
      const message = JSON.parse(text);
      if (message.sampling) message.sampling.next = REGIONS;
      addDefects(message);
      socket.send(JSON.stringify(message));
    });
  });
}

/** Switches through the layers by keyboard, drags a section and watches it grow; gives what was wrong. */
export async function lookAtSampling(page, withRegions) {
  const failures = [];
  const check = (holds, text) => holds || failures.push(text);
  await page.waitForFunction(() => document.documentElement.dataset.state !== "none");
  await page.focus("#layers input:checked");
  for (const name of LAYERS) {
    await page.keyboard.press("ArrowRight");
    const shown = await page.waitForFunction(
      (layer) => document.getElementById("map").dataset.layer === layer && document.getElementById("map-empty").hidden,
      name, { timeout: PATIENCE_MS },
    ).then(() => true, () => false);
    check(shown, `layer ${name} is not shown`);
    if (!shown || name === "deviation") continue;
    const seen = await page.evaluate(() => ({
      title: document.getElementById("map-title").innerText,
      limit: document.getElementById("map-limit").innerText,
      asOf: document.getElementById("map-as-of").innerText,
    }));
    check(/^As of [\d\u202f]+ points/.test(seen.asOf), `layer ${name}: as of "${seen.asOf}"`);
    check(/, [\d.]+/.test(seen.limit), `layer ${name}: limit "${seen.limit}"`);
    check(name !== "gap" || seen.title.includes("mm"), `map of gaps without its unit: "${seen.title}"`);
    check(name !== "noise" || /Noise (not known|[\d.]+ nm)/.test(seen.asOf), `noise in "${seen.asOf}"`);
  }
  await drag(page, check);
  if (withRegions) await regions(page, check);
  return failures;
}

async function drag(page, check) {
  const figures = () => page.evaluate(() => ({
    text: document.getElementById("profile-figures").innerText,
    points: Number(document.getElementById("section-card").dataset.points ?? 0),
    line: ["x1", "y1", "x2", "y2"].map((name) => document.getElementById(`section-${name}`).value).join(),
  }));
  const before = await figures();
  await page.locator("#map").scrollIntoViewIfNeeded();
  const box = await page.locator("#map").boundingBox();
  const at = (x, y) => [box.x + x * box.width, box.y + y * box.height];
  await page.mouse.move(...at(0.35, 0.35));
  await page.mouse.down();
  await page.mouse.move(...at(0.5, 0.45), { steps: 3 });
  await page.mouse.move(...at(0.6, 0.5), { steps: 3 });
  await page.mouse.up();
  const drawn = (old, kind = "line") => page.waitForFunction(([text, wanted]) => {
    const now = document.getElementById("profile-figures").innerText;
    return now !== text && /PV [\d.\u202f]+ (nm|µm)/.test(now) && document.querySelector("#profile canvas")?.width > 0
      && document.getElementById("section-card").dataset.path === wanted;
  }, [old, kind], { timeout: PATIENCE_MS }).then(() => true, () => false);
  check(await drawn(before.text), "no section after a drag");
  const dragged = await figures();
  check(dragged.line !== before.line, `the dragged line is the old one: ${dragged.line}`);
  check(dragged.points > 20, `a section of ${dragged.points} points`);
  const state = () => page.evaluate(() => document.documentElement.dataset.state);
  // The last points may be in the section already where the session ends meanwhile.
  const follows = (await state()) !== "measuring" || (await drawn(dragged.text)) || (await state()) !== "measuring";
  check(follows, "the section does not follow the measurement");
  await page.check("#section-kind input[value=circle]", { force: true });
  const round = await drawn(dragged.text, "circle");
  check(round, `no section along a circle: ${(await figures()).text} ${await page.innerText("#section-message")}`);
  const fields = await page.evaluate(() => [...document.querySelectorAll("#section-fields label:not([hidden]) input")].map((input) => input.id));
  check(fields.join() === "section-r", `fields of a circle: ${fields}`);
}

async function regions(page, check) {
  const rows = await page.evaluate(() => [...document.querySelectorAll("#regions tbody tr")].map((row) => row.innerText));
  check(rows.length === 2, `${rows.length} regions in the table`);
  check(/19\.5 mm².*0\.310.*0\.120 mm/s.test(rows[0] ?? ""), `region 1: "${rows[0]}"`);
  check((rows[1] ?? "").includes("–"), `what is not known is no dash: "${rows[1]}"`);
  const drawnRegions = await page.evaluate(() => document.getElementById("map").dataset.regions);
  check(drawnRegions === "2", `${drawnRegions} regions on the map`);
  // The map has no cell under the cursor but that of the arrow keys, which begin in the middle.
  await page.focus("#map");
  await page.keyboard.press("ArrowUp");
  const told = await page.innerText("#map-readout");
  check(/region 1: 19\.5 mm², ε up to 0\.310, needs a spacing of 0\.120 mm/.test(told), `in a region the map says "${told}"`);
  await page.click("#regions tbody tr:first-child");
  check(await page.evaluate(() => document.querySelector("#regions tbody tr").className) === "chosen", "a region cannot be chosen");
}
