"use strict";
/* The picture at an instant: target, port, corridor, keep-out zone, pursuer with its actuators, trails, axes. */
rvjax.scene = (() => {
  const v = rvjax.vectors,
    shapes = rvjax.shapes;
  const rgb = (hex, alpha = 1) => [...[1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255), alpha];

  /* Okabe and Ito's palette, which readers with any colour vision can distinguish, on a dark ground. */
  const C = {
    ground: rgb("#0d1520").slice(0, 3),
    target: rgb("#8d99a6"),
    targetWire: rgb("#c3ccd6", 0.7),
    pursuer: rgb("#d7dee6"),
    pursuerWire: rgb("#4a5a6b"),
    port: rgb("#f0e442"),
    corridor: rgb("#009e73", 0.09),
    corridorWire: rgb("#1fc79a", 0.5),
    zone: rgb("#cc79a7", 0.05),
    zoneWire: rgb("#cc79a7", 0.4),
    trail: rgb("#56b4e9"),
    saturated: rgb("#e69f00"),
    faulted: rgb("#ff7a33"),
    fires: rgb("#ffffff"),
    ghost: rgb("#b9c6d2", 0.5),
    ghostName: rgb("#d7dee6"),
    axes: ["#ff9d7a", "#8ee3c8", "#a9d4ff"].map((h) => rgb(h)),
    contact: rgb("#ff3b6b"),
  };
  const NAMES = { port: ["docking axis", "y", "z"], lvlh: ["V-bar", "H-bar", "R-bar"], inertial: ["x₀", "y₀", "z₀"] };

  const sizeOf = (hull, otherwise) => {
    if (hull === null) return otherwise;
    return hull.box ? v.norm(hull.box) / 2 : hull.radius;
  };

  /* Radii of target and pursuer, for cameras and arrows [m]. */
  const sizes = (flight) => {
    const { target, pursuer, port } = flight.about.scene;
    const first = sizeOf(target, Math.max(0.4 * v.norm(port), 0.5));
    return { target: first, pursuer: sizeOf(pursuer, 0.25 * first) };
  };

  const body = (drawing, place, hull, size, colour, wire) => {
    if (hull !== null && hull.radius !== undefined) {
      shapes.ellipsoid(drawing, place, hull.centre, [hull.radius, hull.radius, hull.radius], colour, wire, true);
    } else {
      shapes.box(
        drawing,
        place,
        hull ? hull.centre : [0, 0, 0],
        hull ? hull.box : [1, 1, 1].map((x) => 1.1 * x * size),
        colour,
        wire,
      );
    }
  };

  const target = (drawing, place, flight, size) => {
    const { scene } = flight.about,
      tip = flight.port,
      axis = flight.axis;
    body(drawing, place, scene.target, size.target, C.target, C.targetWire);
    drawing.line(place([0, 0, 0]), place(tip), C.targetWire, 3);
    for (const radius of [0.08, 0.14]) drawing.path(shapes.circle(tip, axis, radius * size.target).map(place), C.port, 2.5, true);
    const { angle, radius, length } = scene.corridor;
    const reach = length ?? Math.max(...flight.error) * 1.05,
      funnel = [place, tip, axis, reach, radius, radius + reach * Math.tan(angle)];
    shapes.funnel(drawing, ...funnel, C.corridor, C.corridorWire);
    if (scene.keepOut) shapes.ellipsoid(drawing, place, [0, 0, 0], scene.keepOut, C.zone, C.zoneWire, true);
    [
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ].forEach((e, i) => {
      drawing.line(place([0, 0, 0]), place(v.times(e, 1.35 * size.target)), C.axes[i], 2);
    });
  };

  const colourOf = (actuator) => (actuator.faulted ? C.faulted : actuator.saturated ? C.saturated : C.fires);

  /* Plumes of thrusters, or of forces along the axes, and turning arrows of torques; their length is the share of the limit. */
  const actuators = (drawing, place, flight, state, size) => {
    const { thrusters } = flight.about.scene,
      origin = place([0, 0, 0]);
    const direction = (d) => v.minus(place(d), origin);
    state.actuators.forEach((actuator, i) => {
      const share = Math.min(Math.abs(actuator.value) / actuator.limit, 1.2),
        colour = colourOf(actuator),
        lit = share > 0.004;
      if (thrusters.length > 0) {
        const { at, along } = thrusters[i],
          nozzle = place(at);
        drawing.line(
          nozzle,
          v.add(nozzle, v.times(direction(along), -0.12 * size)),
          actuator.faulted ? C.faulted : C.pursuerWire,
          3,
        );
        if (lit) shapes.plume(drawing, nozzle, v.times(direction(along), -1), (0.15 + share) * size, colour);
        return;
      }
      const axis = [0, 1, 2].map((k) => (k === i % 3 ? Math.sign(actuator.value) || 1 : 0));
      if (i < 3 && lit)
        shapes.plume(
          drawing,
          place(v.times(axis, -1.05 * size)),
          v.times(direction(axis), -1),
          (0.2 + 1.4 * share) * size,
          colour,
        );
      if (i >= 3 && share > 0.02) shapes.turn(drawing, origin, direction(axis), (1.25 + 0.12 * (i - 3)) * size, share, colour, 3);
    });
  };

  const pursuer = (drawing, flight, state, frame, size) => {
    const rows = v.product(frame.rows, state.attitude),
      centre = v.apply(frame.rows, v.minus(state.place, frame.origin));
    const place = shapes.placed(rows, centre),
      hull = flight.about.scene.pursuer;
    const touched = flight.about.events.some((event) => event.kind === "collided" && event.t <= state.t);
    const { thrusters } = flight.about.scene,
      colour = touched ? C.contact : C.pursuer;
    if (thrusters.length > 0) {
      const edges = [0, 1, 2].map((k) => 1.8 * Math.max(...thrusters.map(({ at }) => Math.abs(at[k])), 0.1 * size.pursuer));
      shapes.box(drawing, place, [0, 0, 0], edges, colour, C.pursuerWire);
      if (hull !== null)
        body(drawing, place, hull, size.pursuer, [...colour.slice(0, 3), 0.1], [...C.targetWire.slice(0, 3), 0.35]);
    } else body(drawing, place, hull, size.pursuer, colour, C.pursuerWire);
    [
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ].forEach((e, i) => drawing.line(centre, place(v.times(e, 1.9 * size.pursuer)), C.axes[i], 2));
    const nose = v.times(flight.axis, -1),
      at = v.times(nose, 1.05 * size.pursuer);
    drawing.path(shapes.circle(at, nose, 0.3 * size.pursuer).map(place), C.port, 2.5, true);
    actuators(drawing, place, flight, state, size.pursuer);
    return centre;
  };

  /* Behind the instant as it was flown, coloured where a channel was saturated; before it, faint. */
  const trail = (drawing, flight, name, state, centre) => {
    const points = flight.trail(name),
      [row] = flight.where(state.t);
    for (let i = 1; i < points.length; i++) {
      const flown = i <= row,
        colour = flight.saturated[i] ? C.saturated : C.trail;
      drawing.line(
        points[i - 1],
        points[i],
        flown ? colour : [...colour.slice(0, 3), 0.28],
        flown ? (flight.saturated[i] ? 4 : 2.4) : 1.2,
      );
    }
    drawing.line(points[row], centre, flight.saturated[row] ? C.saturated : C.trail, 2.4);
  };

  const ghost = (drawing, flight, name, t, size) => {
    const points = flight.trail(name),
      frame = flight.frame(name, Math.min(t, flight.last));
    drawing.path(points, C.ghost, 1.1);
    const state = flight.at(Math.min(t, flight.last)),
      centre = v.apply(frame.rows, v.minus(state.place, frame.origin));
    const place = shapes.placed(v.product(frame.rows, state.attitude), centre);
    for (const axis of [
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ]) {
      drawing.path(shapes.circle([0, 0, 0], axis, 0.9 * size.pursuer, 24).map(place), C.ghost, 1, true);
    }
    drawing.label(
      v.add(centre, [0, 0, name === "port" ? 1.5 * size.pursuer : -1.5 * size.pursuer]),
      rvjax.names.short(flight.about),
      C.ghostName,
    );
  };

  /* A drawing of a flight at t. ghosts: other flights; name: of the frame. */
  const draw = (flight, t, name, ghosts) => {
    const drawing = new shapes.Drawing(),
      state = flight.at(t),
      frame = flight.frame(name, t),
      size = sizes(flight);
    const place = shapes.placed(frame.rows, v.times(v.apply(frame.rows, frame.origin), -1));
    target(drawing, place, flight, size);
    for (const other of ghosts) ghost(drawing, other, name, t, size);
    const centre = pursuer(drawing, flight, state, frame, size);
    trail(drawing, flight, name, state, centre);
    const shown = flight.hasOrbit ? name : "port";
    shapes.axes(drawing, [0, 0, 0], v.IDENTITY, (shown === "port" ? 1.2 : 2.2) * size.target, NAMES[shown], C.axes);
    return { drawing, state, frame, size, centre, target: place([0, 0, 0]), port: place(flight.port) };
  };

  return { draw, sizes, colours: C, NAMES };
})();
