// What is drawn over the cells of a map: what is beyond a limit, regions to measure next, defects, a section, marks.

import { beyondPattern, toPixels } from "./axes.js";
import { known } from "./format.js";

/** Hatches the cells whose value is above the limit, and draws a line around them. Gives how many there are. */
export function drawBeyond(pen, { left, top, wide, high }, { nx, ny, values, limit }) {
  if (!known(limit)) return 0;
  const beyond = (column, row) => {
    const inside = column >= 0 && column < nx && row >= 0 && row < ny;
    return inside && known(values[row * nx + column]) && values[row * nx + column] > limit;
  };
  const [w, h] = [wide / nx, high / ny];
  const [cells, outline] = [new Path2D(), new Path2D()];
  let count = 0;
  for (let row = 0; row < ny; row += 1) {
    for (let column = 0; column < nx; column += 1) {
      if (!beyond(column, row)) continue;
      count += 1;
      const [x, y] = [left + column * w, top + high - (row + 1) * h];
      cells.rect(x, y, w, h);
      const side = (outer, x1, y1, x2, y2) => {
        if (outer) return;
        outline.moveTo(x1, y1);
        outline.lineTo(x2, y2);
      };
      side(beyond(column - 1, row), x, y, x, y + h);
      side(beyond(column + 1, row), x + w, y, x + w, y + h);
      side(beyond(column, row + 1), x, y, x + w, y);
      side(beyond(column, row - 1), x, y + h, x + w, y + h);
    }
  }
  pen.fillStyle = beyondPattern(pen);
  pen.fill(cells);
  stroke(pen, outline, 1.2);
  return count;
}

/** Outlines the regions and writes their ranks; the chosen one stands out. */
export function drawRegions(pen, frame, regions, chosen) {
  regions.forEach(({ lines, at }, index) => {
    const path = new Path2D();
    for (const one of lines) {
      one.forEach((place, k) => path[k ? "lineTo" : "moveTo"](...toPixels(frame, place)));
      path.closePath();
    }
    stroke(pen, path, index === chosen ? 3 : 1.6, index === chosen ? [] : [6, 3]);
    const [x, y] = toPixels(frame, at);
    pen.beginPath();
    pen.arc(x, y, 9, 0, 2 * Math.PI);
    pen.fillStyle = index === chosen ? "#111" : "#fff";
    pen.fill();
    pen.lineWidth = 1.5;
    pen.strokeStyle = "#111";
    pen.stroke();
    pen.fillStyle = index === chosen ? "#fff" : "#111";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText(String(index + 1), x, y + 0.5);
  });
}

/** Marks the defects: a diamond with a number beside it, and of what is long its line; the chosen one stands out. */
export function drawDefects(pen, frame, defects, chosen) {
  defects.forEach(({ at, line }, index) => {
    const wide = index === chosen ? 3 : 1.6;
    if (line) {
      const path = new Path2D();
      line.forEach((place, k) => path[k ? "lineTo" : "moveTo"](...toPixels(frame, place)));
      stroke(pen, path, wide);
    }
    const [x, y] = toPixels(frame, at);
    const size = index === chosen ? 9 : 6;
    const diamond = new Path2D();
    [[0, -size], [size, 0], [0, size], [-size, 0]].forEach(([dx, dy], k) => diamond[k ? "lineTo" : "moveTo"](x + dx, y + dy));
    diamond.closePath();
    stroke(pen, diamond, wide);
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    pen.lineWidth = 3;
    pen.strokeStyle = "#fff";
    pen.strokeText(String(index + 1), x + size + 3, y);
    pen.fillStyle = "#111";
    pen.fillText(String(index + 1), x + size + 3, y);
  });
}

