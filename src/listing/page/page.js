"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const panes = ["source", "bytecode", "clif", "asm"];
const byId = (id) => document.getElementById(id);

function make(tag, className, text) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text !== undefined) element.textContent = text;
  return element;
}

/* A row with a number, a text, the source line and the bytecode instruction it belongs to. */
function row(number, text, line, site) {
  const element = make("div", "row");
  element.append(make("span", "", number), make("code", "", text));
  if (line) {
    element.classList.add("linked");
    element.dataset.line = line;
    if (site) element.dataset.site = site;
    const [file, at] = line.split(":").map(Number);
    element.style.setProperty("--hue", String(((file * 67 + at) * 137.508) % 360));
    element.tabIndex = -1;
  }
  return element;
}

function head(text) {
  return make("div", "row head", text);
}

function fill(pane, rows, otherwise) {
  const box = make("div", "rows");
  box.append(...(rows.length > 0 ? rows : [make("div", "none", otherwise)]));
  byId(pane).replaceChildren(box);
  byId(pane).scrollTop = 0;
  const first = box.querySelector(".linked");
  if (first) first.tabIndex = 0;
}

function sourceRows(used) {
  const rows = [];
  data.files.forEach((file, index) => {
    if (![...used].some((line) => line.startsWith(index + ":"))) return;
    rows.push(head(file.name));
    let before = 0;
    for (const [number, text] of file.lines) {
      if (number !== before + 1) rows.push(head("\u22ef"));
      before = number;
      const line = index + ":" + number;
      rows.push(row(String(number), text, used.has(line) ? line : "", ""));
    }
  });
  return rows;
}

function show(surface) {
  active = null;
  byId("outcome").textContent = surface.outcome;
  byId("details").replaceChildren(...surface.details.map(([what, detail]) => {
    const pair = make("div");
    pair.append(make("dt", "", what), make("dd", "", detail));
    return pair;
  }));
  const bytecode = surface.functions.flatMap((index) => {
    const { title, lines } = data.functions[index];
    return [head(title), ...lines.map((line) => row(...line))];
  });
  const clif = surface.clif.map((line) => row(...line));
  const asm = surface.asm.map((line) => row(...line));
  const used = new Set([...bytecode, ...clif, ...asm].map((line) => line.dataset.line).filter(Boolean));
  fill("source", sourceRows(used), "There is no source text.");
  fill("bytecode", bytecode, "");
  fill("clif", clif, "There is no code for this surface.");
  fill("asm", asm, "There is no code for this surface.");
  const first = byId("source").querySelector(".linked");
  if (first) scrollTo(byId("source"), first);
}

/* Brings a row of a pane into the upper part of it. */
function scrollTo(pane, chosen) {
  pane.scrollTop += chosen.getBoundingClientRect().top - pane.getBoundingClientRect().top - pane.clientHeight / 3;
}

/* The row that stays lit while the pointer is elsewhere. */
let active = null;

function light(chosen) {
  for (const element of document.querySelectorAll(".near, .same")) {
    element.classList.remove("near", "same");
  }
  if (!chosen) return;
  const { line, site } = chosen.dataset;
  for (const element of document.querySelectorAll(".linked")) {
    if (element.dataset.line !== line) continue;
    element.classList.add(element === chosen || (site && element.dataset.site === site) ? "same" : "near");
  }
}

function bringIntoView(chosen) {
  for (const pane of panes) {
    const box = byId(pane);
    if (box.contains(chosen)) continue;
    const found = box.querySelector(".same") || box.querySelector(".near");
    if (found && box.offsetParent) scrollTo(box, found);
  }
}

const linked = (event) => event.target instanceof Element ? event.target.closest(".linked") : null;
const main = document.querySelector("main");
main.addEventListener("mouseover", (event) => light(linked(event) || active));
main.addEventListener("mouseleave", () => light(active));
main.addEventListener("click", (event) => { const chosen = linked(event); if (chosen) chosen.focus(); });
main.addEventListener("focusin", (event) => {
  const chosen = linked(event);
  if (!chosen) return;
  const pane = chosen.closest(".lines");
  for (const element of pane.querySelectorAll('.linked[tabindex="0"]')) element.tabIndex = -1;
  chosen.tabIndex = 0;
  active = chosen;
  light(chosen);
  bringIntoView(chosen);
});
main.addEventListener("keydown", (event) => {
  const chosen = linked(event);
  if (!chosen) return;
  const pane = chosen.closest(".lines");
  let next = null;
  if (event.key === "ArrowDown" || event.key === "ArrowUp") {
    const rows = [...pane.querySelectorAll(".linked")];
    next = rows[rows.indexOf(chosen) + (event.key === "ArrowDown" ? 1 : -1)];
  } else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
    const step = event.key === "ArrowRight" ? 1 : -1;
    for (let at = panes.indexOf(pane.id) + step; panes[at] && !next; at += step) {
      const box = byId(panes[at]);
      if (box.offsetParent) next = box.querySelector(".same") || box.querySelector(".near");
    }
  } else if (event.key === "Escape") {
    active = null;
    light(null);
  }
  if (next) {
    event.preventDefault();
    next.focus();
  }
});

for (const button of document.querySelectorAll("#tabs button")) {
  button.addEventListener("click", () => {
    for (const other of document.querySelectorAll("#tabs button")) {
      const isChosen = other === button;
      other.setAttribute("aria-pressed", String(isChosen));
      byId(other.dataset.pane).parentElement.classList.toggle("wide-only", !isChosen);
    }
    if (active) bringIntoView(active);
  });
}

const select = byId("surface");
select.append(...data.surfaces.map((surface, index) => new Option(surface.name, String(index))));
select.addEventListener("change", () => show(data.surfaces[select.value]));
byId("hidden").textContent = data.hidden;
if (data.surfaces.length > 0) {
  const first = data.surfaces.findIndex((surface) => surface.asm.length > 0);
  select.value = String(Math.max(first, 0));
  show(data.surfaces[select.value]);
} else {
  fill("source", [], "This program renders no surfaces.");
}
