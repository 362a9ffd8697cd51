// The token for controls: taken from the address once, kept for this tab only.

const KEY = "asphera.token";

/** Moves `#token=…` out of the address bar into the tab's storage; gives the token or null. */
export function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    store((storage) => storage.setItem(KEY, given));
    history.replaceState(null, "", location.pathname + location.search);
    return given;
  }
  return store((storage) => storage.getItem(KEY));
}

/** Forgets the token: it was refused. */
export const forgetToken = () => store((storage) => storage.removeItem(KEY));

/** Storage can be forbidden by the browser; the page then works until it is reloaded. */
function store(use) {
  try {
    return use(sessionStorage) ?? null;
  } catch {
    return null;
  }
}
