/* The charts of methods. Fetched by image.js, whose names are seen here, when the first one comes. */
"use strict";

function showChart({ diagram, size, reference, tables, marks, methods, number }) {
  const chooser = (name, shown) => {
    const button = make("button", "", shown);
    on(button, "click", () => openTools(true).then(() => tryMethod(methods[name])));
    return button;
  };
  const drawing = make("img");
  drawing.src = "file/" + number;
  drawing.alt = `Chart of ${diagram}: cost against error`;
  const grid = tables.flatMap(({ title, headings, rows, notes }) => {
    const head = make("tr", "", ...headings.map((heading) => make("th", "", heading)));
    const body = rows.map((row) => make("tr", "", ...row.map((cell, column) => make("td", "", column === 0 && methods[cell] ? chooser(cell, cell) : cell))));
    return [make("h3", "", title), make("div", "scroll", make("table", "", head, ...body), ...notes.map((note) => make("p", "", note)))];
  });
  const chosen = marks.filter(([name]) => methods[name]).map(([name, x, y]) => {
    const button = chooser(name, "");
    button.title = name;
    button.style.left = 100 * x + "%";
    button.style.top = 100 * y + "%";
    return button;
  });
  const element = make("div", "chart", make("div", "marks", drawing, ...chosen), make("div", "", ...grid, make("p", "", `Measured at ${size}; the error is the difference from ${reference}. Click a method, there or in the drawing, to render by it.`)));
  element.dataset.diagram = diagram;
  const before = byId("charts").querySelector(`[data-diagram="${diagram}"]`);
  if (before) before.replaceWith(element); else byId("charts").append(element);
  byId("no-chart").hidden = true;
}
