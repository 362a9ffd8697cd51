// The deviation map on a canvas: cells, axes in mm, colour bar in nm, marks, cursor.

import { css, diverging } from "./colours.js";
import { byId, colour, setText } from "./dom.js";
import { DASH, fixed, known, place, signedNm } from "./format.js";

const MARGIN = { left: 66, right: 104, top: 14, bottom: 44 };
const BAR_WIDTH = 16;
const BAR_MIN = 120;
const FONT = "12px system-ui, sans-serif";

export class DeviationMap {
  #canvas;
  #flip;
  #map = null;
  #deviation = null;
  #cell = null; // [column, row] under the cursor.
  #frame = null; // Where the cells stand, in CSS pixels.
  #scale = 1; // The colour bar ends at ± this, nm.
  #table = diverging(false);

  constructor(canvas, flip) {
    this.#canvas = canvas;
    this.#flip = flip;
    flip.onchange = () => {
      this.#paint();
      this.draw();
    };
    this.#paint();
    canvas.onpointermove = (event) => this.#point(event);
    canvas.onpointerleave = () => this.#select(null);
    canvas.onblur = () => this.#select(null);
    canvas.onkeydown = (event) => this.#key(event);
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** Takes the map (or null) and the deviation whose extremes are marked (or null). */
  update(map, deviation) {
    this.#map = map?.nx > 0 && map?.ny > 0 ? map : null;
    this.#deviation = deviation;
    setText(byId("map-max"), extreme(deviation?.max_nm, deviation?.at_max_mm));
    setText(byId("map-min"), extreme(deviation?.min_nm, deviation?.at_min_mm));
    byId("map-empty").hidden = this.#map !== null;
    this.draw();
    this.#tell();
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
    if (!this.#map) {
      this.#frame = null;
      delete canvas.dataset.plot;
      return;
    }
    this.#frame = place1to1(this.#map, width, height);
    this.#scale = scaleOf(this.#map.values_nm);
    this.#drawCells(pen);
    this.#drawAxes(pen);
    this.#drawBar(pen);
    this.#drawMarks(pen);
    this.#drawCursor(pen);
    // For the browser test: where the cells stand, in canvas pixels, and how large that is in mm.
    const { nx, ny, dx_mm: dx, dy_mm: dy } = this.#map;
    canvas.dataset.spanMm = `${nx * dx},${ny * dy}`;
    const { left, top, wide, high } = this.#frame;
    canvas.dataset.plot = [left, top, wide, high].map((v) => Math.round(v * ratio)).join(",");
  }

  /** Takes the colours the operator chose, into the legend too. */
  #paint() {
    this.#table = diverging(this.#flip.checked);
    byId("swatch-plus").replaceChildren(swatch(this.#table(0.75)));
    byId("swatch-minus").replaceChildren(swatch(this.#table(-0.75)));
  }

  #drawCells(pen) {
    const { nx, ny, values_nm: values } = this.#map;
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
        const [r, g, b] = this.#table(value / this.#scale);
        image.data.set([r, g, b, 255], at);
      }
    }
    context.putImageData(image, 0, 0);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(cells, left, top, wide, high);
  }

  #drawAxes(pen) {
    const { left, top, wide, high, perMm, x0, y0 } = this.#frame;
    pen.strokeStyle = colour("edge");
    pen.fillStyle = colour("quiet");
    pen.lineWidth = 1;
    pen.strokeRect(left - 0.5, top - 0.5, wide + 1, high + 1);
    const spanX = wide / perMm;
    const spanY = high / perMm;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const x of ticks(x0, x0 + spanX, Math.max(wide / 70, 2))) {
      const at = left + (x.value - x0) * perMm;
      line(pen, at, top + high, at, top + high + 5);
      pen.fillText(x.text, at, top + high + 8);
    }
    pen.fillText("x in mm", left + wide / 2, top + high + 26);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const y of ticks(y0, y0 + spanY, Math.max(high / 50, 1))) {
      const at = top + high - (y.value - y0) * perMm;
      line(pen, left - 5, at, left, at);
      pen.fillText(y.text, left - 8, at);
    }
    pen.save();
    pen.translate(left - 56, top + high / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText("y in mm", 0, 0);
    pen.restore();
  }

  #drawBar(pen) {
    const { left, top, wide } = this.#frame;
    // A map of few rows is flat; its scale is read all the same.
    const high = Math.max(this.#frame.high, BAR_MIN);
    const x = left + wide + 18;
    for (let row = 0; row < high; row += 1) {
      pen.fillStyle = css(this.#table(1 - (2 * row) / (high - 1)));
      pen.fillRect(x, top + row, BAR_WIDTH, 1.5);
    }
    pen.strokeStyle = colour("edge");
    pen.strokeRect(x - 0.5, top - 0.5, BAR_WIDTH + 1, high + 1);
    pen.fillStyle = colour("quiet");
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    const middle = top + high / 2;
    const decimals = decimalsOf(this.#scale / 2);
    for (const share of [-1, -0.5, 0, 0.5, 1]) {
      const at = middle - share * (high / 2);
      const text = fixed(share * this.#scale, decimals);
      line(pen, x + BAR_WIDTH, at, x + BAR_WIDTH + 4, at);
      pen.fillText(share > 0 ? `+${text}` : text, x + BAR_WIDTH + 7, at);
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    pen.fillText("nm", x + BAR_WIDTH / 2, top + high + 8);
  }

  #drawMarks(pen) {
    if (!this.#deviation) return;
    this.#drawMark(pen, this.#deviation.at_max_mm, -1);
    this.#drawMark(pen, this.#deviation.at_min_mm, 1);
  }

  /** A triangle whose inner corner stands on the place; up for the largest, down for the smallest. */
  #drawMark(pen, [x, y], direction) {
    const { left, top, wide, high, perMm, x0, y0 } = this.#frame;
    const px = left + (x - x0) * perMm;
    const py = top + high - (y - y0) * perMm;
    if (!known(x) || !known(y) || px < left || px > left + wide || py < top || py > top + high) return;
    const size = 7;
    pen.beginPath();
    pen.moveTo(px, py + direction * size);
    pen.lineTo(px - size, py - direction * size * 0.8);
    pen.lineTo(px + size, py - direction * size * 0.8);
    pen.closePath();
    pen.fillStyle = "#111";
    pen.strokeStyle = "#fff";
    pen.lineWidth = 2;
    pen.stroke();
    pen.fill();
  }

  #drawCursor(pen) {
    if (!this.#cell) return;
    const { left, top, high, perMm } = this.#frame;
    const [column, row] = this.#cell;
    const [w, h] = [this.#map.dx_mm * perMm, this.#map.dy_mm * perMm];
    pen.lineWidth = 1.5;
    pen.strokeStyle = "#fff";
    pen.strokeRect(left + column * w - 2, top + high - (row + 1) * h - 2, w + 4, h + 4);
    pen.strokeStyle = "#111";
    pen.strokeRect(left + column * w - 3.5, top + high - (row + 1) * h - 3.5, w + 7, h + 7);
  }

  #point(event) {
    if (!this.#frame) return;
    const { left, top, high, perMm } = this.#frame;
    const { nx, ny, dx_mm: dx, dy_mm: dy } = this.#map;
    const column = Math.floor((event.offsetX - left) / perMm / dx);
    const row = Math.floor((top + high - event.offsetY) / perMm / dy);
    this.#select(column >= 0 && column < nx && row >= 0 && row < ny ? [column, row] : null);
  }

  #key(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step || !this.#map) return;
    event.preventDefault();
    const { nx, ny } = this.#map;
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
    const map = this.#map;
    if (map && this.#cell && (this.#cell[0] >= map.nx || this.#cell[1] >= map.ny)) this.#cell = null;
    if (!map || !this.#cell) {
      setText(byId("map-readout"), map ? "Point at the map, or focus it and use the arrow keys." : DASH);
      return;
    }
    const [column, row] = this.#cell;
    const value = map.values_nm[row * map.nx + column];
    const x = fixed(map.x0_mm + column * map.dx_mm, 3);
    const y = fixed(map.y0_mm + row * map.dy_mm, 3);
    setText(byId("map-readout"), `x ${x} mm, y ${y} mm: ${known(value) ? `${signedNm(value)} nm` : "no data"}`);
  }
}

/** The largest square-pixel frame of the map inside the canvas. */
function place1to1(map, width, height) {
  const spanX = map.nx * map.dx_mm;
  const spanY = map.ny * map.dy_mm;
  const roomX = Math.max(width - MARGIN.left - MARGIN.right, 20);
  const roomY = Math.max(height - MARGIN.top - MARGIN.bottom, 20);
  const perMm = Math.min(roomX / spanX, roomY / spanY);
  const [wide, high] = [spanX * perMm, spanY * perMm];
  return {
    left: Math.round(MARGIN.left + (roomX - wide) / 2),
    top: MARGIN.top,
    wide,
    high,
    perMm,
    x0: map.x0_mm - map.dx_mm / 2,
    y0: map.y0_mm - map.dy_mm / 2,
  };
}

/** The next round number at or above the largest size: the scale does not tremble with every point. */
function scaleOf(values) {
  let largest = 0;
  for (const value of values) if (known(value)) largest = Math.max(largest, Math.abs(value));
  if (largest === 0) return 1;
  const power = 10 ** Math.floor(Math.log10(largest));
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((m) => m * power >= largest * (1 - 1e-9)) * power;
}

/** Round numbers from `low` to `high`, about `wanted` of them, all with the same decimals. */
function ticks(low, high, wanted) {
  const rough = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((m) => m * power >= rough) * power;
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const list = [];
  const end = Math.floor(high / step + 1e-9);
  for (let k = Math.ceil(low / step - 1e-9); k <= end; k += 1) {
    list.push({ value: k * step, text: fixed(k * step, decimals) });
  }
  return list;
}

/** How many decimals write a round number in full. */
function decimalsOf(value) {
  let decimals = 0;
  while (decimals < 6 && Math.abs(value * 10 ** decimals - Math.round(value * 10 ** decimals)) > 1e-6) {
    decimals += 1;
  }
  return decimals;
}

function line(pen, x1, y1, x2, y2) {
  pen.beginPath();
  pen.moveTo(x1, y1);
  pen.lineTo(x2, y2);
  pen.stroke();
}

function noDataPattern(pen) {
  const tile = new OffscreenCanvas(6, 6);
  const context = tile.getContext("2d");
  context.fillStyle = colour("no-data");
  context.fillRect(0, 0, 6, 6);
  context.strokeStyle = colour("no-data-line");
  context.lineWidth = 1;
  for (const shift of [-6, 0, 6]) line(context, shift - 1, 7, shift + 7, -1);
  return pen.createPattern(tile, "repeat");
}

const extreme = (value, point) => (known(value) ? `${signedNm(value)} nm at ${place(point)}` : DASH);

/** A filled square of this colour. A drawing, since style attributes are not allowed here. */
function swatch(rgb) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [16, 16];
  const pen = canvas.getContext("2d");
  pen.fillStyle = css(rgb);
  pen.fillRect(0, 0, 16, 16);
  return canvas;
}
