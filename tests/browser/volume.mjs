// Looks at the page of a measured volume with a real browser.
//
//   node volume.mjs URL [--chromium PATH] [--screenshots PREFIX]
//
// The volume has, beside a lens, two voxels that touch by a corner and two that touch by an edge. Prints one JSON object
// { ok, failures }. Exit code: 0 where nothing failed, else 1. Needs `npm ci` in this folder once.

import { parseArgs } from "node:util";

import { chromium } from "playwright-core";

import { texts } from "./probe.mjs";
import { lookAtWidths } from "./widths.mjs";

const CHROMIUM_ARGUMENTS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync",
];
const TIMEOUT_MS = 60_000;
const AXES = ["x", "y", "z"];

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    chromium: { type: "string", default: "/usr/bin/chromium" },
    screenshots: { type: "string" },
  },
});
const url = new URL(positionals[0]);
const failures = [];
const check = (holds, text) => holds || failures.includes(text) || failures.push(text);

/** What a slice shows; runs in the browser and stands alone. */
function sliceOf(axis) {
  const canvas = document.getElementById(`slice-${axis}`);
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  let [line, dark, light, orange, blue] = [0, 0, 0, 0, 0];
  for (let at = 0; at < data.length; at += 4) {
    const [r, g, b, alpha] = data.slice(at, at + 4);
    if (alpha < 255) continue;
    if (Math.hypot(r - 0x12, g - 0xd6, b - 0xb4) < 40) line += 1;
    if (r === g && g === b) r < 80 ? (dark += 1) : r > 170 && (light += 1);
    if (r > b + 50) orange += 1;
    if (b > r + 50) blue += 1;
  }
  const { index, contour, points, cells } = canvas.dataset;
  const place = document.getElementById(`slice-${axis}-place`).innerText;
  return { ...Object.fromEntries(Object.entries({ index, contour, points, cells }).map(([k, v]) => [k, Number(v)])), place, line, dark, light, orange, blue };
}

/** The colours of the faces in space. */
function solidOf() {
  const canvas = document.getElementById("solid");
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  let [orange, blue] = [0, 0];
  for (let at = 0; at < data.length; at += 4) {
    if (data[at] > data[at + 2] + 40) orange += 1;
    if (data[at + 2] > data[at] + 40) blue += 1;
  }
  return { ...canvas.dataset, orange, blue };
}

function listen(page) {
  const own = (address) => ["blob:", "data:"].includes(new URL(address).protocol) || new URL(address).host === url.host;
  page.on("console", (message) => check(!["error", "warning"].includes(message.type()), `console: ${message.text()}`));
  page.on("pageerror", (error) => check(false, `uncaught: ${error.message}`));
  page.on("request", (request) => check(own(request.url()), `request to another host: ${request.url()}`));
  page.on("response", (answer) => check(answer.status() < 400, `status ${answer.status()}: ${answer.url()}`));
}

/** Waits until a slice is drawn, of another number than `not`. */
const drawn = (page, axis, not = null) => page.waitForFunction(
  ([name, other]) => {
    const canvas = document.getElementById(`slice-${name}`);
    return canvas.dataset.index === String(document.getElementById(`slice-${name}-at`).value) && canvas.dataset.index !== other;
  },
  [axis, not],
  { timeout: TIMEOUT_MS },
);

/** Slices in the middle of the lens, and a slider that the keyboard moves. */
async function lookAtSlices(page) {
  for (const axis of AXES) {
    await drawn(page, axis);
    const seen = await page.evaluate(sliceOf, axis);
    check(seen.contour > 100 && seen.line > 100, `slice ${axis}: a line of ${seen.contour} pieces, ${seen.line} pixels`);
    check(seen.dark > 3000 && seen.light > 1000, `slice ${axis}: ${seen.dark} dark and ${seen.light} light pixels`);
  }
  for (const axis of ["x", "y"]) {
    const seen = await page.evaluate(sliceOf, axis);
    check(seen.points > 50 && seen.orange > 30 && seen.blue > 30, `slice ${axis}: ${seen.points} points, ${seen.orange} orange and ${seen.blue} blue pixels`);
  }
  const before = await page.evaluate(sliceOf, "z");
  await page.focus("#slice-z-at");
  for (let step = 0; step < 3; step += 1) await page.keyboard.press("ArrowRight");
  await drawn(page, "z", String(before.index));
  const after = await page.evaluate(sliceOf, "z");
  check(after.index === before.index + 3, `three steps from ${before.index} to ${after.index}`);
  check(/^z = −?\d+\.\d{3} mm$/.test(after.place) && after.place !== before.place, `place "${before.place}", then "${after.place}"`);
  await page.keyboard.press("Home");
  await drawn(page, "z", String(after.index));
  const first = await page.evaluate(sliceOf, "z");
  check(first.index === 0 && first.contour === 0 && first.light === 0, `the first slice is air: ${JSON.stringify(first)}`);
  await page.uncheck("#volume-contour");
  check((await page.evaluate(sliceOf, "x")).line === 0, "the line is drawn where it is not wanted");
  await page.check("#volume-contour");
  await page.hover("#slice-x");
  const told = await page.innerText("#slice-x-readout");
  check(/^y −?\d+\.\d{3}, z −?\d+\.\d{3} mm: about \d/.test(told), `readout "${told}"`);
}

