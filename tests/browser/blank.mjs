// Looks for cards that are mostly blank: a neighbour makes them high, and they have little to show.

/** Lower parts of a card that are blank may be this high. */
const BLANK_MAX_PX = 320;

/** Cards with more than that, and more than half of them, blank; each with its height and what is blank of it. */
export async function lookAtBlanks(page) {
  const found = await page.evaluate(blanks, BLANK_MAX_PX);
  return found.map(({ id, height, blank }) => `card ${id}: ${blank} of ${height} pixels are blank`);
}

/** Runs inside the browser and stands alone. */
function blanks(most) {
  const cards = [...document.querySelectorAll("main > .card")].filter((card) => card.offsetParent);
  const lowest = (card) => Math.max(...[...card.querySelectorAll("*")].map((one) => one.getBoundingClientRect().bottom));
  return cards
    .map((card) => ({ id: card.id, height: Math.round(card.offsetHeight), blank: Math.round(card.getBoundingClientRect().bottom - lowest(card)) }))
    .filter(({ height, blank }) => blank > most && blank > height / 2);
}
