// The page, from the data in the element "data".

import {clipDetails} from "./clip_details.js";
import {clipTable} from "./clip_table.js";
import {h, isNumber, short} from "./elements.js";
import {showSamples} from "./samples.js";
import {makeViewer} from "./viewer.js";

const report = JSON.parse(document.getElementById("data").textContent);

function lead() {
  const {ok, warned, rejected} = report.counts;
  const all = report.clips.length;
  const seconds = report.clips.filter((clip) => clip.status !== "rejected")
      .reduce((sum, clip) => sum + (isNumber(clip.seconds) ? clip.seconds : 0), 0);
  return h("p", {class: "lead"}, h("b", {}, `${ok + warned} of ${all} clips`),
      ` are good enough for the library: `, h("b", {}, `${short(seconds / 60)} minutes`),
      ` of motion for ${report.character} at ${report.frames_per_second} frames per second. `,
      warned ? `${warned} of them are worth a look. ` : "",
      rejected ? h("b", {}, `${rejected} ${rejected === 1 ? "was" : "were"} rejected.`) : "");
}

function limits() {
  const rows = report.limits.map((limit) => h("tr", {}, h("td", {class: "text"}, limit.figure),
      h("td", {}, `${limit.warn} ${limit.unit}`),
      h("td", {}, isNumber(limit.reject) ? `${limit.reject} ${limit.unit}` : "never")));
  return h("details", {}, h("summary", {}, "Limits: what warns and what rejects"),
      h("div", {class: "panel", style: "padding: 8px 14px; margin-top: 10px; max-width: 760px"},
          h("table", {}, h("thead", {}, h("tr", {}, h("th", {class: "text"}, "figure"),
              h("th", {}, "warned above"), h("th", {}, "rejected above"))),
              h("tbody", {}, rows))));
}

function showLibrary() {
  const page = document.getElementById("page");
  const viewer = makeViewer(report.bodies);
  const details = h("div", {class: "panel details"});
  const select = (clip) => {
    table.mark(clip);
    details.replaceChildren(...h("div", {}, clipDetails(clip)).childNodes);
    details.scrollTop = 0;
    viewer.show(clip);
  };
  const table = clipTable(report, (clip) => {
    select(clip);
    page.scrollTo && window.scrollTo({top: 0, behavior: "smooth"});
  });
  page.append(
      h("div", {class: "kicker"}, "Sinew motion library"),
      h("h1", {}, report.library.split("/").filter(Boolean).pop() || report.library), lead(),
      report.note ? h("p", {class: "soft small"}, `No pictures: ${report.note}`) : "",
      h("div", {class: "stage"}, viewer.element, details), table.element, limits(),
      h("footer", {}, `Written by ${report.build} into ${report.library}. Drag to turn the view, ` +
          "scroll to come closer. Nothing in this page is loaded from a network."));
  document.title = `${report.library.split("/").filter(Boolean).pop()} · motion library`;
  const first = report.clips.find((clip) => clip.trajectory !== undefined) || report.clips[0];
  if (first) select(first);
}

if (report.samples) showSamples(report);
else showLibrary();
