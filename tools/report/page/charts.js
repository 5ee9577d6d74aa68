// Charts as SVG, in plain JavaScript. Text enters the page as text nodes only.

function put(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (name === "style") node.style.cssText = value;
    else node.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat(4)) {
    if (child === null || child === undefined || child === false) continue;
    node.append(child.nodeType ? child : document.createTextNode(String(child)));
  }
  return node;
}
const h = (tag, attributes, ...children) =>
    put(document.createElement(tag), attributes, children);
const s = (tag, attributes, ...children) =>
    put(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);

const isNumber = (v) => typeof v === "number" && Number.isFinite(v);

// 0.0123 -> "0.0123", 1234567 -> "1.23 M", 42.123 -> "42.1"
function short(value) {
  if (!isNumber(value)) return "–";
  const size = Math.abs(value);
  if (size >= 1e9) return Number((value / 1e9).toPrecision(3)) + " G";
  if (size >= 1e6) return Number((value / 1e6).toPrecision(3)) + " M";
  if (size >= 1e4) return Number((value / 1e3).toPrecision(3)) + " k";
  if (size >= 100) return String(Math.round(value));
  if (size === 0) return "0";
  if (size < 1e-4) return value.toExponential(1);
  return String(Number(value.toPrecision(3)));
}
const percent = (v, digits = 0) => isNumber(v) ? (100 * v).toFixed(digits) + " %" : "–";

// Round numbers that span [low, high], about `count` of them.
function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((m) => m >= raw * 0.999);
  const result = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; ++i) {
    result.push(Number((i * step).toPrecision(12)));
  }
  return result;
}

// Index of the sorted array's value nearest to `at`.
function nearest(sorted, at) {
  let low = 0, high = sorted.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < at) low = middle; else high = middle;
  }
  return at - sorted[low] <= sorted[high] - at ? low : high;
}

// What all charts of a group share: the x axis in use and where the pointer is.
class ChartGroup {
  constructor(axes) {
    this.axes = axes;  // [{key, name, scale, show}]
    this.axis = axes[0];
    this.charts = [];
  }
  use(axis) {
    this.axis = axis;
    for (const chart of this.charts) chart.draw();
  }
  point(x) {
    for (const chart of this.charts) chart.point(x);
  }
}

// One chart of lines over the group's x axis.
//   series: [{name, columns, key, colour, thin}]
//   format: value -> text; low, high: fixed ends of the y axis
//   rules:  [{value, name}] dashed lines across
class LineChart {
  constructor(group, {title, series, format = short, low, high, rules = [], wide}) {
    Object.assign(this, {group, format, low, high, rules});
    this.series = series.filter((one) => one.columns && one.columns[one.key]);
    this.empty = this.series.length === 0;
    if (this.empty) return;
    this.width = wide ? 540 : 350;
    this.height = wide ? 230 : 176;
    this.values = this.series.map(() => h("b"));
    this.svg = s("svg", {viewBox: `0 0 ${this.width} ${this.height}`, role: "img",
                         "aria-label": title});
    this.svg.addEventListener("pointermove", (event) => this.hover(event));
    this.svg.addEventListener("pointerdown", (event) => this.hover(event));
    this.svg.addEventListener("pointerleave", () => group.point(null));
    this.element = h("div", {class: "panel chart" + (wide ? " wide" : "")},
        h("h3", {}, title),
        h("div", {class: "legend"}, this.series.map((one, i) => h("span", {},
            h("i", {style: `background:${one.colour}`}), one.name, this.values[i])),
            rules.map((rule) => h("span", {},
                h("i", {style: "background:var(--faint)"}), rule.name,
                h("b", {}, format(rule.value))))),
        this.svg);
    group.charts.push(this);
    this.draw();
  }

  xs(one) {
    const {key, scale} = this.group.axis;
    return (one.columns[key] || []).map((v) => isNumber(v) ? v / scale : NaN);
  }

