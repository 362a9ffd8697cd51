// Looks at what the page says of the limits while points arrive, beside the word and in the light.

const SAID = /^(FAIL is certain: |No decision yet[.:] |No decision before the end: )/;

/** Gives what was wrong; nothing where the station was done meanwhile. */
export async function lookAtOutlook(page) {
  const failures = [];
  const check = (holds, text) => holds || failures.push(text);
  const read = () => page.evaluate(() => ({
    state: document.documentElement.dataset.state,
    hidden: document.getElementById("outlook").hidden,
    text: document.getElementById("outlook").innerText,
    limits: [...document.querySelectorAll("#checks tbody tr")].map((row) => row.innerText.replace(/\s+/g, " ")),
    about: document.getElementById("u-model").innerText,
  }));
  const seen = await read();
  if (seen.state !== "measuring") return failures;
  check(!seen.hidden && SAID.test(seen.text), `what can be said of the part: "${seen.text}"`);
  check(seen.limits.length > 0, "no limit is listed while it measures");
  for (const limit of seen.limits) check(/(fails, certain|passes|open|known at the end)/.test(limit), `a limit without what can be said: "${limit}"`);
  check(/^± k = 2, (noise only|error budget)/.test(seen.about), `the uncertainty is by "${seen.about}"`);
  await page.keyboard.press("f");
  const note = await page.waitForFunction(
    () => document.documentElement.dataset.state !== "measuring" || document.getElementById("light-note").innerText,
    null, { timeout: 60000 },
  ).then((found) => found.jsonValue(), () => "");
  if (typeof note === "string") check(SAID.test(note), `the light's second line is "${note}"`);
  await page.keyboard.press("f");
  return failures;
}
