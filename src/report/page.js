"use strict";
// Text from the report reaches the page as text nodes and attributes only, never as markup.

const report = JSON.parse(document.getElementById("report").textContent);
const pictures = JSON.parse(document.getElementById("pictures").textContent);

/* ---------------------------------------------------------------- elements */

function put(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat(Infinity)) {
    if (child !== null && child !== undefined && child !== false) element.append(child);
  }
  return element;
}
const html = (name, attributes, ...children) => put(document.createElement(name), attributes, children);
const svgNamespace = document.getElementById("svg").namespaceURI;
const svg = (name, attributes, ...children) => put(document.createElementNS(svgNamespace, name), attributes, children);
const byId = (id) => document.getElementById(id);

/* ---------------------------------------------------------------- figures as text */

/** Three digits; exponents only beyond what is easily read. */
function figure(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1e7 || size < 9.995e-5) return value.toExponential(2).replace("e+", "e");
  return size >= 999.5 ? String(Math.round(value)) : value.toPrecision(3);
}
const milliseconds = (value) => `${figure(value)} ms`;
const megabytes = (value) => (Number.isFinite(value) ? `${figure(value / 1e6)} MB` : "–");
const whole = (value) => (Number.isFinite(value) ? String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f") : "–");
const plural = (count, one, many) => `${count} ${count === 1 ? one : many || one + "s"}`;
const shortened = (text, most) => (text.length > most ? text.slice(0, most - 1) + "…" : text);
const listed = (...parts) => parts.filter((part) => part !== undefined && part !== null && part !== false && part !== "").join(" · ");

/* ---------------------------------------------------------------- the report's data */

/** Errors that grow with the difference; those where more is better are turned round. */
const kMetrics = {
  relmse: { title: "relMSE" },
  rmse: { title: "RMSE" },
  mae: { title: "mean |error|" },
  bias: { title: "|bias|" },
  relative_bias: { title: "|relative bias|" },
  p99: { title: "p99 of |error|" },
  hdr_flip: { title: "HDR-FLIP" },
  flip: { title: "FLIP" },
  ssim: { title: "1 − SSIM", error: (value) => 1 - value },
  // The mean squared error of displayed values, on an axis that reads in dB; equal pictures have no finite PSNR.
  psnr: {
    title: "PSNR, dB", error: (value) => (value === null ? 0 : 10 ** (-value / 10)),
    show: (error) => (error > 0 ? figure(-10 * Math.log10(error)) : "∞"),
  },
  grade: { title: "10 − grade", error: (value) => 10 - value },
};
const metricOf = (name) => ({ title: name, error: Math.abs, show: figure, ...kMetrics[name] });

const configurations = (report.configurations || []).map((c) => ({ ...c, id: String(c.id) }));
const views = (report.views || []).map((v) => ({ ...v, id: String(v.id) }));
const configurationAt = new Map(configurations.map((c, index) => [c.id, index]));
const viewAt = new Map(views.map((v, index) => [v.id, index]));
const rows = (report.rows || []).map((row) => {
  const configuration = String(row.configuration), view = String(row.view);
  if (!configurationAt.has(configuration)) configurationAt.set(configuration, configurations.push({ id: configuration }) - 1);
  if (!viewAt.has(view)) viewAt.set(view, views.push({ id: view }) - 1);
  return { ...row, status: row.status || "missing", c: configurationAt.get(configuration), v: viewAt.get(view) };
});
const rowsOfView = views.map((_, v) => rows.filter((row) => row.v === v));

/** What a configuration changes, as "key = value". */
const changes = (c) => Object.entries(configurations[c].set || {}).map(
  ([key, value]) => `${key} = ${typeof value === "string" ? value : JSON.stringify(value)}`);
const presetOf = (c) => configurations[c].preset || "";

function inOrderOfAppearance(lists) {
  const seen = new Set();
  for (const list of lists) for (const name of list) seen.add(name);
  return [...seen];
}
const passNames = inOrderOfAppearance(rows.map((row) => (row.passes || []).map((pass) => pass.name)));
const channelNames = inOrderOfAppearance(rows.map((row) => Object.keys(row.errors || {})))
  .sort((a, b) => (b === "beauty") - (a === "beauty"));
const metricsFound = inOrderOfAppearance(rows.flatMap((row) => Object.values(row.errors || {}).map((e) => Object.keys(e || {}))));
const metricNames = [...Object.keys(kMetrics).filter((name) => metricsFound.includes(name)),
                     ...metricsFound.filter((name) => !(name in kMetrics))];
const hasFrame = (frame) => rows.some((row) => row.ms && row.ms[frame]);

/** What others are compared with at first: `balanced`, or what changes least of it. */
function usualConfiguration() {
  const changed = configurations.map((c) => (
    c.id === "balanced" ? -1 : c.preset === "balanced" ? Object.keys(c.set || {}).length : Infinity));
  return configurations.length === 0 ? -1 : changed.indexOf(Math.min(...changed));
}

/** Everything that the reader chooses. `c` and `base` are indices of configurations, −1 where there are none. */
const state = {
  frame: hasFrame("steady") || !hasFrame("first") ? "steady" : "first",
  pass: "",
  channel: channelNames[0] || "beauty",
  metric: metricNames[0] || "relmse",
  base: usualConfiguration(),
  picked: -1,
  find: "",
  view: "",
  status: "",
  sort: { column: "", falling: false },
  allPasses: new Set(),
};
state.picked = state.base;

/** {median, p10, p90} of what the time axis shows, or null. */
function timeOf(row, frame = state.frame, pass = state.pass) {
  if (row.status !== "ok") return null;
  const of = pass === "" ? row.ms : (row.passes || []).find((p) => p.name === pass);
  const time = of && of[frame];
  return time && Number.isFinite(time.median) ? time : null;
}
/** The error of a row, 0 or more, or null where the report has none. */
function errorOf(row, channel = state.channel, metric = state.metric) {
  const errors = row.status === "ok" && row.errors && row.errors[channel];
  if (!errors || !(metric in errors) || (errors[metric] === null && metric !== "psnr")) return null;
  const error = metricOf(metric).error(errors[metric]);
  return Number.isFinite(error) ? Math.max(error, 0) : null;
}
const showError = (error) => (error === null ? "–" : metricOf(state.metric).show(error));
const frameTitle = () => (state.frame === "first" ? "first frame" : "steady frame");
const timeTitle = () => (state.pass === "" ? frameTitle() : `${state.pass}, ${frameTitle()}`);
const errorTitle = () => `${metricOf(state.metric).title} of ${state.channel}`;

/** Of points with x and y: those that no other beats in one and equals or beats in the other, by rising x. */
function paretoFront(points) {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  const front = [];
  for (const point of sorted) {
    const last = front[front.length - 1];
    if (!last || point.y < last.y || (point.y === last.y && point.x === last.x)) front.push(point);
  }
  return front;
}

/** What the plot of a view shows; points carry their row. */
function pointsOfView(v) {
  const points = [];
  for (const row of rowsOfView[v]) {
    const time = timeOf(row), y = errorOf(row);
    if (time && y !== null) points.push({ c: row.c, row, x: time.median, low: time.p10, high: time.p90, y });
  }
  return points;
}
const frontOfView = (v) => new Set(paretoFront(pointsOfView(v)).map((point) => point.c));

const needle = () => state.find.trim().toLowerCase().split(/\s+/).filter((word) => word !== "");
const textOfConfiguration = (c) => [configurations[c].id, presetOf(c), ...changes(c)].join("\n").toLowerCase();
const isFound = (text) => needle().every((word) => text.includes(word));

/* ---------------------------------------------------------------- a box that tells about a point */

class Tip {
  constructor(host) {
    this.host = host;
    this.box = html("div", { class: "tip", "aria-hidden": "true" });
    host.append(this.box);
  }
  /** Beside (x, y) in the host's pixels, inside of its width. */
  show(content, x, y) {
    this.box.replaceChildren(...content);
    const width = this.box.offsetWidth, height = this.box.offsetHeight;
    const room = this.host.clientWidth, gap = 16;
    let left = x + gap, top = y - height / 2;
    if (left + width > room) left = x - gap - width;
    if (left < 0) {
      left = Math.min(Math.max(0, x - width / 2), room - width);
      top = y - height - gap < 0 ? y + gap : y - height - gap;
    }
    this.box.style.left = `${Math.max(0, left)}px`;
    this.box.style.top = `${Math.max(0, top)}px`;
    this.box.classList.add("shown");
  }
  hide() { this.box.classList.remove("shown"); }
}

const pairs = (...entries) => html("dl", { class: "pairs" },
  entries.filter(([, value]) => value !== "" && value !== "–").map(([name, value]) => [html("dt", {}, name), html("dd", {}, value)]));
const spread = (time) => (Number.isFinite(time.p10) && Number.isFinite(time.p90) ? ` (${figure(time.p10)} to ${figure(time.p90)})` : "");
function settingsOf(c) {
  const preset = presetOf(c), set = changes(c);
  return html("div", { class: "settings" },
    preset !== "" && html("span", { class: "small soft" }, `preset ${preset}${set.length > 0 ? ", and" : ""}`),
    set.map((change) => html("code", {}, change)));
}

/* ---------------------------------------------------------------- scatter plots */

const measure = document.createElement("canvas").getContext("2d");
function textWidth(text) {
  measure.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  return measure.measureText(text).width;
}

/** A logarithmic axis from pixel `from` to `to`. Zeros have a lane of their own before its start. */
function logAxis(values, from, to) {
  const positive = values.filter((value) => value > 0);
  const hasZero = positive.length < values.length;
  const lane = hasZero ? Math.sign(to - from) * 30 : 0;
  let low = Math.log10(positive.length ? Math.min(...positive) : 1), high = Math.log10(positive.length ? Math.max(...positive) : 1);
  const pad = Math.max(0.06 * (high - low), (0.3 - (high - low)) / 2);
  low -= pad, high += pad;
  const begin = from + lane;
  const map = (value) => (value > 0 ? begin + ((Math.log10(value) - low) / (high - low)) * (to - begin) : from + lane / 3);
  const ticks = [];
  const least = 10 ** low, most = 10 ** high;
  const decades = high - low;
  const multiples = decades > 3.2 ? [1] : decades > 1.3 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 8];
  for (let power = Math.floor(low); power <= high; power += Math.max(1, Math.ceil(decades / 9))) {
    for (const multiple of multiples) {
      const value = Number(`${multiple}e${power}`);
      if (value >= least && value <= most) ticks.push(value);
    }
  }
  if (ticks.length < 3) {
    const raw = (most - least) / 4, power = 10 ** Math.floor(Math.log10(raw));
    const step = [5, 2, 1].map((multiple) => multiple * power).find((candidate) => candidate <= raw);
    ticks.length = 0;
    for (let k = Math.ceil(least / step); k * step <= most; ++k) ticks.push(Number((k * step).toPrecision(6)));
  }
  return { map, ticks, hasZero, border: begin };
}
const tickText = (value) => (value !== 0 && (value >= 1e5 || value < 1e-3) ? value.toExponential().replace("e+", "e") : String(value));