  extent() {
    let low = Infinity, high = -Infinity;
    for (const one of this.series) {
      const seen = one.columns[one.key].filter(isNumber).sort((a, b) => a - b);
      if (!seen.length) continue;
      // The first steps of training may be far off: they need not set the scale.
      const cut = seen.length > 40 ? Math.floor(seen.length * 0.01) : 0;
      low = Math.min(low, seen[cut]);
      high = Math.max(high, seen[seen.length - 1 - cut]);
    }
    for (const rule of this.rules) {
      low = Math.min(low, rule.value);
      high = Math.max(high, rule.value);
    }
    if (low > 0 && low < 0.6 * high) low = 0;
    if (this.low !== undefined) low = this.low;
    if (this.high !== undefined) high = this.high;
    if (!(high > low)) high = low + (Math.abs(low) || 1);
    return [low, this.high !== undefined ? high : high + 0.05 * (high - low)];
  }

  draw() {
    const box = {left: 44, right: this.width - 8, top: 8, bottom: this.height - 24};
    const [low, high] = this.extent();
    const last = Math.max(...this.series.map((one) =>
        Math.max(0, ...this.xs(one).filter(isNumber))), 1e-9);
    this.x = (v) => box.left + (box.right - box.left) * v / last;
    this.y = (v) => box.bottom - (box.bottom - box.top) *
        (Math.min(Math.max(v, low), high) - low) / (high - low);
    this.box = box;
    this.last = last;
    this.cross = s("line", {class: "cross", y1: box.top, y2: box.bottom, visibility: "hidden"});
    this.dots = this.series.map((one) => s("circle", {r: 3.2, fill: one.colour,
        stroke: "var(--panel)", "stroke-width": 1.5, visibility: "hidden"}));
    this.svg.replaceChildren(
        ...ticks(low, high, 4).flatMap((v) => [
          s("line", {class: "gridline", x1: box.left, x2: box.right, y1: this.y(v), y2: this.y(v)}),
          s("text", {x: box.left - 6, y: this.y(v) + 3.5, "text-anchor": "end"}, this.format(v))]),
        ...ticks(0, last, this.width > 400 ? 7 : 4).map((v) =>
          s("text", {x: this.x(v), y: box.bottom + 15, "text-anchor": "middle"},
            this.group.axis.show(v))),
        s("line", {class: "baseline", x1: box.left, x2: box.right, y1: box.bottom, y2: box.bottom}),
        ...this.rules.map((rule) => s("line", {x1: box.left, x2: box.right, y1: this.y(rule.value),
            y2: this.y(rule.value), stroke: "var(--faint)", "stroke-dasharray": "5 4"})),
        ...this.series.slice().reverse().map((one) => this.line(one)),
        this.cross, ...this.dots);
    this.point(null);
  }

  line(one) {
    const xs = this.xs(one), ys = one.columns[one.key];
    let path = "", pen = "M";
    const dots = [];
    ys.forEach((value, i) => {
      if (!isNumber(value) || !isNumber(xs[i])) { pen = "M"; return; }
      path += `${pen}${this.x(xs[i]).toFixed(1)} ${this.y(value).toFixed(1)}`;
      pen = "L";
      if (ys.length <= 40) {
        dots.push(s("circle", {cx: this.x(xs[i]), cy: this.y(value), r: 2, fill: one.colour}));
      }
    });
    return s("g", {}, s("path", {d: path, fill: "none", stroke: one.colour,
        "stroke-width": one.thin ? 1.1 : 1.9, "stroke-linejoin": "round",
        opacity: one.thin ? 0.75 : 1}), one.thin ? [] : dots);
  }

  hover(event) {
    const frame = this.svg.getBoundingClientRect();
    const x = (event.clientX - frame.left) / frame.width * this.width;
    const share = (x - this.box.left) / (this.box.right - this.box.left);
    this.group.point(Math.min(Math.max(share, 0), 1) * this.last);
  }

