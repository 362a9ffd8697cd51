// Small steps on the document, shared by all parts of the page.

/** The element with this id; the page's own ids are known to exist. */
export const byId = (id) => document.getElementById(id);

/** Sets a text only where it changed, so that screen readers stay quiet. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Sets an attribute only where it changed; null removes it. */
export function setAttribute(element, name, value) {
  if (value === null) element.removeAttribute(name);
  else if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}

/** A new element with a class and a text. */
export function make(tag, className = "", text = "") {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text) element.textContent = text;
  return element;
}

/** One of the symbols of index.html. */
export function icon(name) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("aria-hidden", "true");
  const use = document.createElementNS(space, "use");
  use.setAttribute("href", `#i-${name}`);
  svg.append(use);
  return svg;
}

/**
 * Makes the rows of a table's body equal to `rows`, reusing what stands there. Each row is
 * `{ key, cells, className }`; a cell is a text or `{ text, className, icon, small }`.
 */
export function setRows(table, rows, headed = true) {
  const body = table.tBodies[0];
  rows.forEach((row, index) => {
    const line = body.rows[index] ?? body.insertRow();
    setAttribute(line, "data-key", row.key);
    if (line.className !== (row.className ?? "")) line.className = row.className ?? "";
    row.cells.forEach((cell, column) => fillCell(line, column, cell, headed && column === 0));
    while (line.cells.length > row.cells.length) line.deleteCell(-1);
  });
  while (body.rows.length > rows.length) body.deleteRow(-1);
}

function fillCell(line, column, cell, header) {
  const want = typeof cell === "string" ? { text: cell } : cell;
  let element = line.cells[column];
  if (!element) {
    element = make(header ? "th" : "td");
    if (header) element.scope = "row";
    line.append(element);
  }
  const mark = `${want.icon ?? ""}|${want.text}|${want.small ?? ""}`;
  if (element.dataset.mark !== mark) {
    element.dataset.mark = mark;
    element.replaceChildren(
      ...(want.icon ? [icon(want.icon)] : []),
      want.text,
      ...(want.small ? [make("small", "", want.small)] : []),
    );
  }
  if (element.className !== (want.className ?? "")) element.className = want.className ?? "";
}

/** The value of a colour variable of app.css in the present colour scheme. */
export const colour = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
