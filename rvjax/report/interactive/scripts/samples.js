"use strict";
/* The samples of the page and a selection of them: ranges of columns and outcomes, all of which a selected sample meets. */
rvjax.samples = (() => {
  class Samples {
    constructor(about, columns) {
      const high = columns["sample.high"],
        low = columns["sample.low"];
      this.about = about;
      this.n = about.block.rows;
      this.number = Array.from({ length: this.n }, (_, i) => Math.round(high[i]) * 32768 + Math.round(low[i]));
      this.outcome = Array.from(columns.outcome, (code) => about.outcomes[Math.round(code)]);
      this.columns = about.columns.map((column) => ({
        ...column,
        values: columns[column.name],
        ends: this._ends(columns[column.name]),
      }));
      this.place = new Map(this.number.map((sample, i) => [sample, i]));
      this.kept = new Set(about.kept);
      this.ranges = new Map();
      this.outcomes = new Set(about.outcomes);
      this.listeners = [];
      this._select();
    }

    /* Smallest and largest finite value, and whether the axis is logarithmic. */
    _ends(values) {
      let low = Infinity,
        high = -Infinity;
      for (const x of values) {
        if (Number.isFinite(x)) {
          if (x < low) low = x;
          if (x > high) high = x;
        }
      }
      if (low > high) return { low: 0, high: 1, log: false };
      return { low, high, log: low > 0 && high > 100 * low };
    }

    column(name) {
      return this.columns.find((column) => column.name === name);
    }

    listen(listener) {
      this.listeners.push(listener);
    }

    /* Sets several ranges: name → [low, high] with both ends, or null for none. */
    choose(changes) {
      Object.entries(changes).forEach(([name, range]) => {
        if (range === null) this.ranges.delete(name);
        else this.ranges.set(name, range);
      });
      this._select();
    }

    only(outcome, on) {
      if (on) this.outcomes.add(outcome);
      else this.outcomes.delete(outcome);
      this._select();
    }

    clear() {
      this.ranges.clear();
      this.outcomes = new Set(this.about.outcomes);
      this._select();
    }

    get all() {
      return this.ranges.size === 0 && this.outcomes.size === this.about.outcomes.length;
    }

    _select() {
      const tests = [...this.ranges].map(([name, [low, high]]) => [this.column(name).values, low, high]);
      this.selected = Array.from(
        { length: this.n },
        (_, i) =>
          this.outcomes.has(this.outcome[i]) && tests.every(([values, low, high]) => values[i] >= low && values[i] <= high),
      );
      this.counts = this._count();
      this.listeners.forEach((listener) => listener());
    }

    /* shown: selected in the page; n, captured: of those that stand for the run. */
    _count() {
      let shown = 0,
        n = 0,
        captured = 0;
      for (let i = 0; i < this.n; i++) {
        if (!this.selected[i]) continue;
        shown += 1;
        if (i >= this.about.random) continue;
        n += 1;
        if (this.outcome[i] === "captured") captured += 1;
      }
      const interval = this.about.interval && n > 0 ? rvjax.statistics.clopperPearson(captured, n, this.about.confidence) : null;
      return { shown, n, captured, interval };
    }

    /* A sentence on the selection. */
    get sentence() {
      const { shown, n, captured, interval } = this.counts,
        count = (x) => x.toLocaleString("en-US");
      const percent = (x, way) => {
        const rounded = way(x * 1e4) / 100;
        return `${rounded.toFixed(2)} %`;
      };
      const more =
        shown > n ? ` Beside them ${count(shown - n)} selected samples that were chosen by their outcome and do not count.` : "";
      if (n === 0) return `No sample that stands for the run is selected.${more}`;
      const share = percent(captured / n, Math.round);
      const bounds =
        interval === null
          ? "no interval: the samples are not independent draws"
          : `${percent(interval[0], Math.floor)} … ${percent(interval[1], Math.ceil)}, ${100 * this.about.confidence} % confidence, Clopper–Pearson`;
      return `${count(n)} of ${count(this.about.random)} samples selected, ${count(captured)} captured: ${share} (${bounds}).${more}`;
    }
  }

  return { Samples };
})();