/** The lines of a contour, its ends as rings and its junctions as squares. */
export function drawContour(pen, frame, { lines, ends, junctions }) {
  const path = new Path2D();
  for (const { closed, places } of lines) {
    places.forEach((place, k) => path[k ? "lineTo" : "moveTo"](...toPixels(frame, place)));
    if (closed) path.closePath();
  }
  stroke(pen, path, 1.6);
  for (const place of ends) dot(pen, toPixels(frame, place), 4, false);
  for (const place of junctions) {
    const [x, y] = toPixels(frame, place);
    pen.fillStyle = "#fff";
    pen.fillRect(x - 4.5, y - 4.5, 9, 9);
    pen.fillStyle = "#111";
    pen.fillRect(x - 3, y - 3, 6, 6);
  }
}

/** The boxes of parts with number and answer; of what failed or is unknown the lines are broken. */
export function drawParts(pen, frame, parts) {
  for (const { number, word, corners } of parts) {
    const path = new Path2D();
    corners.forEach((place, k) => path[k ? "lineTo" : "moveTo"](...toPixels(frame, place)));
    path.closePath();
    pen.setLineDash(word === "FAIL" || word === "unknown" ? [6, 4] : []);
    stroke(pen, path, 1.2);
    pen.setLineDash([]);
    const pixels = corners.map((place) => toPixels(frame, place));
    const [x, y] = [Math.min(...pixels.map(([x]) => x)) + 3, Math.min(...pixels.map(([, y]) => y)) + 3];
    pen.textAlign = "left";
    pen.textBaseline = "top";
    pen.lineWidth = 3;
    pen.strokeStyle = "#fff";
    pen.strokeText(`${number} ${word}`, x, y);
    pen.fillStyle = "#111";
    pen.fillText(`${number} ${word}`, x, y);
  }
}

/** A section's path, its beginning as a dot, and the place under the cursor of its profile as a ring. */
export function drawSection(pen, frame, lines, cursor) {
  for (const places of lines) {
    const path = new Path2D();
    places.forEach((place, k) => path[k ? "lineTo" : "moveTo"](...toPixels(frame, place)));
    stroke(pen, path, 2);
  }
  const start = lines[0]?.[0];
  if (start) dot(pen, toPixels(frame, start), 4, true);
  if (cursor) dot(pen, toPixels(frame, cursor), 6, false);
}

/** A triangle whose inner corner stands on the place; up for the largest, down for the smallest. */
export function drawMark(pen, frame, place, direction) {
  const { left, top, wide, high } = frame;
  const [x, y] = toPixels(frame, place);
  if (!known(x) || !known(y) || x < left || x > left + wide || y < top || y > top + high) return;
  const size = 7;
  pen.beginPath();
  pen.moveTo(x, y + direction * size);
  pen.lineTo(x - size, y - direction * size * 0.8);
  pen.lineTo(x + size, y - direction * size * 0.8);
  pen.closePath();
  pen.fillStyle = "#111";
  pen.strokeStyle = "#fff";
  pen.lineWidth = 2;
  pen.stroke();
  pen.fill();
}

/** The cell under the cursor. */
export function drawCursor(pen, { left, top, wide, high }, { nx, ny }, [column, row]) {
  const [w, h] = [wide / nx, high / ny];
  pen.lineWidth = 1.5;
  pen.strokeStyle = "#fff";
  pen.strokeRect(left + column * w - 2, top + high - (row + 1) * h - 2, w + 4, h + 4);
  pen.strokeStyle = "#111";
  pen.strokeRect(left + column * w - 3.5, top + high - (row + 1) * h - 3.5, w + 7, h + 7);
}

/** Dark between light edges: to be seen on every colour. */
function stroke(pen, path, width, dash = []) {
  pen.lineWidth = width + 2;
  pen.strokeStyle = "rgba(255, 255, 255, .9)";
  pen.setLineDash([]);
  pen.stroke(path);
  pen.lineWidth = width;
  pen.strokeStyle = "#111";
  pen.setLineDash(dash);
  pen.stroke(path);
  pen.setLineDash([]);
}

function dot(pen, [x, y], radius, filled) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.lineWidth = 4;
  pen.strokeStyle = "#fff";
  pen.stroke();
  pen.lineWidth = 2;
  pen.strokeStyle = "#111";
  pen.stroke();
  pen.fillStyle = "#111";
  if (filled) pen.fill();
}