/** A plot that fills `host` and follows its width. `make()` gives what it shows at the moment. */
class Scatter {
  constructor(host, make) {
    this.host = host, this.make = make;
    this.drawing = svg("svg", { role: "group" });
    host.append(this.drawing);
    this.tip = new Tip(host);
    this.width = 0;
    this.drawing.addEventListener("pointermove", (event) => { if (event.pointerType !== "touch") this.over(this.nearest(event)); });
    this.drawing.addEventListener("pointerleave", () => this.over(null));
    this.drawing.addEventListener("click", (event) => {
      const point = this.nearest(event);
      if (point) pick(point.c);
      this.over(point);
    });
    this.drawing.addEventListener("keydown", (event) => this.key(event));
    this.drawing.addEventListener("focusout", () => this.over(null));
    new ResizeObserver(() => { if (host.clientWidth !== this.width) this.draw(); }).observe(host);
  }

  draw() {
    this.width = this.host.clientWidth;
    if (this.width === 0) return;
    this.tip.hide();
    const spec = this.make(), points = spec.points;
    this.points = points;
    this.drawing.replaceChildren();
    let empty = this.host.querySelector(".empty");
    if (empty) empty.remove();
    this.drawing.style.display = points.length === 0 ? "none" : "";
    if (points.length === 0) {
      this.host.append(html("p", { class: "empty" }, spec.empty));
      return;
    }
    const width = this.width, height = Math.round(Math.min(470, Math.max(300, 0.64 * width)));
    const area = { left: 54, right: width - 12, top: 28, bottom: height - 46 };
    const extra = spec.unity ? [1] : [];
    const inLimits = (value) => Number.isFinite(value) && value > 0;
    const x = logAxis([...points.flatMap((p) => [p.x, ...[p.low, p.high].filter(inLimits)]), ...extra], area.left, area.right);
    const y = logAxis([...points.map((p) => p.y), ...extra], area.bottom, area.top);
    this.area = area;
    const front = paretoFront(points.filter((p) => !p.part));
    const best = new Set(front);
    for (const point of points) point.px = x.map(point.x), point.py = y.map(point.y);
    this.front = front;

    put(this.drawing, { viewBox: `0 0 ${width} ${height}`, height,
      "aria-label": `${spec.label}. ${plural(points.length, "configuration")}, ${front.length} on the Pareto front. ` +
        "Arrow keys go from one to the next, Enter picks it." }, []);
    const lines = svg("g", { "aria-hidden": "true" });
    let lastRight = -Infinity;
    for (const value of x.ticks) {
      const at = x.map(value), text = spec.xShow(value), half = textWidth(text) / 2;
      lines.append(svg("line", { class: "grid", x1: at, x2: at, y1: area.top, y2: area.bottom }));
      if (at - half < lastRight + 6 || at + half > width) continue;
      lines.append(svg("text", { x: at, y: area.bottom + 16, "text-anchor": "middle" }, text));
      lastRight = at + half;
    }
    let lastTop = Infinity;
    for (const value of y.ticks) {
      const at = y.map(value);
      lines.append(svg("line", { class: "grid", x1: area.left, x2: area.right, y1: at, y2: at }));
      if (lastTop - at < 14) continue;
      lines.append(svg("text", { x: area.left - 7, y: at + 4, "text-anchor": "end" }, spec.yShow(value)));
      lastTop = at;
    }
    if (y.hasZero) {
      lines.append(svg("line", { class: "zero", x1: area.left, x2: area.right, y1: y.border, y2: y.border }));
      lines.append(svg("text", { x: area.left - 7, y: y.map(0) + 4, "text-anchor": "end" }, spec.yShow(0)));
    }
    if (x.hasZero) {
      lines.append(svg("line", { class: "zero", x1: x.border, x2: x.border, y1: area.top, y2: area.bottom }));
      lines.append(svg("text", { x: x.map(0), y: area.bottom + 16, "text-anchor": "middle" }, "0"));
    }
    if (spec.unity) {
      lines.append(svg("line", { class: "unity", x1: x.map(1), x2: x.map(1), y1: area.top, y2: area.bottom }));
      lines.append(svg("line", { class: "unity", x1: area.left, x2: area.right, y1: y.map(1), y2: y.map(1) }));
    }
    const floor = spec.floor > 0 ? y.map(spec.floor) : Infinity;
    if (floor > area.top && floor < area.bottom) {
      lines.append(svg("line", { class: "floor", x1: area.left, x2: area.right, y1: floor, y2: floor }));
      lines.append(svg("text", { x: area.right - 4, y: floor + 14, "text-anchor": "end" }, "noise of the reference"));
    }
    lines.append(svg("path", { class: "axis", fill: "none", d: `M${area.left} ${area.top}V${area.bottom}H${area.right}` }));
    lines.append(svg("text", { class: "title", x: 2, y: 14 }, `↑ ${shortened(spec.yTitle, Math.floor(width / 7) - 4)}`));
    lines.append(svg("text", { class: "title", x: area.right, y: height - 8, "text-anchor": "end" }, `${spec.xTitle} →`));
    this.drawing.append(lines);

    if (front.length > 0) {
      let steps = `M${front[0].px} ${area.top}`;
      for (const point of front) steps += `H${point.px}V${point.py}`;
      steps += `H${area.right}`;
      this.drawing.append(svg("path", { class: "reach", "aria-hidden": "true", d: `${steps}V${area.top}Z` }));
      this.drawing.append(svg("path", { class: "front", "aria-hidden": "true", d: steps }));
    }
    this.order = [...points].sort((a, b) => a.px - b.px || b.py - a.py);
    const clampX = (value) => Math.min(area.right, Math.max(area.left, value));
    for (const point of [...this.order.filter((p) => !best.has(p)), ...front]) {
      const isBest = best.has(point);
      const { px, py } = point;
      const whisker = inLimits(point.high) && Number.isFinite(point.low)
        ? `M${clampX(x.map(point.low))} ${py}H${clampX(x.map(point.high))}M${clampX(x.map(point.low))} ${py - 3}v6M${clampX(x.map(point.high))} ${py - 3}v6` : null;
      point.mark = svg("g", {
        class: `point${isBest ? " best" : ""}${point.part ? " part" : ""}`, "data-c": point.c, role: "button", tabindex: -1,
        "aria-label": `${configurations[point.c].id}: ${point.text}${isBest ? "; on the Pareto front" : ""}`,
      },
        whisker && svg("path", { class: "whisker", d: whisker }),
        svg("circle", { class: "ring", cx: px, cy: py, r: 9.5 }),
        isBest ? svg("path", { class: "mark", d: `M${px} ${py - 6.5}l6.5 6.5l-6.5 6.5l-6.5 -6.5z` })
               : svg("circle", { class: "mark", cx: px, cy: py, r: 4.2 }));
      point.mark.addEventListener("focus", () => this.over(point));
      this.drawing.append(point.mark);
    }
    this.order[0].mark.setAttribute("tabindex", 0);
    this.names = svg("g", { "aria-hidden": "true" });
    this.drawing.append(this.names);
    this.mark();
  }

