"use strict";
/* Shows the lines of a drawing on a plain canvas where there is no WebGL2, and the names of things on top of either. */
rvjax.canvas = (() => {
  /* Place of a point in pixels, and its depth; null behind the near plane. */
  const projected = (view, width, height, p) => {
    const m = view.matrix;
    const w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
    if (w < view.near) return null;
    const x = (m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12]) / w,
      y = (m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]) / w;
    return [(0.5 + 0.5 * x) * width, (0.5 - 0.5 * y) * height, w];
  };

  const css = (colour) =>
    `rgba(${colour
      .slice(0, 3)
      .map((part) => Math.round(255 * part))
      .join(",")},${colour[3]})`;

  class Renderer {
    constructor(canvas) {
      this.canvas = canvas;
      this.context = canvas.getContext("2d");
      this.lost = false;
    }

    show(drawing, view, background) {
      const { context, canvas } = this,
        s = drawing.segments;
      context.fillStyle = css([...background, 1]);
      context.fillRect(0, 0, canvas.width, canvas.height);
      for (let i = 0; i < s.length; i += 11) {
        const a = projected(view, canvas.width, canvas.height, [s[i], s[i + 1], s[i + 2]]);
        const b = projected(view, canvas.width, canvas.height, [s[i + 3], s[i + 4], s[i + 5]]);
        if (a === null || b === null) continue;
        context.strokeStyle = css([s[i + 6], s[i + 7], s[i + 8], s[i + 9]]);
        context.lineWidth = s[i + 10] * view.pixels;
        context.beginPath();
        context.moveTo(a[0], a[1]);
        context.lineTo(b[0], b[1]);
        context.stroke();
      }
    }
  }

  /* The names of things, on a transparent canvas of the same size. */
  const names = (canvas, drawing, view) => {
    const context = canvas.getContext("2d");
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.font = `600 ${12 * view.pixels}px system-ui, "DejaVu Sans", sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineWidth = 3 * view.pixels;
    context.strokeStyle = "#0d1520";
    const taken = [],
      tall = 14 * view.pixels;
    for (const { at, text, colour } of drawing.labels) {
      const place = projected(view, canvas.width, canvas.height, at);
      if (place === null) continue;
      const half = context.measureText(text).width / 2 + 4 * view.pixels;
      const x = Math.min(Math.max(place[0], half), canvas.width - half);
      const hidden = () =>
        taken.find((other) => Math.abs(other.x - x) < other.half + half && Math.abs(other.y - place[1]) < tall);
      for (let other = hidden(), tries = 0; other !== undefined && tries < 8; other = hidden(), tries++)
        place[1] = other.y + tall;
      taken.push({ x, y: place[1], half });
      context.strokeText(text, x, place[1]);
      context.fillStyle = css(colour);
      context.fillText(text, x, place[1]);
    }
  };

  return { Renderer, names };
})();
