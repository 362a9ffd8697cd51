// Looks at the contour of a blade: on the map, in words, and that the box takes it away.

/** Whether a contour is drawn on the map, and of how many points the page says it is. */
export function contourShown() {
  const note = document.getElementById("contour-note").innerText;
  const points = /As of ([\d\u202f]+) points/.exec(note)?.[1].replaceAll("\u202f", "");
  return { lines: Number(document.getElementById("map").dataset.contour ?? 0), points: Number(points ?? 0), note };
}

/** Looks at it when the session has ended; gives what was wrong. `live` is the first one that was seen while measuring. */
export async function lookAtContour(page, live) {
  const failures = [];
  const check = (holds, text) => holds || failures.push(text);
  const shown = await page.evaluate(contourShown);
  check(live, "no contour was drawn while measuring");
  check(live === null || (live.points >= 100 && live.points < shown.points), `the first contour is of ${live?.points} points, the last of ${shown.points}`);
  check(shown.lines === 1, `${shown.lines} lines of the contour on the map`);
  check(/^Contour \(connect2d\): 1 closed and 0 open lines, 12\d\.?\d* mm; 0 ends ○ and 0 junctions ■/.test(shown.note), `note "${shown.note}"`);
  check(!/not seen yet/.test(shown.note), `points are missing at the end: "${shown.note}"`);
  await page.uncheck("#show-contour");
  check((await page.evaluate(contourShown)).lines === 0, "a contour that is not wanted is drawn");
  await page.check("#show-contour");
  return failures;
}
