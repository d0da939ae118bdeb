"use strict";
/* Vectors [x, y, z], quaternions [q0, q1, q2, q3], rotations as three rows. */
rvjax.vectors = (() => {
  const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const norm = (a) => Math.hypot(a[0], a[1], a[2]);
  const unit = (a) => {
    const length = norm(a);
    return length > 0 ? times(a, 1 / length) : [1, 0, 0];
  };
  const mix = (a, b, s) => a.map((part, i) => part + (b[i] - part) * s);

  /* A unit vector normal to a. */
  const beside = (a) => unit(cross(a, Math.abs(a[0]) < 0.8 * norm(a) ? [1, 0, 0] : [0, 1, 0]));

  /* Three rows: M v. */
  const apply = (m, v) => [dot(m[0], v), dot(m[1], v), dot(m[2], v)];
  const transposed = (m) => [0, 1, 2].map((i) => [m[0][i], m[1][i], m[2][i]]);
  const product = (a, b) => {
    const columns = transposed(b);
    return a.map((row) => columns.map((column) => dot(row, column)));
  };
  const IDENTITY = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];

  /* v + 2 u × (u × v + q0 v) as three rows, for a unit quaternion. */
  const ofQuaternion = ([w, x, y, z]) => [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];

  /* On the shorter arc between two unit quaternions; as the quotient of the quantised ones is not quite 1, it is made 1. */
  const slerp = (a, b, s) => {
    let along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const sign = along < 0 ? -1 : 1;
    along = Math.min(Math.abs(along), 1);
    const angle = Math.acos(along);
    const [p, q] = angle < 1e-4 ? [1 - s, s] : [Math.sin((1 - s) * angle), Math.sin(s * angle)].map((x) => x / Math.sin(angle));
    const mixed = a.map((part, i) => p * part + sign * q * b[i]);
    const length = Math.hypot(...mixed);
    return mixed.map((part) => part / length);
  };

  /* T → port: x along the docking axis n; y and z of T after the shortest turn (docs/campaigns.md, frame: port). */
  const portAxes = (n) => {
    if (Math.hypot(n[1], n[2]) < 1e-12)
      return n[0] > 0
        ? IDENTITY
        : [
            [-1, 0, 0],
            [0, -1, 0],
            [0, 0, 1],
          ];
    const k = n[0] > 0 ? 1 / (1 + n[0]) : (1 - n[0]) / (n[1] * n[1] + n[2] * n[2]);
    return [n, [-n[1], 1 - k * n[1] * n[1], -k * n[1] * n[2]], [-n[2], -k * n[1] * n[2], 1 - k * n[2] * n[2]]];
  };

  return {
    add,
    minus,
    times,
    dot,
    cross,
    norm,
    unit,
    mix,
    beside,
    apply,
    transposed,
    product,
    ofQuaternion,
    slerp,
    portAxes,
    IDENTITY,
  };
})();
