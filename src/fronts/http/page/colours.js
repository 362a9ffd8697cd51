// The colours of the maps: blue, near-white, orange-brown for the deviation, near-white to dark green-blue
// for what is never negative.
//
// Both arms fall in lightness alike, so that size reads without hue, and blue against orange stays
// apart for red-green and blue-yellow colour blindness.

const MIDDLE = [244, 243, 239];
const BLUE = [MIDDLE, [146, 186, 222], [49, 112, 180], [10, 40, 92]];
const ORANGE = [MIDDLE, [243, 182, 128], [206, 96, 30], [104, 30, 6]];
const SEA = [MIDDLE, [176, 211, 190], [74, 150, 150], [14, 70, 96]];
const STEPS = 255;

/** A table of colours from 0 to 1, light to dark. */
export function sequential() {
  const steps = Array.from({ length: STEPS + 1 }, (_, step) => between(SEA, step / STEPS));
  return (t) => steps[Math.round(Math.min(Math.max(t, 0), 1) * STEPS)];
}

/** A table of colours from -1 to +1: `table(t)` gives `[r, g, b]`, 0 to 255. */
export function diverging(flipped) {
  const [minus, plus] = flipped ? [ORANGE, BLUE] : [BLUE, ORANGE];
  const arm = (anchors) =>
    Array.from({ length: STEPS + 1 }, (_, step) => between(anchors, step / STEPS));
  const [below, above] = [arm(minus), arm(plus)];
  return (t) => {
    const step = Math.round(Math.min(Math.abs(t), 1) * STEPS);
    return t < 0 ? below[step] : above[step];
  };
}

/** A colour as CSS text. */
export const css = ([r, g, b]) => `rgb(${r}, ${g}, ${b})`;

function between(anchors, t) {
  const at = t * (anchors.length - 1);
  const low = Math.min(Math.floor(at), anchors.length - 2);
  return anchors[low].map((from, i) => Math.round(from + (anchors[low + 1][i] - from) * (at - low)));
}
