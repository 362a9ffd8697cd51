// Looks for what is wider than the window, on screens of many widths, with figures as they are and with long ones.

const WIDTHS = [320, 360, 414, 480, 600, 700, 759, 761, 820, 900, 1024, 1100, 1179, 1181, 1280, 1366, 1400, 1500, 1600, 1760, 1920];
/** A running fit may be far off at first. */
const LONG = "123\u202f456\u202f789.0";

/** Makes the window as wide as each of them, and as it was; gives what was too wide. */
export async function lookAtWidths(page) {
  const failures = [];
  const before = page.viewportSize();
  for (const width of WIDTHS) {
    await page.setViewportSize({ width, height: 900 });
    // The charts follow the window a frame later.
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    for (const long of [null, LONG]) {
      const { wider, by } = await page.evaluate(overflow, long);
      if (wider > 0) failures.push(`${wider} pixels too wide for a window of ${width}${long ? " with long figures" : ""}: ${by}`);
    }
  }
  await page.setViewportSize(before);
  return failures;
}

/** How much wider than the window the page is, and by what; runs inside the browser and stands alone. */
function overflow(long) {
  const shown = ["pv", "rms"].map((id) => document.getElementById(id));
  const texts = shown.map((one) => one.textContent);
  // In one go, so that no snapshot comes between.
  if (long) shown.forEach((one) => { one.textContent = long; });
  const wider = document.documentElement.scrollWidth - innerWidth;
  const beyond = wider > 0 ? [...document.querySelectorAll("body *")].filter((one) => one.getBoundingClientRect().right > innerWidth + 0.5) : [];
  const by = beyond.slice(0, 4).map((one) => `${one.tagName.toLowerCase()}#${one.id || one.closest("[id]")?.id}`).join(", ");
  shown.forEach((one, at) => { one.textContent = texts[at]; });
  return { wider, by };
}
