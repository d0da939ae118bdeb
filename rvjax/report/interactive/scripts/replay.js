"use strict";
/* The replay: which flight, which instant, and everything that shows them. */
rvjax.names = (() => {
  const words = (about) => about.outcome.replace("_", " ");

  /* A flight in a few letters: p50, worst 3, 17. */
  const short = (about) => (about.percentile !== null ? `p${Math.round(100 * about.percentile)}` : `${about.sample}`);

  const long = (about) => {
    const parts = [`sample ${about.sample}`, words(about)];
    if (about.percentile !== null) parts.push(`${Math.round(100 * about.percentile)} % of the settling times`);
    if (about.worst !== null) parts.push(`worst ${about.worst}`);
    return parts.join(", ");
  };

  return { words, short, long };
})();

rvjax.replay = (() => {
  const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
  const UPWARD = { port: 1, lvlh: -1, inertial: -1 };

  class Replay {
    /* parts: {scene, names: canvases}. */
    constructor(about, parts) {
      Object.assign(this, { about, parts, t: 0, speed: 8, playing: false, frame: "port", ghostly: "percentiles", ghosts: [] });
      Object.assign(this, { flight: null, seen: null, waiting: false, first: null, listeners: [] });
      this.camera = new rvjax.camera.Camera();
      this.renderer = this._renderer();
      new ResizeObserver(() => this.redraw()).observe(parts.scene);
    }

    _renderer() {
      try {
        return new rvjax.webgl.Renderer(this.parts.scene);
      } catch {
        const plain = this.parts.scene.cloneNode(); /* a canvas that was asked for WebGL gives no other picture */
        this.parts.scene.replaceWith(plain);
        this.parts.scene = plain;
        document.getElementById("scene-plain").hidden = false;
        return new rvjax.canvas.Renderer(plain);
      }
    }

    /* Calls `listener(what)` after a change: "flight", "time" or "state". */
    listen(listener) {
      this.listeners.push(listener);
    }

    _tell(what) {
      this.listeners.forEach((listener) => listener(what));
    }

    entry(sample) {
      return this.about.flights.find((about) => about.sample === sample);
    }

    get last() {
      return this.flight.last;
    }

    /* Shows a kept flight from an instant on; false where it is not kept. */
    async open(sample, t = 0) {
      const about = this.entry(sample);
      if (about === undefined) return false;
      this.flight = await rvjax.flight.load(about);
      this.ghosts = this.ghosts.filter((other) => other !== this.flight);
      this.t = Math.min(Math.max(t, 0), this.last);
      this._tell("flight");
      this.draw();
      await this._haunt();
      this.redraw();
      return true;
    }

    async ghost(which) {
      this.ghostly = which;
      await this._haunt();
      this.redraw();
    }

    async _haunt() {
      const others = this.about.flights.filter((about) => about !== this.flight.about);
      const shown = { none: [], all: others, percentiles: others.filter((about) => about.percentile !== null) }[this.ghostly];
      this.ghosts = await Promise.all(shown.map(rvjax.flight.load));
    }

    to(t) {
      this.t = Math.min(Math.max(t, 0), this.last);
      if (this.t >= this.last) this.playing = false;
      this._tell("time");
      this.redraw();
    }

    /* The row before or after the instant. */
    step(way) {
      const { flight, t } = this,
        small = 1e-9 * Math.max(this.last, 1);
      const [row] = flight.where(t + small);
      this.pause();
      if (way > 0) this.to(flight.t[Math.min(flight.t[row] > t + small ? row : row + 1, flight.rows - 1)]);
      else this.to(flight.t[flight.t[row] < t - small ? row : Math.max(row - 1, 0)]);
    }

    look(name) {
      this.camera.choose(name, !calm());
      this._tell("state");
      this._glide();
    }

    inFrame(name) {
      this.frame = name;
      this.camera.blend = null;
      this._tell("state");
      this.redraw();
    }

    faster(factor) {
      this.speed = Math.min(Math.max(this.speed * factor, 1), 64);
      this._tell("state");
    }

    play() {
      if (this.playing) return;
      if (this.t >= this.last) this.t = 0;
      this.playing = true;
      this._tell("state");
      let before = null;
      const tick = (now) => {
        if (!this.playing) return;
        if (before !== null) this.to(this.t + ((now - before) / 1000) * this.speed);
        before = now;
        if (this.playing) requestAnimationFrame(tick);
        else this._tell("state");
      };
      requestAnimationFrame(tick);
    }

    pause() {
      if (!this.playing) return;
      this.playing = false;
      this._tell("state");
    }

    /* The camera on its way to another place. */
    _glide() {
      const begin = performance.now(),
        blend = this.camera.blend;
      const tick = (now) => {
        if (blend === null || this.camera.blend !== blend) return this.redraw();
        blend.share = Math.min((now - begin) / 350, 1);
        if (blend.share >= 1) this.camera.blend = null;
        this.draw();
        if (this.camera.blend !== null) requestAnimationFrame(tick);
        return undefined;
      };
      requestAnimationFrame(tick);
    }

    redraw() {
      if (this.waiting || this.flight === null) return;
      this.waiting = true;
      requestAnimationFrame(() => {
        this.waiting = false;
        this.draw();
      });
    }

    draw() {
      const { scene, names } = this.parts,
        pixels = Math.min(window.devicePixelRatio || 1, 2);
      const width = Math.round(scene.clientWidth * pixels),
        height = Math.round(scene.clientHeight * pixels);
      if (width === 0 || height === 0 || this.flight === null) return;
      for (const canvas of [scene, names]) {
        if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
      }
      const shown = rvjax.scene.draw(this.flight, this.t, this.frame, this.ghosts);
      const upward = this.flight.hasOrbit ? UPWARD[this.frame] : 1;
      const view = this.camera.view({ ...shown, flight: this.flight, t: this.t }, upward, width, height, pixels);
      this.renderer.show(shown.drawing, view, rvjax.scene.colours.ground);
      rvjax.canvas.names(names, shown.drawing, view);
      this.seen = {
        t: this.t,
        sample: this.flight.about.sample,
        place: shown.state.place,
        quaternion: shown.state.quaternion,
        centre: shown.centre,
      };
      this.first ??= performance.now();
    }

    get upward() {
      return this.flight !== null && this.flight.hasOrbit ? UPWARD[this.frame] : 1;
    }
  }

  return { Replay, calm };
})();
