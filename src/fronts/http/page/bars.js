// Bar charts by uPlot, with the looks of the other charts.

import { axis } from "./plots.js";

/** Digits that a tick needs and no more. */
const plain = (_, ticks) => ticks.map((tick) => String(Number(tick.toPrecision(6))));

/**
 * A chart of bars in `place`. Each of `series` is `{ fill, line }`, functions that give the colours of now;
 * `share` is how much of its room a bar takes. `moved` is called with the place under the cursor, or null.
 */
export function barChart(place, { height, series, share, x, y, moved, drawn = () => {}, xRange }) {
  const size = () => ({ width: place.clientWidth, height });
  const paths = uPlot.paths.bars({ size: [share, Infinity], align: 0 });
  const chart = new uPlot({
    ...size(),
    padding: [8, 14, 0, 0],
    scales: { x: { time: false, range: xRange }, y: { range: (_, low, high) => fromZero(low, high) } },
    axes: [
      { ...axis, label: x.label, size: 30, space: 40, values: plain, incrs: x.incrs, grid: { show: false } },
      { ...axis, label: y.label, size: 62, values: plain, incrs: y.incrs },
    ],
    series: [
      { label: x.label },
      ...series.map(({ fill, line }) => ({ fill, stroke: line, width: 1, paths, points: { show: false } })),
    ],
    legend: { show: false },
    hooks: { setCursor: [(self) => moved(self.cursor.idx ?? null)], draw: [drawn] },
    cursor: { y: false, points: { show: false }, drag: { x: false, y: false } },
  }, [[], ...series.map(() => [])], place);
  new ResizeObserver(() => place.clientWidth > 0 && chart.setSize(size())).observe(place);
  return chart;
}

/** Bars stand on zero, whatever they are. */
function fromZero(low, high) {
  const [bottom, top] = [Math.min(low ?? 0, 0), Math.max(high ?? 0, 0)];
  const room = 0.08 * (top - bottom) || 1;
  return [bottom < 0 ? bottom - room : 0, top > 0 ? top + room : bottom < 0 ? 0 : 1];
}
