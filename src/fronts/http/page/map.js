// The map on its canvas: the cells of the layer that is looked at, what is drawn over them, cursor and drag.

import { drawAxes, drawBar, noDataPattern, place1to1, toMm } from "./axes.js";
import { css } from "./colours.js";
import { byId, setText } from "./dom.js";
import { DASH, count, fixed, known, significant } from "./format.js";
import { LAYERS, chartOf, sayCell } from "./layers.js";
import { drawBeyond, drawContour, drawCursor, drawDefects, drawMark, drawParts, drawRegions, drawSection } from "./overlay.js";
import { listed, pointsSince } from "./series.js";

const FONT = "12px system-ui, sans-serif";
const DRAG_PIXELS = 5;

export class PartMap {
  #canvas = byId("map");
  #flip = byId("flip");
  #layer = "deviation";
  #snapshot = null;
  #maps = null;
  #view = null; // The deviation without terms; null for that as fitted.
  #chart = null; // What is drawn of the layer: grid, values, limit.
  #regions = null;
  #defects = null;
  #contour = null;
  #parts = null;
  #section = null; // { lines, cursor } in the part frame.
  #cell = null; // [column, row] under the cursor.
  #drag = null; // Where a drag began, in pixels.
  #dragged = false;
  #frame = null; // Where the cells stand, in CSS pixels.
  #table = null;
  /** Called with the name of a layer that is chosen. */
  onLayer = () => {};
  /** Whether lines over the map mean anything: not where it is a surface in space, laid flat. */
  takesLines = true;
  /** Called with the two ends of a line that is being dragged, in the part frame. */
  onLine = () => {};

