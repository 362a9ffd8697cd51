// What the map can show: the form deviation, or the sampling. Each layer says its words, colours and scale.

import { diverging, sequential } from "./colours.js";
import { known, percent, signedNm, significant } from "./format.js";

const MOST = 0.99;
const SIDES = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];

/** The next round number at or above a size: a scale does not tremble with every point. */
export function roundUp(size) {
  if (!(size > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(size));
  return SIDES.find((m) => m * power >= size * (1 - 1e-9)) * power;
}

const sampled = {
  signed: false,
  table: () => sequential(),
  /** To where all but a few cells are, so that one sliver does not make the rest pale; at most to twice the limit. */
  scale(values, limit) {
    const sorted = values.filter(known).sort((a, b) => a - b);
    const most = roundUp(sorted[Math.floor(MOST * (sorted.length - 1))] ?? 0);
    return limit ? Math.min(most, roundUp(2 * limit)) : most;
  },
  values: (maps) => maps.values,
};

export const LAYERS = {
  deviation: {
    signed: true,
    title: "Form deviation",
    small: "nm, cell means",
    unit: "nm",
    label: "Map of the form deviation in nm over x and y in mm.",
    table: (flipped) => diverging(flipped),
    scale(values) {
      let largest = 0;
      for (const value of values) if (known(value)) largest = Math.max(largest, Math.abs(value));
      return roundUp(largest);
    },
    say: (value) => `${signedNm(value)} nm`,
  },
  gap: {
    ...sampled,
    title: "Gap",
    small: "mm, largest in each cell",
    unit: "mm",
    label: "Map of the largest gap in mm over x and y in mm.",
    beyond: "gap beyond the limit",
    layer: "gap_mm",
    say: (value) => `gap ${significant(value)} mm`,
  },
  epsilon: {
    ...sampled,
    title: "ε",
    small: "gap / local feature size, largest in each cell",
    unit: "ε",
    label: "Map of ε, gap over local feature size, over x and y in mm.",
    beyond: "ε beyond the target",
    layer: "epsilon",
    say: (value) => `ε ${significant(value)}`,
  },
  noise: {
    ...sampled,
    title: "Facet tilt by noise",
    small: "mrad, mean in each cell",
    unit: "mrad",
    label: "Map of how far noise turns the facets, in mrad, over x and y in mm.",
    beyond: "denser than the noise allows",
    layer: "tilt_mrad",
    say: (value) => `facets turned by ${significant(value)} mrad`,
  },
};

/** What a layer draws: a grid with its values and limit, or null. */
export function chartOf(name, deviation, maps) {
  if (name === "deviation") {
    return deviation?.nx > 0 && deviation?.ny > 0
      ? { ...deviation, values: deviation.values_nm, limit: null, shares: null }
      : null;
  }
  if (!maps) return null;
  const { values, limit } = maps[LAYERS[name].layer];
  return { ...maps, values, limit, shares: maps.undersampled.values };
}

/** The value of a cell in words, with what is not sampled densely enough. */
export function sayCell(name, chart, at) {
  const value = chart.values[at];
  const share = chart.shares?.[at];
  const missing = known(share) && share > 0 ? `, ${percent(share)} not sampled densely enough` : "";
  const nothing = chart.shares && share === 1 && !known(value) ? "not scanned" : "no data";
  return known(value) ? `${LAYERS[name].say(value)}${missing}` : nothing;
}
