// The page: sections in reading order, from the data in the element "data".

const data = JSON.parse(document.getElementById("data").textContent);
const minutes = (m) => !isNumber(m) ? "–" : m < 1 ? `${Math.round(60 * m)} s`
    : m < 100 ? `${m.toFixed(1)} min` : `${(m / 60).toFixed(1)} h`;
const plain = (name) => name.replaceAll("_", " ");
const of = (a, b) => isNumber(a) && isNumber(b) ? `${a} of ${b}` : "–";

function stat({number, unit, label, beside, mood}) {
  return h("div", {class: "panel stat " + (mood || "")},
      h("div", {class: "number"}, number, unit ? h("small", {}, " " + unit) : null),
      h("div", {class: "label"}, label), beside ? h("div", {class: "beside"}, beside) : null);
}

function summary(head) {
  if (!isNumber(head.starts)) {
    return ["This run has not been evaluated yet."];
  }
  const all = head.succeeded_starts === head.starts;
  const zero = head.zero_action || {};
  return ["The policy survives ", h("b", {}, of(head.succeeded_starts, head.starts), " starts"),
      isNumber(head.seconds) ? ` of up to ${short(head.seconds)} s` : "",
      isNumber(head.e_g_mpjpe_mm) ? [all ? " and stays " : "; until it falls it is ",
        h("b", {}, `${Math.round(head.e_g_mpjpe_mm)} mm`), " from the reference"] : "",
      isNumber(head.minutes) ? [", after ", h("b", {}, minutes(head.minutes)),
        ` of training and ${short(head.samples)} samples`] : "", ". ",
      isNumber(zero.starts) ? `Without a policy (action zero), ${
        of(zero.succeeded_starts, zero.starts)} survive.` : ""];
}

function stats(head) {
  const zero = head.zero_action || {};
  const beside = (text) => isNumber(zero.starts) ? "zero action: " + text : null;
  const all = isNumber(head.starts) && head.succeeded_starts === head.starts;
  return h("div", {class: "stats"},
      stat({number: isNumber(head.starts) ? head.succeeded_starts : "–",
            unit: isNumber(head.starts) ? `of ${head.starts}` : "", label: "starts survived",
            mood: !isNumber(head.starts) ? "" : all ? "good" :
                head.succeeded_starts === 0 ? "bad" : "",
            beside: beside(`${of(zero.succeeded_starts, zero.starts)}, ${
                percent(zero.survived_share)} of the time`)}),
      stat({number: isNumber(head.e_g_mpjpe_mm) ? head.e_g_mpjpe_mm.toFixed(1) : "–", unit: "mm",
            label: "mean distance from the reference",
            beside: beside(`${short(zero.e_g_mpjpe_mm)} mm until it falls`)}),
      stat({number: minutes(head.minutes), label: "of training, evaluation left out",
            beside: isNumber(head.wall_minutes) ?
                `${minutes(head.wall_minutes)} on the wall clock` : null}),
      stat({number: short(head.samples), label: "samples (control steps)",
            beside: isNumber(head.iterations) ? `${head.iterations} iterations` : null}));
}

function player(film) {
  const canvas = h("canvas", {width: film.width, height: film.height, role: "img",
      "aria-label": "reference and simulation side by side"});
  const time = h("span", {});
  const slider = h("input", {type: "range", min: 0, max: film.frames - 1, value: 0,
                             "aria-label": "time"});
  const button = h("button", {class: "round", "aria-label": "play or pause"});
  const sheet = new Image();
  let frame = 0, playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, last = 0;
  const show = () => {
    canvas.getContext("2d").drawImage(sheet, (frame % film.columns) * film.width,
        Math.floor(frame / film.columns) * film.height, film.width, film.height,
        0, 0, film.width, film.height);
    slider.value = frame;
    time.textContent = `${(frame / film.fps).toFixed(1)} s`;
    button.textContent = playing ? "❚❚" : "▶";
  };
  const step = (now) => {
    if (playing && now - last >= 1000 / film.fps) {
      last = now;
      frame = (frame + 1) % film.frames;
      show();
    }
    requestAnimationFrame(step);
  };
  button.addEventListener("click", () => { playing = !playing; show(); });
  slider.addEventListener("input", () => {
    playing = false;
    frame = Number(slider.value);
    show();
  });
  sheet.addEventListener("load", () => { show(); requestAnimationFrame(step); });
  sheet.src = film.sheet;
  return h("div", {class: "panel player"}, canvas,
      h("div", {class: "names"}, h("span", {}, "reference"), h("span", {}, "simulation")),
      h("div", {class: "controls"}, button, slider, time));
}

