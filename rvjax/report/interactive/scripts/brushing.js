"use strict";
/* The linked pictures of the samples: one selection for all of them and for the table. */
rvjax.brushing = (() => {
  const { number } = rvjax.signals,
    { cell, option } = rvjax.controls;
  const at = (id) => document.getElementById(id);
  const ROWS = 25;

  class Brushing {
    /* opened(sample): shows a kept flight; command(sample): flies it again. */
    constructor(samples, opened, command) {
      Object.assign(this, { samples, opened, command });
      const { columns } = samples,
        draws = columns.filter((c) => c.kind === "draw"),
        metrics = columns.filter((c) => c.kind === "metric");
      const telling = metrics.filter((c) => c.ends.high > c.ends.low);
      const x = (draws[0] || columns[0]).name,
        y = (telling[0] || columns[0]).name;
      this.table = [...draws.slice(0, 3), ...telling.slice(0, 3)];
      this.parallel = new rvjax.plots.Parallel(samples, draws, telling);
      this.scatter = new rvjax.plots.Scatter(samples, x, y, (sample) => this.open(sample));
      this.histogram = new rvjax.plots.Histogram(samples, y);
      this._lists(x, y);
      this._form();
      samples.listen(() => this.show());
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this._draw());
      this.show();
    }

    _lists(x, y) {
      const lists = { "scatter-x": x, "scatter-y": y, "histogram-column": y, "filter-column": y };
      Object.entries(lists).forEach(([id, name]) => {
        at(id).append(...this.samples.columns.map((column) => option(column.name, column.label)));
        at(id).value = name;
      });
      const change = () => {
        this.scatter.names = [at("scatter-x").value, at("scatter-y").value];
        this.histogram.name = at("histogram-column").value;
        this._draw();
      };
      ["scatter-x", "scatter-y", "histogram-column"].forEach((id) => at(id).addEventListener("change", change));
    }

    _form() {
      const typed = (id, otherwise) => {
        const text = at(id).value.trim().replace("−", "-");
        return text === "" || Number.isNaN(Number(text)) ? otherwise : Number(text);
      };
      at("filter-set").addEventListener("click", () => {
        this.samples.choose({ [at("filter-column").value]: [typed("filter-from", -Infinity), typed("filter-to", Infinity)] });
      });
      at("filter-clear").addEventListener("click", () => this.samples.clear());
    }

    async open(sample) {
      const message = at("sample-message");
      message.replaceChildren();
      if (this.samples.kept.has(sample) && (await this.opened(sample))) return;
      message.append(
        `Sample ${sample}, ${this.samples.outcome[this.samples.place.get(sample)].replace("_", " ")}: `,
        "its flight is not kept in this report. ",
      );
      message.append(cell("code", this.command(sample)), " flies it again.");
    }

    show() {
      at("selection").textContent = this.samples.sentence;
      this._filters();
      this._draw();
      this._table();
    }

    _draw() {
      this.parallel.draw();
      this.scatter.draw();
      this.histogram.draw();
    }

    /* What is selected, as buttons that take it away, and the outcomes. */
    _filters() {
      const outcomes = this.samples.about.outcomes
        .filter((outcome) => this.samples.outcome.includes(outcome))
        .map((outcome) => {
          const label = document.createElement("label"),
            box = document.createElement("input");
          Object.assign(box, { type: "checkbox", checked: this.samples.outcomes.has(outcome) });
          box.addEventListener("change", () => this.samples.only(outcome, box.checked));
          label.append(box, ` ${outcome.replace("_", " ")}`);
          return label;
        });
      const chips = [...this.samples.ranges].map(([name, [low, high]]) => {
        const column = this.samples.column(name),
          chip = cell("button", `${column.label}: ${number(low)} … ${number(high)} ×`, "chip");
        chip.type = "button";
        chip.setAttribute("aria-label", `Remove the range of ${column.label}`);
        chip.addEventListener("click", () => this.samples.choose({ [name]: null }));
        return chip;
      });
      at("filters").replaceChildren(...outcomes, ...chips);
    }

    /* Failed samples first, then in the order of the page. */
    _table() {
      const { samples } = this,
        head = document.createElement("tr");
      const unit = (column) => (column.unit && column.unit !== "1" ? `, ${column.unit}` : "");
      ["sample", "outcome", "", ...this.table.map((column) => column.label + unit(column))].forEach((text) => {
        const made = cell("th", text);
        made.scope = "col";
        head.append(made);
      });
      at("sample-table").tHead.replaceChildren(head);
      const chosen = samples.number.map((_, i) => i).filter((i) => samples.selected[i]);
      const order = [
        ...chosen.filter((i) => samples.outcome[i] !== "captured"),
        ...chosen.filter((i) => samples.outcome[i] === "captured"),
      ];
      at("sample-table").tBodies[0].replaceChildren(...order.slice(0, ROWS).map((i) => this._row(i)));
      const shown = Math.min(order.length, ROWS);
      at("sample-caption").textContent =
        `${shown} of ${order.length.toLocaleString("en-US")} selected samples, failed ones first. ` +
        "Numbers are rounded to 1/65,532 of the range of their column.";
    }

    _row(i) {
      const { samples } = this,
        row = document.createElement("tr"),
        sample = samples.number[i],
        kept = samples.kept.has(sample);
      const button = cell("button", kept ? "replay" : "command");
      button.type = "button";
      button.setAttribute("aria-label", `${kept ? "Replay" : "Command for"} sample ${sample}`);
      button.addEventListener("click", () => this.open(sample));
      const action = document.createElement("td");
      action.append(button);
      row.append(cell("td", String(sample)), cell("td", samples.outcome[i].replace("_", " ")), action);
      row.append(...this.table.map((column) => cell("td", number(column.values[i], 4), "number")));
      return row;
    }
  }

  return { Brushing };
})();
