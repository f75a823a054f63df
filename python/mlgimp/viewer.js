// Shows a field over the frames of a run on a canvas: points as parallelograms of their size, boxes of levels, the indenter.
// The data is the element "film", see film.py. Lengths are in m, places on the canvas in its dots.
"use strict";

const film = JSON.parse(document.getElementById("film").textContent);
const element = (name) => document.getElementById(name);
const canvas = element("field");
const pen = canvas.getContext("2d");
const slider = element("frame");
const MARGIN = { left: 70, right: 120, below: 46, above: 14 }; // around the field, in dots of a screen without scaling
const CODES = 4095; // steps of a value, as in film.py
const PLACE_BYTES = 4;
const VALUE_BYTES = 2;
const DECADES = 3; // of a logarithmic scale
const FRAMES_PER_SECOND = 12;
const CLOSER = 0.8; // of the window, when a step of the wheel or a key zooms
const SMALL = 1e-6; // of a dot: what rounding leaves where a point ends at the line between two
const INDENTER = "#8c8c8c";
const LINE = "#262626";

const orders = []; // of the points of each frame, the largest first, so that the small ones lie above
const values = {}; // codes by field, an array for each frame
let places = null; // [frame] = {x, y, ax, ay, bx, by}: middles of points, and from there to the middles of two sides, whole numbers in steps
let field = film.fields[0];
let palette = null; // colour by code, as the canvas keeps it
let view = null; // window that is shown: [left, right, lower, upper]
let picture = null; // memory of the field's dots
let timer = null;

// ---- data ----

// Bytes of a text in base64 that is compressed.
async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Columns of whole numbers, [frame][column][point]: each is kept as differences, see film.py.
function columnsOf(bytes, count, width) {
  const frames = [];
  let at = 0;
  film.frames.forEach((frame, number) => {
    const own = [];
    const n = frame.count;
    for (let column = 0; column < count; ++column) {
      const found = new Int32Array(n);
      const before = frame.same ? frames[number - 1][column] : null;
      let last = 0;
      for (let p = 0; p < n; ++p) {
        let folded = 0;
        for (let byte = width - 1; byte >= 0; --byte) folded = folded * 256 + bytes[at + byte * n + p];
        const change = folded % 2 ? -(folded + 1) / 2 : folded / 2;
        last = (before ? before[p] : last) + change;
        found[p] = last;
      }
      own.push(found);
      at += width * n;
    }
    frames.push(own);
  });
  return frames;
}

async function readPlaces() {
  const frames = columnsOf(await unpack(film.places), 6, PLACE_BYTES);
  places = frames.map(([x, y, ax, ay, bx, by]) => ({ x, y, ax, ay, bx, by }));
}

async function readField(chosen) {
  if (!values[chosen.name]) {
    values[chosen.name] = columnsOf(await unpack(chosen.values), 1, VALUE_BYTES).map(([codes]) => codes);
  }
}

// Points of a frame, the largest first.
function orderOf(number) {
  if (!orders[number]) {
    const { ax, ay, bx, by } = places[number];
    const keys = Float64Array.from(ax, (_, p) => Math.abs(ax[p] * by[p] - ay[p] * bx[p]));
    const largest = keys.reduce((one, other) => Math.max(one, other), 1);
    const parts = 2 ** 21 / largest; // a size and a number of 32 bits fit into one number of 53
    for (let p = 0; p < keys.length; ++p) keys[p] = Math.floor((largest - keys[p]) * parts) * 2 ** 32 + p;
    keys.sort();
    orders[number] = Uint32Array.from(keys, (key) => key % 2 ** 32);
  }
  return orders[number];
}

// ---- colours ----

// Place of a value on the scale, 0 to 1.
function shareOf(code) {
  const linear = code / CODES;
  if (!element("logarithmic").checked) return linear;
  const { low, high } = field;
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const size = Math.abs(low + linear * (high - low)) / largest;
  const share = Math.max(0, 1 + Math.log10(Math.max(size, 1e-12)) / DECADES);
  return low + high < 0 ? 1 - share : share;
}

function colourOf(code) {
  const table = film.colours[field.colours];
  const at = 6 * Math.min(255, Math.floor(256 * shareOf(code)));
  return table.slice(at, at + 6);
}

function makePalette() {
  palette = new Uint32Array(CODES + 1);
  for (let code = 0; code <= CODES; ++code) {
    const colour = parseInt(colourOf(code), 16);
    palette[code] = 0xff000000 | ((colour & 0xff) << 16) | (colour & 0xff00) | (colour >> 16);
  }
}

function canBeLogarithmic() {
  return field.low >= 0 || field.high <= 0;
}

// ---- drawing ----

