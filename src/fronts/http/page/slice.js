// One slice through a volume: its slider, its picture, the line at the threshold, points and cells on it.

import { css } from "./colours.js";
import { byId, colour, make, setText } from "./dom.js";
import { fixed, known, signedNm, significant } from "./format.js";
import { areAlong, placeMm } from "./lattice.js";
import { askStation } from "./token.js";

const WITHIN = [[1, 2], [0, 2], [0, 1]];
const NAMES = ["x", "y", "z"];
const LINE = "#12d6b4";
const MARGIN = 8;

export class SliceView {
  #name;
  #axis;
  #token;
  #canvas;
  #slider;
  #volume = null;
  #slice = null;
  #picture = null;
  #busy = false;
  #colours = null;
  #shown = {};
  #chosen = null;
  #frame = null;
  /** Called when another slice is wanted. */
  onMove = () => {};
  /** Called with a place in samples that was pressed. */
  onPick = () => {};

  constructor(name, axis, token) {
    [this.#name, this.#axis, this.#token] = [name, axis, token];
    this.#canvas = byId(`slice-${name}`);
    this.#slider = byId(`slice-${name}-at`);
    this.#slider.oninput = () => {
      this.#sayPlace();
      this.onMove();
      this.#fetch();
    };
    this.#canvas.onpointermove = ({ offsetX, offsetY }) => this.#tell(this.#placeAt(offsetX, offsetY));
    this.#canvas.onpointerleave = () => this.#tell(null);
    this.#canvas.onclick = ({ offsetX, offsetY }) => {
      const place = this.#placeAt(offsetX, offsetY);
      if (place) this.onPick(place);
    };
    new ResizeObserver(() => this.#draw()).observe(this.#canvas);
  }

  /** The sample across which the slice lies. */
  get index() {
    return this.#slider.valueAsNumber;
  }