function hero() {
  const film = data.film;
  const [name, recipe] = data.title.split(" · ");
  const mark = s("svg", {viewBox: "0 0 24 12", class: "mark", "aria-hidden": "true"},
      s("path", {d: "M1 6c4-7 7-7 11 0s7 7 11 0"}), s("path", {d: "M1 6c4 7 7 7 11 0s7-7 11 0"}));
  const words = h("div", {}, h("div", {class: "kicker"}, mark, "Sinew training report", recipe ? ` · ${recipe}` : ""),
      h("h1", {}, name), h("p", {class: "lead"}, summary(data.headline)));
  return h("header", {},
      h("div", {class: "hero" + (film ? " film" : "")}, words, film ? player(film) : null),
      stats(data.headline), data.notes.map((note) => h("p", {class: "notice"}, note)));
}

function section(title, words, ...content) {
  return h("section", {}, h("h2", {}, title), words ? h("p", {}, words) : null, content);
}

function filmSection() {
  const film = data.film;
  if (!film) {
    return section("In motion", "No pictures: " + (data.film_note || "there is no bundle."));
  }
  return section("In motion",
      `${plain(film.clip)}: reference above, simulated body below, seen by one camera that ` +
      "follows the reference, so that drifting apart is seen.",
      h("figure", {class: "panel strip"}, h("div", {class: "scroll"},
          h("img", {src: film.strip, alt: "film strip of reference and simulation"})),
        h("figcaption", {}, film.survived ? `All ${short(film.seconds)} s were survived.` :
            `The policy fell after ${short(film.seconds)} s.`)));
}

const AXES = [
  {key: "train_s", name: "training time", scale: 60, show: (v) => `${short(v)} min`},
  {key: "wall_s", name: "wall time", scale: 60, show: (v) => `${short(v)} min`},
  {key: "samples", name: "samples", scale: 1, show: short},
  {key: "iteration", name: "iterations", scale: 1, show: short}];

function chartList(group) {
  const train = data.training, evals = data.evaluations, zero = data.headline.zero_action || {};
  const line = (columns, key, name, colour, thin) =>
      ({columns, key, name, colour: `var(--c${colour})`, thin});
  const rule = (value, name) => isNumber(value) ? [{value, name}] : [];
  const zeroShare = zero.starts ? zero.succeeded_starts / zero.starts : NaN;
  return [
    {title: "Success and survival", wide: true, low: 0, high: 1, format: percent,
     series: [line(evals, "succeeded_share", "starts survived", 0),
              line(evals, "survived_share", "time survived", 1),
              line(evals, "left_out_succeeded_share", "left-out starts survived", 2)],
     rules: rule(zeroShare, "starts, zero action")},
    {title: "Distance from the reference, mm", wide: true, low: 0,
     series: [line(evals, "e_g_mpjpe_mm", "evaluation", 0),
              line(train, "tracking_mm", "training, with noise", 2, true)]},
    {title: "Reward per step",
     series: [line(train, "reward", "reward", 0),
              line(train, "reward_position", "position", 1, true),
              line(train, "reward_rotation", "rotation", 2, true),
              line(train, "reward_linear", "speed", 3, true),
              line(train, "reward_angular", "spin", 4, true)]},
    {title: "Error of joint targets, mrad", low: 0,
     series: [line(train, "action_error_mrad", "against the teacher", 0)]},
    {title: "Imitation loss", low: 0, series: [line(train, "action_loss", "actions", 0)]},
    {title: "Latent: KL to the prior, nats", low: 0,
     series: [line(train, "latent_kl", "KL", 2)]},
    {title: "Latent: steps of the mean", low: 0,
     series: [line(train, "continuity_loss", "distance", 1)]},
    {title: "Episodes that fail", low: 0, high: 1, format: percent,
     series: [line(train, "fail_share", "failed", 3)]},
    {title: "Steps per episode", low: 0,
     series: [line(train, "episode_steps", "steps", 0)]},
    {title: "KL divergence per iteration", low: 0, series: [line(train, "kl", "KL", 2)]},
    {title: "Clipped ratios", low: 0, format: percent,
     series: [line(train, "clip_fraction", "share", 1)]},
    {title: "Value: variance explained", low: -1, high: 1,
     series: [line(train, "explained_variance", "share", 0)]},
    {title: "Gradient norms", low: 0,
     series: [line(train, "policy_gradient_norm", "policy", 0),
              line(train, "value_gradient_norm", "value", 1)]},
    {title: "Losses", series: [line(train, "policy_loss", "policy", 0),
                               line(train, "value_loss", "value", 1)]},
    {title: "Exploration: noise factor", low: 0,
     series: [line(train, "std_factor", "of the initial", 3)]},
    {title: "Learning rates", low: 0,
     series: [line(train, "policy_learning_rate", "policy", 0),
              line(train, "value_learning_rate", "value", 1)]},
    {title: "Samples per second", low: 0,
     series: [line(train, "samples_per_s", "all actors", 0)]}]
      .map((one) => new LineChart(group, one)).filter((chart) => !chart.empty);
}

