// A section's answer as columns to draw, and what of its way is missing.

/**
 * The columns of a profile: way in mm, value, index of the point. Between two pieces stands a point without
 * a value, so that nothing is drawn there.
 */
export function columns(section) {
  const { piece, deviation_nm: deviation, z_mm: z } = section.points;
  const way = wayOf(section);
  const mean = section.height?.mean_mm ?? 0;
  const data = [[], [], []];
  way.forEach((s, k) => {
    if (k > 0 && piece[k] !== piece[k - 1]) push(data, (way[k - 1] + s) / 2, null, null);
    push(data, s, deviation ? deviation[k] : (z[k] - mean) * 1e3, k);
  });
  return data;
}

/** The way of each point; pieces that a plane cuts out each begin at 0, and are laid one behind the other. */
function wayOf({ path, pieces, points }) {
  if (path.kind !== "plane") return points.s_mm;
  const before = [0];
  pieces.forEach(({ to_s_mm: length }) => before.push(before.at(-1) + length));
  return points.s_mm.map((s, k) => before[points.piece[k]] + s);
}

function push(data, ...values) {
  values.forEach((value, column) => data[column].push(value));
}

/** The stretches of a way of `length` mm that no piece covers; at its ends, where the length is known. */
export function gaps(section, length) {
  if (section.path.kind === "plane") return [];
  const found = [];
  let reached = length !== null ? 0 : section.pieces[0]?.from_s_mm ?? 0;
  const end = length ?? section.pieces.at(-1)?.to_s_mm ?? 0;
  for (const { from_s_mm, to_s_mm } of [...section.pieces, { from_s_mm: end, to_s_mm: end }]) {
    if (from_s_mm - reached > 1e-9 * Math.max(end, 1)) found.push([reached, from_s_mm]);
    reached = Math.max(reached, to_s_mm);
  }
  return found;
}

/** How long the path is, mm; null of a radius and a plane, which end where the surface does. */
export function lengthOf({ kind, from_mm: from, to_mm: to, radius_mm: radius }) {
  if (kind === "line") return Math.hypot(to[0] - from[0], to[1] - from[1]);
  return kind === "circle" ? 2 * Math.PI * radius : null;
}
