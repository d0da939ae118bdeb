"use strict";
/* Shows a drawing with WebGL2. Segments are rectangles of some pixels' width, cut at the near plane. */
rvjax.webgl = (() => {
  const LINES = `#version 300 es
    layout(location = 0) in vec2 corner;
    layout(location = 1) in vec3 a;
    layout(location = 2) in vec3 b;
    layout(location = 3) in vec4 colour;
    layout(location = 4) in float width;
    uniform mat4 view;
    uniform vec2 size;
    uniform float near;
    out vec4 tint;
    void main() {
      vec4 p = view * vec4(a, 1.0), q = view * vec4(b, 1.0);
      tint = colour;
      if (p.w < near && q.w < near) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
      if (p.w < near) p = mix(p, q, (near - p.w) / (q.w - p.w));
      if (q.w < near) q = mix(q, p, (near - q.w) / (p.w - q.w));
      vec2 from = p.xy / p.w * size, to = q.xy / q.w * size, along = to - from;
      float reach = length(along);
      vec2 side = reach > 1e-6 ? vec2(-along.y, along.x) / reach : vec2(0.0, 1.0);
      vec4 end = corner.x < 0.5 ? p : q;
      end.xy += side * corner.y * width / size * end.w;
      end.z -= 0.0004 * end.w;
      gl_Position = end;
    }`;
  const FACES = `#version 300 es
    layout(location = 0) in vec3 place;
    layout(location = 1) in vec4 colour;
    uniform mat4 view;
    out vec4 tint;
    void main() { tint = colour; gl_Position = view * vec4(place, 1.0); }`;
  const TINT = `#version 300 es
    precision mediump float;
    in vec4 tint;
    out vec4 colour;
    void main() { colour = vec4(tint.rgb * tint.a, tint.a); }`;

  const program = (gl, vertex, fragment) => {
    const made = gl.createProgram();
    for (const [kind, source] of [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment],
    ]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made) || "no shader program");
    return made;
  };

  const attributes = (gl, buffer, stride, parts, divisor) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    let offset = 0;
    for (const [location, count] of parts) {
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, count, gl.FLOAT, false, 4 * stride, 4 * offset);
      gl.vertexAttribDivisor(location, divisor);
      offset += count;
    }
  };

  class Renderer {
    constructor(canvas) {
      const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
      if (gl === null) throw new Error("no WebGL2");
      this.gl = gl;
      this.canvas = canvas;
      this.lost = false;
      canvas.addEventListener("webglcontextlost", () => {
        this.lost = true;
      });
      this.lines = program(gl, LINES, TINT);
      this.faces = program(gl, FACES, TINT);
      this.corners = gl.createBuffer();
      this.data = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]), gl.STATIC_DRAW);
      this.forLines = gl.createVertexArray();
      gl.bindVertexArray(this.forLines);
      attributes(gl, this.corners, 2, [[0, 2]], 0);
      attributes(
        gl,
        this.data,
        11,
        [
          [1, 3],
          [2, 3],
          [3, 4],
          [4, 1],
        ],
        1,
      );
      this.forFaces = gl.createVertexArray();
      gl.bindVertexArray(this.forFaces);
      attributes(
        gl,
        this.data,
        7,
        [
          [0, 3],
          [1, 4],
        ],
        0,
      );
    }

    show(drawing, view, background) {
      const { gl, canvas } = this;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(background[0], background[1], background[2], 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      this._faces(drawing.solids, view, true);
      this._lines(drawing.segments, view);
      this._faces(drawing.veils, view, false);
    }

    _faces(numbers, view, deep) {
      const { gl } = this;
      if (numbers.length === 0) return;
      gl.useProgram(this.faces);
      gl.uniformMatrix4fv(gl.getUniformLocation(this.faces, "view"), false, view.matrix);
      gl.depthMask(deep);
      gl.bindVertexArray(this.forFaces);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.data);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
      gl.drawArrays(gl.TRIANGLES, 0, numbers.length / 7);
      gl.depthMask(true);
    }

    _lines(numbers, view) {
      const { gl, canvas } = this;
      if (numbers.length === 0) return;
      gl.useProgram(this.lines);
      gl.uniformMatrix4fv(gl.getUniformLocation(this.lines, "view"), false, view.matrix);
      gl.uniform2f(gl.getUniformLocation(this.lines, "size"), canvas.width / view.pixels, canvas.height / view.pixels);
      gl.uniform1f(gl.getUniformLocation(this.lines, "near"), view.near);
      gl.bindVertexArray(this.forLines);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.data);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, numbers.length / 11);
    }
  }

  return { Renderer };
})();
