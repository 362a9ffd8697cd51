// Where the samples of a volume lie, by the three steps of its grid.

/** Whether each axis of the grid lies along x, y and z of the frame. */
export const areAlong = (steps) =>
  steps.every((step, axis) => step.every((side, other) => other === axis || Math.abs(side) <= 1e-6 * Math.hypot(...step)));

/** Whether the axes of the grid are at right angles to each other. */
export const areRight = (steps) =>
  [[0, 1], [0, 2], [1, 2]].every(([a, b]) => {
    const product = steps[a].reduce((sum, side, axis) => sum + side * steps[b][axis], 0);
    return Math.abs(product) <= 1e-6 * Math.hypot(...steps[a]) * Math.hypot(...steps[b]);
  });

/** The place of a sample, mm of the frame. */
export const placeMm = (origin, steps, sample) =>
  origin.map((at, axis) => at + steps.reduce((sum, step, of) => sum + step[axis] * sample[of], 0));
