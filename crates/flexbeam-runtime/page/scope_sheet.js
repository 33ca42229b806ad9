// The settings of a scope: a dialog that changes nothing until it is taken.
// Enters: a scope (SI) and the signals of the run. Leaves: another scope (SI), checked.

import { unitsOf } from "./chart_signals.js";
import { colourOf } from "./colours.js";
import { element } from "./element.js";

const KINDS = [
  ["time", "Time"],
  ["xy", "XY"],
  ["spectrum", "Spectrum"],
];
const EDGES = [
  ["rising", "Rising"],
  ["falling", "Falling"],
  ["either", "Either"],
];
const MODES = [
  ["auto", "Auto: rolls while nothing crosses"],
  ["normal", "Normal: keeps the last crossing"],
  ["single", "Single: keeps the first crossing"],
];

export class ScopeSheet {
  /**
   * @param {{scope: object, signals: import("./chart_signals.js").Signal[], ends: [number, number]|null, ontake: (scope: object) => void}} of
   *   ends: of the left axis as shown now, offered when it is to be fixed
   */
  constructor({ scope, signals, ends, ontake }) {
    this.scope = scope;
    this.all = signals;
    this.ends = ends;
    this.ontake = ontake;
    this.chosen = scope.signals.filter((key) => signals.some((signal) => signal.key === key));
    this.error = element("p", { class: "scope-error", role: "alert" });
    this.form = element("form", { method: "dialog", novalidate: true, onsubmit: (event) => this.take(event) }, ...this.parts());
    this.element = element(
      "dialog",
      {
        class: "scope-sheet",
        "aria-label": "Scope settings",
        onclose: () => this.leave(),
        onkeydown: (event) => this.key(event),
      },
      this.form,
    );
    this.followSignals();
    this.followKind();
    this.before = document.activeElement;
    document.getElementById("sheets").append(this.element);
    this.open();
  }

  /** Not modal: Emergency stop must stay within reach. */
  open() {
    this.element.show();
    this.title.select();
  }

  /** Gives the focus back to where it was. */
  leave() {
    this.element.remove();
    if (this.before?.isConnected) this.before.focus();
  }

  key(event) {
    if (event.key !== "Escape" || event.defaultPrevented) return;
    event.preventDefault();
    this.element.close();
  }

  parts() {
    const { scope } = this;
    this.title = element("input", { name: "title", value: scope.title, required: true });
    this.span = number("span_s", scope.span_s);
    const cancel = element("button", { type: "button", text: "Cancel", onclick: () => this.element.close() });
    return [
      element("h2", { text: "Scope settings" }),
      row("Title", this.title),
      element(
        "fieldset",
        { class: "scope-kinds" },
        element("legend", { text: "Kind" }),
        ...KINDS.map(([value, text]) => radio("kind", value, text, scope.kind === value, () => this.followKind())),
      ),
      this.signalList(),
      row("Span", this.span, "s"),
      this.rangePart(),
      this.triggerPart(),
      this.error,
      element("footer", {}, cancel, element("button", { type: "submit", class: "scope-take", text: "Apply" })),
    ];
  }

  signalList() {
    this.boxes = this.all.map((signal) => {
      const box = element("input", { type: "checkbox", onchange: () => this.choose(signal.key, box.checked) });
      box.checked = this.chosen.includes(signal.key);
      const swatch = element("i", { class: "scope-swatch", "aria-hidden": "true" });
      swatch.style.setProperty("--signal", colourOf(signal.key));
      const label = element(
        "label",
        {},
        box,
        swatch,
        element("span", { text: signal.label }),
        element("small", { text: signal.unit }),
      );
      return { signal, box, label };
    });
    this.across = element("select", { onchange: () => this.putFirst(this.across.value) });
    this.acrossRow = row("x axis", this.across);
    const list = element("div", { class: "scope-signals" }, ...this.boxes.map(({ label }) => label));
    this.hint = element("p", { class: "scope-hint" });
    return element("fieldset", {}, element("legend", { text: "Signals" }), list, this.hint, this.acrossRow);
  }

  rangePart() {
    const { range } = this.scope;
    this.fitted = element("input", { type: "checkbox", onchange: () => this.followRange() });
    this.fitted.checked = !range;
    this.low = number("low", "");
    this.high = number("high", "");
    this.unit = element("span", { class: "scope-unit" });
    this.rangeRow = element(
      "div",
      { class: "scope-row" },
      element("label", { text: "From " }, this.low),
      element("label", { text: "to " }, this.high),
      this.unit,
    );
    const fit = element("label", { class: "scope-check" }, this.fitted, "Fit to the data");
    return element("fieldset", {}, element("legend", { text: "Left axis" }), fit, this.rangeRow);
  }

