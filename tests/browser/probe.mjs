// What check.mjs reads from the page. Each function runs inside the browser and stands alone.

/** What the canvases show, in pixels, with the state they belong to. */
export function drawn() {
  const root = document.documentElement;
  // Reads go through copies: the page's own canvases stay as they are.
  const copy = (w, h) => new OffscreenCanvas(w, h).getContext("2d", { willReadFrequently: true });
  const variable = (name) => {
    const pen = copy(1, 1);
    pen.fillStyle = getComputedStyle(root).getPropertyValue(`--${name}`).trim();
    pen.fillRect(0, 0, 1, 1);
    return pen.getImageData(0, 0, 1, 1).data;
  };
  const pixels = (canvas, x, y, w, h) => {
    const pen = copy(w, h);
    pen.drawImage(canvas, -x, -y);
    return pen.getImageData(0, 0, w, h);
  };
  const distance = (data, at, colour) =>
    Math.hypot(data[at] - colour[0], data[at + 1] - colour[1], data[at + 2] - colour[2]);

  // A pixel is painted where it is none of the two colours of the no-data hatching nor between them.
  const [ground, hatch] = [variable("no-data"), variable("no-data-line")];
  const between = Array.from({ length: 9 }, (_, k) => [0, 1, 2].map((i) => ground[i] + ((hatch[i] - ground[i]) * k) / 8));
  const map = document.getElementById("map");
  let painted = 0;
  let aspect = null;
  const colours = new Set();
  if (map.dataset.plot) {
    const [x, y, w, h] = map.dataset.plot.split(",").map(Number);
    const { data } = pixels(map, x, y, w, h);
    for (let at = 0; at < data.length; at += 4) {
      if (between.some((colour) => distance(data, at, colour) < 14)) continue;
      painted += 1;
      colours.add([0, 1, 2].map((i) => data[at + i] >> 4).join());
    }
    const [mmX, mmY] = map.dataset.spanMm.split(",").map(Number);
    aspect = (w / mmX) / (h / mmY);
  }

  // How many pixel columns of a chart hold its line's colour.
  const columns = [["plot-pv", "series-pv"], ["plot-rms", "series-rms"]].map(([id, series]) => {
    const canvas = document.querySelector(`#${id} canvas`);
    if (!canvas || canvas.width === 0 || canvas.height === 0) return 0;
    const { data, width } = pixels(canvas, 0, 0, canvas.width, canvas.height);
    const colour = variable(series);
    const found = new Set();
    for (let at = 0; at < data.length; at += 4) {
      if (data[at + 3] > 200 && distance(data, at, colour) < 40) found.add((at / 4) % width);
    }
    return found.size;
  });
  return {
    state: root.dataset.state,
    stream: root.dataset.stream,
    sequence: Number(root.dataset.sequence ?? 0),
    painted,
    colours: colours.size,
    aspect,
    columns,
  };
}

/** The texts a person reads. */
export function texts() {
  const text = (selector) => document.querySelector(selector)?.innerText.trim() ?? "";
  const cells = (row) => [...row.cells].map((cell) => cell.innerText.trim());
  const links = [...document.querySelectorAll("#links tbody tr")].map((row) => {
    const [name, devices, state, rate, readings, errors, lost, reconnects, age, lastError] = cells(row);
    const shape = row.cells[2]?.querySelector("use")?.getAttribute("href") ?? "";
    return { name: name.split("\n")[0], devices, state, shape, rate, readings, errors, lost, reconnects, age, lastError };
  });
  const named = (element) => element.innerText?.trim() || element.ariaLabel || element.labels?.length;
  return {
    station: text("#station"),
    verdict: text("#verdict-text"),
    note: text("#verdict-note"),
    pv: text("#pv"),
    rms: text("#rms"),
    reasons: [...document.querySelectorAll("#reasons li")].map((item) => item.innerText),
    mapTitle: text("#map-title"),
    legend: text("#map-legend").replace(/\s+/g, " "),
    fraction: text("#fraction"),
    received: text("#points tr[data-key=received] td"),
    linkHeads: [...document.querySelectorAll("#links thead th")].map((cell) => cell.innerText.trim()),
    links,
    skipped: document.getElementById("skipped").hidden ? "" : text("#skipped"),
    overflow: document.documentElement.scrollWidth - innerWidth,
    unlabelled: [...document.querySelectorAll("button, input, canvas[tabindex]")]
      .filter((element) => !element.hidden && !named(element)).map((element) => element.id),
  };
}

/** How the page shows that it is not live. */
export function lost() {
  const banner = document.getElementById("stale-banner");
  return {
    banner: banner.hidden ? "" : banner.innerText.trim(),
    greyed: Number(getComputedStyle(document.querySelector("main")).opacity) <= 0.6,
    states: [...document.querySelectorAll("#links tbody tr")].map((row) => row.cells[2].innerText.trim()),
  };
}
