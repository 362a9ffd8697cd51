// The faces of a volume in space, coloured by their deviation; turned by dragging or with the arrow keys.

import { css } from "./colours.js";
import { byId, colour } from "./dom.js";

const HOME = [0.6, -0.5]; // Turn about the vertical and tilt, rad.
const TURN_RAD = Math.PI / 24;
const DRAG_RAD = 0.008;
const TILT_MOST = Math.PI / 2;
const MARGIN = 14;

export class SolidView {
  #canvas = byId("solid");
  #volume = null;
  #places = []; // Of each face: place in mm about the middle, and deviation.
  #boxMm = [1, 1, 1];
  #turn = [...HOME];
  #drag = null;
  #shown = null;
  #waiting = false;

  constructor() {
    const canvas = this.#canvas;
    canvas.onpointerdown = (event) => {
      if (event.button !== 0) return;
      this.#drag = [event.clientX, event.clientY, ...this.#turn];
      canvas.setPointerCapture(event.pointerId);
    };
    canvas.onpointermove = (event) => {
      if (!this.#drag) return;
      const [x, y, turn, tilt] = this.#drag;
      this.#to(turn + (event.clientX - x) * DRAG_RAD, tilt + (event.clientY - y) * DRAG_RAD);
    };
    canvas.onpointerup = canvas.onpointercancel = () => { this.#drag = null; };
    canvas.onkeydown = (event) => this.#key(event);
    new ResizeObserver(() => this.#soon()).observe(canvas);
  }

  take(volume) {
    this.#volume = volume;
    this.#boxMm = volume.size.map((side, axis) => side * Math.hypot(...volume.steps_mm[axis]));
    this.#places = volume.faces.map((face) => face.places.map((place) => [...this.#centred(place), place[3]]));
    this.#turn = [...HOME];
  }

  /** `{ table, scale, faces, at, cells, chosen }`: colours, which faces, where the slices lie, whether cells are drawn, which is chosen. */
  show(shown) {
    this.#shown = shown;
    this.#soon();
  }

  /** A place in samples as mm about the middle of the volume. */
  #centred(place) {
    return [0, 1, 2].map((i) => this.#volume.steps_mm.reduce((sum, step, axis) =>
      sum + step[i] * (place[axis] - (this.#volume.size[axis] - 1) / 2), 0));
  }

  #key(event) {
    const [turn, tilt] = this.#turn;
    const to = {
      ArrowLeft: [turn - TURN_RAD, tilt],
      ArrowRight: [turn + TURN_RAD, tilt],
      ArrowUp: [turn, tilt - TURN_RAD],
      ArrowDown: [turn, tilt + TURN_RAD],
      Home: HOME,
    }[event.key];
    if (!to) return;
    event.preventDefault();
    this.#to(...to);
  }

  #to(turn, tilt) {
    this.#turn = [turn, Math.min(Math.max(tilt, -TILT_MOST), TILT_MOST)];
    this.#soon();
  }

  /** Once a frame, however often it is asked for. */
  #soon() {
    if (this.#waiting) return;
    this.#waiting = true;
    requestAnimationFrame(() => {
      this.#waiting = false;
      this.#draw();
    });
  }

  /** Right, up and towards the eye of a place. */
  #seen([x, y, z]) {
    const [turn, tilt] = this.#turn;
    const [s, c] = [Math.sin(turn), Math.cos(turn)];
    const [right, away] = [c * x - s * y, s * x + c * y];
    const [st, ct] = [Math.sin(tilt), Math.cos(tilt)];
    return [right, ct * z - st * away, -ct * away - st * z];
  }

  #draw() {
    const canvas = this.#canvas;
    const ratio = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0 || !this.#volume || !this.#shown) return;
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const reach = Math.hypot(...this.#boxMm);
    const perMm = (Math.min(width, height * 1.3) - 2 * MARGIN) / reach;
    const pixel = ([right, up]) => [width / 2 + right * perMm, height / 2 - up * perMm];
    this.#drawBox(pen, pixel, false);
    const drawn = this.#drawFaces(pen, pixel, perMm);
    this.#drawBox(pen, pixel, true);
    const cells = this.#shown.cells ? this.#drawCells(pen, pixel) : 0;
    Object.assign(canvas.dataset, { faces: drawn, cells, turn: this.#turn.map((rad) => rad.toFixed(3)).join(",") });
  }

  /** Squares from far to near. Gives how many. */
  #drawFaces(pen, pixel, perMm) {
    const { table, scale, faces } = this.#shown;
    const spacing = Math.max(...this.#volume.steps_mm.map((step) => Math.hypot(...step)));
    const squares = this.#places.flatMap((places, index) => {
      if (!faces[index]) return [];
      const side = 1.25 * spacing * this.#volume.faces[index].gathered * perMm;
      return places.map((place) => ({ seen: this.#seen(place), nm: place[3], side: Math.max(side, 1.5) }));
    });
    squares.sort((a, b) => a.seen[2] - b.seen[2]);
    for (const { seen, nm, side } of squares) {
      const [x, y] = pixel(seen);
      pen.fillStyle = css(table(nm / scale));
      pen.fillRect(x - side / 2, y - side / 2, side, side);
    }
    return squares.length;
  }

  /** The volume and its slices as frames: behind the faces those edges that lie behind, before them the others. */
  #drawBox(pen, pixel, inFront) {
    const half = this.#volume.size.map((side) => [-0.5, side - 0.5]);
    const corner = (bits) => [0, 1, 2].map((axis) => half[axis][(bits >> axis) & 1]);
    const edges = [];
    for (let bits = 0; bits < 8; bits += 1) {
      for (const axis of [0, 1, 2]) {
        if (!((bits >> axis) & 1)) edges.push({ ends: [corner(bits), corner(bits | (1 << axis))], style: "edge" });
      }
    }
    this.#shown.at.forEach((at, axis) => {
      const [u, v] = [0, 1, 2].filter((other) => other !== axis);
      const of = (a, b) => {
        const place = [at, at, at];
        [place[u], place[v]] = [half[u][a], half[v][b]];
        return place;
      };
      const ring = [of(0, 0), of(1, 0), of(1, 1), of(0, 1)];
      ring.forEach((from, side) => edges.push({ ends: [from, ring[(side + 1) % 4]], style: "accent" }));
    });
    pen.lineWidth = 1;
    for (const { ends, style } of edges) {
      const [from, to] = ends.map((end) => this.#seen(this.#centred(end)));
      if ((from[2] + to[2] >= 0) !== inFront) continue;
      pen.strokeStyle = colour(style);
      pen.beginPath();
      pen.moveTo(...pixel(from));
      pen.lineTo(...pixel(to));
      pen.stroke();
    }
    if (!inFront) return;
    pen.fillStyle = colour("quiet");
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    ["x", "y", "z"].forEach((name, axis) => {
      const end = half.map(([low]) => low);
      end[axis] = half[axis][1] + 0.06 * Math.max(...this.#volume.size);
      pen.fillText(name, ...pixel(this.#seen(this.#centred(end))));
    });
  }

  #drawCells(pen, pixel) {
    const { cells } = this.#volume.grid;
    cells.forEach((cell, index) => {
      const [x, y] = pixel(this.#seen(this.#centred(cell.at)));
      const size = index === this.#shown.chosen ? 9 : 4.5;
      for (const [style, width] of [["#fff", 4], ["#c2183c", 2]]) {
        pen.strokeStyle = style;
        pen.lineWidth = width;
        pen.beginPath();
        pen.moveTo(x - size, y - size);
        pen.lineTo(x + size, y + size);
        pen.moveTo(x - size, y + size);
        pen.lineTo(x + size, y - size);
        pen.stroke();
      }
    });
    return cells.length;
  }
}
