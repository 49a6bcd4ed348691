/* The connection: what the server tells, and what it is asked for. */
const DEBOUNCE = 150;
const told = document.body.dataset;
const live = { synced: null, revision: 0, canEdit: false, timer: 0, diskText: null };

function status(state, words) {
  byId("status").dataset.state = state;
  byId("status").textContent = words;
}

function notice(words, canTake) {
  byId("notice").hidden = !words;
  byId("notice-text").textContent = words || "";
  byId("take").hidden = !canTake;
}

const noticeGone = () => notice("gmlvm view does not answer.");
async function post(path, body) {
  const response = await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }).catch(() => null);
  const answer = response ? await response.json().catch(() => ({})) : { error: "the server does not answer" };
  if (!response || !response.ok) throw new Error(answer.error || "refused");
  return answer;
}

const selects = { engine: byId("engine"), precision: byId("precision"), sampling: byId("sampling") };
const chosen = () => ({ engine: selects.engine.value, precision: selects.precision.value, sampling: selects.sampling.value });
function choose(choice) {
  for (const [name, select] of Object.entries(selects)) {
    if (![...select.options].some((option) => option.value === choice[name])) select.add(new Option(choice[name], choice[name]));
    select.value = choice[name];
  }
  selects.sampling.disabled = choice.precision === "certified";
}

function render() {
  clearTimeout(live.timer);
  live.synced = text.value;
  post("run", { text: text.value, choice: chosen() }).catch((error) => notice(`Not rendered: ${error.message}.`));
}

/* As text fields have it: without carriage returns. */
const plain = (source) => source.replaceAll("\r\n", "\n");
function setText(source) {
  if (source === text.value) return;
  const { selectionStart, selectionEnd, scrollTop, scrollLeft } = text;
  text.value = source;
  text.setSelectionRange(selectionStart, selectionEnd);
  Object.assign(text, { scrollTop, scrollLeft });
  redraw();
}

function showDirty() {
  byId("dirty").hidden = live.diskText === null || text.value === live.diskText;
}

async function save() {
  if (!live.canEdit) return notice("Not saved: the page may only write the file if gmlvm view is started with --edit.");
  try {
    live.revision = (await post("save", { text: live.hasCrs ? text.value.replaceAll("\n", "\r\n") : text.value, revision: live.revision })).revision;
    notice("");
  } catch (error) {
    notice(`Not saved: ${error.message}.`);
  }
}

on(text, "input", () => {
  redraw();
  mark([]);
  showDirty();
  clearTimeout(live.timer);
  live.timer = setTimeout(render, DEBOUNCE);
});
on(window, "keydown", (event) => {
  if ((event.ctrlKey || event.metaKey) && event.key === "s") { event.preventDefault(); save(); }
});
for (const select of Object.values(selects)) on(select, "change", () => { choose(chosen()); render(); });
on(byId("dismiss"), "click", () => notice(""));
on(byId("take"), "click", () => { setText(live.diskText); notice(""); showDirty(); render(); });

function chooseTab(name) {
  told.tab = name;
  for (const tab of all("[role=tab]")) tab.ariaSelected = tab.dataset.tab === name;
  for (const page of all(".page")) page.hidden = page.dataset.page !== name;
  follow();
}
for (const tab of all("[role=tab]")) on(tab, "click", () => chooseTab(tab.dataset.tab));

function showProblems(diagnostics) {
  mark(diagnostics);
  byId("count").hidden = diagnostics.length === 0;
  byId("count").textContent = diagnostics.length;
  byId("fine").hidden = diagnostics.length > 0;
  byId("problems").replaceChildren(...diagnostics.map(({ code, message, spans, trace, notes, helps }) => {
    const button = make("button", "", make("b", "", message), " ");
    const span = spans.find((span) => span.primary);
    button.append(make("code", "", [code, span && `${span.file}:${span.line}:${span.column}`].filter(Boolean).join(" · ")));
    const calls = trace.map((call) => `called at ${call.file}:${call.line}:${call.column} in ${call.within}` + (call.repeats > 1 ? `, ${call.repeats - 1} times more` : ""));
    const labels = spans.filter((span) => span.label).map((span) => `${span.line}: ${span.label}`);
    for (const line of [...labels, ...calls, ...notes, ...helps]) button.append(make("span", "", line));
    const here = spans.find((span) => span.file === editor.name && span.primary) || spans.find((span) => span.file === editor.name);
    on(button, "click", () => { if (here) jump(here.line, here.column, here.line === here.end_line ? here.end_column : here.column); });
    return make("li", "", button);
  }));
}

