// Serves the built page: node serve.mjs [PORT], by default 8000. Any static server does; this one also says
// that the page is isolated, which spares the first visit a reload.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = {
  ".html": "text/html; charset=utf-8",
  ".css": "text/css; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".json": "application/json",
  ".svg": "image/svg+xml",
  ".wasm": "application/wasm",
};

export const ISOLATED = {
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
};

/** A server of a folder's files; port 0 takes any that is free. */
export function serve(folder, port, headers = ISOLATED) {
  const server = createServer(async (request, response) => {
    try {
      const { pathname } = new URL(request.url, "http://localhost");
      // Normalized from the root, so that no `..` leads out of the folder.
      const path = normalize(join("/", decodeURIComponent(pathname)));
      const file = join(folder, path.endsWith("/") ? join(path, "index.html") : path);
      const body = await readFile(file);
      response.writeHead(200, { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream", ...headers });
      response.end(body);
    } catch {
      response.writeHead(404, { "Content-Type": "text/plain", ...headers });
      response.end("not found\n");
    }
  });
  return new Promise((resolve, reject) => {
    server.once("error", reject);
    server.listen(port, "127.0.0.1", () => resolve(server));
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const dist = fileURLToPath(new URL("dist", import.meta.url));
  const server = await serve(dist, Number(process.argv[2] ?? 8000));
  console.log(`http://localhost:${server.address().port}/`);
}
