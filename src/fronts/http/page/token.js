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

/** Headers of a request with the token, if there is one. */
export const headersWith = (token) => (token ? { Authorization: `Bearer ${token}` } : {});

/** What the station answers as JSON: null where it has none; undefined where it is gone, as the stream tells: the next snapshot asks again. */
export async function askStation(path, token) {
  try {
    const answer = await fetch(path, { headers: headersWith(token) });
    return answer.ok ? await answer.json() : null;
  } catch {
    return undefined;
  }
}

/** Storage can be forbidden by the browser; the page then works until it is reloaded. */
function store(use) {
  try {
    return use(sessionStorage) ?? null;
  } catch {
    return null;
  }
}