/* JSON has the keys of an object in any order. */
const PHASES = ["read", "compile", "run", "build", "jit", "trace", "write"];
const RAYS = ["primary", "reflected", "shadow", "shadow_blocked", "surface_calls"];
const seconds = (t) => t >= 1 ? t.toFixed(2) + " s" : (1000 * t).toFixed(t < 0.01 ? 2 : 1) + " ms";
function table(caption, rows) {
  const body = make("tbody");
  for (const [name, value, share] of rows) {
    const row = make("tr", "", make("th", "", name.replaceAll("_", " ")), make("td", "", typeof value === "number" ? value.toLocaleString("fr") : value));
    if (share !== undefined) {
      const bar = make("div", "share");
      bar.style.width = 100 * share + "%";
      row.append(make("td", "", bar));
    }
    body.append(row);
  }
  return make("table", "", make("caption", "", caption), body);
}

function showStats({ total, phases, counts, rays, threads, engine, precision, sampling, images }) {
  const longest = Math.max(...Object.values(phases), 1e-6);
  byId("stats").replaceChildren(
    table("Phases", [...PHASES.map((name) => [name, seconds(phases[name]), phases[name] / longest]), ["total", seconds(total), 0]]),
    table("Rays", RAYS.map((name) => [name, rays[name]])),
    table("Counts", [...Object.entries(counts), ["threads", threads], ["engine", engine], ["numbers", precision], ["samples", sampling]]),
    ...images.map((image, index) => table(images.length > 1 ? `Image ${index + 1}` : "Image", Object.entries(image).filter(([, value]) => value !== null && typeof value !== "object").map(([name, value]) => [name, PHASES.includes(name) ? seconds(value) : value]))));
}

const handlers = {
  source({ name, text: onDisk, revision, edit }) {
    const source = plain(onDisk);
    editor.name = name;
    byId("name").textContent = name;
    document.title = name + " – gmlvm";
    const isOurs = live.synced !== null && text.value !== live.diskText && text.value !== source;
    Object.assign(live, { revision, canEdit: edit, diskText: source, hasCrs: source !== onDisk });
    if (isOurs) notice("The file has been changed by another program.", true);
    else { setText(source); live.synced = source; notice(""); }
    showDirty();
  },
  disk({ error }) { notice(`Of ${editor.name}, ${error}.`); },
  started({ run, choice, text: source }) {
    if (source !== undefined && text.value === live.synced) { setText(source); live.synced = source; showDirty(); }
    view.run = run;
    choose(choice);
    status("busy", "rendering");
  },
  image({ run, image, name, width, height }) { Object.assign(imagesOf(run)[image] ||= {}, { name, width, height }); },
  coarse: onDraft,
  band: onDraft,
  picture: onPicture,
  known: onKnown,
  plan({ image, lines }) {
    const plans = byId("plan");
    if (image === 0 || !plans.parts) plans.parts = [];
    plans.parts[image] = lines;
    plans.textContent = plans.parts.map((lines, index) => (plans.parts.length > 1 ? `Image ${index + 1}\n` : "") + lines.join("\n")).join("\n\n");
  },
  stats({ stats }) { showStats(stats); live.total = stats.total; },
  async code({ number }) {
    const response = await fetch("file/" + number);
    if (response.status === 200) showCode(await response.json());
  },
  chart(message) { script("chart.js").then(() => showChart(message), noticeGone); },
  ended({ run, ok, n, diagnostics }) {
    told.run = run;
    showProblems(diagnostics || []);
    onEnd(run, ok);
    if (ok) status("good", n === 0 ? "no image" : `rendered in ${seconds(live.total)}`);
    else status("bad", diagnostics.length === 1 ? "1 problem" : `${diagnostics.length} problems`);
  },
};

function connect() {
  const events = new EventSource("events");
  /* After a loss of the connection everything is told again. */
  let last = 0, known = 0;
  on(events, "open", () => { known = last; notice(""); });
  on(events, "message", ({ data }) => {
    const message = JSON.parse(data);
    if (message.number <= known) return;
    last = Math.max(last, message.number);
    if (message.run === 0 || message.run >= view.run || message.event === "started") handlers[message.event]?.(message);
    told.revision = live.revision;
  });
  on(events, "error", noticeGone);
}

on(byId("status"), "click", () => chooseTab("problems"));
chooseTab(isNarrow() ? "source" : "code");
redraw();
connect();
