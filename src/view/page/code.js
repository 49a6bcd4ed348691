/* The code of surface functions, linked to the source by lines. */
const code = { data: null, root: -1, rows: [] };
const FORMS = ["bytecode", "clif", "asm"];

function codeRow([number, content, line, site]) {
  const row = make("div", "row", make("span", "", number), make("code", "", content));
  if (!line) return row;
  const [file, at] = line.split(":").map(Number);
  row.classList.add("linked");
  row.dataset.line = line;
  row.dataset.site = site;
  row.tabIndex = -1;
  row.style.setProperty("--hue", ((file * 67 + at) * 137.508) % 360);
  row.append(make("i", "", file === code.root ? at : code.data.files[file].name.split("/").pop() + ":" + at));
  return row;
}

function fill(form, rows) {
  const content = rows.length > 0 ? rows : [make("div", "row head", "There is no code for this surface.")];
  byId(form).replaceChildren(make("div", "", ...content));
  byId(form).scrollTop = 0;
}

function showSurface(index) {
  const surface = code.data.surfaces[index];
  byId("surface").value = index;
  byId("how").hidden = !surface;
  if (!surface) { FORMS.forEach((form) => fill(form, [])); byId("details").replaceChildren(); return; }
  byId("how").textContent = surface.outcome;
  byId("how").dataset.how = surface.outcome.split(/[ ,:]/)[0];
  byId("details").replaceChildren(...surface.details.map(([what, detail]) => make("div", "", make("dt", "", what), make("dd", "", detail))));
  fill("bytecode", surface.functions.flatMap((number) => {
    const { title, lines } = code.data.functions[number];
    return [make("div", "row head", title), ...lines.map(codeRow)];
  }));
  fill("clif", surface.clif.map(codeRow));
  fill("asm", surface.asm.map(codeRow));
  code.rows = [...all("#columns .linked")];
}

function showCode(data) {
  const before = byId("surface").value;
  code.data = data;
  code.root = data.files.findIndex((file) => file.name === editor.name);
  byId("surface").replaceChildren(...data.surfaces.map((surface, index) => new Option(surface.name, index)));
  byId("hidden-rows").textContent = data.hidden;
  const native = data.surfaces.findIndex((surface) => surface.asm.length > 0);
  showSurface(data.surfaces[before] ? Number(before) : Math.max(native, 0));
}

/* Lights the rows of a line; those of the same instruction more. `from` is where the pointer is. */
function lightRows(line, site, from, scrolls) {
  for (const row of code.rows) {
    const isOf = Boolean(line) && row.dataset.line === line;
    const isSame = isOf && (row === from || Boolean(site) && row.dataset.site === site);
    row.classList.toggle("same", isSame);
    row.classList.toggle("near", isOf && !isSame);
  }
  if (!line || !scrolls) return;
  for (const form of FORMS) {
    const box = byId(form), found = box.querySelector(".same") || box.querySelector(".near");
    if (found && !box.contains(from)) box.scrollTop += found.getBoundingClientRect().top - box.getBoundingClientRect().top - box.clientHeight / 3;
  }
}

/* A line of the source is pointed at, or none. */
function lightSource(line, scrolls) {
  lightLines(line, line, false);
  lightRows(line && code.root >= 0 ? code.root + ":" + line : "", "", null, scrolls);
}

function lightFrom(row, scrolls) {
  lightRows(row ? row.dataset.line : "", row ? row.dataset.site : "", row, scrolls);
  const [file, line] = row ? row.dataset.line.split(":").map(Number) : [-1, 0];
  const isHere = row && file === code.root;
  lightLines(isHere ? line : 0, line, true);
  if (isHere && scrolls) reveal(line);
}

const columns = byId("columns");
const linked = (event) => event.target.closest(".linked");
on(columns, "mouseover", (event) => lightFrom(linked(event), false));
on(columns, "mouseleave", () => lightFrom(null));
on(columns, "click", (event) => { if (linked(event)) lightFrom(linked(event), true); });
on(byId("surface"), "change", () => showSurface(Number(byId("surface").value)));
for (const button of all("#forms button")) {
  on(button, "click", () => {
    for (const other of all("#panel [data-form]")) {
      const isChosen = other.dataset.form === button.dataset.form;
      other.classList.toggle("shown", isChosen);
      if (other.type) other.ariaPressed = isChosen;
    }
  });
}
