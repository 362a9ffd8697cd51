// Looks at the live page with a real browser while a station measures and when it is done.
//
//   node check.mjs URL [--chromium PATH] [--timeout SECONDS] [--screenshot FILE]
//                      [--measuring-screenshot FILE] [--until complete|measuring]
//                      [--scheme light|dark] [--width PIXELS] [--height PIXELS] [--then-lost]
//                      [--sampling] [--regions] [--form] [--contour] [--parts]
//
// The URL `-` stands for the first line of the standard input: the browser is started first, and `ready` on the
// standard error says so. Whoever reads it starts the daemon.
//
// --then-lost: afterwards writes the line `end the station` to the standard error and waits until
// the page says that it is not live. Whoever reads the line ends the daemon.
//
// --sampling: while it measures, looks at the maps of the sampling and at sections; with --regions also at regions
// to measure next, and at the end at defects, which are added to what the station says.
//
// --form: while it measures and at the end, takes Zernike terms out of what is shown, opens the light, makes the window
// wider and narrower, and looks at what is said of the limits.
//
// --contour: looks at the contour of a blade while it measures and at the end. --parts: at the parts of a tray.
//
// Prints one JSON object: { ok, failures, measuring, final, lost, requests }. Exit code: 0 where nothing
// failed, 1 where something did, 2 for a wrong call. Needs `npm ci` in this folder once.

import { once } from "node:events";
import { createInterface } from "node:readline";
import { parseArgs } from "node:util";

import { chromium } from "playwright-core";

import { lookAtBlanks } from "./blank.mjs";
import { contourShown, lookAtContour } from "./contour.mjs";
import { lookAtParts, partsShown } from "./parts.mjs";
import { lookAtDefects } from "./defects.mjs";
import { lookAtForm, openLight, readLight } from "./form.mjs";
import { lookAtOutlook } from "./outlook.mjs";
import { drawn, lost, texts } from "./probe.mjs";
import { addFindings, lookAtSampling } from "./sampling.mjs";
import { lookAtWidths } from "./widths.mjs";

const CHROMIUM_ARGUMENTS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync",
];
const POLL_MS = 100;
/** Cells painted, in pixels: well above the two marks and the cursor. */
const PAINTED_MIN = 500;
const LINE_COLUMNS_MIN = 20;

const call = readCall();
const failures = [];
const fail = (text) => failures.includes(text) || failures.push(text);
const failLoad = (text) => mayFail || fail(text);
const check = (holds, text) => holds || fail(text);
const result = { ok: false, failures, measuring: null, final: null, lost: null, requests: 0 };
/** Whether the daemon may be gone: then failed requests are what is to be expected. */
let mayFail = false;

const browser = await chromium.launch({ executablePath: call.chromium, args: CHROMIUM_ARGUMENTS });
try {
  const page = await browser.newPage({
    viewport: { width: call.width, height: call.height },
    colorScheme: call.scheme,
  });
  if (call.url === null) {
    console.error("ready");
    const [line] = await once(createInterface({ input: process.stdin }), "line");
    call.url = new URL(line.trim()).href;
  }
  listen(page);
  if (call.regions) await addFindings(page);
  await page.goto(call.url);
  await follow(page);
  if (call["then-lost"]) await lose(page);
} catch (error) {
  fail(`the check broke off: ${error.message}`);
} finally {
  await browser.close();
}
result.ok = failures.length === 0;
console.log(JSON.stringify(result, null, 1));
process.exit(result.ok ? 0 : 1);

function readCall() {
  try {
    const { values, positionals } = parseArgs({
      allowPositionals: true,
      options: {
        chromium: { type: "string", default: "/usr/bin/chromium" },
        timeout: { type: "string", default: "120" },
        screenshot: { type: "string" },
        sampling: { type: "boolean", default: false },
        regions: { type: "boolean", default: false },
        form: { type: "boolean", default: false },
        contour: { type: "boolean", default: false },
        parts: { type: "boolean", default: false },
        "then-lost": { type: "boolean", default: false },
        "measuring-screenshot": { type: "string" },
        until: { type: "string", default: "complete" },
        scheme: { type: "string", default: "light" },
        width: { type: "string", default: "1400" },
        height: { type: "string", default: "1000" },
      },
    });
    const [timeout, width, height] = [values.timeout, values.width, values.height].map(Number);
    const right = positionals.length === 1 && [timeout, width, height].every((n) => n > 0)
      && ["complete", "measuring"].includes(values.until) && ["light", "dark"].includes(values.scheme);
    if (!right) throw new Error("one URL is needed, and options in their range");
    return { ...values, url: positionals[0] === "-" ? null : new URL(positionals[0]).href, timeout, width, height };
  } catch (error) {
    console.error(`wrong call: ${error.message}; the first lines of check.mjs say how`);
    process.exit(2);
  }
}

