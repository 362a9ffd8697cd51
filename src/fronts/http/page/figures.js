// The tables of mesh, sampling and fit.

import { byId, setRows, setText } from "./dom.js";
import { DASH, angles, count, fixed, known, measured, mm, nm, percent, significant, unitText } from "./format.js";

const pair = (key, name, text, className = "") => ({ key, className, cells: [name, { text, className: "num" }] });
const withUnit = (text, unit) => (text === DASH ? DASH : `${text} ${unit}`);

/** What is counted by its reason and is in the mesh all the same, or in its account. */
const MESHED = ["conflict", "not_meshable", "outside_aperture", "outside_domain"];

/** How many points for the mesh came after `asOf` of them; some fewer where one has several flags. */
export function pointsSince({ received, flagged }, asOf) {
  const unmeshed = Object.entries(flagged).filter(([reason]) => !MESHED.includes(reason));
  return Math.max(received - unmeshed.reduce((sum, [, number]) => sum + number, 0) - asOf, 0);
}

export function showFigures({ mesh, sampling, form, points }) {
  const empty = mesh.vertices === 0;
  // While points arrive these are kept up with them; what else there is waits for the next look at the whole mesh.
  const newest = sampling.current ?? sampling;
  setRows(byId("mesh"), [
    pair("vertices", "Vertices", count(mesh.vertices)),
    pair("triangles", "Triangles", count(mesh.triangles)),
    pair("edges", "Edges", count(mesh.edges)),
    pair("hull", "On the hull", count(mesh.hull)),
    pair("area", "Area", empty || mesh.area_mm2 == null ? DASH : withUnit(significant(mesh.area_mm2, 6), "mm²")),
    ...planeRows(mesh.projection),
    pair("projectable", "Projectable", empty ? DASH : mesh.projectable ? "yes" : "no", !empty && !mesh.projectable ? "bad" : ""),
    pair("relief", "Folds, walls, spikes", empty ? DASH : `${count(mesh.relief.folds.length)}, ${count(mesh.relief.walls)}, ${count(mesh.relief.spikes)}`, mesh.relief.folds.length > 0 ? "bad" : ""),
  ]);
  setRows(byId("sampling"), [
    pair("coverage", "Coverage", percent(sampling.coverage)),
    pair("undersampled", "Undersampled", withUnit(significant(sampling.undersampled_area_mm2), "mm²")),
    pair("uncovered", "Not scanned", withUnit(significant(sampling.uncovered_area_mm2), "mm²")),
    pair("gap", "Largest gap", withUnit(mm(newest.gap_max_mm), "mm")),
    pair("epsilon_max", "ε max, gap / lfs", significant(newest.epsilon_max)),
    pair("epsilon_p99", "ε p99 by area", significant(newest.epsilon_p99)),
    ...targetRows(sampling, newest),
    pair("newest", "Gap and ε as of", newest.as_of_points ? `${count(newest.as_of_points)} points` : DASH, "sub"),
    pair("noise", "Noise of the heights", withUnit(nm(sampling.noise_sigma_nm), "nm")),
    pair("overdense", "Too dense for the noise", percent(sampling.overdense_fraction)),
    pair("islands", "Islands, holes", sampling.islands === null ? DASH : `${count(sampling.islands)}, ${count(sampling.holes)}`),
    pair("as_of", "As of", sampling.as_of_points ? `${count(sampling.as_of_points)} points` : DASH),
    pair("behind", "Points since then", sampling.as_of_points ? count(pointsSince(points, sampling.as_of_points)) : DASH),
  ]);
  showFit(form);
}

// What is allowed; ρ only where it was asked for.
function targetRows({ epsilon_target: epsilon, rho_target: rho, reach_mm: reach }, newest) {
  const rows = known(epsilon) ? [pair("epsilon_target", "ε allowed", significant(epsilon))] : [];
  if (!known(rho)) return rows;
  return [
    ...rows,
    pair("rho_max", "ρ max, gap / reach", significant(newest.rho_max)),
    pair("rho_target", "ρ allowed", significant(rho)),
    pair("reach", "Reach, smallest lfs", withUnit(mm(reach), "mm")),
  ];
}

// Only where something else than z was asked for: most stations need no such row.
function planeRows(projection) {
  if (!projection) return [];
  const { how, plane, points, wanted } = projection;
  if (how === "fitting") return [pair("plane", "Fitting the plane", `${count(points)} of ${count(wanted)}`)];
  const origin = {
    given: "as given",
    fitted: `from ${count(points)} points`,
    unfitted: `none through ${count(points)} points, so along z`,
  }[how];
  return [
    pair("plane", "Plane of projection", origin, how === "unfitted" ? "bad" : ""),
    pair("normal", "Its normal x, y, z", plane.normal.map((part) => fixed(part, 5)).join(", "), "sub"),
  ];
}

