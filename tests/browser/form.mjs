// Looks at what the page tells of the form: terms taken out, Zernike bars, histogram, bands, and the light.

const PATIENCE_MS = 60000;
/** Of the window's width: 19 mm high capitals on a screen 53 cm wide, 22 minutes of arc from 3 m. */
const FIGURES_MIN = 0.049;
/** WCAG 2.2, 1.4.6, for large letters. */
const CONTRAST_MIN = 4.5;

/** Takes terms out and puts them back, opens and closes the light; gives what was wrong. */
export async function lookAtForm(page) {
  const failures = [];
  const check = (holds, text) => holds || failures.push(text);
  await remove(page, check);
  await charts(page, check);
  await light(page, check);
  return failures;
}

async function remove(page, check) {
  // In one go: a session may end between two questions.
  const before = await page.evaluate(() => ({ headline: document.getElementById("pv").innerText, state: document.documentElement.dataset.state }));
  await page.focus("#remove input[value=piston]");
  // By keyboard, as who has no mouse does.
  for (const name of ["piston", "tilt", "power"]) {
    await page.focus(`#remove input[value=${name}]`);
    await page.keyboard.press("Space");
  }
  const words = "less piston, tilt and power";
  const removed = await page.waitForFunction((text) => {
    const shown = (id) => document.getElementById(id).innerText.toLowerCase();
    return shown("map-title").includes(text) && shown("histogram-of").includes(text) && shown("removed-terms").includes(text);
  }, words, { timeout: PATIENCE_MS }).then(() => true, () => false);
  check(removed, `map and histogram do not say "${words}": ${await page.innerText("#map-title")}, ${await page.innerText("#removed-message")}`);
  if (!removed) return;
  const shown = await page.evaluate(() => ({
    figures: document.getElementById("removed-figures").innerText,
    of: document.getElementById("removed-of").innerText,
    marks: getComputedStyle(document.querySelector(".as-fitted")).display,
    headline: document.getElementById("pv").innerText,
    state: document.documentElement.dataset.state,
  }));
  const [, pv, rms] = /^PV ([\d.\u202f]+) nm, RMS ([\d.\u202f]+) nm/.exec(shown.figures) ?? [];
  check(pv !== undefined, `figures without terms: "${shown.figures}"`);
  check(shown.of.includes("The verdict is of the deviation as fitted"), `of what: "${shown.of}"`);
  check(shown.marks === "none", "the extremes as fitted are marked on a map without terms");
  if (before.state === "measuring" && shown.state === "measuring") {
    check(/of the means of cells$/.test(shown.figures) && shown.of.includes("provisional"), `running figures: "${shown.figures}" ${shown.of}`);
  }
  if (before.state === "complete") {
    check(shown.headline === before.headline, `the headline went from ${before.headline} to ${shown.headline} with the terms`);
    const wanted = await page.evaluate(async () => {
      const { form } = await (await fetch("/api/v1/report")).json();
      const of = (name) => form.figures.find((one) => one.name.startsWith(name) && one.variant === "piston, tilt, power removed").value.toFixed(1);
      return [of("PV"), of("RMS")];
    });
    const plain = [pv, rms].map((text) => text?.replaceAll("\u202f", ""));
    check(plain.join() === wanted.join(), `the page says ${plain}, the report ${wanted}`);
    const bars = await page.innerText("#zernike-readout");
    check(bars.startsWith("Largest: "), `Zernike terms: "${bars}"`);
  }
  for (const name of ["piston", "tilt", "power"]) await page.uncheck(`#remove input[value=${name}]`, { force: true });
  const back = await page.waitForFunction(
    () => document.getElementById("removed").hidden && document.getElementById("map-card").dataset.removed === "",
    null, { timeout: PATIENCE_MS },
  ).then(() => true, () => false);
  check(back, "the terms do not come back");
}