  // Shows the values at x (in units of the axis), or the last ones.
  point(x) {
    this.cross.setAttribute("visibility", x === null ? "hidden" : "visible");
    if (x !== null) {
      this.cross.setAttribute("x1", this.x(Math.min(x, this.last)));
      this.cross.setAttribute("x2", this.x(Math.min(x, this.last)));
    }
    this.series.forEach((one, i) => {
      const xs = this.xs(one), ys = one.columns[one.key];
      let at = x === null ? ys.length - 1 : nearest(xs, x);
      while (x === null && at > 0 && !isNumber(ys[at])) --at;
      this.values[i].textContent = this.format(ys[at]);
      const seen = x !== null && isNumber(ys[at]);
      this.dots[i].setAttribute("visibility", seen ? "visible" : "hidden");
      if (seen) {
        this.dots[i].setAttribute("cx", this.x(xs[at]));
        this.dots[i].setAttribute("cy", this.y(ys[at]));
      }
    });
  }
}

// Sequential colours, dark to light, that eyes of all kinds tell apart.
const HEAT = [[24, 15, 61], [68, 15, 118], [114, 31, 129], [158, 47, 127], [205, 64, 113],
              [241, 96, 93], [253, 149, 103], [254, 201, 141], [252, 253, 191]];
function heat(share) {
  const at = Math.min(Math.max(share, 0), 1) * (HEAT.length - 1);
  const i = Math.min(Math.floor(at), HEAT.length - 2);
  const mix = HEAT[i].map((v, c) => Math.round(v + (HEAT[i + 1][c] - v) * (at - i)));
  return `rgb(${mix.join(",")})`;
}
const heatRamp = () =>
    `linear-gradient(90deg,${HEAT.map((c) => `rgb(${c.join(",")})`).join(",")})`;

// rows x columns of mm as coloured cells; says what is under the pointer.
function heatMap({names, rows, seconds, means}) {
  const left = 118, top = 4, cell = 19, right = 132, width = 940;
  const columns = rows[0].length, height = top + cell * rows.length + 26;
  const high = Math.max(1, ...rows.flat().filter(isNumber));
  const step = (width - left - right) / columns;
  const readout = h("div", {class: "readout"}, "Point at a cell for its error.");
  const longest = Math.max(1, ...means);
  const svg = s("svg", {class: "heat", viewBox: `0 0 ${width} ${height}`, role: "img",
                        "aria-label": "tracking error per body over the clip"});
  rows.forEach((row, b) => {
    const y = top + b * cell;
    svg.append(s("text", {x: left - 8, y: y + 13.5, "text-anchor": "end"}, names[b]));
    row.forEach((value, i) => svg.append(s("rect", {x: left + i * step, y, width: step + 0.4,
        height: cell - 1.5, fill: isNumber(value) ? heat(value / high) : "var(--grid)"})));
    svg.append(s("rect", {x: width - right + 12, y: y + 4, height: cell - 9.5, rx: 2,
                          width: 78 * means[b] / longest, fill: "var(--accent)"}),
               s("text", {x: width - right + 17 + 78 * means[b] / longest, y: y + 13},
                 Math.round(means[b])));
  });
  for (const t of ticks(0, seconds, 6)) {
    const x = left + (width - left - right) * t / seconds;
    svg.append(s("text", {x, y: height - 9, "text-anchor": "middle"}, `${short(t)} s`));
  }
  svg.append(s("text", {x: width - right + 12, y: height - 9}, "mean, mm"));
  svg.addEventListener("pointermove", (event) => {
    const frame = svg.getBoundingClientRect();
    const i = Math.floor(((event.clientX - frame.left) / frame.width * width - left) / step);
    const b = Math.floor(((event.clientY - frame.top) / frame.height * height - top) / cell);
    if (!rows[b] || i < 0 || i >= columns) return;
    readout.textContent = `${names[b]} at ${short((i + 0.5) / columns * seconds)} s: ` +
        (isNumber(rows[b][i]) ? `${short(rows[b][i])} mm` : "never reached");
  });
  return h("div", {}, h("div", {class: "scroll"}, svg),
      h("div", {class: "bar", style: "margin:8px 0 0"}, readout,
        h("div", {class: "readout"}, "0 mm", h("span", {class: "ramp",
            style: `background:${heatRamp()}`}), `${short(high)} mm`)));
}
