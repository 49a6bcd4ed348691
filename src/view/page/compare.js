"use strict";
/* What looks at an image more closely: another image beside it, exposure, and maps of errors, of cost
   and of certainty. The server computes them when they are asked for; what is light is linear, and 1 is
   full scale. */
const compare = { a: null, turn: 0, maps: new Map(), values: null };

const SHOWN = [
  ["image", "the image"], ["a", "difference from A"], ["error-f64", "difference from double"], ["error-dd", "difference from double-double"],
  ["error-certified", "difference from certified"], ["rays", "cost: rays"], ["work", "cost: instructions"], ["certainty", "certainty"],
];
/* As in src/run/certainty.rs. */
const CERTAINTIES = [
  ["0 0 0", "certain in doubles"], ["96 96 96", "in double-double"], ["213 94 0", "not certain: boundary"],
  ["240 228 66", "light"], ["0 114 178", "surface"], ["255 255 255", "colour"],
];
/* From the least to the most; zero is black. Lightness rises all along, for any colour vision. */
const HEAT = [[40, 11, 84], [101, 21, 110], [159, 42, 99], [212, 72, 66], [245, 125, 21], [250, 193, 39], [252, 255, 164]];
/* Scales of errors reach down so many decades. */
const DECADES = 6;

const option = ([value, words]) => new Option(words, value);
const labelled = (words, ...controls) => make("label", "", words, ...controls);
const named = (tag, id, more) => Object.assign(make(tag), { id }, more);
const shows = named("select", "shows"), metric = named("select", "metric"), legend = named("div", "legend");
const stops = named("input", "stops", { type: "range", min: -8, max: 8, step: 0.5, value: 0 }), stopsShown = make("output");
const pinButton = named("button", "pin", { textContent: "Keep as A" }), pinned = named("span", "pinned"), unpin = named("button", "unpin", { textContent: "Drop A" });
const overlay = named("canvas", "overlay", { hidden: true }), before = named("canvas", "before"), divider = named("input", "divider", { type: "range", min: 0, max: 100, step: "any", value: 50 });
const sides = [named("span", "side-a", { className: "side", textContent: "A" }), named("span", "side-b", { className: "side", textContent: "now" })];
shows.append(...SHOWN.map(option));
metric.append(...[["absolute", "absolute"], ["squared", "squared"]].map(option));
divider.setAttribute("aria-label", "Divider between A, on the left, and the image as it is now");
metric.setAttribute("aria-label", "Measure of the difference");
pinButton.title = "Keep this image, to compare others with it";
legend.setAttribute("role", "status");
byId("tools").append(labelled("Show ", shows), metric, labelled("Exposure ", stops, stopsShown), pinButton, pinned, unpin, legend);
stack.append(overlay, before, divider, ...sides);

const place = () => ({ run: Number(picture.dataset.run), image: Math.max(0, byId("which").selectedIndex), width: picture.width, height: picture.height });

/* A map of the image that is shown, asked for once. */
function mapOf(of) {
  const { run, image } = place(), key = [run, image, of].join(" ");
  for (const other of compare.maps.keys()) if (!other.startsWith(run + " ")) compare.maps.delete(other);
  if (!compare.maps.has(key)) compare.maps.set(key, askMap(`map?run=${run}&image=${image}&of=${of}`).catch((error) => { compare.maps.delete(key); throw error; }));
  return compare.maps.get(key);
}

async function askMap(path) {
  const response = await fetch(path).catch(() => ({}));
  if (response.status !== 200) throw new Error(response.status === 204 ? "the run of this image has ended" : "the server does not answer");
  const type = response.headers.get("Content-Type");
  if (type === "application/json") throw new Error((await response.json()).error);
  return type === "image/png" ? createImageBitmap(await response.blob()) : response.arrayBuffer();
}

/* The light of bytes, which are linear: what there is if an image cannot be traced again. */
const lightOfBytes = ({ data }) => Float32Array.from({ length: data.length / 4 * 3 }, (_, at) => data[(at / 3 | 0) * 4 + at % 3] / 255);
const bytesNow = () => context.getImageData(0, 0, picture.width, picture.height);
function lightNow() {
  const bytes = bytesNow();
  return mapOf("light").then((map) => new Float32Array(map), () => lightOfBytes(bytes));
}