  constructor(regions, defects, contour, parts) {
    this.#regions = regions;
    this.#defects = defects;
    this.#contour = contour;
    this.#parts = parts;
    const canvas = this.#canvas;
    for (const input of document.querySelectorAll("#layers input")) {
      input.onchange = () => this.#choose(input.value);
      // A browser may restore what was chosen before a reload.
      if (input.checked) this.#layer = input.value;
    }
    this.#flip.onchange = () => this.#repaint();
    canvas.onpointerdown = (event) => this.#press(event);
    canvas.onpointermove = (event) => this.#move(event);
    canvas.onpointerup = (event) => this.#release(event);
    canvas.onpointercancel = () => { this.#drag = null; };
    canvas.onpointerleave = () => this.#select(null);
    canvas.onblur = () => this.#select(null);
    canvas.onkeydown = (event) => this.#key(event);
    new ResizeObserver(() => this.draw()).observe(canvas);
    this.#repaint();
  }

  get layer() {
    return this.#layer;
  }

  /** The chart that is drawn, for whoever needs its extent; null without one. */
  get chart() {
    return this.#chart ?? chartOf("deviation", this.#deviation, null);
  }

  update(snapshot) {
    this.#snapshot = snapshot;
    const deviation = snapshot.form?.deviation;
    // In the words of the report, so that both name one place in one frame.
    setText(byId("map-max"), extreme(snapshot.view, "Highest"));
    setText(byId("map-min"), extreme(snapshot.view, "Lowest"));
    this.#show();
  }

  /** Takes the maps of the sampling, or null. */
  setMaps(maps) {
    this.#maps = maps;
    if (this.#layer !== "deviation") this.#show();
  }

  /** Takes the deviation without terms, or null. */
  setView(view) {
    this.#view = view;
    if (this.#layer === "deviation") this.#show();
  }

  setSection(section) {
    this.#section = section;
    this.draw();
  }

  draw() {
    const canvas = this.#canvas;
    const ratio = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0 || height === 0) return;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.font = FONT;
    if (!this.#chart) {
      this.#frame = null;
      delete canvas.dataset.plot;
      return;
    }
    const [chart, layer] = [this.#chart, LAYERS[this.#layer]];
    const frame = place1to1(chart, width, height);
    this.#frame = frame;
    const scale = layer.scale(chart.values, chart.limit);
    this.#drawCells(pen, scale);
    canvas.dataset.beyond = drawBeyond(pen, frame, chart);
    const isFlat = layer.signed && this.#isInSpace;
    drawAxes(pen, frame, isFlat ? "laid flat" : undefined);
    const cut = chart.values.some((value) => known(value) && Math.abs(value) > scale);
    const { limit } = chart;
    drawBar(pen, frame, { table: this.#table, low: layer.signed ? -scale : 0, high: scale, unit: layer.unit, limit, cut });
    const contour = this.#contour.shown;
    this.#clipped(pen, () => {
      if (contour) drawContour(pen, frame, contour);
      drawParts(pen, frame, this.#parts.shown);
      if (this.#section && !isFlat) drawSection(pen, frame, this.#section.lines, this.#section.cursor);
      drawRegions(pen, frame, this.#regions.shown, this.#regions.chosen);
      drawDefects(pen, frame, this.#defects.shown, this.#defects.chosen);
    });
    this.#drawMarks(pen);
    if (this.#cell) drawCursor(pen, frame, chart, this.#cell);
    // For the browser test: what is shown, where the cells stand in canvas pixels, and how large that is.
    const { nx, ny, dx_mm: dx, dy_mm: dy } = chart;
    canvas.dataset.layer = this.#layer;
    canvas.dataset.spanMm = `${nx * dx},${ny * dy}`;
    canvas.dataset.regions = this.#regions.shown.length;
    canvas.dataset.parts = this.#parts.shown.length;
    canvas.dataset.contour = contour ? contour.lines.length : 0;
    canvas.dataset.defects = this.#defects.shown.length;
    const { left, top, wide, high } = frame;
    canvas.dataset.plot = [left, top, wide, high].map((v) => Math.round(v * ratio)).join(",");
  }

  /** Moves the cursor to a place of the part frame, if that is on the map. */
  pointAt([x, y]) {
    const chart = this.#chart;
    if (!chart) return;
    const [column, row] = [(x - chart.x0_mm) / chart.dx_mm, (y - chart.y0_mm) / chart.dy_mm].map(Math.round);
    if (column >= 0 && column < chart.nx && row >= 0 && row < chart.ny) this.#select([column, row]);
  }

  #wideMm() {
    return this.#chart.nx * this.#chart.dx_mm;
  }

  /** Whether the cells are those of a chart of a part as a whole: places of the part are none of it. */
  get #isInSpace() {
    return Boolean(this.#snapshot?.mesh?.reconstruction);
  }

  get #deviation() {
    return this.#view?.map ?? this.#snapshot?.map;
  }

  #choose(name) {
    this.#layer = name;
    this.#repaint();
    this.onLayer(name);
    this.#show();
  }

  /** Takes the chosen colours, and what the legend says of the layer. */
  #repaint() {
    const layer = LAYERS[this.#layer];
    this.#table = layer.table(this.#flip.checked);
    this.#sayTitle();
    this.#canvas.setAttribute("aria-label", `${layer.label} Arrow keys move the cursor.`);
    byId("map-card").dataset.layer = this.#layer;
    if (layer.signed) {
      byId("swatch-plus").replaceChildren(swatch(this.#table(0.75)));
      byId("swatch-minus").replaceChildren(swatch(this.#table(-0.75)));
    }
    this.draw();
  }

  /** What is drawn says itself what was taken out of it. */
  #sayTitle() {
    const layer = LAYERS[this.#layer];
    const removed = layer.signed ? this.#view?.removed ?? [] : [];
    const flat = layer.signed && this.#isInSpace ? ", laid flat" : "";
    // Parts that lie apart have no form together: their heights show where they lie.
    if (layer.signed && this.#isOfParts) return this.#setTitle("Height over the plane through all parts", layer.small, "");
    const title = removed.length ? `${layer.title} less ${listed(removed)}` : `${layer.title}${flat}`;
    this.#setTitle(title, layer.small, removed.join(","));
  }

  #setTitle(title, fine, removed) {
    const heading = byId("map-title");
    if (heading.dataset.title !== title) heading.replaceChildren(`${title} `, small(fine));
    heading.dataset.title = title;
    byId("map-card").dataset.removed = removed;
  }

  /** Whether the points are parts alone, without a form of the whole. */
  get #isOfParts() {
    return Boolean(this.#snapshot?.parts && !this.#snapshot.form);
  }

  #show() {
    this.#sayTitle();
    this.#chart = chartOf(this.#layer, this.#deviation, this.#maps);
    byId("map-empty").hidden = this.#chart !== null;
    const sampling = this.#layer !== "deviation";
    const measured = this.#snapshot?.points.received > 0;
    setText(byId("map-empty"), sampling && this.#isOfParts ? "Parts lie apart: each has its own sampling." : sampling && measured ? "The mesh was not looked at yet." : "No point has landed yet.");
    this.#sayLimit(sampling);
    this.draw();
    this.#tell();
  }

  #sayLimit(sampling) {
    const [layer, maps] = [LAYERS[this.#layer], this.#maps];
    if (!sampling || !maps) {
      setText(byId("map-as-of"), "");
      setText(byId("map-limit"), layer.beyond ?? "");
      return;
    }
    const { limit } = maps[layer.layer];
    const unit = layer.unit === "ε" ? "" : ` ${layer.unit}`;
    setText(byId("map-limit"), known(limit) ? `${layer.beyond}, ${significant(limit)}${unit}` : "no limit");
    const newer = this.#snapshot ? pointsSince(this.#snapshot.points, maps.as_of_points) : 0;
    const noise = this.#layer !== "noise" ? ""
      : maps.noise_unknown ? ` Noise not known: ${maps.noise_unknown}.`
      : ` Noise ${significant(maps.noise_sigma_nm)} nm.`;
    setText(byId("map-as-of"), `As of ${count(maps.as_of_points)} points${newer > 0 ? `, ${count(newer)} newer ones not seen yet` : ""}.${noise}`);
  }

  #drawCells(pen, scale) {
    const { nx, ny, values } = this.#chart;
    const { left, top, wide, high } = this.#frame;
    pen.fillStyle = noDataPattern(pen);
    pen.fillRect(left, top, wide, high);
    const cells = new OffscreenCanvas(nx, ny);
    const context = cells.getContext("2d");
    const image = context.createImageData(nx, ny);
    for (let row = 0; row < ny; row += 1) {
      for (let column = 0; column < nx; column += 1) {
        const value = values[row * nx + column];
        if (!known(value)) continue;
        // The first row has the smallest y: it stands at the bottom.
        const at = 4 * ((ny - 1 - row) * nx + column);
        const [r, g, b] = this.#table(value / scale);
        image.data.set([r, g, b, 255], at);
      }
    }
    context.putImageData(image, 0, 0);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(cells, left, top, wide, high);
  }

  #clipped(pen, draw) {
    const { left, top, wide, high } = this.#frame;
    pen.save();
    pen.beginPath();
    pen.rect(left, top, wide, high);
    pen.clip();
    draw();
    pen.restore();
  }

  #drawMarks(pen) {
    const deviation = this.#snapshot?.form?.deviation;
    // They are those of the deviation as fitted.
    if (!deviation || this.#layer !== "deviation" || this.#view || this.#isInSpace) return;
    drawMark(pen, this.#frame, deviation.at_max_mm, -1);
    drawMark(pen, this.#frame, deviation.at_min_mm, 1);
  }

  #press(event) {
    if (!this.#frame || event.button !== 0) return;
    this.#drag = [event.offsetX, event.offsetY];
    this.#dragged = false;
    this.#canvas.setPointerCapture(event.pointerId);
  }

  /** A press that did not become a drag chooses what lies there. */
  #release(event) {
    if (this.#drag && !this.#dragged && this.#frame) {
      const place = toMm(this.#frame, [event.offsetX, event.offsetY]);
      if (!this.#defects.choose(place, this.#wideMm())) this.#regions.choose(place);
    }
    this.#drag = null;
  }

  #move(event) {
    if (!this.#frame) return;
    const { nx, ny, dx_mm: dx, dy_mm: dy } = this.#chart;
    const at = [event.offsetX, event.offsetY];
    if (this.#drag && Math.hypot(at[0] - this.#drag[0], at[1] - this.#drag[1]) >= DRAG_PIXELS) {
      this.#dragged = true;
      this.onLine(toMm(this.#frame, this.#drag), toMm(this.#frame, at));
    }
    const [x, y] = toMm(this.#frame, at);
    const column = Math.floor((x - this.#frame.x0) / dx);
    const row = Math.floor((y - this.#frame.y0) / dy);
    this.#select(column >= 0 && column < nx && row >= 0 && row < ny ? [column, row] : null);
  }

  #key(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step || !this.#chart) return;
    event.preventDefault();
    const { nx, ny } = this.#chart;
    const [column, row] = this.#cell ?? [nx >> 1, ny >> 1];
    const inside = (value, end) => Math.min(Math.max(value, 0), end - 1);
    this.#select([inside(column + step[0], nx), inside(row + step[1], ny)]);
  }

  #select(cell) {
    if (`${cell}` === `${this.#cell}`) return;
    this.#cell = cell;
    this.draw();
    this.#tell();
  }

  #tell() {
    const chart = this.#chart;
    if (chart && this.#cell && (this.#cell[0] >= chart.nx || this.#cell[1] >= chart.ny)) this.#cell = null;
    if (!chart || !this.#cell) {
      const how = "Point at the map, or focus it and use the arrow keys";
      setText(byId("map-readout"), chart ? `${how}${this.takesLines ? "; drag to draw a section" : ""}.` : DASH);
      return;
    }
    const [column, row] = this.#cell;
    const [x, y] = [chart.x0_mm + column * chart.dx_mm, chart.y0_mm + row * chart.dy_mm];
    const what = this.#defects.at([x, y], this.#wideMm()) ?? this.#regions.at([x, y]);
    const told = `x ${fixed(x, 3)} mm, y ${fixed(y, 3)} mm: ${sayCell(this.#layer, chart, row * chart.nx + column)}`;
    setText(byId("map-readout"), what ? `${told}; ${what}` : told);
  }
}

/** The highest or lowest place of a view: its value, and the frame that its name states. */
function extreme(view, name) {
  const blocks = view?.chapters.find(({ id }) => id === "deviation")?.blocks ?? [];
  const fact = blocks.flatMap(({ facts }) => facts ?? []).find((one) => one.name.startsWith(name));
  return fact ? [fact.value, ...fact.name.split(", ").slice(1)].join(", ") : DASH;
}

function small(text) {
  const element = document.createElement("small");
  element.textContent = text;
  return element;
}

/** A filled square of this colour. A drawing, since style attributes are not allowed here. */
function swatch(rgb) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [16, 16];
  const pen = canvas.getContext("2d");
  pen.fillStyle = css(rgb);
  pen.fillRect(0, 0, 16, 16);
  return canvas;
}
