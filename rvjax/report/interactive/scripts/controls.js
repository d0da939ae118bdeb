"use strict";
/* Buttons, keys, the address of the page, and the lists beside the replay. */
rvjax.controls = (() => {
  const { number } = rvjax.signals;
  const at = (id) => document.getElementById(id);
  const cell = (name, text, label = "") => {
    const made = document.createElement(name);
    made.textContent = text;
    if (label) made.className = label;
    return made;
  };
  const option = (value, text) => {
    const made = cell("option", text);
    made.value = value;
    return made;
  };

  /* {sample, t} of `#sample=17&t=83.2`; null of any other address. */
  const address = (hash = location.hash) => {
    const found = /^#sample=(\d+)(?:&t=([0-9.eE+]+))?$/.exec(hash);
    return found === null ? null : { sample: Number(found[1]), t: found[2] === undefined ? 0 : Number(found[2]) || 0 };
  };

  /* Flies a sample again, in a shell. */
  const command = (folder, sample) => {
    const plain = /^[\w@%+=:,./-]+$/.test(folder),
      quoted = `'${folder.replaceAll("'", `'"'"'`)}'`;
    return `rvjax replay ${plain ? folder : quoted} --sample ${sample}`;
  };

  class Controls {
    constructor(replay, folder) {
      Object.assign(this, { replay, folder, touched: false, later: null, rows: [] });
      this.signals = new rvjax.signals.Signals(at("signals"), (t) => this.go(t));
      this._fill();
      this._wire();
      this._mouse();
      replay.listen((what) => this.changed(what));
    }

    _fill() {
      at("flight").append(...this.replay.about.flights.map((about) => option(about.sample, rvjax.names.long(about))));
      at("speed").append(...[1, 2, 4, 8, 16, 32, 64].map((factor) => option(factor, `×${factor}`)));
      if (!this.replay.about.flights.some((about) => about.percentile !== null)) {
        at("ghosts").querySelector("[value=percentiles]").textContent = "percentiles (none kept)";
      }
    }

    _wire() {
      const { replay } = this,
        on = (id, event, action) => at(id).addEventListener(event, action);
      on("play", "click", () => (replay.playing ? replay.pause() : replay.play()));
      on("time", "input", () => this.go(Number(at("time").value)));
      on("speed", "change", () => replay.faster(Number(at("speed").value) / replay.speed));
      on("flight", "change", () => this.open(Number(at("flight").value), 0));
      on("frame", "change", () => replay.inFrame(at("frame").value));
      on("camera", "change", () => replay.look(at("camera").value));
      on("ghosts", "change", () => replay.ghost(at("ghosts").value));
      on("closer", "click", () => this._nearer(1.25));
      on("farther", "click", () => this._nearer(0.8));
      on("link", "click", () => this._copy());
      on("replay", "keydown", (event) => this._key(event));
      window.addEventListener("hashchange", (event) => this.follow(true, new URL(event.newURL).hash));
    }

    _nearer(factor) {
      this.replay.camera.nearer(factor);
      this.replay.redraw();
    }

    /* Keys act in the section of the replay; lists and buttons keep theirs. */
    _key(event) {
      const { replay } = this,
        kind = event.target.tagName;
      if (event.ctrlKey || event.altKey || event.metaKey || kind === "SELECT" || (kind === "BUTTON" && event.key === " ")) return;
      const far = event.shiftKey ? 20 : 1,
        step = (way) => {
          for (let i = 0; i < far; i++) replay.step(way);
        };
      const actions = {
        " ": () => (replay.playing ? replay.pause() : replay.play()),
        ArrowRight: () => step(1),
        ArrowLeft: () => step(-1),
        Home: () => this.go(0),
        End: () => this.go(replay.last),
        "+": () => replay.faster(2),
        "=": () => replay.faster(2),
        "-": () => replay.faster(0.5),
      };
      if (!(event.key in actions)) return;
      event.preventDefault();
      this.touched = true;
      actions[event.key]();
    }

    _mouse() {
      const stage = at("stage"),
        { replay } = this;
      stage.addEventListener("pointerdown", (event) => {
        stage.focus({ preventScroll: true });
        stage.setPointerCapture(event.pointerId);
      });
      stage.addEventListener("pointermove", (event) => {
        if (!(event.buttons & 1)) return;
        replay.camera.turn(event.movementX * 0.008, event.movementY * 0.008, replay.upward);
        at("camera").value = "free";
        replay.redraw();
      });
      stage.addEventListener(
        "wheel",
        (event) => {
          if (document.activeElement !== stage) return; /* the page scrolls unless the reader has chosen the picture */
          event.preventDefault();
          this._nearer(Math.exp(-event.deltaY * 0.001));
        },
        { passive: false },
      );
    }

    /* An instant that the reader chose. */
    go(t) {
      this.touched = true;
      this.replay.pause();
      this.replay.to(t);
    }

    /* A flight that the reader chose; where it is not kept, the command that flies it again. */
    async open(sample, t) {
      this.touched = true;
      this.replay.pause();
      const kept = await this.replay.open(sample, t);
      this.say(kept ? "" : sample);
      return kept;
    }

    say(sample) {
      const message = at("replay-message");
      message.replaceChildren();
      if (sample === "") return;
      message.append(
        `The flight of sample ${sample} is not kept in this report. `,
        cell("code", command(this.folder, sample)),
        " flies it again.",
      );
    }

    /* Opens what the address says. */
    async follow(scroll, hash) {
      const wanted = address(hash);
      if (wanted === null) return false;
      clearTimeout(this.later); /* of the instant before: the address is newer */
      this.later = null;
      const kept = await this.open(wanted.sample, wanted.t);
      if (scroll) at("replay").scrollIntoView({ block: "start", behavior: "instant" });
      return kept;
    }

    get link() {
      return `#sample=${this.replay.flight.about.sample}&t=${Number(this.replay.t.toFixed(3))}`;
    }

    _remember() {
      if (!this.touched || this.later !== null) return;
      this.later = setTimeout(() => {
        this.later = null;
        history.replaceState(null, "", this.link);
      }, 250);
    }

    async _copy() {
      this.touched = true;
      history.replaceState(null, "", this.link);
      try {
        await navigator.clipboard.writeText(location.href);
        at("link").textContent = "Copied";
      } catch {
        at("link").textContent = "The address has it";
      }
      setTimeout(() => {
        at("link").textContent = "Copy link to this instant";
      }, 1500);
    }

    changed(what) {
      const { replay } = this;
      if (what === "flight") this._flight();
      at("play").textContent = replay.playing ? "Pause" : "Play";
      at("play").setAttribute("aria-pressed", String(replay.playing));
      at("speed").value = String(replay.speed);
      at("camera").value = replay.camera.name;
      at("frame").value = replay.frame;
      at("time").value = String(replay.t);
      at("time").setAttribute("aria-valuetext", `${number(replay.t, 4)} s`);
      at("clock").textContent = `${replay.t.toFixed(1)} of ${number(replay.last, 5)} s`;
      this.signals.move(replay.t);
      this._instant();
      this._remember();
    }

    _flight() {
      const { replay } = this,
        { about } = replay.flight;
      at("flight").value = String(about.sample);
      at("time").max = String(replay.last);
      this.signals.show(replay.flight, replay.last);
      at("events").replaceChildren(
        ...this._events(about).map(({ t, text, kind }) => {
          const item = document.createElement("li"),
            button = cell("button", `${number(t, 4)} s`);
          button.type = "button";
          button.addEventListener("click", () => this.go(t));
          item.append(button, " ", cell("span", text, `event ${kind}`));
          return item;
        }),
      );
      this._table();
    }

    /* Events and faults by time; actuators whose fault begins at the same instant share a line. */
    _events(about) {
      const begun = new Map();
      about.faults.forEach((fault) => {
        const key = `${fault.from} ${fault.fault}`,
          entry = begun.get(key) || { t: fault.from, kind: "fault", name: fault.fault, on: [] };
        entry.on.push(fault.actuator);
        begun.set(key, entry);
      });
      const faults = [...begun.values()].map((entry) => ({ ...entry, text: `fault ${entry.name}: ${entry.on.join(", ")}` }));
      const events = about.events.map((event) => {
        const until = event.to === undefined ? "" : `, until ${number(event.to, 4)} s`;
        return { ...event, text: event.text + until };
      });
      return [...faults, ...events].sort((a, b) => a.t - b.t);
    }

    _table() {
      const body = at("instant").tBodies[0];
      const row = (name) => {
        const made = document.createElement("tr"),
          head = cell("th", name),
          value = document.createElement("td");
        head.scope = "row";
        made.append(head, value);
        body.append(made);
        return value;
      };
      body.replaceChildren();
      this.rows = ["position error", "attitude error", "speed", "rate"].map(row);
      this.rows.push(...this.replay.flight.actuators(0).map((actuator) => row(actuator.name)));
    }

    _instant() {
      const state = this.replay.flight.at(this.replay.t);
      const texts = [
        `${number(state.position_error_m)} m`,
        `${number(state.attitude_error_deg)}°`,
        `${number(state.speed_m_s)} m/s`,
        `${number(state.rate_deg_s)}°/s`,
        ...state.actuators.map(
          ({ value, limit, unit, faulted, saturated }) =>
            `${number(Math.round((1e4 * value) / limit) * 1e-4 * limit)} of ${number(limit)} ${unit}` +
            `${faulted ? ", fault" : ""}${saturated ? ", saturated" : ""}`,
        ),
      ];
      const { about } = this.replay.flight,
        quantum = (name) => about.block.columns.find((column) => column[0] === name)[2];
      const [place, turn] = [
        ["px", "py", "pz"],
        ["q1", "q2", "q3"],
      ].map((names) => Math.max(...names.map(quantum)) / 2);
      at("replay-now").textContent =
        `Sample ${about.sample} at ${number(this.replay.t, 5)} s: ${texts[0]} and ${texts[1]} off. ` +
        `Places are rounded to ±${number(1e3 * place, 2)} mm, attitudes to about ±${number((360 / Math.PI) * turn, 2)}°; ` +
        "lines are straight between kept instants.";
      texts.forEach((text, i) => {
        this.rows[i].textContent = text;
        const actuator = state.actuators[i - 4];
        this.rows[i].className =
          actuator === undefined ? "" : actuator.faulted ? "faulted" : actuator.saturated ? "saturated" : "";
      });
    }
  }

  return { Controls, address, command, cell, option };
})();