async function charts(page, check) {
  const seen = await page.evaluate(() => ({
    terms: Number(document.getElementById("zernike").dataset.terms),
    of: document.getElementById("zernike-of").innerText,
    why: document.getElementById("zernike-empty").innerText,
    bins: Number(document.getElementById("histogram").dataset.bins),
    histogram: document.getElementById("histogram-of").innerText,
    bands: document.getElementById("plot-bands").innerText,
    readout: document.getElementById("plot-readout").innerText,
    state: document.documentElement.dataset.state,
  }));
  const source = seen.state === "complete" ? "of all points" : "of the map of cells";
  check(seen.terms > 30 ? seen.of.includes(source) : /^Not known: /.test(seen.why), `Zernike terms: ${seen.terms} ${seen.of} ${seen.why}`);
  check(seen.bins >= 4 && seen.histogram.includes(source), `histogram: ${seen.bins} bins ${seen.histogram}`);
  check(/PV: band of ±u, k = 2, .*RMS: band of ±u, k = 2, .*(noise only|error budget of the nominal file)/s.test(seen.bands), `bands: "${seen.bands}"`);
  check(/RMS [\d.\u202f]+ ± [\d.\u202f]+ nm/.test(seen.readout), `RMS without its uncertainty: "${seen.readout}"`);
}

const SHAPES = { MEASURING: "measuring", FINISHING: "measuring", PASS: "pass", FAIL: "fail", UNDECIDED: "undecided", "NO DATA": "stale" };

async function light(page, check) {
  await page.keyboard.press("f");
  const open = await page.waitForSelector("#light[open]", { timeout: PATIENCE_MS }).then(() => true, () => false);
  check(open, "the key f opens no light");
  if (!open) return;
  const seen = await page.evaluate(readLight);
  check(seen.shape === `#l-${SHAPES[seen.word]}`, `the light says ${seen.word} with the shape ${seen.shape}`);
  check(seen.wide <= 0 && seen.high <= 0, `the light is ${seen.wide} by ${seen.high} pixels larger than the window`);
  check(seen.contrast >= CONTRAST_MIN, `contrast of the light ${seen.contrast}`);
  check(seen.figures >= FIGURES_MIN || seen.portrait, `figures of ${seen.figures} of the width`);
  for (const key of ["pv", "rms"]) check(/^[\d.\u202f]+$/.test(seen[key]), `${key} of the light "${seen[key]}"`);
  check(/%$|^–$/.test(seen.coverage), `coverage of the light "${seen.coverage}"`);
  await page.keyboard.press("f");
  const closed = await page.waitForFunction(
    () => !document.getElementById("light").open && !document.fullscreenElement, null, { timeout: PATIENCE_MS },
  ).then(() => true, () => false);
  check(closed, "the key f does not close the light");
}

/** Opens the light, for what it shows when the station goes. */
export const openLight = (page) => page.keyboard.press("f");

/** What the light shows; runs inside the browser and stands alone. */
export function readLight() {
  const text = (id) => document.getElementById(id).innerText.trim();
  const dialog = document.getElementById("light");
  const style = getComputedStyle(dialog);
  const parts = (colour) => colour.match(/[\d.]+/g).slice(0, 3).map(Number);
  const luminance = (colour) => {
    const [r, g, b] = parts(colour).map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  // Of stripes, the first.
  const ground = style.backgroundImage === "none" ? style.backgroundColor : /rgb\([^)]*\)/.exec(style.backgroundImage)[0];
  const [dark, bright] = [luminance(ground), luminance(style.color)].sort((a, b) => a - b);
  return {
    kind: dialog.dataset.kind,
    word: text("light-word"),
    note: text("light-note"),
    shape: document.getElementById("light-shape").getAttribute("href"),
    pv: text("light-pv"),
    rms: text("light-rms"),
    coverage: text("light-coverage"),
    contrast: (bright + 0.05) / (dark + 0.05),
    figures: parseFloat(getComputedStyle(document.getElementById("light-pv")).fontSize) / innerWidth,
    portrait: innerHeight > innerWidth,
    wide: dialog.scrollWidth - dialog.clientWidth,
    high: dialog.scrollHeight - dialog.clientHeight,
  };
}
