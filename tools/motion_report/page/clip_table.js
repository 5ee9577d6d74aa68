// The table of all clips: sorted by any column, filtered, coloured by limits.

import {h, isNumber, short} from "./elements.js";

const RANK = {rejected: 0, warned: 1, ok: 2};

const figure = (name) => (clip) => clip.figures && clip.figures[name];

// `limit`: the figure of report.json's limits that colours the column.
export const COLUMNS = [
  {title: "clip", text: true, value: (clip) => clip.name},
  {title: "source", text: true, value: (clip) => (clip.source && clip.source.format) || ""},
  {title: "length", unit: "s", value: (clip) => clip.seconds},
  {title: "rate", unit: "1/s", digits: 0,
   value: (clip) => clip.source && clip.source.frames_per_second},
  {title: "foot skate", unit: "cm/s", value: figure("foot_skate_cm_per_s"), limit: "foot skate"},
  {title: "in floor", unit: "cm", value: figure("penetration_cm"),
   limit: "largest depth below the floor"},
  {title: "floating", unit: "cm", value: figure("floating_cm"),
   limit: "mean gap between body and floor in contact"},
  {title: "beyond limits", unit: "%", value: figure("joint_limit_violations_percent"),
   limit: "angles beyond joint limits"},
  {title: "joint speed", unit: "rad/s", value: figure("peak_joint_speed_rad_per_s"),
   limit: "peak joint speed"},
  {title: "acceleration", unit: "rad/s²", digits: 0,
   value: figure("peak_joint_acceleration_rad_per_s2"), limit: "peak joint acceleration"},
  {title: "retarget error", unit: "cm", value: figure("retarget_error_cm"),
   limit: "retargeting error"},
  {title: "root force", unit: "body weights", digits: 2,
   value: figure("residual_force_bodyweights"), limit: "unexplained root force"},
  {title: "root torque", unit: "Nm", value: figure("residual_torque_nm")},
  {title: "peak torque", unit: "x limit", digits: 2, value: figure("peak_torque_ratio"),
   limit: "peak torque over its limit"},
];

function compare(a, b) {
  if (typeof a === "string" || typeof b === "string") return String(a).localeCompare(String(b));
  if (!isNumber(a)) return isNumber(b) ? 1 : 0;  // unknown ones last
  return isNumber(b) ? a - b : -1;
}

function cell(clip, column, limits) {
  const value = column.value(clip);
  if (column.text) {
    return h("td", {class: "text name", title: column.title === "clip" ? clip.file : null},
        column.title === "clip" ? h("i", {class: "dot " + clip.status, title: clip.status}) : null,
        value);
  }
  const limit = limits[column.limit];
  const bad = limit && isNumber(value) && isNumber(limit.reject) && value > limit.reject;
  const odd = limit && isNumber(value) && value > limit.warn;
  return h("td", {class: bad ? "rejected" : odd ? "warned" : null},
      short(value, column.digits ?? 1));
}

// `select(clip)` is called when a row is chosen. Returns {element, mark(clip)}.
export function clipTable(report, select) {
  const limits = Object.fromEntries(report.limits.map((limit) => [limit.figure, limit]));
  const state = {column: -1, down: false, status: "all", search: ""};
  const body = h("tbody");
  const rows = new Map();
  for (const clip of report.clips) {
    const measured = Boolean(clip.figures);
    const cells = measured ? COLUMNS.map((column) => cell(clip, column, limits)) :
        [cell(clip, COLUMNS[0], limits),
         h("td", {class: "text reason", colspan: COLUMNS.length - 1, title: clip.reason},
             clip.reason)];
    rows.set(clip, h("tr", {click: () => select(clip), tabindex: 0,
        keydown: (event) => { if (event.key === "Enter") select(clip); }}, cells));
  }
  const heads = COLUMNS.map((column, index) => h("th", {class: column.text ? "text" : null},
      h("button", {click: () => {
        state.down = state.column === index ? !state.down : !column.text;
        state.column = index;
        show();
      }}, column.title), column.unit ? h("small", {}, column.unit) : null));
  const count = h("span", {class: "soft small"});
  const show = () => {
    heads.forEach((head, index) => {
      if (index !== state.column) head.removeAttribute("aria-sort");
      else head.setAttribute("aria-sort", state.down ? "descending" : "ascending");
    });
    const chosen = report.clips.filter((clip) =>
        (state.status === "all" || clip.status === state.status) &&
        `${clip.name} ${clip.file}`.toLowerCase().includes(state.search));
    const column = COLUMNS[state.column];
    chosen.sort((a, b) => {
      if (!column) return RANK[a.status] - RANK[b.status];
      const x = column.value(a), y = column.value(b);
      // What is unknown stays at the end either way.
      if (!column.text && (!isNumber(x) || !isNumber(y))) return compare(x, y);
      return state.down ? compare(y, x) : compare(x, y);
    });
    body.replaceChildren(...chosen.map((clip) => rows.get(clip)));
    count.textContent = `${chosen.length} of ${report.clips.length} clips`;
  };
  const buttons = ["all", "ok", "warned", "rejected"].map((status) => h("button", {
    "aria-pressed": status === "all",
    click: () => {
      state.status = status;
      buttons.forEach((button) =>
          button.setAttribute("aria-pressed", button.dataset.status === status));
      show();
    }, "data-status": status}, status === "all" ? "all" : `${status} ${report.counts[status]}`));
  const filters = h("div", {class: "filters"}, h("div", {class: "segmented"}, buttons),
      h("input", {type: "search", placeholder: "name or folder", "aria-label": "search",
        input: (event) => { state.search = event.target.value.toLowerCase(); show(); }}), count);
  show();
  return {
    element: h("section", {}, filters, h("div", {class: "panel scroll"},
        h("table", {}, h("thead", {}, h("tr", {}, heads)), body))),
    mark: (clip) => rows.forEach((row, of) => row.setAttribute("aria-selected", of === clip)),
  };
}