const scaling = () => canvas.width / canvas.clientWidth; // dots of the canvas in one of the page
const number = () => Number(slider.value);

// Where the window lies on the canvas: its left and upper corner in dots, and dots in one metre.
function frameOfView() {
  const one = scaling();
  const room = {
    left: MARGIN.left * one, top: MARGIN.above * one, width: canvas.width - (MARGIN.left + MARGIN.right) * one,
    height: canvas.height - (MARGIN.above + MARGIN.below) * one,
  };
  const perMetre = Math.min(room.width / (view[1] - view[0]), room.height / (view[3] - view[2]));
  const width = Math.max(1, Math.round(Math.min(room.width, perMetre * (view[1] - view[0]))));
  const height = Math.max(1, Math.round(Math.min(room.height, perMetre * (view[3] - view[2]))));
  return { left: Math.round(room.left), top: Math.round(room.top), width, height, perMetre };
}

// Paints the dots that a parallelogram touches: its middle (x, y) and the vectors a and b from there to the middles of two sides, in
// dots. Of a side s these are |offset x s| < area + 0.5 (|s_x| + |s_y|), of which each line of dots has an interval.
function paint(dots, box, x, y, ax, ay, bx, by, colour) {
  const reachX = Math.abs(ax) + Math.abs(bx);
  const reachY = Math.abs(ay) + Math.abs(by);
  const area = Math.abs(ax * by - ay * bx);
  const slopeA = ay === 0 ? 0 : ax / ay;
  const slopeB = by === 0 ? 0 : bx / by;
  const halfA = ay === 0 ? reachX + 0.5 : (area + 0.5 * (Math.abs(ax) + Math.abs(ay))) / Math.abs(ay);
  const halfB = by === 0 ? reachX + 0.5 : (area + 0.5 * (Math.abs(bx) + Math.abs(by))) / Math.abs(by);
  const end = Math.min(box.height, Math.ceil(y + reachY - SMALL));
  for (let line = Math.max(0, Math.floor(y - reachY + SMALL)); line < end; ++line) {
    const up = line + 0.5 - y;
    const low = Math.max(up * slopeA - halfA, up * slopeB - halfB);
    const high = Math.min(up * slopeA + halfA, up * slopeB + halfB);
    const first = line * box.width + Math.max(0, Math.ceil(x + low - 0.5 + SMALL));
    const last = line * box.width + Math.min(box.width, Math.floor(x + high - 0.5 - SMALL) + 1);
    for (let dot = first; dot < last; ++dot) dots[dot] = colour;
  }
}

function drawPoints(box) {
  if (!picture || picture.width !== box.width || picture.height !== box.height) picture = pen.createImageData(box.width, box.height);
  const dots = new Uint32Array(picture.data.buffer).fill(0xffffffff);
  const { x, y, ax, ay, bx, by } = places[number()];
  const codes = values[field.name][number()];
  const unit = film.step * box.perMetre;
  const left = (film.start[0] - view[0]) * box.perMetre;
  const top = (view[3] - film.start[1]) * box.perMetre;
  const middle = 2 * -view[0] * box.perMetre; // twice the place of the axis
  for (const p of orderOf(number())) {
    const across = left + x[p] * unit;
    const down = top - y[p] * unit;
    paint(dots, box, across, down, ax[p] * unit, -ay[p] * unit, bx[p] * unit, -by[p] * unit, palette[codes[p]]);
    if (!film.mirror) continue;
    const colour = palette[field.odd ? CODES - codes[p] : codes[p]];
    paint(dots, box, middle - across, down, -ax[p] * unit, -ay[p] * unit, -bx[p] * unit, -by[p] * unit, colour);
  }
  pen.putImageData(picture, box.left, box.top);
}

function drawOutlines(box) {
  const frame = film.frames[number()];
  const across = (x) => box.left + (x - view[0]) * box.perMetre;
  const up = (y) => box.top + (view[3] - y) * box.perMetre;
  pen.save();
  pen.beginPath();
  pen.rect(box.left, box.top, box.width, box.height);
  pen.clip();
  pen.strokeStyle = LINE;
  pen.lineWidth = scaling();
  for (const [left, lower, right, upper] of frame.boxes) {
    const from = film.mirror ? -right : left;
    pen.strokeRect(across(from), up(upper), (right - from) * box.perMetre, (upper - lower) * box.perMetre);
  }
  if (film.indenter && frame.tip) {
    pen.beginPath();
    for (const [x, y] of film.indenter) pen.lineTo(across(frame.tip[0] + x), up(frame.tip[1] + y));
    pen.closePath();
    pen.fillStyle = INDENTER;
    pen.fill();
    pen.stroke();
  }
  pen.restore();
  pen.strokeRect(box.left, box.top, box.width, box.height);
}