  triggerPart() {
    const { trigger } = this.scope;
    this.triggered = element("input", { type: "checkbox", onchange: () => this.followTrigger() });
    this.triggered.checked = Boolean(trigger);
    this.source = choice(
      this.all.map((signal) => [signal.key, signal.label]),
      trigger?.signal ?? this.chosen[0],
    );
    this.source.addEventListener("change", () => this.followTrigger());
    this.edge = choice(EDGES, trigger?.edge ?? "rising");
    this.mode = choice(MODES, trigger?.mode ?? "auto");
    this.level = number("level", trigger ? trim(trigger.level * this.factorOf(trigger.signal)) : 0);
    this.levelUnit = element("span", { class: "scope-unit" });
    this.before = number("before", trim((trigger?.before ?? 0.1) * 100));
    this.triggerRows = element(
      "div",
      {},
      row("Signal", this.source),
      row("Edge", this.edge),
      element(
        "div",
        { class: "scope-row" },
        element("label", {}, element("span", { text: "Level" }), this.level),
        this.levelUnit,
      ),
      row("Mode", this.mode),
      row("Before the crossing", this.before, "%"),
    );
    const on = element("label", { class: "scope-check" }, this.triggered, "Stand still at a crossing");
    this.triggerField = element("fieldset", {}, element("legend", { text: "Trigger" }), on, this.triggerRows);
    return this.triggerField;
  }

  get kind() {
    return this.form.querySelector("input[name=kind]:checked").value;
  }

  factorOf(key) {
    return this.all.find((signal) => signal.key === key)?.factor ?? 1;
  }

  /** Signals that have a vertical axis. */
  get vertical() {
    const keys = this.kind === "xy" ? this.chosen.slice(1) : this.chosen;
    return keys.map((key) => this.all.find((signal) => signal.key === key));
  }

  choose(key, yes) {
    this.chosen = yes ? [...this.chosen, key] : this.chosen.filter((other) => other !== key);
    this.followSignals();
  }

  putFirst(key) {
    this.chosen = [key, ...this.chosen.filter((other) => other !== key)];
    this.followSignals();
  }

  /** Two units have an axis each; signals of a third cannot be chosen. */
  followSignals() {
    const units = unitsOf(this.vertical);
    const full = units.length >= 2;
    for (const { signal, box, label } of this.boxes) {
      box.disabled = full && !units.includes(signal.unit) && !box.checked;
      label.classList.toggle("off", box.disabled);
    }
    this.hint.textContent = full ? `A plot has two axes; these are ${units.join(" and ")}.` : "";
    this.across.replaceChildren(
      ...this.chosen.map((key) => element("option", { value: key, text: this.all.find((s) => s.key === key).label })),
    );
    this.followRange();
  }

  followKind() {
    this.acrossRow.hidden = this.kind !== "xy";
    this.triggerField.hidden = this.kind !== "time";
    this.followSignals();
    this.followTrigger();
  }

  followRange() {
    this.rangeRow.hidden = this.fitted.checked;
    const [signal] = this.vertical;
    this.unit.textContent = signal?.unit ?? "";
    if (this.fitted.checked || this.low.value !== "") return;
    const ends = this.scope.range?.map((value) => value * (signal?.factor ?? 1)) ?? this.ends ?? [-1, 1];
    [this.low.value, this.high.value] = ends.map(trim);
  }

  followTrigger() {
    this.triggerRows.hidden = !this.triggered.checked;
    this.levelUnit.textContent = this.all.find((signal) => signal.key === this.source.value)?.unit ?? "";
  }

  /** The scope as it is in the sheet, or what is wrong with it. */
  read() {
    const scope = { title: this.title.value.trim(), kind: this.kind, signals: this.chosen, span_s: this.span.valueAsNumber };
    if (!scope.title) return wrong(this.title, "found no title, needed a few words");
    const least = scope.kind === "xy" ? 2 : 1;
    if (scope.signals.length < least)
      return wrong(this.boxes[0].box, `found ${scope.signals.length} signals, needed ${least} or more`);
    if (!(scope.span_s > 0 && scope.span_s < Infinity)) return wrong(this.span, "the span must be a number of seconds above 0");
    if (!this.fitted.checked) {
      const factor = this.vertical[0]?.factor ?? 1;
      scope.range = [this.low.valueAsNumber / factor, this.high.valueAsNumber / factor];
      if (!(scope.range[0] < scope.range[1])) return wrong(this.high, "the upper end must be a number above the lower one");
    }
    if (scope.kind === "time" && this.triggered.checked) {
      scope.trigger = {
        signal: this.source.value,
        edge: this.edge.value,
        level: this.level.valueAsNumber / this.factorOf(this.source.value),
        mode: this.mode.value,
        before: this.before.valueAsNumber / 100,
      };
      if (!Number.isFinite(scope.trigger.level)) return wrong(this.level, "the level must be a number");
      if (!(scope.trigger.before >= 0 && scope.trigger.before <= 1))
        return wrong(this.before, "the share before the crossing must be 0 to 100 %");
    }
    return { scope };
  }

  take(event) {
    event.preventDefault();
    const { scope, field, error } = this.read();
    this.error.textContent = error ?? "";
    if (error) return field.focus();
    this.element.close();
    return this.ontake(scope);
  }
}

function wrong(field, error) {
  return { field, error };
}

function row(text, field, unit = "") {
  return element(
    "label",
    { class: "scope-row" },
    element("span", { text }),
    field,
    element("span", { class: "scope-unit", text: unit }),
  );
}

function number(name, value) {
  return element("input", { type: "number", name, step: "any", value });
}

function radio(name, value, text, on, onchange) {
  const input = element("input", { type: "radio", name, value, onchange });
  input.checked = on;
  return element("label", { class: "scope-check" }, input, text);
}

function choice(entries, value) {
  const select = element("select", {}, ...entries.map(([key, text]) => element("option", { value: key, text })));
  select.value = value;
  return select;
}

/** Six digits: what a person would write. */
function trim(value) {
  return Number(value.toPrecision(6));
}
