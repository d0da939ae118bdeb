"use strict";
/* A kept flight: its columns, and its state at any instant between two rows. */
rvjax.flight = (() => {
  const v = rvjax.vectors;
  const CHANNELS = ["fx", "fy", "fz", "tx", "ty", "tz"];
  const SATURATED = 0.99; /* of its limit, as in the metric saturation_duty */

  class Flight {
    constructor(about, clock, columns) {
      Object.assign(this, { about, t: clock.subarray(0, about.block.rows), columns, trails: {} });
      this.last = this.t[this.t.length - 1];
      this.rows = this.t.length;
      this.hasOrbit = "l0" in columns;
      this.axis = about.scene.axis;
      this.port = about.scene.port;
      this.portRows = v.portAxes(this.axis);
      this.shares = CHANNELS.map((name, i) => this._share(name, i));
      this.saturated = Array.from({ length: this.rows }, (_, row) =>
        this.shares.some((share) => Math.abs(share[row]) >= SATURATED),
      );
      const place = (row) => ["px", "py", "pz"].map((name) => columns[name][row]);
      this.error = Array.from({ length: this.rows }, (_, row) => v.norm(v.minus(place(row), this.port)));
      this.angle = Array.from({ length: this.rows }, (_, row) =>
        this._angle(["q0", "q1", "q2", "q3"].map((n) => columns[n][row])),
      );
    }

    /* Commanded wrench of a channel as a signed share of the limit on its side. */
    _share(name, i) {
      const { upper, lower } = this.about.scene.limits,
        values = this.columns[`cmd_${name}`];
      return Float64Array.from(values || [], (x) => x / (x >= 0 ? upper[i] : lower[i]));
    }

    /* Principal angle of a quaternion, in degrees. */
    _angle(q) {
      return (2 * Math.atan2(Math.hypot(q[1], q[2], q[3]), Math.abs(q[0])) * 180) / Math.PI;
    }

    /* Row before an instant and the share of the way to the next. */
    where(t) {
      let low = 0,
        high = this.rows - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (this.t[middle] <= t) low = middle;
        else high = middle;
      }
      const step = this.t[high] - this.t[low];
      return [low, step > 0 ? Math.min(Math.max((t - this.t[low]) / step, 0), 1) : 0];
    }

    /* A column at an instant, on the straight line between two rows. */
    value(name, t) {
      const [row, s] = this.where(t),
        column = this.columns[name];
      if (column === undefined) return NaN;
      const next = Math.min(row + 1, this.rows - 1);
      return s === 0 ? column[row] : s === 1 ? column[next] : column[row] + (column[next] - column[row]) * s;
    }

    quaternion(letter, t) {
      const [row, s] = this.where(t),
        next = Math.min(row + 1, this.rows - 1);
      const q = (at) => [0, 1, 2, 3].map((i) => this.columns[letter + i][at]);
      return v.slerp(q(row), q(next), s);
    }

    /* All of it at an instant. place: in T; attitude: components in P → in T, three rows. */
    at(t) {
      const place = ["px", "py", "pz"].map((name) => this.value(name, t)),
        quaternion = this.quaternion("q", t);
      return {
        t,
        place,
        quaternion,
        attitude: v.ofQuaternion(quaternion),
        position_error_m: v.norm(v.minus(place, this.port)),
        attitude_error_deg: this._angle(quaternion),
        speed_m_s: this.value("speed", t),
        rate_deg_s: (this.value("rate", t) * 180) / Math.PI,
        actuators: this.actuators(t),
      };
    }

    /* Every actuator at an instant: what it gives, its limit, whether it is saturated or has a fault. */
    actuators(t) {
      const { limits, thrusters } = this.about.scene;
      const faulted = (name) => this.about.faults.some((f) => f.actuator === name && f.from <= t && t < f.to);
      if (thrusters.length > 0) {
        return thrusters.map(({ name, most }) => {
          const value = this.value(`thrust_${name}_N`, t);
          return {
            name,
            unit: "N",
            command: NaN,
            value,
            limit: most,
            saturated: value >= SATURATED * most,
            faulted: faulted(name),
          };
        });
      }
      return CHANNELS.map((name, i) => {
        const command = this.value(`cmd_${name}`, t);
        const value = `applied_${name}` in this.columns ? this.value(`applied_${name}`, t) : command;
        const limit = command >= 0 ? limits.upper[i] : limits.lower[i];
        const saturated = Math.abs(command) >= SATURATED * limit;
        return { name, unit: i < 3 ? "N" : "N·m", command, value, limit, saturated, faulted: faulted(name) };
      });
    }

    /* T → frame of the picture at an instant: x ↦ rows (x − origin). */
    frame(name, t) {
      if (name === "port" || !this.hasOrbit) return { rows: this.portRows, origin: this.port };
      const rows = v.transposed(v.ofQuaternion(this.quaternion("l", t)));
      if (name === "lvlh") return { rows, origin: [0, 0, 0] };
      const turn = this.value("turn", t),
        c = Math.cos(turn),
        s = Math.sin(turn);
      return {
        rows: v.product(
          [
            [c, 0, -s],
            [0, 1, 0],
            [s, 0, c],
          ],
          rows,
        ),
        origin: [0, 0, 0],
      };
    }

    /* The places of all rows in a frame, each at its instant. */
    trail(name) {
      this.trails[name] ||= Array.from({ length: this.rows }, (_, row) => {
        const { rows, origin } = this.frame(name, this.t[row]);
        return v.apply(
          rows,
          v.minus(
            ["px", "py", "pz"].map((column) => this.columns[column][row]),
            origin,
          ),
        );
      });
      return this.trails[name];
    }
  }

  const clocks = {},
    made = {};

  /* The flight of an entry of the index; read once. */
  const load = (about) => {
    made[about.sample] ||= rvjax.blocks.read(`flight-${about.sample}`, about.block).then((columns) => {
      clocks[about.clock] ||= rvjax.blocks.plain(`clock-${about.clock}`);
      return new Flight(about, clocks[about.clock], columns);
    });
    return made[about.sample];
  };

  return { Flight, load, CHANNELS, SATURATED };
})();
