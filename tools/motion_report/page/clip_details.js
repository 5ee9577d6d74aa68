// Everything that is known of one clip.

import {h, isNumber, short} from "./elements.js";

const plain = (name) => name.replaceAll("_", " ");

// "foot_skate_cm_per_s" as words and a unit.
const UNITS = [["_cm_per_s", "cm/s"], ["_m_per_s", "m/s"], ["_rad_per_s2", "rad/s²"],
  ["_rad_per_s", "rad/s"], ["_percent", "%"], ["_bodyweights", "body weights"], ["_nm", "Nm"],
  ["_cm", "cm"], ["_rad", "rad"]];

function named(key) {
  const unit = UNITS.find(([suffix]) => key.endsWith(suffix));
  return unit ? [plain(key.slice(0, -unit[0].length)), unit[1]] : [plain(key), ""];
}

function terms(pairs) {
  return h("dl", {}, pairs.filter(([, value]) => value !== "" && value !== undefined &&
      value !== null).map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
}

function sourceTerms(clip) {
  const source = clip.source || {};
  const concluded = new Set(source.concluded || []);
  const fact = (key, text) => text && concluded.has(key) ? `${text} (concluded)` : text;
  return terms([
    ["file", clip.file], ["format", source.format], ["skeleton map", source.map],
    ["rate", isNumber(source.frames_per_second) ? fact("frames_per_second",
        `${short(source.frames_per_second, 2)} per second`) : ""],
    ["unit", isNumber(source.metres_per_unit) && source.metres_per_unit > 0 ?
        fact("metres_per_unit", `${source.metres_per_unit.toPrecision(4)} m`) : ""],
    ["up", fact("up_axis", source.up_axis)],
    ["quaternions", fact("quaternion_order", source.quaternion_order)],
    ["length", isNumber(clip.seconds) ? `${short(clip.seconds, 2)} s${
        clip.loops ? ", loops" : ""}` : ""],
    ["recording", clip.trial],
    ["import", isNumber(clip.import_core_seconds) ?
        `${short(clip.import_core_seconds, 2)} s of a core` : ""],
  ]);
}

function jointErrors(clip) {
  const errors = (clip.retarget_errors || []).filter((error) => isNumber(error.mean_cm));
  if (errors.length === 0) return null;
  const most = Math.max(...errors.map((error) => error.max_cm), 1e-6);
  return [h("h3", {}, "Distance from the scaled source, mean and largest"),
    h("div", {class: "bars"}, errors.map((error) => [h("span", {}, plain(error.joint)),
      h("div", {class: "bar"},
          h("i", {class: "max", style: `width:${100 * error.max_cm / most}%`}),
          h("i", {style: `width:${100 * error.mean_cm / most}%`})),
      h("span", {class: "soft"}, `${short(error.mean_cm)} / ${short(error.max_cm)} cm`)]))];
}

// The panel's content for a clip.
export function clipDetails(clip) {
  const findings = clip.findings || [];
  const reasons = findings.length > 0 ? findings : clip.reason ? [clip.reason] : [];
  const list = [
    ...reasons.map((text, index) =>
        h("li", {class: index === 0 ? clip.status : "warned"}, text)),
    ...(clip.warnings || []).map((text) => h("li", {class: "note"}, text)),
    ...(clip.note ? [h("li", {class: "note"}, clip.note)] : []),
  ];
  return [
    h("h2", {}, clip.name, h("span", {class: "badge " + clip.status}, clip.status)),
    list.length ? h("ul", {class: "findings"}, list) : null,
    clip.strip ? h("img", {class: "strip", src: clip.strip,
                           alt: `eight moments of ${clip.name}`}) : null,
    h("h3", {}, "Source"), sourceTerms(clip),
    clip.figures ? [h("h3", {}, "Figures"), terms(Object.entries(clip.figures).map(
        ([key, value]) => [named(key)[0], isNumber(value) ?
            `${short(value, 2)} ${named(key)[1]}` : "not a number"]))] : null,
    jointErrors(clip),
  ];
}
