// The sheet at the end of a run. Enters: the result as the run reports it. Leaves: its figures; the data stay on the page.

import { element } from "./element.js";
import { count, runTime, shortTime } from "./number.js";
import { Sheet } from "./sheet.js";

const TITLES = { over: "The run is over", asked: "The run was stopped", fault: "Fault: the run was stopped" };

/** Opens the sheet. */
export function openResult(result) {
  const { lateness, execution } = result;
  const times = ({ median_s, p99_s, max_s }) => [median_s, p99_s, max_s].map(shortTime);
  const rows = [
    ["Time", runTime(result.ticks * result.period_s)],
    ["Ticks", count(result.ticks)],
    ["Missed periods", count(result.missed)],
    ["Without a fresh measurement", count(result.stale)],
    ["Not in the recording", count(result.unrecorded)],
    ["Recording", result.recording ?? "none"],
  ];
  const table = element("table", { class: "figures" }, element("tbody", {}, ...rows.map(([name, value]) => element("tr", {}, element("th", { scope: "row", text: name }), element("td", { text: value })))));
  const timing = element("table", { class: "figures" },
    element("thead", {}, element("tr", {}, element("td"), ...["median", "99 %", "longest"].map((text) => element("th", { scope: "col", text })))),
    element("tbody", {}, ...[["Lateness", lateness], ["Execution", execution]].filter(([, one]) => one)
      .map(([name, one]) => element("tr", {}, element("th", { scope: "row", text: name }), ...times(one).map((text) => element("td", { text }))))));
  const warnings = (result.warnings ?? []).map((text) => element("li", { text }));
  const close = element("button", { type: "button", class: "main", text: "Look at the data", onclick: () => sheet.close() });
  const sheet = new Sheet({
    title: TITLES[result.cause] ?? "The run is over", kind: result.cause === "fault" ? "fault" : "",
    body: [element("p", { class: "cause", text: result.text }), table, timing,
      ...(warnings.length ? [element("h3", { text: "Warnings" }), element("ul", { class: "warnings" }, ...warnings)] : []),
      element("p", { class: "hint", text: "The rig is at 0 V. What this page has of the run stays until the next run begins at this address." })],
    actions: [element("span", { class: "gap" }), close],
  });
  close.focus();
}