  /** Rings, names and fading by what is picked and found. */
  mark() {
    if (!this.points || this.points.length === 0) return;
    for (const point of this.points) {
      point.faded = !isFound(textOfConfiguration(point.c));
      point.mark.classList.toggle("picked", point.c === state.picked);
      point.mark.classList.toggle("faded", point.faded);
      point.mark.setAttribute("aria-pressed", point.c === state.picked);
    }
    this.names.replaceChildren();
    const taken = this.points.filter((p) => !p.faded).map((p) => ({ l: p.px - 7, r: p.px + 7, t: p.py - 7, b: p.py + 7 }));
    const most = this.width < 480 ? 18 : 26;
    const chosen = this.points.filter((p) => p.c === state.picked);
    for (const point of [...chosen, ...this.front.filter((p) => p.c !== state.picked)]) {
      if (point.faded) continue;
      const text = shortened(configurations[point.c].id, most), width = textWidth(text), { px, py } = point;
      const places = [[px + 9, py - 6], [px - 9 - width, py + 14], [px - 9 - width, py - 6], [px + 9, py + 14], [px - width / 2, py - 12], [px - width / 2, py + 20]];
      for (const [left, base] of places) {
        const box = { l: left - 2, r: left + width + 2, t: base - 11, b: base + 3 };
        if (box.l < this.area.left || box.r > this.area.right + 8 || box.t < this.area.top - 6 || box.b > this.area.bottom) continue;
        if (taken.some((t) => box.l < t.r && t.l < box.r && box.t < t.b && t.t < box.b)) continue;
        taken.push(box);
        this.names.append(svg("text", { class: point.c === state.picked ? "name chosen" : "name", x: left, y: base }, text));
        break;
      }
    }
  }