const chosenWords = () => Object.values(selects).map((select) => select.selectedOptions[0].text).join(", ");
function pin() {
  if (!picture.dataset.run) return;
  const { width, height } = place();
  compare.a = { width, height, bytes: bytesNow(), light: lightNow(), words: chosenWords() };
  refresh();
}

/* Renders by another method, beside what there is now. */
function tryMethod(choice) {
  if (!compare.a) pin();
  choose(choice);
  render();
}

/* Light as pixels, this many stops brighter. */
function exposed(light, width, height, stops) {
  const pixels = new ImageData(width, height), gain = 255 * 2 ** stops;
  for (let from = 0, to = 0; from < light.length; to++) {
    for (let c = 0; c < 3; c++) pixels.data[to++] = Math.floor(Math.min(255, Math.max(0, light[from++] * gain)) || 0);
    pixels.data[to] = 255;
  }
  return pixels;
}

/* How far numbers are apart. */
function apart(one, other) {
  return one.map((a, at) => {
    const b = other[at], d = Math.abs(a - b);
    return a === b || a !== a && b !== b ? 0 : d === d ? d : Infinity;
  });
}

/* The largest difference of each pixel's channels, and what there is to say of all of them. */
function differences(channels, isSquared) {
  const values = new Float64Array(channels.length / 3);
  let sum = 0, largest = 0;
  channels.forEach((d, at) => {
    const value = isSquared ? d * d : d, pixel = at / 3 | 0;
    sum += value;
    values[pixel] = Math.max(values[pixel], value);
    largest = Math.max(largest, value);
  });
  const count = values.reduce((count, value) => count + (value > 0), 0);
  const mean = sum / channels.length;
  const means = isSquared ? `mean ${short(mean)}, its root ${short(Math.sqrt(mean))}` : `mean ${short(mean)}`;
  const words = count ? `${count} of ${values.length} pixels differ · largest ${short(largest)} · ${means}` : `all ${values.length} pixels are the same`;
  const most = largest === Infinity ? 1 : 10 ** Math.ceil(Math.log10(largest || 1));
  return { values, words, least: most / 10 ** (isSquared ? 2 * DECADES : DECADES), most };
}

function costs(map, isWork) {
  const all = new Uint32Array(map), values = Float64Array.from({ length: all.length / 2 }, (_, at) => all[2 * at + isWork]);
  let largest = 0, sum = 0;
  for (const value of values) { largest = Math.max(largest, value); sum += value; }
  const unit = isWork ? "instructions" : "rays";
  return { values, words: `${sum.toLocaleString("en")} ${unit} · largest ${largest} · mean ${short(sum / values.length)} a pixel, at its centre`, least: 1, most: Math.max(largest, 2) };
}

const short = (x) => Number.isInteger(x) && x < 1e6 ? String(x) : x < 1e-3 ? x.toExponential(1).replace(".0", "") : String(Number(x.toPrecision(3)));

/* The colour of a value between the least and the most, by its logarithm. */
function heat(value, { least, most }) {
  if (!(value > 0)) return [0, 0, 0];
  const share = Math.log(value / least) / Math.log(most / least), at = Math.min(1, Math.max(0, share)) * (HEAT.length - 1);
  const low = Math.min(Math.floor(at), HEAT.length - 2);
  return HEAT[low].map((c, channel) => Math.round(c + (HEAT[low + 1][channel] - c) * (at - low)));
}

function heatMap(map, width, height) {
  const pixels = new ImageData(width, height);
  map.values.forEach((value, at) => pixels.data.set([...heat(value, map), 255], 4 * at));
  return pixels;
}

