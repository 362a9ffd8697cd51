// From the part frame of the maps to the frame of the mesh and back, and where a region lies.
//
// The mesh lies in the plane of projection: along z its u and v are x and y of the measured frame. A part
// lies nearly straight there, so for drawing its height is left out: an error far below a pixel.

const numbers = (list) => Array.isArray(list) && typeof list[0] === "number";
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Where the part lies, as of one snapshot. Without a fit both frames are the same. */
export class Frames {
  #axes = [[1, 0], [0, 1]]; // What x and y of the part are in the plane, row by row.
  #shift = [0, 0];
  #plane = null; // u and v in the measured frame; null along z.

  constructor(pose, plane) {
    this.#plane = plane ? [plane.u, plane.v] : null;
    if (!pose) return;
    const [u, v] = this.#plane ?? [[1, 0, 0], [0, 1, 0]];
    const columns = turned(pose);
    const shift = [pose.tx_mm, pose.ty_mm, pose.tz_mm];
    this.#axes = [u, v].map((axis) => [dot(axis, columns[0]), dot(axis, columns[1])]);
    this.#shift = [dot(u, shift), dot(v, shift)];
  }

  static of({ form, mesh }) {
    return new Frames(form?.fit.pose, mesh?.projection?.plane);
  }

  /** The name of the frame of the mesh. */
  get name() {
    return this.#plane ? "plane of projection" : "measured frame";
  }

  /** A place of the part in the frame of the mesh. */
  toMesh([x, y]) {
    return this.#axes.map((row, i) => row[0] * x + row[1] * y + this.#shift[i]);
  }

  /** A place of the mesh in the part frame. */
  toPart([u, v]) {
    const [[a, b], [c, d]] = this.#axes;
    const [p, q] = [u - this.#shift[0], v - this.#shift[1]];
    const area = a * d - b * c;
    return [(d * p - b * q) / area, (a * q - c * p) / area];
  }

  /** A place of the measured frame, with or without its height, in the part frame. */
  measuredToPart(place) {
    const whole = this.#plane && place.length > 2;
    return this.toPart(whole ? this.#plane.map((axis) => dot(axis, place)) : place);
  }
}

/** The first two columns of Rz·Ry·Rx. */
function turned({ rx_rad, ry_rad, rz_rad }) {
  const [sx, sy, sz] = [rx_rad, ry_rad, rz_rad].map(Math.sin);
  const [cx, cy, cz] = [rx_rad, ry_rad, rz_rad].map(Math.cos);
  return [
    [cz * cy, sz * cy, -sy],
    [cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx],
  ];
}

/** All closed lines in a region's polygons, whichever way they are nested: lists of places. */
export function rings(shape) {
  if (Array.isArray(shape)) return numbers(shape[0]) ? [shape] : shape.flatMap(rings);
  return shape && typeof shape === "object" ? Object.values(shape).flatMap(rings) : [];
}

/** Whether a place lies within closed lines, holes left out. */
export function within(lines, [x, y]) {
  let inside = false;
  for (const line of lines) {
    line.forEach(([x1, y1], at) => {
      const [x0, y0] = line[(at || line.length) - 1];
      if (y0 > y !== y1 > y && x < x0 + ((x1 - x0) * (y - y0)) / (y1 - y0)) inside = !inside;
    });
  }
  return inside;
}