  /** The point within a finger's width of an event, or null. */
  nearest(event) {
    if (!this.points) return null;
    const frame = this.drawing.getBoundingClientRect();
    const x = event.clientX - frame.left, y = event.clientY - frame.top;
    let found = null, least = 24;
    for (const point of this.points) {
      const distance = Math.hypot(point.px - x, point.py - y);
      if (distance < least && !point.faded) found = point, least = distance;
    }
    return found;
  }
  over(point) {
    for (const near of this.drawing.querySelectorAll(".near")) near.classList.remove("near");
    if (!point) return this.tip.hide();
    point.mark.classList.add("near");
    this.tip.show(point.tip(), point.px, point.py);
  }
  key(event) {
    const at = this.order ? this.order.findIndex((p) => p.mark === event.target) : -1;
    if (at < 0) return;
    if (event.key === "Escape") return this.over(null);
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      return pick(this.order[at].c);
    }
    const last = this.order.length - 1;
    const to = { ArrowRight: at + 1, ArrowUp: at + 1, ArrowLeft: at - 1, ArrowDown: at - 1, Home: 0, End: last }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const next = this.order[Math.min(last, Math.max(0, to))];
    this.order[at].mark.setAttribute("tabindex", -1);
    next.mark.setAttribute("tabindex", 0);
    next.mark.focus();
  }
}

const keyOfPlot = () => html("div", { class: "key" },
  html("span", {}, svg("svg", { class: "plot-key", viewBox: "0 0 18 12", "aria-hidden": "true" },
    svg("path", { d: "M9 0l6 6l-6 6l-6 -6z", fill: "var(--accent)" })), "on the Pareto front"),
  html("span", {}, svg("svg", { viewBox: "0 0 18 12", "aria-hidden": "true" },
    svg("path", { d: "M0 6h18M.5 3v6M17.5 3v6", stroke: "var(--point)", fill: "none" }),
    svg("circle", { cx: 9, cy: 6, r: 4.2, fill: "var(--card)", stroke: "var(--point)", "stroke-width": 1.6 })),
    "dominated; whiskers p10 to p90"),
  html("span", {}, svg("svg", { viewBox: "0 0 18 12", "aria-hidden": "true" },
    svg("circle", { cx: 9, cy: 6, r: 5, fill: "none", stroke: "var(--picked)", "stroke-width": 2.25 })), "picked"));

/* ---------------------------------------------------------------- plots of this report */

function tipOfRow(row) {
  const time = timeOf(row), error = errorOf(row);
  return [html("strong", {}, configurations[row.c].id),
    pairs([timeTitle(), time ? milliseconds(time.median) + spread(time) : "–"],
          [errorTitle(), showError(error)],
          ["samples a pixel", figure(row.samples_per_pixel)],
          ["memory", megabytes(row.memory_bytes)]),
    settingsOf(row.c)];
}

/** Why a view has no point to show. */
function emptyReason(list) {
  if (list.length === 0) return "No rows yet.";
  const ok = list.filter((row) => row.status === "ok").length;
  if (ok === 0) {
    return list.every((row) => row.status === "failed") ? `All ${plural(list.length, "row")} failed; the table says why.`
                                                        : "Nothing has been measured yet.";
  }
  return `No row has both a time of “${timeTitle()}” and ${errorTitle()}.`;
}

/** The relMSE that a picture without error would have, for the noise of the reference; undefined where it is not known. */
const noiseOf = (v) => ((views[v].reference || {}).noise_relmse || {})[state.channel];

function viewPlot(v) {
  const points = pointsOfView(v);
  for (const point of points) {
    point.text = `${milliseconds(point.x)}, ${errorTitle()} ${showError(point.y)}`;
    point.tip = () => tipOfRow(point.row);
  }
  return { points, xTitle: `ms, ${timeTitle()}`, yTitle: errorTitle(), xShow: tickText,
           yShow: state.metric === "psnr" ? showError : tickText, floor: state.metric === "relmse" ? noiseOf(v) : undefined,
           label: `${views[v].id}: milliseconds of ${timeTitle()} against ${errorTitle()}`, empty: emptyReason(rowsOfView[v]) };
}

/** Geometric means over views of time and error, over those of the configuration `state.base`. */
function overviewPoints() {
  const bases = rowsOfView.map((list) => list.find((row) => row.c === state.base));
  const usable = views.map((_, v) => v).filter((v) => {
    const time = bases[v] && timeOf(bases[v]), error = bases[v] ? errorOf(bases[v]) : null;
    return time && time.median > 0 && error > 0;
  });
  const points = [];
  configurations.forEach((_, c) => {
    const sums = { x: 0, y: 0, low: 0, high: 0 };
    let count = 0;
    for (const v of usable) {
      const row = rowsOfView[v].find((candidate) => candidate.c === c);
      const time = row && timeOf(row), error = row ? errorOf(row) : null;
      if (!time || error === null) continue;
      const base = timeOf(bases[v]).median;
      sums.x += Math.log(time.median / base), sums.low += Math.log(time.p10 / base), sums.high += Math.log(time.p90 / base);
      sums.y += Math.log(error / errorOf(bases[v]));
      ++count;
    }
    if (count === 0) return;
    const mean = (sum) => Math.exp(sum / count);
    points.push({ c, x: mean(sums.x), y: mean(sums.y), low: mean(sums.low), high: mean(sums.high), count, part: count < usable.length });
  });
  return { points, usable };
}

const times = (value) => `${figure(value)}×`;
function overviewPlot() {
  const { points, usable } = overviewPoints();
  const base = state.base < 0 ? "" : configurations[state.base].id;
  for (const point of points) {
    const over = `${point.count} of ${plural(views.length, "view")}`;
    point.text = `${times(point.x)} the time and ${times(point.y)} the error of ${base}, over ${over}`;
    point.tip = () => [html("strong", {}, configurations[point.c].id),
      pairs(["time", `${times(point.x)}${Number.isFinite(point.low) ? ` (${figure(point.low)} to ${figure(point.high)})` : ""}`],
            ["error", times(point.y)], ["views", over]),
      point.part && html("p", { class: "small" }, "Not in all views: left out of the front."), settingsOf(point.c)];
    point.tip = ((tip) => () => tip().filter((part) => part))(point.tip);
  }
  const note = byId("overview-note");
  const left = views.length - usable.length;
  note.textContent = `Each view counts as a ratio to ${base}; the plot shows the geometric means.` +
    (left > 0 ? ` Without ${plural(left, "view")} where ${base} has no time or no error above zero.` : "") +
    (points.some((point) => point.part) ? " Dashed: configurations that some views lack." : "");
  const error = state.metric === "psnr" ? `squared error of displayed ${state.channel}` : errorTitle();
  return { points, unity: true, xTitle: `time over ${shortened(base, 18)}'s, ${timeTitle()}`, yTitle: `${error} over ${base}'s`,
           xShow: (value) => `${tickText(value)}×`, yShow: (value) => `${tickText(value)}×`,
           label: `All views: time against error, as ratios to ${base}`,
           empty: rows.some((row) => row.status === "ok") ? `Nothing to compare: ${base} has no time and error in any view.` : emptyReason(rows) };
}

