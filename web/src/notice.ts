//! What a request came to, in words.

import { Refused } from "./api/client.ts";
import { element, fill } from "./element.ts";

/** A place for the last refusal. */
export class Complaints {
  readonly root = element("div", { role: "alert" });

  /** Does something; where it is refused, says why and gives nothing. */
  async hear<T>(work: () => Promise<T>): Promise<T | null> {
    try {
      const done = await work();
      fill(this.root);
      return done;
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      fill(this.root, element("div", { class: "notice bad" }, element("p", {}, error.message)));
      // The button that was pressed may be a screen away.
      this.root.scrollIntoView({ block: "center" });
      return null;
    }
  }
}
