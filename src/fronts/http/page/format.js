// Numbers as people read them: sensible digits, units, and a dash for what is not known.

/** Stands for an absent value. Never a zero. */
export const DASH = "–";

const MINUS = "−";
const NARROW = "\u202f";

/** Whether a value is there: JSON null stands for absent and for not finite. */
export const known = (value) => typeof value === "number" && Number.isFinite(value);

/** A number with fixed decimals and grouped thousands. */
export function fixed(value, decimals) {
  if (!known(value)) return DASH;
  const [whole, rest] = Math.abs(value).toFixed(decimals).split(".");
  const digits = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, NARROW) : whole;
  const text = rest === undefined ? digits : `${digits}.${rest}`;
  return value < 0 && /[1-9]/.test(text) ? MINUS + text : text;
}

/** A count. */
export const count = (value) => fixed(value, 0);

/** A count with its noun: `1 part`, `3 parts`. */
export const counted = (value, noun) => `${count(value)} ${noun}${value === 1 ? "" : "s"}`;

/** Nanometres to 0.1. */
export const nm = (value) => fixed(value, 1);

/** Nanometres to 0.1 with their sign. */
export const signedNm = (value) => (known(value) && value > 0 ? `+${nm(value)}` : nm(value));

/** A place `(x, y)` in mm. */
export const place = (point) =>
  point ? `(${fixed(point[0], 3)}, ${fixed(point[1], 3)}) mm` : DASH;

/** A share of 1 in percent; 100 % only where nothing is missing. */
export function percent(share) {
  if (!known(share)) return DASH;
  const shown = share < 1 ? Math.min(share * 100, 99.9) : share * 100;
  return `${fixed(shown, 1)}${NARROW}%`;
}

/** Three significant digits, without exponent. */
export function significant(value, digits = 3) {
  if (!known(value)) return DASH;
  if (value === 0) return "0";
  const magnitude = Math.floor(Math.log10(Math.abs(value)));
  return fixed(value, Math.min(Math.max(digits - 1 - magnitude, 0), 12));
}

/** Events per second. */
export const rate = (hz) => (known(hz) && hz >= 100 ? fixed(hz, 0) : significant(hz, 3));

/** Seconds as `4.2 s`, `3 min 05 s`, `1 h 02 min`. */
export function duration(seconds) {
  if (!known(seconds)) return DASH;
  if (seconds < 10) return `${fixed(Math.max(seconds, 0), 1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  const two = (n) => String(n).padStart(2, "0");
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
  return `${Math.floor(whole / 3600)} h ${two(Math.floor((whole % 3600) / 60))} min`;
}

/** The time of day of a Date, local. */
export const timeOfDay = (date) => date.toLocaleTimeString("en-GB", { hour12: false });

/** Sign and scope of a figure that has a limit: `PV`, `RMS from 0-4.5 mm`. */
export const figureWords = ({ symbol, scope }) => (scope ? `${symbol} ${scope}` : symbol);

/** A value of that figure, with the digits its unit has. */
export const figureValue = ({ unit }, value) => (unit === "nm" ? nm(value) : significant(value, 4));

/** With a capital in front. */
export const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1);