/** The front as a table: what the plot shows, in words. */
function frontTable(v) {
  const front = paretoFront(pointsOfView(v));
  if (front.length === 0) return [];
  const body = front.map((point) => html("tr", { "data-c": point.c },
    html("th", { class: "text", scope: "row" }, pickButton(point.c)),
    html("td", {}, figure(point.x)), html("td", {}, showError(point.y)),
    html("td", { class: "text wide" }, settingsOf(point.c))));
  return [html("div", { class: "scroll plain", tabindex: 0, role: "region", "aria-label": `Pareto front of ${views[v].id}` }, html("table", {},
    html("thead", {}, html("tr", {}, html("th", { class: "text plain", scope: "col" }, "Pareto front"),
      html("th", { class: "plain", scope: "col" }, "ms"), html("th", { class: "plain", scope: "col" }, metricOf(state.metric).title),
      html("th", { class: "text plain wide", scope: "col" }, "settings"))),
    html("tbody", {}, body)))];
}
const pickButton = (c) => html("button", { type: "button", onclick: () => pick(c), title: "Pick in all plots" }, configurations[c].id);

/* ---------------------------------------------------------------- passes */

/** Colours go to the passes that take most of any frame; the same in all views and frames. */
const passColour = (() => {
  const share = new Map(passNames.map((name) => [name, 0]));
  for (const row of rows) {
    for (const frame of ["first", "steady"]) {
      const all = (row.passes || []).filter((pass) => pass[frame]);
      const sum = all.reduce((total, pass) => total + pass[frame].median, 0);
      if (sum > 0) for (const pass of all) share.set(pass.name, share.get(pass.name) + pass[frame].median / sum);
    }
  }
  const largest = new Set([...passNames].sort((a, b) => share.get(b) - share.get(a)).slice(0, 7));
  const colours = new Map();
  for (const name of passNames) if (largest.has(name)) colours.set(name, colours.size);
  return colours;
})();

function passBars(v, card) {
  const list = rowsOfView[v].filter((row) => timeOf(row, state.frame, "") && (row.passes || []).some((pass) => pass[state.frame]));
  if (list.length === 0) return [html("p", { class: "empty" }, "No times of passes.")];
  const front = frontOfView(v);
  const total = (row) => timeOf(row, state.frame, "").median;
  const many = list.length > 14;
  const shown = list.filter((row) => !many || state.allPasses.has(v) || front.has(row.c) || row.c === state.picked)
    .sort((a, b) => total(a) - total(b));
  const medians = (row) => row.passes.filter((pass) => pass[state.frame]).map((pass) => ({ name: pass.name, ms: pass[state.frame].median }));
  const sumOf = (row) => medians(row).reduce((sum, pass) => sum + pass.ms, 0);
  const longest = Math.max(...shown.map((row) => Math.max(sumOf(row), total(row))), 1e-9);
  const tip = new Tip(card);

  const bars = shown.map((row) => {
    const parts = medians(row);
    const rest = parts.filter((pass) => !passColour.has(pass.name)).reduce((sum, pass) => sum + pass.ms, 0);
    const segments = [...parts.filter((pass) => passColour.has(pass.name)).map((pass) => ({ ms: pass.ms, colour: passColour.get(pass.name) })),
                      { ms: rest, colour: 7 }].filter((segment) => segment.ms > 0);
    const stack = html("div", { class: "stack", style: `width:${(100 * sumOf(row)) / longest}%` }, segments.map((segment) =>
      html("i", { style: `flex:${segment.ms} 0 0;background:var(--p${segment.colour});color:var(--t${segment.colour})` },
        segment.ms / longest > 0.1 ? figure(segment.ms) : "")));
    const tell = (event) => {
      const frame = card.getBoundingClientRect();
      tip.show([html("strong", {}, configurations[row.c].id),
        pairs(...parts.map((pass) => [pass.name, milliseconds(pass.ms)]), ["frame", milliseconds(total(row))])],
        event.clientX - frame.left, event.clientY - frame.top);
    };
    return html("div", { class: "pass-row", "data-c": row.c, onpointermove: tell, onpointerleave: () => tip.hide(), onclick: () => pick(row.c) },
      html("span", { class: `who${front.has(row.c) ? " best" : ""}`, title: configurations[row.c].id }, configurations[row.c].id),
      html("div", { class: "track" }, stack), html("span", { class: "total" }, milliseconds(total(row))));
  });
  const used = new Set(shown.flatMap((row) => medians(row).map((pass) => pass.name)));
  const swatches = [...passColour].filter(([name]) => used.has(name)).map(([name, colour]) =>
    html("li", {}, html("i", { style: `background:var(--p${colour})` }), name));
  if ([...used].some((name) => !passColour.has(name))) swatches.push(html("li", {}, html("i", { style: "background:var(--p7)" }), "all others"));
  const columns = passNames.filter((name) => used.has(name));
  const table = () => html("div", { class: "scroll" }, html("table", {},
    html("thead", {}, html("tr", {}, html("th", { class: "text plain", scope: "col" }, "ms"),
      html("th", { class: "plain", scope: "col" }, "frame"), columns.map((name) => html("th", { class: "plain", scope: "col" }, name)))),
    html("tbody", {}, shown.map((row) => {
      const of = new Map(medians(row).map((pass) => [pass.name, pass.ms]));
      return html("tr", { "data-c": row.c }, html("th", { class: "text", scope: "row" }, pickButton(row.c)),
        html("td", {}, figure(total(row))), columns.map((name) => html("td", {}, of.has(name) ? figure(of.get(name)) : "–")));
    }))));
  const figures = html("details", { class: "small", ontoggle: (event) => {
    if (event.target.open && event.target.children.length === 1) event.target.append(table()), mark();
  } }, html("summary", {}, "These bars in figures"));
  return [html("ul", { class: "swatches" }, swatches), html("div", { class: "passes", "aria-hidden": "true" }, bars),
    many && html("p", { class: "bar" }, html("button", { type: "button", onclick: () => {
      state.allPasses.has(v) ? state.allPasses.delete(v) : state.allPasses.add(v);
      drawPasses(v);
    } }, state.allPasses.has(v) ? "Only the Pareto front" : `All ${list.length} configurations`)),
    figures, tip.box].filter((part) => part);
}

/* ---------------------------------------------------------------- pictures */

const picture = (images, name) => (images && images[name] ? pictures[images[name]] : undefined);
const referenceImages = (v) => (views[v].reference || {}).images;

