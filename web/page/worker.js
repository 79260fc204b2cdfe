// Runs the program beside the page. A job is one run of it:
//
//     { module, args, files }                     answered by { code, out, err }
//     { module, args, files, mailbox, picture }   a `step` that is told wishes; every line it says is
//                                                 answered by { line, picture, milliseconds }

import { ask, folderOf, run } from "./program.js";
import { Wishes } from "./wish.js";

self.onmessage = async ({ data: { module, args, files, mailbox, picture } }) => {
  const folder = folderOf(files);
  try {
    if (!mailbox) {
      self.postMessage(await ask(module, args, folder));
      return;
    }
    const stdin = new Wishes(mailbox, 0);
    const err = [];
    const code = await run(module, {
      args,
      folder,
      stdin,
      out: (line) => answer(line, { folder, stdin, picture }),
      err: (line) => err.push(line),
    });
    self.postMessage({ code, err: err.join("\n") });
  } catch (error) {
    self.postMessage({ code: 2, err: String(error) });
  }
};

function answer(text, { folder, stdin, picture }) {
  const line = JSON.parse(text);
  const milliseconds = performance.now() - stdin.since;
  if (line.schema) stdin.begun();
  if (line.error) stdin.refused();
  // A level is drawn; other lines tell how a session begins, or why it does not.
  if (line.level === undefined) {
    self.postMessage({ line, milliseconds });
    return;
  }
  // The program makes a new file for each picture, so this one may be given away.
  const { buffer } = picture.split("/").reduce((at, name) => at.get(name).contents ?? at.get(name), folder.dir.contents).data;
  self.postMessage({ line, milliseconds, picture: buffer }, [buffer]);
}
