"use strict";
/* What is common, and the source: a text field over a layer that colours it. */
const byId = (id) => document.getElementById(id);
const all = (selector) => document.querySelectorAll(selector);
const isNarrow = () => matchMedia("(max-width: 760px)").matches;
const on = (target, type, listener) => target.addEventListener(type, listener);
function make(tag, className, ...content) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  element.append(...content);
  return element;
}

const LINE = 19, TAB = 8, MAX_COLORED = 150000;
const text = byId("text"), layers = byId("layers"), tip = byId("tip");
const editor = { lines: [""], marks: [], name: "" };
const TOKENS = /(%[^\n]*)|("[^"\n]*"?)|(\/[A-Za-z][\w-]*)|(-?\d[\d.eE+-]*)|([A-Za-z][\w-]*)/g;
const ruler = make("span", "ruler", "0".repeat(100));
layers.append(ruler);
const KINDS = ["c", "s", "b", "n", "w"];

function colored(source) {
  const parts = document.createDocumentFragment();
  let end = 0;
  for (const match of source.matchAll(TOKENS)) {
    parts.append(source.slice(end, match.index), make("span", KINDS[match.slice(1).findIndex(Boolean)], match[0]));
    end = match.index + match[0].length;
  }
  parts.append(source.slice(end));
  return parts;
}

function redraw() {
  const source = text.value;
  editor.lines = source.split("\n");
  const isPlain = source.length > MAX_COLORED;
  text.classList.toggle("plain", isPlain);
  byId("colors").replaceChildren(isPlain ? "" : colored(source));
  byId("numbers").textContent = editor.lines.map((_, index) => index + 1).join("\n");
  follow();
}

function follow() {
  const left = text.offsetLeft + parseFloat(getComputedStyle(text).paddingLeft);
  layers.style.transform = `translate(${left - text.scrollLeft}px, ${-text.scrollTop}px)`;
  byId("numbers").style.transform = `translateY(${-text.scrollTop}px)`;
}

/* The column at which a character is shown, from 0: tabs take several. */
function shownColumn(line, column) {
  let at = 0;
  for (const c of [...(editor.lines[line - 1] || "")].slice(0, column - 1)) at += c === "\t" ? TAB - at % TAB : 1;
  return at;
}

/* Underlines what diagnostics are about. */
function mark(diagnostics) {
  const marks = [];
  for (const { message, code, spans, helps, notes } of diagnostics) {
    for (const span of spans.filter((span) => span.file === editor.name)) {
      const label = [span.primary ? (code ? code + ": " : "") + message : "", span.label, ...(span.primary ? [...notes, ...helps] : [])];
      for (let line = span.line; line <= Math.min(span.end_line, span.line + 99); line++) {
        const start = line === span.line ? shownColumn(line, span.column) : 0;
        const end = line === span.end_line ? shownColumn(line, span.end_column) : shownColumn(line, Infinity);
        marks.push({ line, start, end: Math.max(end, start + 1), primary: span.primary, label: label.filter(Boolean).join("\n") });
      }
    }
  }
  editor.marks = marks;
  byId("squiggles").replaceChildren(...marks.map((mark) => {
    const element = make("div", mark.primary ? "primary" : "", "\u00a0".repeat(mark.end - mark.start));
    element.dataset.line = mark.line;
    Object.assign(element.style, { top: (mark.line - 1) * LINE + "px", left: mark.start + "ch", width: mark.end - mark.start + "ch" });
    return element;
  }));
}

/* Lights lines, from the first to the last. */
function lightLines(first, last, isSame) {
  byId("bands").replaceChildren();
  for (let line = first; first && line <= Math.min(last, first + 400); line++) {
    const band = make("div", isSame ? "same" : "");
    band.dataset.line = line;
    band.style.top = (line - 1) * LINE + "px";
    byId("bands").append(band);
  }
}

function jump(line, column, endColumn) {
  if (isNarrow()) chooseTab("source");
  const before = editor.lines.slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0);
  const width = (n) => [...(editor.lines[line - 1] || "")].slice(0, n - 1).join("").length;
  text.focus();
  text.setSelectionRange(before + width(column || 1), before + width(endColumn || column || 1));
  reveal(line);
}

function reveal(line) {
  const top = (line - 1) * LINE;
  if (top < text.scrollTop || top > text.scrollTop + text.clientHeight - 2 * LINE) text.scrollTop = Math.max(0, top - text.clientHeight / 3);
  text.scrollLeft = 0;
  follow();
}

/* Line and shown column under the pointer. */
function under(event) {
  const box = text.getBoundingClientRect(), style = getComputedStyle(text);
  const line = Math.floor((event.clientY - box.top - parseFloat(style.paddingTop) + text.scrollTop) / LINE) + 1;
  const column = (event.clientX - box.left - parseFloat(style.paddingLeft) + text.scrollLeft) / (ruler.getBoundingClientRect().width / 100);
  return { line: line >= 1 && line <= editor.lines.length ? line : 0, column };
}

on(text, "mousemove", (event) => {
  const { line, column } = under(event);
  const labels = editor.marks.filter((mark) => mark.line === line && column >= mark.start && column < mark.end).map((mark) => mark.label);
  tip.hidden = !labels.some(Boolean);
  if (!tip.hidden) {
    tip.textContent = labels.filter(Boolean).join("\n\n");
    const pane = byId("source").getBoundingClientRect();
    tip.style.left = Math.max(4, Math.min(event.clientX - pane.left, pane.width - tip.offsetWidth - 8)) + "px";
    tip.style.top = Math.min(event.clientY - pane.top + 16, pane.height - tip.offsetHeight - 4) + "px";
  }
  lightSource(line);
});
on(text, "mouseleave", () => { tip.hidden = true; lightSource(0); });
on(text, "scroll", follow);
on(text, "click", () => lightSource(text.value.slice(0, text.selectionStart).split("\n").length, true));
on(window, "resize", follow);