/** The chosen channel where the view has pictures of it, else one that it has; "" without any. */
function channelOfPictures(v) {
  const has = (channel) => picture(referenceImages(v), channel) || rowsOfView[v].some((row) => picture(row.images, channel));
  return [state.channel, "beauty", ...channelNames].find(has) || "";
}

let cut = 50;  // % of the width that shows the reference, in all pictures alike
function comparer(reference, result, name, channel) {
  const alt = (what) => `${what}, ${channel}`;
  if (!reference || !result) {
    const only = reference ? "reference" : "result";
    return html("div", { class: "compare" }, html("img", { src: reference || result, alt: alt(only === "result" ? name : only) }),
      html("span", { class: "tag left" }, only));
  }
  const box = html("div", { class: "compare", style: `--cut:${cut}%` },
    html("img", { src: result, alt: alt(name) }), html("img", { class: "over", src: reference, alt: alt("reference") }),
    html("span", { class: "cut" }), html("span", { class: "tag left" }, "reference"), html("span", { class: "tag right" }, "result"),
    html("input", { type: "range", min: 0, max: 100, step: 0.5, value: cut, "aria-label": "Share of the width that shows the reference", oninput: (event) => {
      cut = Number(event.target.value);
      box.style.setProperty("--cut", `${cut}%`);
    } }));
  return box;
}

function stepper(v, done) {
  const list = rowsOfView[v].map((row) => row.c);
  const to = (step) => { pick(list[(list.indexOf(state.picked) + step + list.length) % list.length]); done(); };
  return html("div", { class: "stepper" },
    html("button", { type: "button", "aria-label": "Previous configuration", onclick: () => to(-1) }, "‹"),
    html("select", { "aria-label": "Configuration", onchange: (event) => { pick(Number(event.target.value)); done(); } },
      list.map((c) => html("option", { value: c, selected: c === state.picked }, configurations[c].id))),
    html("button", { type: "button", "aria-label": "Next configuration", onclick: () => to(1) }, "›"));
}

/** What is known of the picked configuration in a view, in words. */
function readout(row) {
  const time = timeOf(row);
  return html("div", { class: "readout" }, row.status !== "ok"
    ? html("p", {}, html("strong", {}, row.status === "failed" ? "Failed: " : "Not measured"), row.reason || "")
    : pairs([timeTitle(), time ? milliseconds(time.median) + spread(time) : "–"], [errorTitle(), showError(errorOf(row))],
            ["samples a pixel", figure(row.samples_per_pixel)], ["memory", megabytes(row.memory_bytes)], ["voxels", whole(row.voxels)]),
    settingsOf(row.c));
}

function picturesOfPicked(v, large) {
  const row = rowsOfView[v].find((candidate) => candidate.c === state.picked);
  const channel = channelOfPictures(v);
  const reference = picture(referenceImages(v), channel), result = row && picture(row.images, channel);
  const heat = row && picture(row.images, `${channel}_heatmap`);
  const name = row ? configurations[row.c].id : "";
  const heatImage = heat && [html("img", { src: heat, alt: `Heat map of the error of ${name}, ${channel}` }), html("span", { class: "tag left" }, "error")];
  return { row, channel, parts: [(reference || result) && comparer(reference, result, name, channel),
    heat && (large ? html("div", { class: "heat" }, heatImage)
                   : html("button", { class: "heat", type: "button", onclick: () => enlarge(v), title: "Enlarge" }, heatImage))].filter((part) => part) };
}

function drawPictures(v) {
  const card = byId(`pictures-${v}`);
  const { row, channel, parts } = picturesOfPicked(v, false);
  card.replaceChildren(
    html("div", { class: "bar" }, stepper(v, () => byId(`pictures-${v}`).querySelector("select").focus()),
      channel !== "" && html("button", { type: "button", onclick: () => enlarge(v) }, "Enlarge")),
    ...(parts.length > 0 ? parts : channel !== "" ? [html("p", { class: "empty" }, "No picture of this configuration.")] : []),
    row ? readout(row) : html("p", { class: "empty" }, "This view has no row of the picked configuration."));
  for (const nothing of [...card.childNodes].filter((node) => node.nodeType === 3)) nothing.remove();
}

function drawStrip(v) {
  const strip = byId(`strip-${v}`), channel = channelOfPictures(v);
  const list = rowsOfView[v].filter((row) => picture(row.images, channel))
    .sort((a, b) => ((timeOf(a) || {}).median ?? Infinity) - ((timeOf(b) || {}).median ?? Infinity));
  strip.parentElement.hidden = list.length === 0;
  strip.replaceChildren(...list.map((row) => html("button", {
    type: "button", class: "thumb", "data-c": row.c, "aria-pressed": row.c === state.picked,
    "aria-label": `${configurations[row.c].id}: pick`, onclick: () => pick(row.c), ondblclick: () => enlarge(v),
  }, html("img", { src: picture(row.images, channel), alt: "", loading: "lazy", decoding: "async" }),
    html("span", { title: configurations[row.c].id }, configurations[row.c].id),
    html("span", { class: "soft" }, listed(timeOf(row) && milliseconds(timeOf(row).median), errorOf(row) !== null && showError(errorOf(row)) || "")))));
}

function enlarge(v) {
  const dialog = byId("large");
  const { row, channel, parts } = picturesOfPicked(v, true);
  dialog.replaceChildren(
    html("div", { class: "bar" }, html("h2", {}, views[v].id, html("span", { class: "soft small" }, ` ${channel}`)),
      html("button", { type: "button", onclick: () => dialog.close() }, "Close")),
    html("div", { class: "bar" }, stepper(v, () => { enlarge(v); dialog.querySelector("select").focus(); })),
    html("div", { class: "both" }, parts), row ? readout(row) : "");
  if (!dialog.open) dialog.showModal();
}
byId("large").addEventListener("click", (event) => { if (event.target === event.currentTarget) event.target.close(); });

/* ---------------------------------------------------------------- table */

const collator = new Intl.Collator("en", { numeric: true });
let fronts = [];  // of each view, for the table
function columns() {
  const time = (title, frame, pass) => ({ id: `${frame} ${pass}`, title, value: (row) => (timeOf(row, frame, pass) || {}).median, show: figure });
  return [
    { id: "configuration", title: "configuration", text: true, value: (row) => configurations[row.c].id },
    { id: "view", title: "view", text: true, value: (row) => views[row.v].id },
    { id: "status", title: "status", text: true, value: (row) => row.status },
    { id: "front", title: "front", value: (row) => (fronts[row.v].has(row.c) ? 0 : 1), show: (value) => (value === 0 ? "◆" : "") },
    time("first, ms", "first", ""), time("steady, ms", "steady", ""),
    ...(state.pass ? [time(`${state.pass}, ${state.frame}, ms`, state.frame, state.pass)] : []),
    ...metricNames.map((name) => ({ id: name, title: metricOf(name).title, value: (row) => errorOf(row, state.channel, name) ?? undefined, show: metricOf(name).show })),
    { id: "memory", title: "MB", value: (row) => row.memory_bytes, show: (value) => figure(value / 1e6) },
    { id: "samples", title: "samples a pixel", value: (row) => row.samples_per_pixel, show: figure },
    { id: "voxels", title: "voxels", value: (row) => row.voxels, show: whole },
    { id: "settings", title: "settings", text: true, value: (row) => [presetOf(row.c), ...changes(row.c)].join(", ") },
  ];
}

