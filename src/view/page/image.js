/* The image: what is there, what is coming, and what its pixels are about. */
const picture = byId("picture"), draft = byId("draft"), stack = byId("stack");
const context = picture.getContext("2d", { willReadFrequently: true });
const view = { run: 0, good: 0, chosen: 0, images: new Map(), asked: null, isAsking: false };

async function bitmap(number) {
  const response = await fetch("file/" + number);
  return response.status === 200 ? createImageBitmap(await response.blob()) : null;
}

/* What is known of the images of a run. */
function imagesOf(run) {
  if (!view.images.has(run)) view.images.set(run, []);
  return view.images.get(run);
}

function fit() {
  const frame = byId("frame"), style = getComputedStyle(frame);
  const room = [frame.clientWidth - 2 * parseFloat(style.paddingLeft), frame.clientHeight - 2 * parseFloat(style.paddingTop)];
  const scale = Math.min(room[0] / picture.width, room[1] / picture.height);
  stack.style.width = picture.width * scale + "px";
  stack.style.height = picture.height * scale + "px";
  stack.classList.toggle("large", scale >= 2);
}

function resize({ width, height }) {
  if (picture.width === width && picture.height === height) return;
  for (const canvas of [picture, draft]) Object.assign(canvas, { width, height });
  fit();
}

/* Shows the chosen image of the last run that succeeded, or of the current one. */
function showImage() {
  const run = view.images.has(view.run) && imagesOf(view.run).some((image) => image.bitmap) && !stack.classList.contains("stale") ? view.run : view.good;
  const images = imagesOf(run);
  const image = images[view.chosen] || images[0];
  if (!image || !image.bitmap) return;
  const { bitmap } = image;
  resize(bitmap);
  context.drawImage(bitmap, 0, 0);
  picture.dataset.run = run;
  picture.dataset.number = image.number;
  draft.getContext("2d").clearRect(0, 0, draft.width, draft.height);
  byId("size").textContent = `${image.name} · ${image.width}×${image.height}` + (image.line ? " · " + image.line : "");
  const which = byId("which");
  which.hidden = images.length < 2;
  which.replaceChildren(...images.map((image, index) => new Option(`${index + 1}: ${image.name}`, index)));
  which.value = images.indexOf(image);
  view.onShown?.();
}

async function onPicture({ run, image, number }) {
  const found = await bitmap(number);
  if (!found || run < view.good) return;
  Object.assign(imagesOf(run)[image] ||= {}, { bitmap: found, number });
  showImage();
}

function onKnown({ run, image, line }) {
  Object.assign(imagesOf(run)[image] ||= {}, { line });
  showImage();
}

/* A coarse image, or a band of rows. */
async function onDraft({ event, run, image, number, y, height }) {
  const about = imagesOf(run)[image];
  if (!about || image !== view.chosen && imagesOf(run).length > 1) return;
  const found = await bitmap(number);
  if (!found || run !== view.run || about.bitmap) return;
  resize(about);
  const isCoarse = event === "coarse";
  draft.getContext("2d").drawImage(found, 0, isCoarse ? 0 : y, about.width, isCoarse ? about.height : height);
}

/* Ends a run's drafts: what it failed to show is not kept. */
function onEnd(run, isGood) {
  stack.classList.toggle("stale", !isGood);
  draft.getContext("2d").clearRect(0, 0, draft.width, draft.height);
  if (isGood) {
    view.good = run;
    for (const other of [...view.images.keys()]) if (other < run) view.images.delete(other);
  }
  showImage();
}

function colorAt(x, y) {
  return [...context.getImageData(x, y, 1, 1).data.subarray(0, 3)];
}

function tellPixel(x, y, color, about) {
  const swatch = make("span", "swatch");
  swatch.style.background = `rgb(${color.join(" ")})`;
  const parts = [swatch, make("b", "", `(${x}, ${y})`), ` colour ${color.join(" ")}`];
  if (about) {
    const { seen, rays, instructions, certainty } = about;
    if (seen) {
      const place = seen.function ? ` at ${seen.function.file}:${seen.function.line}` : "";
      parts.push(" · ", make("b", "", `${seen.kind} ${seen.shape}`), `, face ${seen.face}, u ${seen.u.toPrecision(4)}, v ${seen.v.toPrecision(4)}, ${seen.distance.toPrecision(4)} away`);
      parts.push(" · ", make("b", "", `surface ${seen.surface}`), `: ${seen.title}${place}, ${seen.how}`);
    } else parts.push(" · nothing is met");
    const plural = (n, one) => `${n} ${one}${n === 1 ? "" : "s"}`;
    parts.push(` · ${plural(rays.primary + rays.reflected, "ray")}, ${rays.shadow} toward lights, ${plural(rays.surface_calls, "surface call")}, ${instructions} instructions`);
    if (certainty) parts.push(" · " + certainty);
  }
  byId("pixel").replaceChildren(...parts);
}

/* Asks about the last pixel pointed at, one after the other. */
async function ask() {
  if (view.isAsking) return;
  view.isAsking = true;
  while (view.asked) {
    const { x, y, jumps } = view.asked;
    view.asked = null;
    const run = Number(picture.dataset.run);
    const response = await fetch(`pixel?run=${run}&image=${Math.max(0, byId("which").selectedIndex)}&x=${x}&y=${y}`).catch(() => null);
    const about = response && response.ok ? await response.json() : null;
    tellPixel(x, y, about ? about.color : colorAt(x, y), about);
    const seen = about && about.seen, place = seen && seen.function;
    const isHere = place && place.file === editor.name;
    lightLines(isHere ? place.line : 0, isHere ? place.end : 0, false);
    if (jumps && isHere) jump(place.line);
    else if (isHere && document.activeElement !== text) reveal(place.line);
    if (jumps && seen && code.data) {
      const found = code.data.surfaces.findIndex((surface) => surface.numbers.includes(seen.surface));
      if (found >= 0) showSurface(found);
    }
  }
  view.isAsking = false;
}

function pointAt(event, jumps) {
  if (!picture.dataset.run) return;
  const box = picture.getBoundingClientRect();
  const at = (offset, length, n) => Math.min(n - 1, Math.max(0, Math.floor(offset / length * n)));
  const x = at(event.clientX - box.left, box.width, picture.width), y = at(event.clientY - box.top, box.height, picture.height);
  view.onPoint?.(x, y);
  if (!view.isAsking) tellPixel(x, y, colorAt(x, y), null);
  view.asked = { x, y, jumps };
  ask();
}

on(picture, "mousemove", (event) => pointAt(event, false));
on(picture, "click", (event) => pointAt(event, true));
on(picture, "mouseleave", () => { view.asked = null; lightLines(0, 0); });
on(byId("which"), "change", () => { view.chosen = Number(byId("which").value); showImage(); });

/* What compares images, or shows charts, is fetched when it is first wanted. */
const { nonce } = document.currentScript, scripts = {};
function script(src) {
  return scripts[src] ||= new Promise((onload, failed) => {
    document.body.append(Object.assign(make("script"), { src, nonce, onload, onerror() { delete scripts[src]; failed(); } }));
  });
}
function openTools(isOpen) {
  if (!scripts["compare.js"]) document.head.append(Object.assign(make("link"), { rel: "stylesheet", href: "compare.css", nonce }));
  return script("compare.js").then(() => {
    byId("tools").hidden = !isOpen;
    byId("inspect").ariaExpanded = isOpen;
    refresh();
  }, noticeGone);
}
on(byId("inspect"), "click", () => openTools(byId("tools").hidden));
new ResizeObserver(fit).observe(byId("frame"));
