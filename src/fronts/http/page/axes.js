// The frame of a map on its canvas: where the cells stand, axes in mm, the colour bar, patterns.

import { css } from "./colours.js";
import { colour } from "./dom.js";
import { fixed } from "./format.js";

const MARGIN = { left: 66, right: 104, top: 14, bottom: 44 };
const BAR_WIDTH = 16;
const BAR_MIN = 120;

/** The largest square-pixel frame of a chart inside the canvas. */
export function place1to1(chart, width, height) {
  const spanX = chart.nx * chart.dx_mm;
  const spanY = chart.ny * chart.dy_mm;
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
    x0: chart.x0_mm - chart.dx_mm / 2,
    y0: chart.y0_mm - chart.dy_mm / 2,
  };
}

/** A place in mm as a place on the canvas, and the other way round. */
export const toPixels = ({ left, top, high, perMm, x0, y0 }, [x, y]) =>
  [left + (x - x0) * perMm, top + high - (y - y0) * perMm];
export const toMm = ({ left, top, high, perMm, x0, y0 }, [px, py]) =>
  [x0 + (px - left) / perMm, y0 + (top + high - py) / perMm];

/** Axes of a map; `where` is the frame that its x and y are of. */
export function drawAxes(pen, { left, top, wide, high, perMm, x0, y0 }, where = "part frame") {
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
  pen.fillText(`x in mm, ${where}`, left + wide / 2, top + high + 26);
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
  pen.fillText(`y in mm, ${where}`, 0, 0);
  pen.restore();
}

/** The colours from `low` to `high`; above, where values are cut off there; the limit as a line across. */
export function drawBar(pen, frame, { table, low, high, unit, limit, cut }) {
  const { left, top, wide } = frame;
  // A map of few rows is flat; its scale is read all the same.
  const tall = Math.max(frame.high, BAR_MIN);
  const x = left + wide + 18;
  const share = (value) => (value - low) / (high - low);
  for (let row = 0; row < tall; row += 1) {
    const at = 1 - row / (tall - 1);
    pen.fillStyle = css(table(low < 0 ? 2 * at - 1 : at));
    pen.fillRect(x, top + row, BAR_WIDTH, 1.5);
  }
  pen.strokeStyle = colour("edge");
  pen.strokeRect(x - 0.5, top - 0.5, BAR_WIDTH + 1, tall + 1);
  pen.fillStyle = colour("quiet");
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  const step = (high - low) / 4;
  const decimals = decimalsOf(step);
  for (const part of [0, 1, 2, 3, 4]) {
    const value = part === 2 && low < 0 ? 0 : low + part * step;
    const at = top + tall * (1 - share(value));
    const text = fixed(value, decimals);
    line(pen, x + BAR_WIDTH, at, x + BAR_WIDTH + 4, at);
    const sign = low < 0 && value > 0 ? "+" : cut && part === 4 ? "≥ " : "";
    pen.fillText(`${sign}${text}`, x + BAR_WIDTH + 7, at);
  }
  if (limit && limit < high) {
    const at = top + tall * (1 - share(limit));
    pen.strokeStyle = colour("ink");
    pen.lineWidth = 2;
    line(pen, x - 5, at, x + BAR_WIDTH + 3, at);
  }
  pen.textAlign = "center";
  pen.textBaseline = "top";
  pen.fillText(unit, x + BAR_WIDTH / 2, top + tall + 8);
}

/** What stands where nothing is known. */
export function noDataPattern(pen) {
  return stripes(pen, colour("no-data"), [[colour("no-data-line"), 1]], -1);
}

/** What stands over what is beyond a limit: dark and light, to be seen on every colour, and leaning the other way. */
export function beyondPattern(pen) {
  return stripes(pen, null, [["rgba(255, 255, 255, .85)", 2.4], ["#111", 1.1]], 1);
}

function stripes(pen, ground, lines, lean) {
  const tile = new OffscreenCanvas(6, 6);
  const context = tile.getContext("2d");
  if (ground) {
    context.fillStyle = ground;
    context.fillRect(0, 0, 6, 6);
  }
  for (const [style, width] of lines) {
    context.strokeStyle = style;
    context.lineWidth = width;
    for (const shift of [-6, 0, 6]) {
      if (lean < 0) line(context, shift - 1, 7, shift + 7, -1);
      else line(context, shift - 1, -1, shift + 7, 7);
    }
  }
  return pen.createPattern(tile, "repeat");
}

export function line(pen, x1, y1, x2, y2) {
  pen.beginPath();
  pen.moveTo(x1, y1);
  pen.lineTo(x2, y2);
  pen.stroke();
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
