// Goes over the page as a reader would, and leaves what there is to see in an element.
const text = (pane, name) =>
  [...document.querySelectorAll(`#${pane} .${name} code`)].map((code) => code.textContent.trim());
const lit = () => Object.fromEntries(["source", "bytecode", "clif", "asm"].map((pane) =>
  [pane, { near: text(pane, "near"), same: text(pane, "same") }]));
const find = (pane, part) => [...document.querySelectorAll(`#${pane} .row`)]
  .find((row) => row.textContent.includes(part));
const over = (row) => row.querySelector("code").dispatchEvent(new MouseEvent("mouseover", { bubbles: true }));
const press = (key) => document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
const seen = { title: document.title, layout: getComputedStyle(document.body).display, images: document.images.length };
over(find("source", "u v mulf"));
seen.source = lit();
over(find("asm", "mulsd"));
seen.asm = lit();
document.querySelector("main").dispatchEvent(new MouseEvent("mouseleave"));
seen.nothing = lit();
find("source", "u v mulf").focus();
press("ArrowRight");
seen.focused = document.activeElement.closest(".lines").id + " " + document.activeElement.textContent;
over(find("source", "product product"));
document.querySelector("main").dispatchEvent(new MouseEvent("mouseleave"));
seen.kept = lit();
seen.names = [...document.querySelectorAll("#surface option")].map((option) => option.textContent);
const surface = document.querySelector("#surface");
surface.value = "1";
surface.dispatchEvent(new Event("change"));
seen.outcome = document.querySelector("#outcome").textContent;
seen.clif = document.querySelector("#clif").textContent;
document.querySelectorAll("#tabs button")[0].click();
seen.tabs = ["bytecode", "clif", "asm"].map((pane) =>
  document.getElementById(pane).parentElement.classList.contains("wide-only"));
const result = document.createElement("pre");
result.id = "seen";
result.textContent = encodeURIComponent(JSON.stringify(seen));
document.body.append(result);
