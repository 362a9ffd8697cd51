// The figures of standards that the final report has: a table by name, and what they rest on.

import { byId, setRows, setText } from "./dom.js";
import { nm, significant, unitText } from "./format.js";

/** Shows them once they are there: running figures have none. */
export function showStandards(form) {
  const figures = form?.figures ?? [];
  byId("standards-card").hidden = figures.length === 0;
  if (figures.length === 0) return;
  const { minimum_zone: zone, indication, texture } = form;
  setText(byId("standards-indication"), indication
    ? `ISO 10110-5: ${indication.found}${indication.asked ? `; asked ${indication.asked}` : ""}`
    : "");
  const shown = [...figures, ...(zone ? [zone.width] : []), ...(texture?.figures ?? [])];
  setRows(byId("standards"), shown.map((figure) => ({
    key: `${figure.name} ${figure.variant}`,
    cells: [
      { text: figure.name, small: figure.source },
      figure.variant,
      {
        text: `${significant(figure.value, 4)} ${unitText(figure.unit)}`.trim(),
        small: uncertainty(figure),
        className: "num",
      },
    ],
  })));
  setText(byId("standards-note"), [
    zone ? `Minimum zone ${zone.termination}: none near by is narrower than ${nm(zone.lower_nm)} nm.` : "",
    texture ? `Texture: ${texture.surface}, less ${texture.f_operation}. ${texture.filters.join(". ")}` : "",
  ].filter(Boolean).join(" "));
  byId("standards-note").hidden = !zone && !texture;
}

/** The uncertainty, the interval, and what both are made of. */
function uncertainty({ u, unit, simulated, noise_adds: adds, without_noise: without }) {
  if (u === undefined && adds !== undefined) {
    return without === undefined
      ? `noise adds at most ${significant(adds, 3)} ${unitText(unit)}`
      : `without noise ${significant(without, 4)} ${unitText(unit)}`;
  }
  if (u === undefined) return undefined;
  const known = `u ${significant(u, 2)} ${unitText(unit)}`.trim();
  if (!simulated) return known;
  const { low, high, p, model, covers, draws, without_noise } = simulated;
  return `without noise ${significant(without_noise, 4)}, ${known}; ${significant(low, 4)} to ${significant(high, 4)}, ${significant(100 * p, 2)} % of ${covers ?? model} (${draws} draws)`;
}