/** The rows that the filters leave, in the order of the table. */
function rowsShown() {
  const all = columns(), column = all.find((candidate) => candidate.id === state.sort.column);
  const left = rows.filter((row) => (state.view === "" || row.v === Number(state.view)) &&
    (state.status === "" || row.status === state.status || (state.status === "front" && fronts[row.v].has(row.c))) &&
    isFound(`${textOfConfiguration(row.c)}\n${views[row.v].id}\n${row.status}\n${row.reason || ""}`.toLowerCase()));
  if (!column) return left;
  const sign = state.sort.falling ? -1 : 1;
  return left.map((row, index) => ({ row, index, value: column.value(row) })).sort((a, b) => {
    const none = (a.value === undefined || a.value === null) - (b.value === undefined || b.value === null);
    if (none !== 0) return none;  // what is missing comes last either way
    const order = column.text ? collator.compare(a.value, b.value) : a.value - b.value;
    return sign * order || a.index - b.index;
  }).map((entry) => entry.row);
}

function drawTable() {
  fronts = views.map((_, v) => frontOfView(v));
  const all = columns(), shown = rowsShown();
  const head = all.map((column) => html("th", {
    scope: "col", class: column.text ? "text" : "", "aria-sort": state.sort.column !== column.id ? "none" : state.sort.falling ? "descending" : "ascending",
  }, html("button", { type: "button", "data-column": column.id, onclick: () => {
    state.sort = { column: column.id, falling: state.sort.column === column.id && !state.sort.falling };
    drawTable();
    document.querySelector(`#table [data-column="${CSS.escape(column.id)}"]`).focus();
  } }, column.title)));
  const cells = (row, column) => {
    if (column.id === "configuration") return html("th", { class: "text", scope: "row" }, pickButton(row.c));
    if (column.id === "view") return html("td", { class: "text view" }, views[row.v].id);
    if (column.id === "status") return html("td", { class: "text status" }, row.status);
    if (column.id === "settings") return html("td", { class: "text" }, settingsOf(row.c));
    const value = column.value(row);
    return html("td", column.id === "front" && value === 0 ? { "aria-label": "on the Pareto front" } : {},
      value === undefined || value === null ? "–" : column.show(value));
  };
  const body = shown.map((row) => html("tr", { "data-c": row.c, class: row.status === "ok" ? "" : row.status },
    row.status === "ok" ? all.map((column) => cells(row, column))
      : [all.slice(0, 3).map((column) => cells(row, column)),
         html("td", { class: "reason", colspan: all.length - 4 }, row.reason || (row.status === "missing" ? "not measured yet" : "no reason given")),
         cells(row, all[all.length - 1])]));
  if (shown.length === 0) body.push(html("tr", {}, html("td", { class: "text", colspan: all.length }, rows.length === 0 ? "No rows yet." : "No row passes the filters.")));
  byId("table").replaceChildren(html("thead", {}, html("tr", {}, head)), html("tbody", {}, body));
  byId("table-count").textContent = `${shown.length} of ${plural(rows.length, "row")}`;
  byId("save").disabled = shown.length === 0;
  markPicked(byId("table"));
}

