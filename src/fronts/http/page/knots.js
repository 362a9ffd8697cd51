// Places where lines of a contour end or meet.

/** Ends of open lines that no other line has, and places that several share. */
export function knots(chains) {
  const places = new Map();
  for (const { closed, points_mm: points } of chains) {
    if (closed || points.length === 0) continue;
    for (const place of [points[0], points[points.length - 1]]) {
      const at = places.get(`${place}`) ?? { place, lines: 0 };
      at.lines += 1;
      places.set(`${place}`, at);
    }
  }
  const all = [...places.values()];
  const placesOf = (wanted) => all.filter(wanted).map(({ place }) => place);
  return { ends: placesOf(({ lines }) => lines === 1), junctions: placesOf(({ lines }) => lines > 1) };
}
