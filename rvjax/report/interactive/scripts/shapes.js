"use strict";
/* A drawing: line segments and triangles in the frame of the picture, which `webgl` and `canvas` show. Colours are [r, g, b, a]. */
rvjax.shapes = (() => {
  const v = rvjax.vectors;

  class Drawing {
    constructor() {
      this.segments = []; /* a, b, colour, width in pixels: 11 numbers each */
      this.solids = []; /* place, colour: 7 numbers for each corner of an opaque triangle */
      this.veils = []; /* likewise for translucent triangles */
      this.labels = []; /* {at, text, colour} */
    }

    line(a, b, colour, width = 1.5) {
      this.segments.push(a[0], a[1], a[2], b[0], b[1], b[2], colour[0], colour[1], colour[2], colour[3], width);
    }

    path(points, colour, width, closed = false) {
      for (let i = 1; i < points.length; i++) this.line(points[i - 1], points[i], colour, width);
      if (closed && points.length > 1) this.line(points[points.length - 1], points[0], colour, width);
    }

    triangle(a, b, c, colour) {
      const target = colour[3] < 1 ? this.veils : this.solids;
      for (const p of [a, b, c]) target.push(p[0], p[1], p[2], colour[0], colour[1], colour[2], colour[3]);
    }

    quad(a, b, c, d, colour) {
      this.triangle(a, b, c, colour);
      this.triangle(a, c, d, colour);
    }

    label(at, text, colour) {
      this.labels.push({ at, text, colour });
    }
  }

  /* p → origin + M p. rotation: three rows. */
  const placed = (rotation, origin) => (p) => v.add(origin, v.apply(rotation, p));

  const shaded = (colour, normal) => {
    const light = 0.62 + 0.38 * v.dot(v.unit(normal), [0.42, 0.36, -0.83]);
    return [colour[0] * light, colour[1] * light, colour[2] * light, colour[3]];
  };

  const circle = (centre, axis, radius, count = 48) => {
    const side = v.beside(axis),
      other = v.cross(v.unit(axis), side);
    return Array.from({ length: count }, (_, i) => {
      const angle = (2 * Math.PI * i) / count;
      return v.add(centre, v.add(v.times(side, radius * Math.cos(angle)), v.times(other, radius * Math.sin(angle))));
    });
  };

  /* An ellipsoid, its wires, and, with a surface, its faces. */
  const ellipsoid = (drawing, place, centre, radii, colour, wire, surface) => {
    const point = (lat, lon) => [
      centre[0] + radii[0] * Math.cos(lat) * Math.cos(lon),
      centre[1] + radii[1] * Math.cos(lat) * Math.sin(lon),
      centre[2] + radii[2] * Math.sin(lat),
    ];
    const rings = 12,
      sectors = 24;
    const lat = (i) => -Math.PI / 2 + (Math.PI * i) / rings,
      lon = (j) => (2 * Math.PI * j) / sectors;
    if (surface) {
      const origin = place([0, 0, 0]);
      for (let i = 0; i < rings; i++) {
        for (let j = 0; j < sectors; j++) {
          const corners = [
            [i, j],
            [i, j + 1],
            [i + 1, j + 1],
            [i + 1, j],
          ].map(([a, b]) => place(point(lat(a), lon(b))));
          const middle = point(lat(i + 0.5), lon(j + 0.5)).map((x, k) => (x - centre[k]) / (radii[k] * radii[k]));
          drawing.quad(...corners, colour[3] < 1 ? colour : shaded(colour, v.minus(place(middle), origin)));
        }
      }
    }
    for (let i = 2; i < rings; i += 2) {
      drawing.path(
        Array.from({ length: 36 }, (_, j) => place(point(lat(i), (2 * Math.PI * j) / 36))),
        wire,
        1,
        true,
      );
    }
    for (let j = 0; j < sectors; j += 4) {
      drawing.path(
        Array.from({ length: 19 }, (_, i) => place(point(-Math.PI / 2 + (Math.PI * i) / 18, lon(j)))),
        wire,
        1,
      );
    }
  };

  const FACES = [
    [0, 1, 3, 2],
    [4, 6, 7, 5],
    [0, 4, 5, 1],
    [2, 3, 7, 6],
    [0, 2, 6, 4],
    [1, 5, 7, 3],
  ];
  const NORMALS = [
    [-1, 0, 0],
    [1, 0, 0],
    [0, -1, 0],
    [0, 1, 0],
    [0, 0, -1],
    [0, 0, 1],
  ];

  /* A box with these edges along the axes. */
  const box = (drawing, place, centre, edges, colour, wire) => {
    const corner = (i) => place([0, 1, 2].map((k) => centre[k] + edges[k] * (((i >> (2 - k)) & 1) - 0.5)));
    const corners = Array.from({ length: 8 }, (_, i) => corner(i)),
      origin = place([0, 0, 0]);
    FACES.forEach((face, i) => {
      drawing.quad(...face.map((k) => corners[k]), shaded(colour, v.minus(place(NORMALS[i]), origin)));
      drawing.path(
        face.map((k) => corners[k]),
        wire,
        1.2,
        true,
      );
    });
  };

  /* Wires and veil of a cone about `axis` whose radius grows from `near` at `from` to `far` at `to`. */
  const funnel = (drawing, place, from, axis, length, near, far, colour, wire) => {
    const count = 32,
      to = v.add(from, v.times(axis, length));
    const begin = circle(from, axis, near, count).map(place),
      end = circle(to, axis, far, count).map(place);
    for (let i = 0; i < count; i++) {
      const next = (i + 1) % count;
      drawing.quad(begin[i], begin[next], end[next], end[i], colour);
      if (i % 4 === 0) drawing.line(begin[i], end[i], wire, 1);
    }
    for (const share of [0.25, 0.5, 0.75, 1]) {
      const ring = circle(v.add(from, v.times(axis, length * share)), axis, near + (far - near) * share, 48).map(place);
      drawing.path(ring, wire, 1, true);
    }
    if (near > 0) drawing.path(begin, wire, 1, true);
  };

  /* An arrow with a head of two strokes in each of two planes. */
  const arrow = (drawing, from, to, colour, width) => {
    const along = v.minus(to, from),
      side = v.beside(along),
      other = v.unit(v.cross(along, side)),
      size = 0.22 * v.norm(along);
    drawing.line(from, to, colour, width);
    for (const s of [side, v.times(side, -1), other, v.times(other, -1)]) {
      drawing.line(to, v.add(v.add(to, v.times(along, -0.28)), v.times(s, 0.5 * size)), colour, width);
    }
  };

  /* Three axes from an origin with their names. rows: unit vectors in the picture. */
  const axes = (drawing, origin, rows, length, names, colours) => {
    rows.forEach((row, i) => {
      const end = v.add(origin, v.times(row, length));
      arrow(drawing, origin, end, colours[i], 2);
      drawing.label(v.add(origin, v.times(row, 1.12 * length)), names[i], colours[i]);
    });
  };

  /* A plume: a cone from its nozzle, four sides, brighter lines along its edges. */
  const plume = (drawing, nozzle, along, length, colour) => {
    const count = 8,
      ring = circle(v.add(nozzle, v.times(along, length)), along, 0.28 * length, count);
    for (let i = 0; i < count; i++) {
      drawing.triangle(nozzle, ring[i], ring[(i + 1) % count], [...colour.slice(0, 3), 0.5]);
      if (i % 2 === 0) drawing.line(nozzle, ring[i], colour, 1.6);
    }
  };

  /* Three quarters of a circle with an arrow head: a torque about `axis`, counted by the right hand. */
  const turn = (drawing, centre, axis, radius, share, colour, width) => {
    const points = circle(centre, axis, radius, 36).slice(0, 2 + Math.round(30 * share));
    drawing.path(points, colour, width);
    const last = points[points.length - 1],
      before = points[points.length - 2],
      along = v.unit(v.minus(last, before));
    const out = v.unit(v.minus(last, centre));
    for (const sign of [-1, 1]) {
      drawing.line(last, v.add(last, v.add(v.times(along, -0.22 * radius), v.times(out, sign * 0.16 * radius))), colour, width);
    }
  };

  return { Drawing, placed, circle, ellipsoid, box, funnel, arrow, axes, plume, turn };
})();