// Round numbers between two, at most so many.
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((times) => times * power >= rough * (1 - 1e-9));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(k * step);
  return found;
}

const inWords = (value) => Number(value.toPrecision(4)).toString();

function drawAxes(box) {
  const one = scaling();
  const { factor, name } = film.length;
  pen.fillStyle = "#111";
  pen.font = `${12 * one}px sans-serif`;
  pen.textAlign = "center";
  pen.textBaseline = "top";
  const below = box.top + box.height;
  const shown = [view[0], view[0] + box.width / box.perMetre, view[3] - box.height / box.perMetre, view[3]].map((end) => end * factor);
  for (const x of ticks(shown[0], shown[1], Math.max(3, box.width / one / 90))) {
    const at = box.left + (x / factor - view[0]) * box.perMetre;
    pen.fillRect(at, below, one, 4 * one);
    pen.fillText(inWords(x), at, below + 6 * one);
  }
  pen.fillText(`${film.axes[0]} (${name})`, box.left + box.width / 2, below + 24 * one);
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const y of ticks(shown[2], shown[3], Math.max(3, box.height / one / 60))) {
    const at = box.top + (view[3] - y / factor) * box.perMetre;
    pen.fillRect(box.left - 4 * one, at, 4 * one, one);
    pen.fillText(inWords(y), box.left - 7 * one, at);
  }
  turned(`${film.axes[1]} (${name})`, box.left - 55 * one, box.top + box.height / 2);
}

// Text from below to above.
function turned(text, x, y) {
  pen.save();
  pen.translate(x, y);
  pen.rotate(-Math.PI / 2);
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(text, 0, 0);
  pen.restore();
}

// Numbers beside the colour bar, [[value, place from 0 to 1]].
function marksOfBar() {
  const { low, high } = field;
  if (!element("logarithmic").checked) return ticks(low, high, 6).map((value) => [value, (value - low) / (high - low)]);
  const largest = Math.abs(low) > Math.abs(high) ? low : high;
  const power = Math.sign(largest) * 10 ** Math.floor(Math.log10(Math.abs(largest)));
  return [0, 1, 2].map((decade) => power / 10 ** decade).map((value) => [value, shareOf(((value - low) / (high - low)) * CODES)]);
}

function drawBar(box) {
  const one = scaling();
  const left = box.left + box.width + 16 * one;
  const height = Math.max(box.height, Math.min(120 * one, canvas.height - 2 * box.top));
  const table = film.colours[field.colours];
  for (let k = 0; k < 256; ++k) {
    pen.fillStyle = `#${table.slice(6 * k, 6 * k + 6)}`;
    pen.fillRect(left, box.top + height * (1 - (k + 1) / 256), 14 * one, height / 256 + one);
  }
  pen.strokeRect(left, box.top, 14 * one, height);
  pen.fillStyle = "#111";
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  for (const [value, share] of marksOfBar()) pen.fillText(inWords(value), left + 18 * one, box.top + height * (1 - share));
  turned(field.unit ? `${field.label} (${field.unit})` : field.label, left + 84 * one, box.top + height / 2);
}

function draw() {
  if (!places || !values[field.name]) return;
  const begun = performance.now();
  const box = frameOfView();
  pen.fillStyle = "#fff";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  drawPoints(box);
  drawOutlines(box);
  drawAxes(box);
  drawBar(box);
  showState();
  canvas.dataset.milliseconds = performance.now() - begun;
}

function showState() {
  const words = `frame ${number() + 1} of ${film.frames.length}: ${film.frames[number()].words}`;
  element("state").textContent = words;
  slider.setAttribute("aria-valuetext", words);
  canvas.setAttribute("aria-label", `${field.label}, ${words}`);
  const mark = element("mark");
  const place = film.marks && film.marks[number()];
  if (mark && place) Object.assign(mark.style, { display: "block", left: `${100 * place[0]}%`, top: `${100 * place[1]}%` });
}

// ---- what the user does ----

function resize() {
  canvas.width = Math.round(canvas.clientWidth * (window.devicePixelRatio || 1));
  canvas.height = Math.round(canvas.clientHeight * (window.devicePixelRatio || 1));
  draw();
}

function zoomTo(wished) {
  view = [...wished];
  draw();
}

function move(steps) {
  slider.value = Math.min(film.frames.length - 1, Math.max(0, number() + steps));
  draw();
}

function stop() {
  clearInterval(timer);
  timer = null;
  element("play").textContent = "Play";
}

function play() {
  if (timer) {
    stop();
    return;
  }
  if (number() === film.frames.length - 1) slider.value = 0;
  element("play").textContent = "Stop";
  timer = setInterval(() => {
    if (number() === film.frames.length - 1) stop();
    else move(1);
  }, 1000 / FRAMES_PER_SECOND);
  draw();
}