function curves() {
  const axes = AXES.filter((axis) => data.training[axis.key]);
  if (!axes.length) return section("Learning curves", "metrics.jsonl has no rows.");
  const group = new ChartGroup(axes);
  const buttons = axes.map((axis) => h("button", {"aria-pressed": String(axis === group.axis),
      onclick: (event) => {
        for (const button of buttons) button.setAttribute("aria-pressed", String(button === event.target));
        group.use(axis);
      }}, axis.name));
  return section("Learning curves",
      "Point at a chart: all of them show that moment. Numbers at rest are the last ones.",
      h("div", {class: "bar"}, h("span", {class: "soft small"}, "horizontal axis"),
        h("div", {class: "segmented", role: "group"}, buttons)),
      h("div", {class: "charts"}, chartList(group).map((chart) => chart.element)));
}

const HARDEST = [
  {name: "clip", text: true, show: (c) => c.name},
  {name: "starts", show: (c) => short(c.visits)},
  {name: "failed", show: (c) => short(c.failures)},
  {name: "failure rate", show: (c) => percent(c.failure_rate, 1)},
  {name: "share of starts", show: (c) => percent(c.probability, 1)},
  {name: "tracking error", show: (c) =>
    isNumber(c.tracking_error_mm) ? `${short(c.tracking_error_mm)} mm` : "–"},
  {name: "evaluations failed", show: (c) => of(c.failed_evaluations, c.evaluations)},
  {name: "latest", show: (c) => c.failed_latest === null ? "–" :
    h("span", {class: c.failed_latest ? "no" : "yes"},
      `${percent(c.succeeded_share)}, ${short(c.mean_error_mm)} mm`)},
  {name: "last start", show: (c) => c.last_seen < 0 ? "never" : short(c.last_seen)}];

function curriculum() {
  const {curves, clips, rule, summary} = data.curriculum || {};
  const axes = curves ? AXES.filter((axis) => curves[axis.key]) : [];
  if (!axes.length) return null;
  const line = (key, name, colour, thin) =>
      ({columns: curves, key, name, colour: `var(--c${colour})`, thin});
  const group = new ChartGroup(axes);
  const charts = [
    {title: "How wide the starts are spread", wide: true, low: 0, format: percent,
     series: [line("entropy_share", "entropy, of uniform", 0),
              line("floor_share", "floor", 1, true),
              line("largest_clip_share", "largest clip", 2, true)], rules: []},
    {title: "The hardest tenth", wide: true, low: 0, high: 1, format: percent,
     series: [line("hardest_share", "bins: share of starts", 0),
              line("hardest_failure_rate", "bins: failure rate", 3),
              line("worst_success", "clips: starts survived", 1)], rules: []},
    {title: "Clips that failed their latest evaluation", low: 0,
     series: [line("hard_clips", "clips", 3)], rules: []},
    {title: "Clips with half of the starts", low: 0,
     series: [line("clips_of_half", "clips", 0)], rules: []}]
      .map((one) => new LineChart(group, one)).filter((chart) => !chart.empty);
  return section("Where episodes start",
      [rule ? `Rule: ${plain(rule)}. ` : "", summary ? `${summary.clips} clips${
        summary.drawn_clips < summary.clips ? ` (starts from ${summary.drawn_clips} of them)` : ""
        } in ${summary.bins} bins of time, ${summary.left_out_clips} clips left out of training. ` : "",
       "A bin's failure rate is the share of recent passages that failed there or shortly after."],
      h("div", {class: "charts"}, charts.map((chart) => chart.element)),
      clips && clips.length ? h("div", {class: "panel scroll", style: "margin-top:14px"},
        h("table", {}, h("thead", {}, h("tr", {}, HARDEST.map((column) =>
            h("th", {class: column.text ? "text" : ""}, column.name)))),
          h("tbody", {}, clips.map((clip) => h("tr", {}, HARDEST.map((column) =>
            h("td", {class: column.text ? "text" : ""}, column.show(clip)))))))) : null);
}