  /** Takes another volume, and shows its middle. */
  take(volume) {
    this.#volume = volume;
    this.#slice = null;
    const last = volume.size[this.#axis] - 1;
    this.#slider.max = last;
    this.#slider.value = Math.floor(last / 2);
    this.#sayPlace();
    this.#fetch();
  }

  move(index) {
    const last = this.#volume.size[this.#axis] - 1;
    this.#slider.value = Math.min(Math.max(index, 0), last);
    this.#sayPlace();
    this.#fetch();
  }

  show(colours, shown, chosen) {
    [this.#colours, this.#shown, this.#chosen] = [colours, shown, chosen];
    this.#draw();
  }

  /** Asks for the slice that is wanted; while one is on its way the newest wish counts. */
  async #fetch() {
    const wanted = this.index;
    if (this.#busy || this.#slice?.index === wanted) return;
    this.#busy = true;
    const slice = await askStation(`/api/v1/volume/slice?axis=${this.#name}&index=${wanted}`, this.#token);
    this.#busy = false;
    if (!slice) {
      setText(byId(`slice-${this.#name}-readout`), "The station does not answer with this slice.");
      return;
    }
    this.#slice = slice;
    this.#picture = pictureOf(slice);
    this.#draw();
    this.#tell(null);
    this.#fetch();
  }

  #sayPlace() {
    const { steps_mm, origin_mm } = this.#volume;
    // Of turned or slanted axes a slice has no one coordinate.
    const text = areAlong(steps_mm)
      ? `${this.#name} = ${fixed(origin_mm[this.#axis] + this.index * steps_mm[this.#axis][this.#axis], 3)} mm`
      : `slice ${this.index} of axis ${this.#name}`;
    setText(byId(`slice-${this.#name}-place`), text);
    this.#slider.setAttribute("aria-valuetext", `${text}, slice ${this.index} of ${this.#volume.size[this.#axis]}`);
  }

  /** Lengths of a sample along the columns and rows, mm. */
  #spacing() {
    return WITHIN[this.#axis].map((axis) => Math.hypot(...this.#volume.steps_mm[axis]));
  }

  #draw() {
    const canvas = this.#canvas;
    const ratio = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0 || !this.#slice || !this.#colours) return;
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const { columns, rows, step, contour, points } = this.#slice;
    const [dx, dy] = this.#spacing();
    const [spanX, spanY] = [columns * step * dx, rows * step * dy];
    const perMm = Math.min((width - 2 * MARGIN) / spanX, (height - 2 * MARGIN) / spanY);
    const [wide, high] = [spanX * perMm, spanY * perMm];
    const [left, top] = [(width - wide) / 2, (height - high) / 2];
    this.#frame = { left, top, wide, high, x: dx * perMm, y: dy * perMm, half: step / 2 };
    pen.imageSmoothingEnabled = false;
    // The first row has the smallest place: it stands at the bottom.
    pen.drawImage(this.#picture, left, top, wide, high);
    pen.strokeStyle = colour("edge");
    pen.strokeRect(left - 0.5, top - 0.5, wide + 1, high + 1);
    if (this.#shown.contour) this.#drawContour(pen, contour);
    if (this.#shown.points) this.#drawPoints(pen, points);
    const cells = this.#shown.cells ? this.#drawCells(pen) : 0;
    // For the browser test.
    Object.assign(canvas.dataset, {
      index: this.#slice.index,
      contour: this.#shown.contour ? contour.length : 0,
      points: this.#shown.points ? points.length : 0,
      cells,
    });
  }

  /** A place of the slice, in samples, on the canvas. */
  #pixel([column, row]) {
    const { left, top, high, x, y, half } = this.#frame;
    return [left + (column + half) * x, top + high - (row + half) * y];
  }

  #drawContour(pen, contour) {
    const path = new Path2D();
    for (const [x1, y1, x2, y2] of contour) {
      path.moveTo(...this.#pixel([x1, y1]));
      path.lineTo(...this.#pixel([x2, y2]));
    }
    pen.lineCap = "round";
    for (const [style, width] of [["rgba(0, 0, 0, .75)", 3.4], [LINE, 1.6]]) {
      pen.strokeStyle = style;
      pen.lineWidth = width;
      pen.stroke(path);
    }
  }

  #drawPoints(pen, points) {
    const { table, scale } = this.#colours;
    for (const [column, row, nm] of points) {
      const [x, y] = this.#pixel([column, row]);
      pen.fillStyle = css(table(nm / scale));
      pen.beginPath();
      pen.arc(x, y, 2.4, 0, 2 * Math.PI);
      pen.fill();
    }
  }

  /** Boxes with a cross where a cell is at fault; gives how many lie here. */
  #drawCells(pen) {
    const here = this.#volume.grid.cells.filter(({ at }) => Math.abs(at[this.#axis] - this.#slice.index) <= 0.5);
    for (const cell of here) {
      const [x, y] = this.#pixel(WITHIN[this.#axis].map((axis) => cell.at[axis]));
      const size = cell === this.#chosen ? 11 : 6;
      const path = new Path2D();
      path.rect(x - size, y - size, 2 * size, 2 * size);
      path.moveTo(x - size, y - size);
      path.lineTo(x + size, y + size);
      path.moveTo(x - size, y + size);
      path.lineTo(x + size, y - size);
      for (const [style, width] of [["#fff", 4], ["#c2183c", 2]]) {
        pen.strokeStyle = style;
        pen.lineWidth = width;
        pen.stroke(path);
      }
    }
    return here.length;
  }

  /** The place under the cursor in samples, all three of them; null beside the picture. */
  #placeAt(px, py) {
    if (!this.#frame || !this.#slice) return null;
    const { left, top, high, x, y, half } = this.#frame;
    const found = [(px - left) / x - half, (top + high - py) / y - half].map(Math.round);
    const inside = found.every((at, side) => at >= 0 && at < this.#volume.size[WITHIN[this.#axis][side]]);
    if (!inside) return null;
    const place = [0, 0, 0];
    place[this.#axis] = this.#slice.index;
    WITHIN[this.#axis].forEach((axis, side) => { place[axis] = found[side]; });
    return place;
  }

  #tell(place) {
    const readout = byId(`slice-${this.#name}-readout`);
    if (!this.#slice) return;
    if (!place) {
      const { contour_left_out: pieces, points_left_out: points } = this.#slice;
      const left = [pieces > 0 && `${pieces} pieces of the line`, points > 0 && `${points} points`].filter(Boolean);
      setText(readout, left.length ? `Not drawn: ${left.join(", ")}.` : "");
      return;
    }
    const { columns, step, points } = this.#slice;
    const [column, row] = WITHIN[this.#axis].map((axis) => place[axis]);
    const byte = this.#slice.bytes[Math.floor(row / step) * columns + Math.floor(column / step)];
    const [black, white] = this.#volume.shown_range;
    const grey = byte === 0 ? "no value" : `about ${significant(black + ((byte - 1) / 254) * (white - black), 4)}`;
    const near = points.find(([x, y]) => Math.hypot(x - column, y - row) < 1);
    const sample = [0, 0, 0];
    sample[this.#axis] = this.index;
    WITHIN[this.#axis].forEach((axis, side) => { sample[axis] = [column, row][side]; });
    const mm = placeMm(this.#volume.origin_mm, this.#volume.steps_mm, sample);
    // Along turned or slanted axes all three coordinates change.
    const axes = areAlong(this.#volume.steps_mm) ? WITHIN[this.#axis] : [0, 1, 2];
    const where = axes.map((axis) => `${NAMES[axis]} ${fixed(mm[axis], 3)}`).join(", ");
    setText(readout, `${where} mm: ${grey}${near && known(near[2]) ? `; deviation ${signedNm(near[2])} nm` : ""}`);
  }
}

/** The picture of a slice on a canvas of its own; the bytes stay with the slice. */
function pictureOf(slice) {
  const { columns, rows } = slice;
  slice.bytes = Uint8Array.from(atob(slice.pixels), (letter) => letter.charCodeAt(0));
  const canvas = make("canvas");
  [canvas.width, canvas.height] = [columns, rows];
  const pen = canvas.getContext("2d");
  const image = pen.createImageData(columns, rows);
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const byte = slice.bytes[(rows - 1 - row) * columns + column];
      // A sample without a value is a dull violet: no grey value looks like it.
      const rgb = byte === 0 ? [96, 60, 110] : [byte, byte, byte];
      image.data.set([...rgb, 255], 4 * (row * columns + column));
    }
  }
  pen.putImageData(image, 0, 0);
  return canvas;
}