/** Everything known of the rows in the table, in its order; RFC 4180. */
function csv() {
  const passColumns = passNames.flatMap((name) => ["first", "steady"].map((frame) => [`${name}, ${frame}, ms`, (row) => (timeOf(row, frame, name) || {}).median]));
  const errorColumns = channelNames.flatMap((channel) => metricsFound.map((metric) => [`${channel} ${metric}`, (row) => ((row.errors || {})[channel] || {})[metric]]));
  const timeColumns = ["first", "steady"].flatMap((frame) => ["median", "p10", "p90"].map((part) => [`${frame} ${part}, ms`, (row) => (timeOf(row, frame, "") || {})[part]]));
  const all = [["view", (row) => views[row.v].id], ["configuration", (row) => configurations[row.c].id], ["preset", (row) => presetOf(row.c)],
    ["settings", (row) => changes(row.c).join("; ")], ["status", (row) => row.status], ["reason", (row) => row.reason],
    ...timeColumns, ["memory, bytes", (row) => row.memory_bytes], ["samples a pixel", (row) => row.samples_per_pixel],
    ["voxels", (row) => row.voxels], ...errorColumns, ...passColumns];
  const quoted = (value) => {
    const text = value === undefined || value === null ? "" : String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [all.map(([title]) => title), ...rowsShown().map((row) => all.map(([, value]) => value(row)))]
    .map((line) => line.map(quoted).join(",") + "\r\n").join("");
}
function saveCsv() {
  const link = html("a", { href: URL.createObjectURL(new Blob([csv()], { type: "text/csv" })),
    download: `${String((report.suite || {}).name || "report").replace(/[^\p{L}\p{N}._-]+/gu, "_")}.csv` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/* ---------------------------------------------------------------- the page */

function select(title, options, value, change) {
  return html("label", { class: "field" }, title, html("select", { onchange: (event) => change(event.target.value) },
    options.map(([key, text]) => html("option", { value: key, selected: String(key) === String(value) }, text))));
}
function findField() {
  return html("label", { class: "field find" }, "Find configurations",
    html("input", { type: "search", placeholder: "name, setting, reason", oninput: (event) => {
      state.find = event.target.value;
      for (const other of document.querySelectorAll(".find input")) if (other !== event.target) other.value = state.find;
      mark();
      drawTable();
    } }));
}

const scatters = [];
function markPicked(root) {
  for (const element of root.querySelectorAll("tr[data-c], .pass-row, .thumb")) {
    const c = Number(element.dataset.c);
    element.classList.toggle("picked", c === state.picked);
    if (element.classList.contains("thumb")) element.setAttribute("aria-pressed", c === state.picked);
    if (element.classList.contains("pass-row")) element.classList.toggle("faded", !isFound(textOfConfiguration(c)));
  }
}
/** Shows what is picked and found, without drawing anything anew. */
function mark() {
  for (const scatter of scatters) scatter.mark();
  markPicked(document);
}
function pick(c) {
  state.picked = c;
  mark();
  views.forEach((_, v) => drawPictures(v));
}
function drawPasses(v) {
  const card = byId(`passes-${v}`);
  card.replaceChildren(html("div", { class: "bar" }, html("h3", {}, `Passes, ${frameTitle()}`)), ...passBars(v, card));
  markPicked(card);
}
function draw() {
  for (const scatter of scatters) scatter.draw();
  views.forEach((_, v) => {
    byId(`front-${v}`).replaceChildren(...frontTable(v));
    drawPasses(v);
    drawPictures(v);
    drawStrip(v);
  });
  drawTable();
  mark();
}

function heading() {
  const suite = report.suite || {}, build = report.build || {}, device = report.device || {}, machine = report.machine || {};
  const count = (status) => rows.filter((row) => row.status === status).length;
  const fact = (title, value, wide, code) => value !== "" && value !== undefined &&
    html("div", { class: wide ? "all" : "" }, html("dt", {}, title), html("dd", {}, code ? html("code", {}, value) : value));
  const made = report.times_made || {};
  const hash = suite.sha256 || suite.hash;
  document.title = `${suite.name || "voxcone report"}: speed against error`;
  byId("head").append(
    html("div", { class: "title" }, html("div", {},
      html("p", { class: "brand" }, "voxcone · speed against error"),
      html("h1", {}, suite.name || "Report"),
      html("p", { class: "counts soft" }, listed(plural(views.length, "view"), plural(configurations.length, "configuration"), `${count("ok")} measured`,
        count("failed") > 0 ? `${count("failed")} failed` : "", count("missing") > 0 ? `${count("missing")} missing` : ""))),
      select("Theme", [["system", "as the system"], ["light", "light"], ["dark", "dark"]], themeChoice, (value) => {
        themeChoice = value;
        applyTheme(value);
      })),
    html("dl", { class: "facts" },
      fact("Device", listed(device.renderer, device.version, device.software_rasterizer ? "software rasteriser" : "")),
      fact("Machine", listed(machine.cpu, machine.cores && plural(machine.cores, "core"), machine.memory_bytes && `${figure(machine.memory_bytes / 1e9)} GB`)),
      fact("Build", listed(build.version && `voxcone ${build.version}`, build.compiler, build.type)),
      fact("Made", listed(made.started, made.finished && `to ${made.finished}`)),
      fact("Suite", listed(suite.file, hash && `sha256 ${shortened(String(hash), 13)}`)),
      fact("Command", report.command || "", true, true)));
}

function controls() {
  const redo = (key) => (value) => { state[key] = value; draw(); };
  byId("controls").append(
    select("Frame", [["steady", "steady frame"], ["first", "first frame"]], state.frame, redo("frame")),
    select("Time of", [["", "whole frame"], ...passNames.map((name) => [name, name])], state.pass, redo("pass")),
    select("Channel", (channelNames.length ? channelNames : ["beauty"]).map((name) => [name, name]), state.channel, redo("channel")),
    select("Error", (metricNames.length ? metricNames : ["relmse"]).map((name) => [name, metricOf(name).title]), state.metric, redo("metric")),
    findField());
  byId("controls").addEventListener("submit", (event) => event.preventDefault());
}

function aboutView(v) {
  const view = views[v], reference = view.reference || {};
  const noise = noiseOf(v);
  return listed(view.width && `${view.width}×${view.height}`, view.triangles !== undefined && `${whole(view.triangles)} triangles`,
    reference.samples !== undefined && `reference: ${whole(reference.samples)} samples a pixel`,
    reference.depth !== undefined && `depth ${reference.depth}`, noise > 0 && `its noise alone: relMSE ${figure(noise)} of ${state.channel}`);
}

function sections() {
  const main = byId("main");
  if (views.length > 1) {
    const host = html("div", { class: "plot" });
    main.append(html("section", { "aria-labelledby": "overview" },
      html("div", { class: "heading" }, html("h2", { id: "overview" }, "All views")),
      html("div", { class: "card" },
        html("div", { class: "bar" }, html("p", { class: "soft small", id: "overview-note" }),
          configurations.length > 0 && select("Ratios to", configurations.map((c, index) => [index, c.id]), state.base, (value) => {
            state.base = Number(value);
            draw();
          })),
        host, keyOfPlot()),
      html("ul", { class: "links", "aria-label": "Views" }, views.map((view, v) => html("li", {}, html("a", { href: `#view-${v}` }, view.id))),
        html("li", {}, html("a", { href: "#rows" }, "all rows")))));
    scatters.push(new Scatter(host, overviewPlot));
  }
  views.forEach((view, v) => {
    const host = html("div", { class: "plot" });
    main.append(html("section", { id: `view-${v}`, "aria-labelledby": `title-${v}` },
      html("div", { class: "heading" }, html("h2", { id: `title-${v}` }, view.id), html("p", { class: "soft small wrap" }, aboutView(v))),
      html("div", { class: "pair" },
        html("div", { class: "card" }, host, keyOfPlot(), html("div", { class: "front-list", id: `front-${v}` })),
        html("div", { class: "card", id: `pictures-${v}` })),
      html("div", { class: "card" }, html("h3", {}, "Results, by time"), html("div", { class: "strip", id: `strip-${v}` })),
      html("div", { class: "card plot", id: `passes-${v}` })));
    scatters.push(new Scatter(host, () => viewPlot(v)));
  });
  main.append(html("section", { id: "rows", "aria-labelledby": "rows-title" },
    html("div", { class: "heading" }, html("h2", { id: "rows-title" }, "All rows")),
    html("div", { class: "filters" }, findField(),
      select("View", [["", "all"], ...views.map((view, v) => [v, view.id])], "", (value) => { state.view = value; drawTable(); }),
      select("Status", [["", "all"], ["ok", "ok"], ["front", "on the front"], ["failed", "failed"], ["missing", "missing"]], "",
        (value) => { state.status = value; drawTable(); }),
      html("span", { class: "shown soft small", id: "table-count", role: "status" }),
      html("button", { type: "button", id: "save", onclick: saveCsv }, "Save these rows as CSV")),
    html("div", { class: "scroll", tabindex: 0, role: "region", "aria-labelledby": "rows-title" }, html("table", { id: "table" }))));
  byId("foot").append(
    html("p", {}, "The first frame builds voxels, light and shadows; in a steady frame nothing has moved. " +
      "Times are medians over repeats, whiskers their 10th and 90th percentiles. A configuration is on the Pareto front when no other is " +
      "faster with the same error or less. Errors are against the path-traced reference; scales are logarithmic."),
    html("p", {}, "Pictures here are thumbnails; the full ones lie beside this page, with report.json."));
}

heading();
controls();
sections();
draw();
