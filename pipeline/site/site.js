// Tables that sort and filter, a theme, addresses of numbers, tips of figures. Without it all is there and readable.
"use strict";

const root = document.documentElement;

function stored(value) {
  try {
    if (value !== undefined) localStorage.setItem("theme", value);
    return localStorage.getItem("theme");
  } catch (error) {
    return null; // a page from disk may not keep anything
  }
}

function isDark() {
  const chosen = root.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function theme() {
  const button = document.getElementById("theme");
  if (["light", "dark"].includes(stored())) root.dataset.theme = stored();
  const name = () => {
    button.textContent = isDark() ? "light" : "dark";
    button.setAttribute("aria-label", `switch to ${button.textContent} colours`);
  };
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    stored(root.dataset.theme);
    name();
  });
  button.hidden = false;
  name();
}

// What a cell sorts by: its number, that of its text, or its text; nothing sorts last.
function key(cell) {
  const text = cell.textContent.trim();
  if (text === "–" || text === "") return null;
  if (cell.dataset.v !== undefined) return Number(cell.dataset.v);
  const number = Number(text.replace(/,/g, "").replace("−", "-").replace(/^[<+] ?/, "").replace(/ ?%$/, ""));
  return Number.isNaN(number) ? text.toLowerCase() : number;
}

function compare(a, b) {
  if (typeof a === "number" && typeof b === "number") return a - b;
  return String(a).localeCompare(String(b), undefined, { numeric: true });
}

function sort(table, column, head) {
  const up = head.getAttribute("aria-sort") !== "ascending";
  for (const other of table.querySelectorAll("th[aria-sort]")) other.setAttribute("aria-sort", "none");
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
  const body = table.tBodies[0];
  const rows = [...body.rows].map((row) => [key(row.cells[column]), row]);
  rows.sort(([a], [b]) => {
    if (a === null || b === null) return (a === null) - (b === null);
    return up ? compare(a, b) : compare(b, a);
  });
  body.append(...rows.map(([, row]) => row));
}

function sortable(table) {
  const heads = table.tHead.rows[table.tHead.rows.length - 1].cells;
  [...heads].forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
    head.addEventListener("click", () => sort(table, column, head));
  });
}

function filterable(form) {
  const table = document.querySelector(`table[data-name="${CSS.escape(form.dataset.for)}"]`);
  const search = form.querySelector("input");
  const menus = [...form.querySelectorAll("select")];
  const said = form.querySelector("output");
  const apply = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const row of table.tBodies[0].rows) {
      const text = row.textContent.toLowerCase();
      const fits = words.every((word) => text.includes(word)) &&
        menus.every((menu) => !menu.value || row.cells[menu.dataset.column].textContent.trim() === menu.value);
      row.hidden = !fits;
      shown += fits;
    }
    const all = table.tBodies[0].rows.length;
    said.textContent = shown === all ? `${all} rows` : `${shown} of ${all} rows`;
  };
  form.addEventListener("input", apply);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.hidden = false;
}

// Of charts that share a group one is shown, and a menu above them says which.
function switchable(group) {
  const charts = [...document.querySelectorAll(`.chart[data-group="${CSS.escape(group)}"]`)];
  if (charts.length < 2) return;
  const form = document.createElement("form");
  form.className = "tools show";
  const label = document.createElement("label");
  const menu = document.createElement("select");
  charts.forEach((chart, i) => menu.append(new Option(chart.dataset.choice, i)));
  label.append("show ", menu);
  form.append(label);
  charts[0].before(form);
  const show = () => charts.forEach((chart, i) => { chart.hidden = i !== Number(menu.value); });
  menu.addEventListener("change", show);
  const aim = () => {
    const i = charts.findIndex((chart) => `#${chart.id}` === location.hash);
    if (i >= 0) { menu.value = i; show(); charts[i].scrollIntoView(); }
  };
  addEventListener("hashchange", aim);
  show();
  aim();
}

// A number is addressed by its id: a click puts the address into the bar and marks the cell.
function addressable() {
  const mark = () => {
    for (const cell of document.querySelectorAll("td.here")) cell.classList.remove("here");
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    const folded = target.closest("details");
    if (folded) folded.open = true;
    if (target.matches("td")) target.classList.add("here");
    if (folded || target.matches("td")) target.scrollIntoView({ block: "center", inline: "center" });
  };
  document.addEventListener("click", (event) => {
    const cell = event.target.closest("td[id]");
    if (!cell || event.target.closest("a") || String(getSelection())) return;
    history.replaceState(null, "", `#${encodeURIComponent(cell.id)}`);
    for (const other of document.querySelectorAll("td.here")) other.classList.remove("here");
    cell.classList.add("here");
  });
  addEventListener("hashchange", mark);
  mark();
}

function tips() {
  const tip = document.createElement("div");
  tip.id = "tip";
  tip.hidden = true;
  document.body.append(tip);
  const show = (mark, x, y) => {
    tip.textContent = mark.dataset.tip;
    tip.hidden = false;
    tip.style.left = `${Math.max(8, Math.min(x + 14, innerWidth - tip.offsetWidth - 8))}px`;
    tip.style.top = `${Math.max(8, y - tip.offsetHeight - 12)}px`;
  };
  for (const mark of document.querySelectorAll("[data-tip]")) {
    mark.querySelector("title")?.remove(); // the browser's own tip would come as well
    mark.setAttribute("role", "img");
    mark.setAttribute("aria-label", mark.dataset.tip);
    mark.addEventListener("pointermove", (event) => show(mark, event.clientX, event.clientY));
    mark.addEventListener("pointerleave", () => { tip.hidden = true; });
    mark.addEventListener("focus", () => {
      const box = mark.getBoundingClientRect();
      show(mark, box.left, box.top);
    });
    mark.addEventListener("blur", () => { tip.hidden = true; });
  }
}

theme();
document.querySelectorAll("table[data-name]").forEach(sortable);
document.querySelectorAll("form.tools[data-for]").forEach(filterable);
new Set([...document.querySelectorAll(".chart[data-group]")].map((chart) => chart.dataset.group)).forEach(switchable);
addressable();
tips();
