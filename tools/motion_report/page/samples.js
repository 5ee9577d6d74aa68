// The page of sampled motions: figures of each way to act, samples side by side.

import {h, isNumber, short} from "./elements.js";
import {makeViewer} from "./viewer.js";

const COLUMNS = [
  ["samples", "", (way) => way.samples, 0],
  ["upright", "%", (way) => way.upright_percent, 1],
  ["got up", "%", (way) => way.got_up_percent, 1],
  ["stuck", "%", (way) => way.stuck_percent, 1],
  ["diversity", "m", (way) => way.diversity_m, 3],
  ["coverage", "%", (way) => way.coverage_percent, 1],
  ["distance", "sd", (way) => way.distance, 3],
  ["foot skate", "cm/s", (way) => way.foot_skate_cm_per_s, 1],
  ["root speed", "m/s", (way) => way.root_speed_m_per_s, 2],
];

function table(report, choose) {
  const rows = new Map(report.ways.map((way) => [way, h("tr", {
    "aria-selected": false, click: () => choose(way)},
    h("td", {class: "text name"}, way.name), COLUMNS.map(([, , value, digits]) =>
        h("td", {}, isNumber(value(way)) ? short(value(way), digits) : "–")))]));
  const heads = COLUMNS.map(([name, unit]) =>
      h("th", {}, name, unit ? h("small", {}, " " + unit) : null));
  return {
    element: h("div", {class: "panel scroll"}, h("table", {}, h("thead", {}, h("tr", {},
        h("th", {class: "text"}, "acts by"), heads)), h("tbody", {}, [...rows.values()]))),
    mark: (way) => rows.forEach((row, of) => row.setAttribute("aria-selected", of === way)),
  };
}

export function showSamples(report) {
  const viewer = makeViewer(report.bodies);
  const details = h("div", {class: "panel details"});
  const choose = (way) => {
    rows.mark(way);
    details.replaceChildren(h("h2", {}, way.name),
        h("p", {class: "soft small"}, `${way.trajectories.length} of ${way.samples} samples, ` +
            "each beside the one before it, from:"),
        h("ul", {class: "findings"}, way.starts.map((start) =>
            h("li", {class: "note"}, start))));
    const [first, ...others] = way.trajectories;
    viewer.show({name: way.name, trajectory: first, companions: others,
      reason: "no samples of it are in this page"});
  };
  const rows = table(report, choose);
  document.getElementById("page").append(
      h("div", {class: "kicker"}, "Sinew samples"), h("h1", {}, report.bundle),
      h("p", {class: "lead"}, `The prior alone moves ${report.character} for `,
          h("b", {}, `${short(report.seconds)} seconds`), ` from "${report.start}", seed ${
            report.seed}.`),
      h("div", {class: "stage"}, viewer.element, details), rows.element,
      h("footer", {}, `Written by ${report.build}. What the figures mean is said in the JSON ` +
          "file beside this page. Drag to turn the view, scroll to come closer. Nothing in this " +
          "page is loaded from a network."));
  document.title = "samples · " + report.bundle;
  const first = report.ways.find((way) => way.trajectories.length > 0);
  if (first) choose(first);
}