async function chooseField() {
  const chosen = film.fields.find((each) => each.name === element("component").value);
  await readField(chosen);
  field = chosen;
  const box = element("logarithmic");
  box.disabled = !canBeLogarithmic();
  box.checked = box.checked && !box.disabled;
  makePalette();
  draw();
}

// The place of an event of the mouse in m, and the field on the canvas.
function placeOf(event) {
  const box = frameOfView();
  const x = view[0] + (event.offsetX * scaling() - box.left) / box.perMetre;
  const y = view[3] - (event.offsetY * scaling() - box.top) / box.perMetre;
  return { x, y, box };
}

// Makes the window larger by some times around a place.
function zoomAround(x, y, times) {
  zoomTo([x + (view[0] - x) * times, x + (view[1] - x) * times, y + (view[2] - y) * times, y + (view[3] - y) * times]);
}

function onWheel(event) {
  if (document.activeElement !== canvas) return; // else the page could not be moved past the field
  event.preventDefault();
  const { x, y } = placeOf(event);
  zoomAround(x, y, event.deltaY < 0 ? CLOSER : 1 / CLOSER);
}

function drag(event) {
  const { box } = placeOf(event);
  if (event.buttons === 1) {
    const dx = (-event.movementX * scaling()) / box.perMetre;
    const dy = (event.movementY * scaling()) / box.perMetre;
    zoomTo([view[0] + dx, view[1] + dx, view[2] + dy, view[3] + dy]);
  } else {
    showValue(event);
  }
}

// The value of the point under the mouse.
function showValue(event) {
  if (!places || !values[field.name]) return;
  const { x, y } = placeOf(event);
  const at = [((film.mirror ? Math.abs(x) : x) - film.start[0]) / film.step, (y - film.start[1]) / film.step];
  const own = places[number()];
  let found = -1;
  for (const p of orderOf(number())) {
    const [across, up] = [at[0] - own.x[p], at[1] - own.y[p]];
    const area = Math.abs(own.ax[p] * own.by[p] - own.ay[p] * own.bx[p]);
    if (Math.abs(across * own.ay[p] - up * own.ax[p]) <= area && Math.abs(across * own.by[p] - up * own.bx[p]) <= area) found = p;
  }
  const { factor, name } = film.length;
  const where = `${film.axes[0]} = ${inWords(x * factor)} ${name}, ${film.axes[1]} = ${inWords(y * factor)} ${name}`;
  element("value").textContent = found < 0 ? where : `${where}: ${field.label} ${valueInWords(found, x)}`;
}

function valueInWords(point, x) {
  const stored = values[field.name][number()][point];
  const code = film.mirror && field.odd && x < 0 ? CODES - stored : stored;
  const text = `${inWords(field.low + (code / CODES) * (field.high - field.low))} ${field.unit}`.trim();
  return code === CODES ? `${text} or more` : code === 0 && field.low < 0 ? `${text} or less` : text;
}

function onKey(event) {
  if (["INPUT", "SELECT"].includes(event.target.tagName)) return;
  const steps = { ArrowLeft: -1, ArrowRight: 1, Home: -1e9, End: 1e9 }[event.key];
  const times = { "+": CLOSER, "-": 1 / CLOSER }[event.key];
  if (steps) move(steps);
  if (times && !event.ctrlKey && !event.metaKey) zoomAround((view[0] + view[1]) / 2, (view[2] + view[3]) / 2, times);
  if (steps || (times && !event.ctrlKey && !event.metaKey)) event.preventDefault();
}

function listen() {
  slider.addEventListener("input", draw);
  element("component").addEventListener("change", chooseField);
  element("logarithmic").addEventListener("change", () => { makePalette(); draw(); });
  element("play").addEventListener("click", play);
  element("all").addEventListener("click", () => zoomTo(film.whole));
  element("near").addEventListener("click", () => zoomTo(film.frames[number()].near || film.whole));
  element("near").disabled = !film.frames.some((frame) => frame.near);
  canvas.addEventListener("wheel", onWheel, { passive: false });
  canvas.addEventListener("pointermove", drag);
  document.addEventListener("keydown", onKey);
  window.addEventListener("resize", resize);
}

async function start() {
  if (typeof DecompressionStream === "undefined") {
    element("state").textContent = "This browser is older than 2023 and cannot unpack the fields.";
    return;
  }
  slider.max = film.frames.length - 1;
  slider.value = slider.max;
  view = (film.indenter && film.frames[number()].near) || film.whole;
  listen();
  await readPlaces();
  await chooseField();
  resize();
  canvas.dataset.ready = "true";
}

start();