/** How points were counted, what a surface made from them is, and what the figures must be read with. */
function criterion({ reference, fit: { loss, weights, effective_points: effective } }) {
  const rows = [];
  const row = (key, title, value, className) => rows.push(pair(key, title, value, className));
  if (reference) {
    row("base", "Base under the splines", `${reference.base}, RMS from it ${fixed(reference.base_rms_nm, 1)} nm`);
    row("splines", "Splines", `${reference.cells.join(" × ")} cells of ${fixed(Math.max(...reference.knots_mm), 4)} mm, ${fixed(reference.effective_parameters, 0)} effective parameters`);
    row("follows", "Half followed: waves of", `${fixed(reference.follows_mm, 3)} mm`);
    if (reference.as_of_points) row("made-of", "Base and knots made of", `the first ${count(reference.as_of_points)} points`);
    if (reference.noise_nm !== null) row("left", "Noise left", `${fixed(reference.noise_nm, 2)} nm`);
  }
  if (loss) {
    const origin = loss.threshold_given ? "given" : "found";
    row("loss", "Loss", `${loss.name}, threshold ${fixed(loss.threshold_nm, 1)} nm (${origin})`);
    row("lighter", "Below half weight", `${count(loss.below_half)} points, ${count(loss.left_out)} of them left out`);
  }
  if (weights) row("weights", "Weights 1/u², u", `${fixed(weights.u_min_nm, 2)} to ${fixed(weights.u_max_nm, 2)} nm`);
  if (effective) row("effective", "As many as points of equal weight", count(Math.round(effective)));
  return rows;
}

/** How the deviations are correlated, as u of the parameters counts it; else what it does to those of the shape. */
function correlation({ correlation: found, parameters }) {
  if (!found) return [];
  if (!found.counted) {
    return Object.entries(parameters).filter(([, { u_by_form: u }]) => known(u)).map(([name, { unit, u_by_form: u }]) =>
      pair(`by-form-${name}`, `By form error from part to part, ${name}`, `u ${u.toPrecision(2)} ${unitText(unit)}`.trimEnd(), "sub"));
  }
  const most = found.largest_ratio ? `, up to ${significant(found.largest_ratio, 2)} times that of independent ones (${found.largest_ratio_of})` : "";
  return [pair("correlation", "Correlated over", `${significant(found.length_mm, 2)} mm (${found.kernel})${most}`, "sub")];
}

function showFit(form) {
  setText(byId("nominal"), form ? unitText(form.nominal) : DASH);
  const parameters = Object.entries(form?.fit.parameters ?? {});
  byId("parameters").hidden = parameters.length === 0;
  setRows(byId("parameters"), parameters.map(([name, { value, unit, u }]) => {
    const shown = measured(value, u, unit);
    return {
      key: name,
      cells: [
        name,
        { text: shown.value, className: "num" },
        { text: shown.uncertainty, className: "num" },
        shown.unit,
      ],
    };
  }));
  if (!form) {
    setRows(byId("fit"), [pair("method", "Method", DASH)]);
    return;
  }
  const { fit } = form;
  const { pose } = fit;
  setRows(byId("fit"), [
    pair("method", "Method", fit.method),
    pair("termination", "Ended because", fit.termination),
    pair("iterations", "Iterations", count(fit.iterations)),
    ...(fit.u_model ? [pair("u-model", "u of the parameters by", fit.u_model)] : []),
    ...correlation(fit),
    ...(fit.cautions ?? []).map(({ kind, text }) => pair(`caution-${kind}`, "Caution", text, "bad")),
    ...(fit.indeterminate.length
      ? [pair("indeterminate", "Not determined by the points", fit.indeterminate.join(", "), "bad")]
      : []),
    ...criterion(form),
    ...(fit.undetermined ?? []).filter((one) => !one.by_shape).map(({ parameter, combination }) =>
      pair(`lacks-${parameter}`, "The points do not feel", combination.text, "sub")),
    ...(fit.condition ? [pair("condition", "Condition", significant(fit.condition))] : []),
    pair("shift", "Pose: shift x, y, z", `${[pose.tx_mm, pose.ty_mm, pose.tz_mm].map((v) => fixed(v, 5)).join(", ")} mm`),
    pair("tilt", "Pose: rotation x, y, z", angles([pose.rx_rad, pose.ry_rad, pose.rz_rad])),
  ]);
}
