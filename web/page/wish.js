// What the page wants to see, for a worker that is busy drawing: one integer in shared memory.
//
//     bits 0–13   level in ten-thousandths      bits 14–20   frame      bits 21–26   model
//
// It holds the newest wish only, so positions that the slider has left behind are never drawn; and one
// integer is never read half written.

import { Fd } from "./wasi/index.js";
import { MODELS } from "./models.js";

export const LEVELS = 10_000;
export const FRAMES = 72;

/** Before anything is wanted. */
const NOTHING = -1;

/** The memory for one wish. Wants a page that is isolated from other origins. */
export function mailbox() {
  return new Int32Array(new SharedArrayBuffer(4)).fill(NOTHING);
}

export function wish(mailbox, { level, frame, model }) {
  Atomics.store(mailbox, 0, (model << 21) | (frame << 14) | level);
  Atomics.notify(mailbox, 0);
}

/** Standard input that waits for wishes and tells them as `spinney step` reads them. */
export class Wishes extends Fd {
  #mailbox;
  #told = NOTHING;
  /** The model that was asked for last, and the one that shows. */
  #model;
  #begun;
  #bytes = new Uint8Array(0);
  /** When the newest one was told, in milliseconds. */
  since = 0;

  /** `model`: the number of the one that the program begins with. */
  constructor(mailbox, model) {
    super();
    this.#mailbox = mailbox;
    this.#model = this.#begun = model;
  }

  /** A session with the model that was asked for last has begun. */
  begun() {
    this.#begun = this.#model;
    // What is measured is a step, and not what comes once a model, such as baking cards.
    this.since = performance.now();
  }

  /** It cannot be had: the one before it goes on. */
  refused() {
    this.#model = this.#begun;
  }

  fd_read(size) {
    if (this.#bytes.length === 0) this.#bytes = this.#next();
    const data = this.#bytes.slice(0, size);
    this.#bytes = this.#bytes.slice(size);
    return { ret: 0, data };
  }

  #next() {
    // Returns at once where something else is wanted already.
    Atomics.wait(this.#mailbox, 0, this.#told);
    const wanted = (this.#told = Atomics.load(this.#mailbox, 0));
    const level = wanted & 0x3fff;
    const frame = (wanted >> 14) & 0x7f;
    const model = wanted >> 21;
    const change = model === this.#model ? "" : `model ${MODELS[model].label}\n`;
    this.#model = model;
    this.since = performance.now();
    return new TextEncoder().encode(`${change}${level / LEVELS} ${frame}\n`);
  }
}
