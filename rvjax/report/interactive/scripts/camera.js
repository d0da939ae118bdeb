"use strict";
/* Where the picture is seen from: places that follow the scene, and free ones. */
rvjax.camera = (() => {
  const v = rvjax.vectors;
  const OPENING = (38 * Math.PI) / 180;

  /* T → picture of an LVLH axis; without an orbit those of the port. */
  const axis = (flight, frame, t, i) => {
    if (!flight.hasOrbit) return v.apply(frame.rows, flight.portRows[i]);
    return v.apply(frame.rows, v.transposed(v.ofQuaternion(flight.quaternion("l", t)))[i]);
  };

  /* direction: from what is looked at to the eye; up: upward in the picture. */
  const VIEWS = {
    vbar: ({ flight, frame, t }) => ({ direction: axis(flight, frame, t, 0), up: v.times(axis(flight, frame, t, 2), -1) }),
    rbar: ({ flight, frame, t }) => ({ direction: axis(flight, frame, t, 2), up: axis(flight, frame, t, 0) }),
    hbar: ({ flight, frame, t }) => ({ direction: axis(flight, frame, t, 1), up: v.times(axis(flight, frame, t, 2), -1) }),
    port: ({ flight, frame }) => {
      const along = v.apply(frame.rows, flight.axis),
        up = v.apply(frame.rows, flight.portRows[2]);
      return { direction: v.unit(v.add(along, v.times(up, 0.22))), up };
    },
    chase: ({ flight, frame, state }) => {
      const rows = v.product(frame.rows, state.attitude);
      const along = v.apply(rows, flight.axis),
        up = v.apply(rows, flight.portRows[2]);
      return { direction: v.unit(v.add(along, v.times(up, 0.3))), up };
    },
  };

  class Camera {
    constructor() {
      Object.assign(this, { name: "free", yaw: -0.9, pitch: 0.35, zoom: 1, last: null, blend: null });
    }

    choose(name, smooth) {
      this.blend = smooth && this.last !== null ? { from: this.last, share: 0 } : null;
      this.name = name;
    }

    /* Turns the view by hand; the camera is free from then on. upward: of the frame. */
    turn(dx, dy, upward) {
      if (this.name !== "free" && this.last !== null) {
        const d = this.last.direction;
        this.pitch = Math.asin(Math.min(Math.max(upward * d[2], -1), 1));
        this.yaw = Math.atan2(upward * d[1], d[0]);
        this.name = "free";
      }
      this.blend = null;
      this.yaw -= dx;
      this.pitch = Math.min(Math.max(this.pitch + dy, -1.5), 1.5);
    }

    nearer(factor) {
      this.zoom = Math.min(Math.max(this.zoom * factor, 0.05), 20);
    }

    /* What is looked at, from where. scene: of `rvjax.scene.draw`. */
    _aim(scene, upward) {
      const { centre, target, size } = scene,
        close = this.name === "chase";
      const view =
        this.name === "free"
          ? {
              direction: [
                Math.cos(this.pitch) * Math.cos(this.yaw),
                upward * Math.cos(this.pitch) * Math.sin(this.yaw),
                upward * Math.sin(this.pitch),
              ],
              up: [0, 0, upward],
            }
          : VIEWS[this.name](scene);
      const middle = v.mix(target, centre, 0.5),
        apart = v.norm(v.minus(centre, target)) / 2;
      return {
        ...view,
        focus: close ? v.mix(centre, target, 0.15) : middle,
        radius: (close ? 3.2 * size.pursuer + 0.15 * apart : apart + Math.max(1.25 * size.target, size.pursuer)) / this.zoom,
      };
    }

    /* The matrix of the picture. width, height, pixels: of the canvas, and its pixels for one of the page. */
    view(scene, upward, width, height, pixels) {
      let aim = this._aim(scene, upward);
      if (this.blend !== null) {
        const s = this.blend.share,
          e = s * s * (3 - 2 * s),
          from = this.blend.from;
        aim = {
          direction: v.unit(v.mix(from.direction, aim.direction, e)),
          up: v.mix(from.up, aim.up, e),
          focus: v.mix(from.focus, aim.focus, e),
          radius: from.radius + (aim.radius - from.radius) * e,
        };
      }
      this.last = aim;
      const aspect = width / height,
        distance = aim.radius / Math.sin(OPENING / 2) / Math.min(aspect, 1);
      const eye = v.add(aim.focus, v.times(aim.direction, distance)),
        back = v.unit(aim.direction);
      const flat = v.cross(aim.up, back),
        right = v.norm(flat) > 1e-6 ? v.unit(flat) : v.beside(back),
        up = v.cross(back, right);
      const near = 0.02 * distance,
        far = 40 * distance,
        f = 1 / Math.tan(OPENING / 2);
      const a = (far + near) / (near - far),
        b = (2 * far * near) / (near - far);
      const rows = [
        [...v.times(right, f / aspect), -v.dot(right, eye) * (f / aspect)],
        [...v.times(up, f), -v.dot(up, eye) * f],
        [...v.times(back, a), -v.dot(back, eye) * a + b],
        [...v.times(back, -1), v.dot(back, eye)],
      ];
      const matrix = new Float32Array(16);
      rows.forEach((row, i) =>
        row.forEach((x, j) => {
          matrix[4 * j + i] = x;
        }),
      );
      return { matrix, near, pixels };
    }
  }

  return { Camera, VIEWS };
})();
