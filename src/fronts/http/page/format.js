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

/** Nanometres to 0.1. */
export const nm = (value) => fixed(value, 1);

/** Nanometres to 0.1 with their sign. */
export const signedNm = (value) => (known(value) && value > 0 ? `+${nm(value)}` : nm(value));

/** Millimetres: four decimals below 10, three above. */
export const mm = (value) => fixed(value, known(value) && Math.abs(value) < 10 ? 4 : 3);

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

/**
 * A value with its standard uncertainty: both with as many decimals as two significant digits of
 * the uncertainty take. Small angles become µrad, very small or large numbers take an exponent.
 */
export function measured(value, uncertainty, unit) {
  if (!known(value)) return { value: DASH, uncertainty: DASH, unit: unitText(unit) };
  let factor = 1;
  let unitShown = unitText(unit);
  if (unit === "rad" && Math.abs(value) < 0.01) {
    factor = 1e6;
    unitShown = "µrad";
  }
  const [v, u] = [value * factor, known(uncertainty) ? uncertainty * factor : null];
  const size = Math.max(Math.abs(v), u ?? 0);
  const power = size === 0 ? 0 : Math.floor(Math.log10(size));
  const smallest = unit === "mm" ? -6 : -3;
  const exponent = power < smallest || power > 5 ? power : 0;
  const scale = 10 ** exponent;
  const decimals = u ? 1 - Math.floor(Math.log10(u / scale)) : 5 - (power - exponent);
  const places = Math.min(Math.max(decimals, 0), 9);
  const tail = exponent ? `·10${raised(exponent)}` : "";
  return {
    value: fixed(v / scale, places) + tail,
    uncertainty: u === null ? DASH : fixed(u / scale, places) + tail,
    unit: unitShown,
  };
}

/** Angles that belong together: µrad to 0.01 where all are small, else rad. */
export function angles(list) {
  const small = list.every((rad) => Math.abs(rad) < 0.01);
  const shown = list.map((rad) => (small ? fixed(rad * 1e6, 2) : fixed(rad, 7)));
  return `${shown.join(", ")} ${small ? "µrad" : "rad"}`;
}

/** `mm^-3` as `mm⁻³`; a pure number has none. */
export const unitText = (unit) =>
  !unit || unit === "1" ? "" : unit.replace(/\^(-?\d+)/g, (_, power) => raised(Number(power)));

/** Sign and scope of a figure that has a limit: `PV`, `RMS from 0-4.5 mm`. */
export const figureWords = ({ symbol, scope }) => (scope ? `${symbol} ${scope}` : symbol);

/** A value of that figure, with the digits its unit has. */
export const figureValue = ({ unit }, value) => (unit === "nm" ? nm(value) : significant(value, 4));

/** With a capital in front. */
export const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1);

const raised = (n) =>
  [...String(n)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
