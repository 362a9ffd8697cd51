// Files of the station: opened where a browser may read without the token, else saved.

import { headersWith } from "./token.js";

/** Asks the station, with the token where there is one. */
export class Files {
  #token;
  #say;

  /** `say(text, bad)` tells the reader what became of a request. */
  constructor(token, say) {
    this.#token = token;
    this.#say = say;
  }

  /** The answer to a GET, or null after saying what went wrong. */
  async request(path) {
    const headers = headersWith(this.#token);
    try {
      const answer = await fetch(`/api/v1/${path}`, { headers });
      if (answer.ok) return answer;
      const problem = await answer.json();
      this.#say([problem.error, problem.hint].filter(Boolean).join("; "), true);
    } catch (error) {
      this.#say(`no answer from the station: ${error.message}`, true);
    }
    return null;
  }

  /** Opens a page in a tab of its own, and saves what is none. */
  open(path) {
    // On this machine reading needs no token; a link cannot carry one.
    const near = ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
    if (near && path.endsWith(".html")) window.open(`/api/v1/${path}`, "_blank", "noopener");
    else this.save(path);
  }

  /** Saves a file under the name the station gives it. */
  async save(path) {
    const answer = await this.request(path);
    if (!answer) return;
    const name = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition") ?? "")?.[1];
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await answer.blob());
    link.download = name ?? path.split("/").at(-1);
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    this.#say(`${link.download} saved`);
  }
}