function tell(...content) { legend.replaceChildren(...content); }
function tellScale(map) {
  const bar = make("div"), ticks = [map.least, Math.sqrt(map.least * map.most), map.most];
  bar.style.background = `linear-gradient(90deg, ${HEAT.map((c) => `rgb(${c.join(" ")})`).join()})`;
  const scale = named("div", "scale");
  scale.append(bar, make("p", "", ...ticks.map((tick) => make("span", "", short(tick)))));
  tell(scale, make("span", "", "black: none"), make("span", "", map.words), named("b", "here"));
}
function tellCertainties() {
  tell(...CERTAINTIES.map(([color, words]) => {
    const swatch = make("span", "swatch");
    swatch.style.background = `rgb(${color})`;
    return make("span", "", swatch, words);
  }));
}

/* What lies over the image: pixels, and how they are explained. */
async function over() {
  const { width, height } = place(), what = shows.value, gain = Number(stops.value);
  if (what === "image") return gain === 0 ? null : { pixels: exposed(await lightNow(), width, height, gain) };
  if (what === "certainty") return { bitmap: await mapOf(what), explain: tellCertainties };
  let map;
  if (what === "rays" || what === "work") map = costs(await mapOf("cost"), Number(what === "work"));
  else {
    const { a } = compare;
    if (what === "a" && (!a || a.width !== width || a.height !== height)) throw new Error(a ? "A is of another size" : "there is no A");
    const channels = what === "a" ? apart(await lightNow(), await a.light) : new Float32Array(await mapOf(what));
    map = differences(channels, metric.value === "squared");
  }
  return { pixels: heatMap(map, width, height), explain: () => tellScale(map), values: map.values };
}

function put(canvas, width, height, pixels, bitmap) {
  Object.assign(canvas, { width, height });
  if (bitmap) canvas.getContext("2d").drawImage(bitmap, 0, 0);
  else canvas.getContext("2d").putImageData(pixels, 0, 0);
}

function showA() {
  const { a } = compare, isOn = Boolean(a) && !byId("tools").hidden;
  for (const element of [before, divider, ...sides]) element.hidden = !isOn;
  unpin.hidden = pinned.hidden = !a;
  pinned.textContent = a ? `A: ${a.words}` : "";
  shows.querySelector("[value=a]").disabled = !a;
  before.style.setProperty("--share", divider.value + "%");
  divider.setAttribute("aria-valuetext", `${Math.round(divider.value)} % of A`);
}

/* Draws everything anew; what comes too late is dropped. */
async function refresh() {
  const turn = ++compare.turn, isOpen = !byId("tools").hidden, { a } = compare, { width, height, run } = place();
  const errs = /^(a$|error)/.test(shows.value);
  metric.hidden = !errs;
  for (const other of shows.options) if (other.value.startsWith("error-")) other.disabled = other.value.slice(6) === selects.precision.value;
  if (shows.selectedOptions[0].disabled && shows.value !== "a") shows.value = "image";
  stopsShown.textContent = `${stops.value > 0 ? "+" : ""}${stops.value} EV`;
  compare.values = null;
  showA();
  if (!isOpen || run !== view.good) { overlay.hidden = true; return; }
  tell(shows.value === "image" ? "" : "computing");
  try {
    const [shown, pixelsOfA] = await Promise.all([over(), a && (Number(stops.value) ? a.light.then((light) => exposed(light, a.width, a.height, Number(stops.value))) : a.bytes)]);
    if (turn !== compare.turn) return;
    if (a) put(before, a.width, a.height, pixelsOfA);
    overlay.hidden = !shown;
    if (shown) put(overlay, width, height, shown.pixels, shown.bitmap);
    compare.values = shown && shown.values;
    (shown && shown.explain || tell)();
    told.shown = [run, shows.value, stops.value, metric.value].join(" ");
  } catch (error) {
    if (turn !== compare.turn) return;
    overlay.hidden = true;
    tell(`Not shown: ${error.message}.`);
  }
}

view.onShown = refresh;
view.onPoint = (x, y) => { if (compare.values) byId("here").textContent = `here ${short(compare.values[y * picture.width + x])}`; };
for (const control of [shows, metric]) on(control, "change", refresh);
on(stops, "input", refresh);
on(divider, "input", showA);
on(pinButton, "click", pin);
on(unpin, "click", () => { compare.a = null; if (shows.value === "a") shows.value = "image"; refresh(); });