/** Forbidden and critical cells: the list, and that a row leads all slices there. */
async function lookAtCells(page) {
  const rows = await page.evaluate(() => [...document.querySelectorAll("#volume-table tbody tr")].map((row) => [...row.cells].map((cell) => cell.innerText)));
  const kinds = rows.map((row) => row[1].split("\n")[0]).sort().join();
  // Pairs of cells of case 8 on the lens have a C1 face each, and are allowed.
  check(/^C1(,C1)*,C2,cell of case 8,cell of case 8,forbidden cell$/.test(kinds), `kinds ${kinds}`);
  const grid = await page.innerText("#volume-grid");
  check(/^Grid: 1 forbidden cells, 2 of case 8 without a partner, \d+ C1, 1 C2\. No part whose radius r/.test(grid), `grid "${grid}"`);
  const index = rows.findIndex((row) => row[1].startsWith("forbidden"));
  check(/^−?\d\.\d{3}, −?\d\.\d{3}, −?\d\.\d{3}$/.test(rows[index]?.[2]) && rows[index]?.[3] === "10000001", `row ${rows[index]}`);
  await page.focus(`#volume-table tbody tr:nth-child(${index + 1})`);
  await page.keyboard.press("Enter");
  for (const axis of AXES) {
    await drawn(page, axis);
    await page.waitForFunction((name) => Number(document.getElementById(`slice-${name}`).dataset.cells) > 0, axis, { timeout: TIMEOUT_MS })
      .catch(() => check(false, `slice ${axis} shows no cell at the place of the row`));
  }
  const chosen = await page.evaluate(() => document.querySelector("#volume-table tr.chosen")?.rowIndex);
  check(chosen === index + 1, `row ${chosen} is chosen, not ${index + 1}`);
}

/** Faces in space: coloured, turned by keys, one by one. */
async function lookAtFaces(page) {
  const both = await page.evaluate(solidOf);
  check(Number(both.faces) > 5000 && both.orange > 500 && both.blue > 500, `faces in space: ${JSON.stringify(both)}`);
  check(Number(both.cells) >= 5, `${both.cells} cells in space`);
  await page.focus("#solid");
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction((turn) => document.getElementById("solid").dataset.turn !== turn, both.turn, { timeout: TIMEOUT_MS });
  await page.keyboard.press("Home");
  await page.waitForFunction((turn) => document.getElementById("solid").dataset.turn === turn, both.turn, { timeout: TIMEOUT_MS });
  await page.check("#volume-faces input[value='1']", { force: true });
  await page.waitForFunction((all) => Number(document.getElementById("solid").dataset.faces) < Number(all), both.faces, { timeout: TIMEOUT_MS });
  await page.check("#volume-faces input[value='both']", { force: true });
  await page.click("#volume-figures summary");
  const facts = await page.innerText("#volume-card [data-chapters]");
  check(/Centre thickness/.test(facts) && /u by noise/.test(facts), `figures of the volume: "${facts.slice(0, 200)}"`);
}

const browser = await chromium.launch({ executablePath: values.chromium, args: CHROMIUM_ARGUMENTS });
try {
  for (const [name, colorScheme, width] of [["light", "light", 1400], ["dark", "dark", 1400], ["narrow", "light", 380]]) {
    const page = await browser.newPage({ viewport: { width, height: 1000 }, colorScheme });
    listen(page);
    await page.goto(url.href);
    await page.waitForSelector("#volume-shown:not([hidden])", { timeout: TIMEOUT_MS });
    for (const axis of AXES) await drawn(page, axis);
    await page.waitForTimeout(300);
    if (values.screenshots) await page.screenshot({ path: `${values.screenshots}${name}.png`, fullPage: true });
    const shown = await page.evaluate(texts);
    check(shown.overflow <= 0, `${name}: ${shown.overflow} pixels wider than the window`);
    check(shown.unlabelled.length === 0, `controls without a name: ${shown.unlabelled}`);
    if (name === "light") {
      await lookAtSlices(page);
      await lookAtFaces(page);
      await lookAtCells(page);
      if (values.screenshots) await page.locator("#volume-card").screenshot({ path: `${values.screenshots}cells.png` });
      for (const text of await lookAtWidths(page)) check(false, text);
    }
    await page.close();
  }
} catch (error) {
  check(false, `the check broke off: ${error.message}`);
} finally {
  await browser.close();
}
console.log(JSON.stringify({ ok: failures.length === 0, failures }, null, 1));
process.exit(failures.length === 0 ? 0 : 1);
