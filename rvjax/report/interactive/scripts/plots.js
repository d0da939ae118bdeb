"use strict";
/* Parallel coordinates, scatter and histogram of the samples on canvases; dragging over them selects. */
rvjax.plots = (() => {
  const { number } = rvjax.signals;

  /* Lines of the rest, of the good and of the bad that are stroked at once; where strokes cross, the colour gets denser. */
  const TOGETHER = [Infinity, 32, 32];

  const dark = () => matchMedia("(prefers-color-scheme: dark)").matches;
  const ink = () =>
    dark()
      ? {
          text: "#e4e9ee",
          muted: "#9aa6b2",
          grid: "#36424f",
          rest: "rgba(150,163,176,0.10)",
          dot: "rgba(150,163,176,0.35)",
          good: "#56b4e9",
          bad: "#ff8a4a",
          brush: "rgba(240,228,66,0.25)",
        }
      : {
          text: "#1f2933",
          muted: "#5b6773",
          grid: "#d9dfe5",
          rest: "rgba(91,103,115,0.09)",
          dot: "rgba(91,103,115,0.30)",
          good: "#0072b2",
          bad: "#d55e00",
          brush: "rgba(230,159,0,0.25)",
        };

  /* Value → share of the axis from 0 to 1; infinite and lost values lie beyond its ends. */
  const share = ({ low, high, log }, x) => {
    if (Number.isNaN(x)) return 1.06;
    if (!Number.isFinite(x)) return x > 0 ? 1.06 : -0.06;
    const f = log ? Math.log : (y) => y,
      span = f(high) - f(low);
    return span > 0 ? (f(x) - f(low)) / span : 0.5;
  };
  const value = ({ low, high, log }, s) => {
    if (s > 1.03) return Infinity;
    if (s < -0.03) return -Infinity;
    return log ? Math.exp(Math.log(low) + s * Math.log(high / low)) : low + s * (high - low);
  };

  class Plot {
    constructor(id, height, samples) {
      Object.assign(this, { canvas: document.getElementById(id), height, samples, drag: null });
      this.canvas.style.height = `${height}px`;
      this.context = this.canvas.getContext("2d");
      new ResizeObserver(() => this.draw()).observe(this.canvas);
      const place = (event) => {
        const box = this.canvas.getBoundingClientRect();
        return [event.clientX - box.left, event.clientY - box.top];
      };
      this.canvas.addEventListener("pointerdown", (event) => {
        this.canvas.setPointerCapture(event.pointerId);
        this.drag = { from: place(event), to: place(event) };
      });
      this.canvas.addEventListener("pointermove", (event) => {
        if (this.drag === null) return;
        this.drag.to = place(event);
        this.draw();
      });
      this.canvas.addEventListener("pointerup", () => {
        if (this.drag === null) return;
        const { from, to } = this.drag;
        this.drag = null;
        if (Math.hypot(from[0] - to[0], from[1] - to[1]) < 4) this.click(to);
        else this.brush(from, to);
        this.draw();
      });
    }

    /* Clears the canvas at the pixels of the screen; false where it has no size. */
    begin() {
      const pixels = Math.min(window.devicePixelRatio || 1, 2);
      this.width = this.canvas.clientWidth;
      if (this.width === 0) return false;
      Object.assign(this.canvas, { width: this.width * pixels, height: this.height * pixels });
      this.context.setTransform(pixels, 0, 0, pixels, 0, 0);
      this.context.font = '11px system-ui, "DejaVu Sans", sans-serif';
      return true;
    }

    text(text, x, y, colour, align = "center") {
      Object.assign(this.context, { fillStyle: colour, textAlign: align });
      this.context.fillText(text, x, y);
    }

    box(x, y, width, height, colour) {
      this.context.fillStyle = colour;
      this.context.fillRect(x, y, width, height);
    }

    rank(i) {
      if (!this.samples.selected[i]) return 0;
      return this.samples.outcome[i] === "captured" ? 1 : 2;
    }
  }

  class Parallel extends Plot {
    constructor(samples, draws, metrics) {
      super("parallel", 300, samples);
      Object.assign(this, { draws, metrics, columns: [] });
    }

    /* As many axes as have room: draws, then metrics. */
    _choose() {
      const many = Math.min(Math.max(Math.floor(this.width / 105), 3), 10),
        metrics = Math.min(Math.floor(many / 2), this.metrics.length);
      this.columns = [...this.draws.slice(0, many - metrics), ...this.metrics.slice(0, metrics)];
    }

    x(k) {
      return 46 + (k * (this.width - 92)) / Math.max(this.columns.length - 1, 1);
    }

    y(s) {
      return this.height - 50 - s * (this.height - 100);
    }

    draw() {
      if (!this.begin()) return;
      this._choose();
      const colours = ink(),
        { context, samples } = this,
        paths = [[], [], []],
        drawn = [0, 0, 0];
      for (let i = 0; i < samples.n; i++) {
        const rank = this.rank(i);
        if (drawn[rank]++ % TOGETHER[rank] === 0) paths[rank].push(new Path2D());
        const path = paths[rank].at(-1);
        this.columns.forEach((column, k) => {
          const y = this.y(share(column.ends, column.values[i]));
          if (k) path.lineTo(this.x(k), y);
          else path.moveTo(this.x(k), y);
        });
      }
      const many = Math.min(1, 400 / Math.max(samples.counts.shown, 1));
      [
        [colours.rest, 1],
        [colours.good, Math.max(0.08, 0.5 * many)],
        [colours.bad, Math.max(0.25, 0.8 * many)],
      ].forEach(([colour, alpha], rank) => {
        Object.assign(context, { strokeStyle: colour, globalAlpha: alpha, lineWidth: 1 });
        paths[rank].forEach((path) => context.stroke(path));
      });
      context.globalAlpha = 1;
      this.columns.forEach((column, k) => this._axis(column, this.x(k), k, colours));
      if (this.drag !== null) {
        const x = this.x(this._nearest(this.drag.from[0])),
          [a, b] = [this.drag.from[1], this.drag.to[1]];
        this.box(x - 9, Math.min(a, b), 18, Math.abs(a - b), colours.brush);
      }
    }

    _axis(column, x, k, colours) {
      const { context } = this;
      Object.assign(context, { strokeStyle: colours.text, lineWidth: 1 });
      context.beginPath();
      context.moveTo(x, this.y(0));
      context.lineTo(x, this.y(1));
      context.stroke();
      this.text(number(column.ends.high), x, this.y(1) - 16, colours.muted);
      this.text(number(column.ends.low), x, this.y(0) + 22, colours.muted);
      const name = column.label.length > 22 ? `…${column.label.slice(-21)}` : column.label,
        half = context.measureText(name).width / 2 + 1;
      this.text(name, Math.min(Math.max(x, half), this.width - half), k % 2 ? this.height - 4 : 12, colours.text);
      const range = this.samples.ranges.get(column.name);
      if (range === undefined) return;
      const ends = range.map((end) => this.y(Math.min(Math.max(share(column.ends, end), -0.08), 1.08)));
      this.box(x - 7, ends[1], 14, ends[0] - ends[1], colours.brush);
      context.strokeRect(x - 7, ends[1], 14, ends[0] - ends[1]);
    }

    _nearest(x) {
      return this.columns.reduce((best, _, k) => (Math.abs(this.x(k) - x) < Math.abs(this.x(best) - x) ? k : best), 0);
    }

    brush(from, to) {
      const column = this.columns[this._nearest(from[0])];
      const back = (y) => value(column.ends, (this.height - 50 - y) / (this.height - 100));
      this.samples.choose({ [column.name]: [back(Math.max(from[1], to[1])), back(Math.min(from[1], to[1]))] });
    }

    click(at) {
      this.samples.choose({ [this.columns[this._nearest(at[0])].name]: null });
    }
  }

  class Scatter extends Plot {
    constructor(samples, x, y, opened) {
      super("scatter", 290, samples);
      Object.assign(this, { names: [x, y], opened });
    }

    get axes() {
      return this.names.map((name) => this.samples.column(name));
    }

    place(i, axes) {
      const [sx, sy] = axes.map((column) => share(column.ends, column.values[i]));
      return [58 + sx * (this.width - 86), this.height - 46 - sy * (this.height - 72)];
    }

    draw() {
      if (!this.begin()) return;
      const colours = ink(),
        axes = this.axes,
        { context, samples } = this;
      Object.assign(context, { strokeStyle: colours.grid, lineWidth: 1 });
      context.strokeRect(48, 12, this.width - 60, this.height - 48);
      for (const rank of [0, 1, 2]) {
        context.fillStyle = [colours.dot, colours.good, colours.bad][rank];
        for (let i = 0; i < samples.n; i++) {
          if (this.rank(i) !== rank) continue;
          const [x, y] = this.place(i, axes);
          if (rank === 2) context.fillRect(x - 2.5, y - 2.5, 5, 5);
          else context.fillRect(x - 1.5, y - 1.5, 3, 3);
        }
      }
      const [x, y] = axes,
        bottom = this.height - 22;
      this.text(number(x.ends.low), 58, bottom, colours.muted, "left");
      this.text(number(x.ends.high), this.width - 14, bottom, colours.muted, "right");
      this.text(
        `${x.label}${x.unit && x.unit !== "1" ? `, ${x.unit}` : ""}`,
        48 + (this.width - 60) / 2,
        this.height - 6,
        colours.text,
      );
      this.text(number(y.ends.high), 44, 30, colours.muted, "right");
      this.text(number(y.ends.low), 44, this.height - 44, colours.muted, "right");
      if (this.drag !== null) {
        const { from, to } = this.drag;
        this.box(
          Math.min(from[0], to[0]),
          Math.min(from[1], to[1]),
          Math.abs(from[0] - to[0]),
          Math.abs(from[1] - to[1]),
          colours.brush,
        );
      }
    }

    brush(from, to) {
      const [x, y] = this.axes;
      const backX = (at) => value(x.ends, (at - 58) / (this.width - 86)),
        backY = (at) => value(y.ends, (this.height - 46 - at) / (this.height - 72));
      const range = (back, a, b, turned) =>
        turned ? [back(Math.max(a, b)), back(Math.min(a, b))] : [back(Math.min(a, b)), back(Math.max(a, b))];
      const changes = { [x.name]: range(backX, from[0], to[0], false) };
      if (y !== x) changes[y.name] = range(backY, from[1], to[1], true);
      this.samples.choose(changes);
    }

    click(at) {
      const axes = this.axes;
      let best = -1,
        least = 10;
      for (let i = 0; i < this.samples.n; i++) {
        const [x, y] = this.place(i, axes),
          distance = Math.hypot(x - at[0], y - at[1]);
        if (this.samples.selected[i] && distance < least) [best, least] = [i, distance];
      }
      if (best >= 0) this.opened(this.samples.number[best]);
      else this.samples.choose(Object.fromEntries(this.names.map((name) => [name, null])));
    }
  }

  class Histogram extends Plot {
    constructor(samples, name) {
      super("histogram", 290, samples);
      this.name = name;
      this.bins = 40;
    }

    draw() {
      if (!this.begin()) return;
      const colours = ink(),
        column = this.samples.column(this.name),
        counts = [0, 1, 2].map(() => new Array(this.bins + 2).fill(0));
      for (let i = 0; i < this.samples.n; i++) {
        const s = share(column.ends, column.values[i]);
        const bin = s > 1.03 ? this.bins + 1 : s < -0.03 ? 0 : 1 + Math.min(Math.floor(s * this.bins), this.bins - 1);
        counts[this.rank(i)][bin] += 1;
      }
      const most = Math.max(1, ...counts[0].map((_, k) => counts[0][k] + counts[1][k] + counts[2][k])),
        high = this.height - 72;
      const wide = (this.width - 60) / (this.bins + 2);
      for (let k = 0; k < this.bins + 2; k++) {
        let y = this.height - 46;
        [
          [2, colours.bad],
          [1, colours.good],
          [0, colours.dot],
        ].forEach(([rank, colour]) => {
          const tall = (counts[rank][k] / most) * high;
          y -= tall;
          this.box(48 + k * wide + 0.5, y, wide - 1, tall, colour);
        });
      }
      this.text(String(most), 44, 30, colours.muted, "right");
      this.text(number(column.ends.low), 48 + wide, this.height - 30, colours.muted, "left");
      this.text(number(column.ends.high), this.width - 12 - wide, this.height - 30, colours.muted, "right");
      if (counts.some((list) => list[this.bins + 1] > 0))
        this.text("∞", this.width - 12 - wide / 2, this.height - 30, colours.muted);
      this.text(
        `${column.label}${column.unit && column.unit !== "1" ? `, ${column.unit}` : ""}${column.ends.log ? ", logarithmic" : ""}`,
        48 + (this.width - 60) / 2,
        this.height - 8,
        colours.text,
      );
      if (this.drag !== null)
        this.box(
          Math.min(this.drag.from[0], this.drag.to[0]),
          12,
          Math.abs(this.drag.from[0] - this.drag.to[0]),
          this.height - 58,
          colours.brush,
        );
    }

    brush(from, to) {
      const column = this.samples.column(this.name),
        wide = (this.width - 60) / (this.bins + 2);
      const back = (x) => value(column.ends, (x - 48 - wide) / (wide * this.bins));
      this.samples.choose({ [this.name]: [back(Math.min(from[0], to[0])), back(Math.max(from[0], to[0]))] });
    }

    click() {
      this.samples.choose({ [this.name]: null });
    }
  }

  return { Parallel, Scatter, Histogram, share, value };
})();
