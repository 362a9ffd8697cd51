// Chapters of the view: facts, tables and notes, worded and rounded by the daemon.

import { make, setRows, setText } from "./dom.js";

/** Fills each frame with the chapters its attribute data-chapters names, and those placed under them; a card without any may hide. */
export function showChapters({ chapters }) {
  for (const frame of document.querySelectorAll("[data-chapters]")) {
    const names = frame.dataset.chapters.split(" ");
    const blocks = chapters.filter(({ id, placed_under }) => names.includes(placed_under ?? id)).flatMap((chapter) => chapter.blocks);
    const card = frame.closest(".card");
    if (card.hasAttribute("data-hides")) card.hidden = blocks.length === 0;
    draw(frame, blocks.length ? blocks : [{ kind: "note", text: "Nothing is known yet." }]);
  }
}

/** Makes the elements of a frame equal to the blocks, reusing what stands there. */
function draw(frame, blocks) {
  blocks.forEach((block, index) => {
    let element = frame.children[index];
    if (element?.dataset.kind !== block.kind) {
      const made = MAKE[block.kind]();
      made.dataset.kind = block.kind;
      if (element) element.replaceWith(made);
      else frame.append(made);
      element = made;
    }
    FILL[block.kind](element, block);
  });
  while (frame.children.length > blocks.length) frame.lastElementChild.remove();
}

/** Rows of a table that scrolls. */
const LONG = 24;

const MAKE = {
  facts: () => withBody("pairs"),
  table: () => {
    const frame = make("div", "scroll");
    frame.tabIndex = 0;
    const table = withBody("");
    table.createTHead().insertRow();
    table.createCaption();
    frame.append(table);
    return frame;
  },
  note: () => make("p", "quiet"),
  caution: () => make("p", "bad"),
};

const FILL = {
  facts: (table, { facts }) => setRows(table, facts.map(({ name, value, note, bad }) => ({
    key: name,
    className: bad ? "bad" : "",
    cells: [name, { text: value, small: note, className: "num" }],
  }))),
  table: (frame, { title, columns, rows }) => {
    const table = frame.firstElementChild;
    setText(table.caption, title ?? "");
    frame.classList.toggle("tall", rows.length > LONG);
    const shown = columns.map(({ layout }, index) => ({ layout, index })).filter(({ layout }) => layout !== "fine");
    const fine = columns.findIndex(({ layout }) => layout === "fine");
    heads(table.tHead.rows[0], shown.map(({ index }) => columns[index]));
    setRows(table, rows.map((row, number) => ({
      key: `${number} ${row[0]}`,
      cells: shown.map(({ layout, index }, place) => ({
        text: row[index],
        // What explains a row stands in small letters below its head.
        small: place === 0 && fine >= 0 ? row[fine] : undefined,
        className: layout === "number" ? "num" : "",
      })),
    })));
  },
  note: (line, { text }) => setText(line, text),
  caution: (line, { text }) => setText(line, `Caution: ${text}`),
};

function heads(line, columns) {
  columns.forEach(({ title, layout }, index) => {
    const cell = line.cells[index] ?? line.appendChild(make("th"));
    cell.scope = "col";
    cell.className = layout === "number" ? "num" : "";
    setText(cell, title);
  });
  while (line.cells.length > columns.length) line.deleteCell(-1);
}

function withBody(className) {
  const table = make("table", className);
  table.createTBody();
  return table;
}