/** Collects what a page must not do: errors, refused loads, requests to anyone else. */
function listen(page) {
  const { host } = new URL(call.url);
  const own = (address) => ["blob:", "data:"].includes(new URL(address).protocol) || new URL(address).host === host;
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) failLoad(`console ${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => fail(`uncaught: ${error.message}`));
  page.on("request", (request) => {
    result.requests += 1;
    check(own(request.url()), `request to another host: ${request.url()}`);
  });
  page.on("websocket", (socket) => check(own(socket.url()), `WebSocket to another host: ${socket.url()}`));
  page.on("requestfailed", (request) => failLoad(`request failed: ${request.url()} ${request.failure()?.errorText}`));
  page.on("response", (answer) => check(answer.status() < 400, `status ${answer.status()}: ${answer.url()}`));
}

/** Watches from the first snapshot to the state asked for, and judges on the way and at the end. */
async function follow(page) {
  const until = Date.now() + call.timeout * 1000;
  let [looked, lookedAtForm] = [false, false];
  let contour = null;
  let parts = null;
  const last = { state: "none", stream: "connecting" };
  const ends = call.until === "complete" ? ["complete", "failed"] : [];
  while (Date.now() < until) {
    const seen = await page.evaluate(drawn);
    Object.assign(last, seen);
    if (seen.state === "measuring" && seen.painted > (result.measuring?.painted ?? -1)) {
      const first = (result.measuring?.painted ?? 0) < PAINTED_MIN && seen.painted >= PAINTED_MIN;
      result.measuring = seen;
      if (call.sampling && !looked && seen.painted >= PAINTED_MIN) {
        looked = true;
        for (const text of await lookAtSampling(page, call.regions)) fail(text);
      }
      if (call.form && !lookedAtForm && seen.painted >= PAINTED_MIN) {
        lookedAtForm = true;
        for (const text of await lookAtOutlook(page)) fail(text);
        for (const text of await lookAtForm(page)) fail(`while measuring: ${text}`);
        for (const text of await lookAtBlanks(page)) fail(`while measuring: ${text}`);
        for (const text of await lookAtWidths(page)) fail(`while measuring: ${text}`);
      }
      if (first && call["measuring-screenshot"]) {
        await page.screenshot({ path: call["measuring-screenshot"], fullPage: true });
      }
    }
    if (seen.state === "measuring" && call.parts && !parts) {
      const shown = await page.evaluate(partsShown);
      if (shown.rows.length > 0 && shown.boxes > 0) parts = shown;
    }
    if (seen.state === "measuring" && call.contour && !contour) {
      const shown = await page.evaluate(contourShown);
      if (shown.lines > 0) contour = shown;
    }
    const enough = call.until === "measuring" && (result.measuring?.painted ?? 0) >= PAINTED_MIN
      && result.measuring.columns.every((n) => n >= LINE_COLUMNS_MIN);
    if (ends.includes(seen.state) || enough) break;
    await page.waitForTimeout(POLL_MS);
  }
  check(result.measuring !== null, "no snapshot in state measuring was seen");
  check((result.measuring?.painted ?? 0) >= PAINTED_MIN, `map not painted while measuring: ${result.measuring?.painted ?? 0} pixels`);
  check(last.state === call.until, `state is ${last.state}, not ${call.until}, after ${call.timeout} s`);
  // The frame of the last snapshot.
  await page.waitForTimeout(2 * POLL_MS);
  result.final = { ...await page.evaluate(drawn), ...await page.evaluate(texts) };
  if (call.regions && call.until === "complete") {
    for (const text of await lookAtDefects(page)) fail(text);
  }
  if (call.parts) {
    for (const text of await lookAtParts(page, parts)) fail(text);
  }
  if (call.contour) {
    for (const text of await lookAtContour(page, contour)) fail(text);
  }
  if (call.screenshot) await page.screenshot({ path: call.screenshot, fullPage: true });
  judge(result.final);
  if (call.form && last.state === "complete") {
    for (const text of await lookAtForm(page)) fail(`at the end: ${text}`);
    for (const text of await lookAtBlanks(page)) fail(`at the end: ${text}`);
    for (const text of await lookAtWidths(page)) fail(`at the end: ${text}`);
  }
}

/** Waits until the page tells that the station is gone, and checks how it tells. */
async function lose(page) {
  mayFail = true;
  if (call.form) await openLight(page);
  console.error("end the station");
  await page.waitForSelector("html[data-stream=stale]", { timeout: call.timeout * 1000 });
  await page.waitForTimeout(2 * POLL_MS);
  result.lost = await page.evaluate(lost);
  check(/^NOT LIVE: .*\d\d:\d\d:\d\d/s.test(result.lost.banner), `banner "${result.lost.banner}"`);
  check(result.lost.greyed, "the figures are not greyed");
  if (call.form) {
    const light = await page.evaluate(readLight);
    check(light.kind === "stale" && light.word === "NO DATA" && light.shape === "#l-stale", `the light says ${light.word} without a station`);
    check(/^no data for \d+ s, figures of \d\d:\d\d:\d\d; was [A-Z]+$/.test(light.note), `the light notes "${light.note}"`);
  }
  for (const state of result.lost.states) check(state.startsWith("was "), `link state "${state}" without a station`);
}

function judge(final) {
  check(final.stream === "live", `the stream is ${final.stream}`);
  check(final.painted >= PAINTED_MIN, `map not painted: ${final.painted} pixels`);
  check(final.colours >= 4, `map of ${final.colours} colours`);
  check(Math.abs(final.aspect - 1) < 0.02, `a mm along x is ${final.aspect} times one along y`);
  for (const [index, name] of ["PV", "RMS"].entries()) {
    const columns = final.columns[index];
    // Parts that lie apart have no form together.
    check(call.parts ? columns === 0 : columns >= LINE_COLUMNS_MIN, `${name} line spans ${columns} pixel columns`);
  }
  for (const text of ["+ above nominal", "− below nominal", "no data", "max of the points", "min of the points"]) {
    check(final.legend.includes(text), `legend without "${text}"`);
  }
  check(final.mapTitle.includes("nm"), "map without its unit");
  const extremes = /[+−][\d.\u202f]+ nm at \(/.test(final.legend);
  check(extremes !== Boolean(call.parts), call.parts ? "extremes of a form of the whole" : "extremes without value, unit and place");
  for (const head of ["State", "Rate", "Errors", "Lost", "Reconnects", "Age", "Last error"]) {
    check(final.linkHeads.some((text) => text.startsWith(head)), `links table without "${head}"`);
  }
  check(final.links.length > 0, "no link in the table");
  for (const link of final.links) {
    check(/^(was )?(opening|waiting|connected|stale|closed|ended)$/.test(link.state), `link ${link.name}: state "${link.state}"`);
    check(link.shape, `link ${link.name}: state without a shape`);
    check(/^[\d.\u202f]+$|^–$/.test(link.rate), `link ${link.name}: rate "${link.rate}"`);
    for (const key of ["errors", "lost", "reconnects"]) {
      check(/^[\d\u202f]+$/.test(link[key]), `link ${link.name}: ${key} "${link[key]}"`);
    }
    check(/ (s|min)$|^–$/.test(link.age), `link ${link.name}: age "${link.age}"`);
  }
  check(/%|–/.test(final.fraction), `progress "${final.fraction}"`);
  check(/^[\d\u202f]+$/.test(final.received), `points received "${final.received}"`);
  // The demo of a blade has no limits.
  const unlimited = call.contour ? ["NO LIMITS"] : [];
  const words = call.until === "complete" ? ["PASS", "FAIL", "UNDECIDED"] : ["MEASURING", "FINISHING", "PASS", "FAIL", "UNDECIDED"];
  check([...words, ...unlimited].includes(final.verdict), `verdict "${final.verdict}"`);
  for (const key of ["pv", "rms"]) check((call.parts ? /^–$/ : /^[\d.\u202f]+$/).test(final[key]), `${key} "${final[key]}"`);
  check(final.overflow <= 0, `the page is ${final.overflow} pixels wider than the window`);
  check(final.unlabelled.length === 0, `controls without a name: ${final.unlabelled.join(", ")}`);
}