function coreSeconds() {
  const {stages, total, cores, wall} = data.core_seconds;
  if (!(total > 0)) return section("Where core-seconds went", "The metrics have no time split.");
  const work = stages.filter((one) => ["simulate", "infer", "learn"].includes(one.name))
      .reduce((sum, one) => sum + one.seconds, 0);
  return section("Where core-seconds went",
      `${percent(work / total)} of ${short(total)} core-seconds (${short(cores)} cores for ${
        minutes(wall / 60)}) simulated, inferred or learned.`,
      h("div", {class: "panel"},
        h("div", {class: "stack", role: "img", "aria-label": "core-seconds by stage"},
          stages.map((one) => h("div", {style: `flex:${one.seconds / total} 1 0;background:var(--s-${
              one.name}, var(--c4))`, title: `${one.name}: ${percent(one.seconds / total, 1)}`},
            one.seconds / total > 0.055 ? percent(one.seconds / total) : ""))),
        h("table", {style: "margin-top:14px"}, stages.map((one) => h("tr", {},
          h("td", {}, h("span", {class: "swatch", style: `background:var(--s-${one.name}, var(--c4))`}),
            one.name), h("td", {class: "text soft"}, one.what),
          h("td", {}, short(one.seconds), " s"), h("td", {}, percent(one.seconds / total, 1)))))));
}

function lag() {
  const counts = Object.entries(data.lag.counts || {});
  const total = counts.reduce((sum, [, n]) => sum + n, 0);
  if (!total) return null;
  const words = counts.map(([versions, n]) => `${percent(n / total, n === total ? 0 : 1)} of ${
      total} iterations acted with ${versions === "0" ? "the newest policy (lag 0)" :
      `a policy ${versions} version${versions === "1" ? "" : "s"} old (lag ${versions})`}`);
  return section("Policy lag", null, h("div", {class: "panel"},
      h("div", {class: "stack", style: "height:22px;margin-bottom:12px"},
        counts.map(([, n], i) => h("div", {style: `flex:${n / total} 1 0;background:var(--c${i % 5})`}))),
      h("div", {}, words.join("; "), ". "),
      h("div", {class: "soft small"}, `The recipe allows ${data.lag.max}. `,
        data.lag.reissued ? `${data.lag.reissued} late orders were given to a second actor; ` +
        "that changes no result." : "No order was late.")));
}

function bodies() {
  const evaluation = data.evaluation;
  const clips = evaluation && evaluation.clips ? evaluation.clips.filter((c) => c.profile) : [];
  if (!clips.length) return null;
  const place = h("div", {});
  const show = (clip) => {
    const means = clip.body_mm;
    const order = means.map((_, i) => i).sort((a, b) => means[b] - means[a]);
    place.replaceChildren(heatMap({
      names: order.map((i) => plain(evaluation.bodies[i])),
      rows: order.map((i) => clip.profile.body_mm[i]),
      means: order.map((i) => means[i]), seconds: clip.profile.seconds}));
  };
  show(clips[0]);
  const choice = clips.length > 1 ? h("select", {"aria-label": "clip", onchange: (event) =>
      show(clips[event.target.selectedIndex])}, clips.map((c) => h("option", {}, c.name))) : null;
  return section("Which body is off, and when",
      "Mean distance of each tracked body from the reference over one pass of the clip, all " +
      "starts together; the worst body first.",
      choice ? h("div", {class: "bar"}, choice) : null, h("div", {class: "panel"}, place));
}

const COLUMNS = [
  {name: "clip", value: (c) => c.name, text: true},
  {name: "starts survived", value: (c) => c.succeeded_starts / c.starts, show: (c) => [
    h("span", {class: c.success ? "yes" : "no"}, of(c.succeeded_starts, c.starts)),
    h("span", {class: "meter"}, h("div", {style: `width:${100 * c.succeeded_starts / c.starts}%`}))]},
  {name: "E_g, mm", value: (c) => c.e_g_mpjpe_mm}, {name: "E, mm", value: (c) => c.e_mpjpe_mm},
  {name: "E_vel", value: (c) => c.e_vel}, {name: "E_acc", value: (c) => c.e_acc},
  {name: "first fall", value: (c) => c.failed_at_frame, show: (c) => c.failed_at_frame < 0 ? "none"
    : `${(c.failed_at_frame / (data.evaluation.frames_per_second || 30)).toFixed(2)} s`},
  {name: "zero action", value: (c) => c.zero_action ? c.zero_action.succeeded_starts : NaN,
   show: (c) => c.zero_action ? `${of(c.zero_action.succeeded_starts, c.zero_action.starts)}, ${
     short(c.zero_action.e_g_mpjpe_mm)} mm` : "–"}];

