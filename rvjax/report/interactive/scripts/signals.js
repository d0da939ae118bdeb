"use strict";
/* Signals over time below the scene, with the events and the instant; all share the time line. */
rvjax.signals = (() => {
  const SVG = "http://www.w3.org/2000/svg",
    WIDE = 1000,
    HIGH = 100;

  const element = (name, attributes = {}) => {
    const made = document.createElementNS(SVG, name);
    Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
    return made;
  };

  /* 0.0123 → "0.0123", with a typographic minus. */
  const number = (x, digits = 3) => {
    if (!Number.isFinite(x)) return Number.isNaN(x) ? "–" : x > 0 ? "∞" : "−∞";
    const size = Math.abs(x);
    const text = size > 0 && (size < 1e-3 || size >= 1e5) ? x.toExponential(digits - 1) : String(Number(x.toPrecision(digits)));
    const [mantissa, power] = text.split("e");
    const raised =
      power === undefined
        ? ""
        : `·10${[...power.replace("+", "")].map((sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]).join("")}`;
    return mantissa.replace("-", "−") + raised;
  };

  /* Values → heights, logarithmic where all are positive and their ratio is large. */
  const scaleOf = (lists, fixed) => {
    const finite = lists.flatMap((values) => Array.from(values)).filter(Number.isFinite);
    let [low, high] = fixed || [Math.min(...finite), Math.max(...finite)];
    const log = !fixed && low > 0 && high > 50 * low;
    if (!(high > low)) [low, high] = [low - 1, high + 1];
    const f = log ? Math.log : (x) => x,
      from = f(low),
      span = f(high) - from;
    return { low, high, log, y: (x) => HIGH - 4 - ((f(Math.max(x, log ? low : -Infinity)) - from) / span) * (HIGH - 8) };
  };

  const pathOf = (t, values, last, y) => {
    let text = "",
      begun = false;
    for (let i = 0; i < t.length; i++) {
      if (!Number.isFinite(values[i])) {
        begun = false;
        continue;
      }
      text += `${begun ? "L" : "M"}${((t[i] / last) * WIDE).toFixed(1)},${y(values[i]).toFixed(1)}`;
      begun = true;
    }
    return text;
  };

  const STRIPS = [
    { title: "position error", unit: "m", series: (flight) => [["", flight.error]] },
    { title: "attitude error", unit: "°", series: (flight) => [["", flight.angle]] },
    {
      title: "force, share of its limit",
      unit: "",
      range: [-1.1, 1.1],
      series: (flight) => [0, 1, 2].map((i) => [rvjax.flight.CHANNELS[i], flight.shares[i]]),
    },
    {
      title: "torque, share of its limit",
      unit: "",
      range: [-1.1, 1.1],
      series: (flight) => [3, 4, 5].map((i) => [rvjax.flight.CHANNELS[i], flight.shares[i]]),
    },
  ];

  class Signals {
    /* host: an element; chosen(t): called where the reader picks an instant. */
    constructor(host, chosen) {
      Object.assign(this, { host, chosen, cursors: [], values: [] });
    }

    show(flight, last) {
      Object.assign(this, { flight, last, cursors: [], values: [] });
      this.host.replaceChildren(...STRIPS.map((strip) => this._strip(strip, flight)));
    }

    _strip(strip, flight) {
      const made = document.createElement("div"),
        head = document.createElement("p"),
        value = document.createElement("span");
      const series = strip.series(flight).filter(([, values]) => values.length > 0),
        scale = scaleOf(
          series.map(([, x]) => x),
          strip.range,
        );
      made.className = "strip";
      head.append(strip.title + (strip.unit ? `, ${strip.unit}` : ""));
      series.forEach(([name], i) => {
        if (!name) return;
        const key = document.createElement("span");
        key.className = `key series-${i}`;
        key.textContent = name;
        head.append(" ", key);
      });
      value.className = "now";
      head.append(" ", value);
      const picture = element("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, preserveAspectRatio: "none", role: "img" });
      picture.setAttribute("aria-label", `${strip.title} over time`);
      this._marks(picture, flight);
      if (strip.range)
        [-1, 0, 1].forEach((x) => picture.append(element("path", { class: "grid", d: `M0,${scale.y(x)}H${WIDE}` })));
      series.forEach(([, values], i) => {
        picture.append(element("path", { class: `curve series-${i}`, d: pathOf(flight.t, values, this.last, scale.y) }));
      });
      const cursor = element("path", { class: "cursor", d: `M0,0V${HIGH}` });
      picture.append(cursor);
      this.cursors.push(cursor);
      this.values.push(() => {
        value.textContent =
          series.map(([, values]) => number(this._at(values))).join(" · ") + (strip.unit ? ` ${strip.unit}` : "");
      });
      this._picking(picture);
      const range = document.createElement("span");
      range.className = "range";
      range.textContent = `${number(scale.low)} … ${number(scale.high)}${scale.log ? ", logarithmic" : ""}`;
      if (!strip.range) head.append(range);
      made.append(head, picture);
      return made;
    }

    _marks(picture, flight) {
      const x = (t) => (Math.min(t, this.last) / this.last) * WIDE;
      flight.about.events.forEach((event) => {
        if (event.to !== undefined) {
          const width = Math.max(x(event.to) - x(event.t), 2);
          picture.append(element("rect", { class: `span ${event.kind}`, x: x(event.t), y: 0, width, height: HIGH }));
        } else picture.append(element("path", { class: `mark ${event.kind}`, d: `M${x(event.t)},0V${HIGH}` }));
      });
      flight.about.faults.forEach((fault) =>
        picture.append(element("path", { class: "mark fault", d: `M${x(fault.from)},0V${HIGH}` })),
      );
    }

    _at(values) {
      const [row, s] = this.flight.where(this.t),
        next = Math.min(row + 1, values.length - 1);
      return values[row] + (values[next] - values[row]) * s;
    }

    _picking(picture) {
      const pick = (event) => {
        const box = picture.getBoundingClientRect();
        this.chosen(Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * this.last);
      };
      picture.addEventListener("pointerdown", (event) => {
        picture.setPointerCapture(event.pointerId);
        pick(event);
      });
      picture.addEventListener("pointermove", (event) => {
        if (event.buttons & 1) pick(event);
      });
    }

    move(t) {
      this.t = t;
      const x = (t / this.last) * WIDE;
      this.cursors.forEach((cursor) => cursor.setAttribute("d", `M${x.toFixed(2)},0V${HIGH}`));
      this.values.forEach((show) => show());
    }
  }

  return { Signals, number };
})();
