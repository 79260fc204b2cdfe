// The program: one wasm file, run in a folder that exists in memory only. The same code runs in a page's
// worker, and in Node for the build and its tests.

import { ConsoleStdout, Directory, File, PreopenDirectory, WASI } from "./wasi/index.js";

/** A folder of files in memory. `files`: path below it → text or bytes. */
export function folderOf(files) {
  const encoder = new TextEncoder();
  const root = new Map();
  for (const [path, content] of Object.entries(files)) {
    const parts = path.split("/");
    const name = parts.pop();
    let folder = root;
    for (const part of parts) {
      if (!folder.has(part)) folder.set(part, new Directory(new Map()));
      folder = folder.get(part).contents;
    }
    folder.set(name, new File(typeof content === "string" ? encoder.encode(content) : content));
  }
  return new PreopenDirectory(".", root);
}

/** Runs the program to its end and returns its exit code. `out` and `err` are given whole lines. */
export async function run(module, { args, folder, stdin, out, err }) {
  const files = [
    stdin ?? new ConsoleStdout(() => {}),
    ConsoleStdout.lineBuffered(out),
    ConsoleStdout.lineBuffered(err),
    folder,
  ];
  // Unless told not to, the shim writes every call to the console.
  const wasi = new WASI(["spinney", ...args], ["NO_COLOR=1"], files, { debug: false });
  const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: wasi.wasiImport });
  return wasi.start(instance);
}

/** The same with all that it says at once: { code, out, err }. */
export async function ask(module, args, folder) {
  const said = { out: [], err: [] };
  const code = await run(module, {
    args,
    folder,
    out: (line) => said.out.push(line),
    err: (line) => said.err.push(line),
  });
  return { code, out: said.out.join("\n"), err: said.err.join("\n") };
}