function clipTable() {
  if (!data.evaluation || !data.evaluation.clips) return null;
  const clips = data.evaluation.clips.slice(), body = h("tbody", {});
  const fill = () => body.replaceChildren(...clips.map((clip) => h("tr", {}, COLUMNS.map((column) =>
      h("td", {class: column.text ? "text" : ""}, column.show ? column.show(clip) :
        column.text ? column.value(clip) : short(column.value(clip)))))));
  let sorted = null, direction = 1;
  const head = COLUMNS.map((column) => {
    const cell = h("th", {class: column.text ? "text" : ""}, h("button", {onclick: () => {
      direction = sorted === column ? -direction : 1;
      sorted = column;
      for (const other of head) other.removeAttribute("aria-sort");
      cell.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
      clips.sort((a, b) => direction * (column.text ? column.value(a).localeCompare(column.value(b))
          : (column.value(a) ?? Infinity) - (column.value(b) ?? Infinity)));
      fill();
    }}, column.name));
    return cell;
  });
  fill();
  const definitions = Object.entries(data.evaluation.definitions || {});
  return section("Evaluation, clip by clip",
      `${data.evaluation.starts_per_clip ?? ""} evenly spaced starts per clip, mean action; ` +
      `looping clips run ${short(data.evaluation.seconds)} s. A clip succeeds if all its starts do.`,
      h("div", {class: "panel"}, h("div", {class: "scroll"},
          h("table", {}, h("thead", {}, h("tr", {}, head)), body))),
      definitions.length ? h("details", {style: "margin-top:14px"},
          h("summary", {}, "What the figures mean"), h("dl", {}, definitions.map(([name, words]) =>
              [h("dt", {}, name), h("dd", {}, words)]))) : null);
}

function command(text) {
  const button = h("button", {class: "copy", onclick: () => {
    if (!navigator.clipboard) return;
    navigator.clipboard.writeText(text).then(() => { button.textContent = "copied"; }, () => {});
  }}, "copy");
  return h("div", {class: "command"}, h("pre", {}, text), button);
}

function reproduce() {
  const bundle = data.bundle && data.bundle.provenance ? data.bundle.provenance : {};
  const facts = [["run", data.run], ["bundle trained by build", bundle.build],
                 ["report written by build", data.build],
                 ["recipe sha256", bundle.recipeSha256 || bundle.recipe_sha256],
                 ["library sha256", bundle.librarySha256 || bundle.library_sha256],
                 ["snapshot sha256", bundle.snapshotSha256 || bundle.snapshot_sha256]]
      .filter(([, value]) => value);
  return section("How to reproduce it",
      "One seed gives the same weights, bit for bit, within one build and one class of CPU, " +
      "however many actors work.",
      h("div", {class: "panel"}, data.reproduce.map(command)),
      h("details", {class: "panel", style: "margin-top:14px"}, h("summary", {}, "Configuration"),
        h("pre", {}, data.config || "absent")),
      h("details", {class: "panel", style: "margin-top:14px"},
        h("summary", {}, "Identity of everything"), h("dl", {}, facts.map(([name, value]) =>
            [h("dt", {}, name), h("dd", {}, value)]))));
}

function credits() {
  if (!data.credits.length) return null;
  return section("Data and licences", null, h("div", {class: "panel scroll"}, h("table", {},
      h("thead", {}, h("tr", {}, ["clip", "origin", "licence"].map((name) =>
          h("th", {class: "text"}, name)))),
      h("tbody", {}, data.credits.map((one) => h("tr", {}, [one.name, one.origin, one.licence].map(
          (text) => h("td", {class: "text", style: "white-space:normal"}, text || "not stated"))))))));
}

document.title = `${data.title} · Sinew report`;
put(document.getElementById("page"), {}, [hero(), filmSection(), curves(), curriculum(), bodies(), clipTable(),
    coreSeconds(), lag(), reproduce(), credits(),
    h("footer", {}, "Written by `sinew report`. This file is complete: it loads nothing.")]);
