// Builds the page into dist/: node build.mjs [PROGRAM.wasm]
//
// Without a program it is built as `.ci/cross` builds it, so that the page runs the very file whose digests
// are checked there. All else is copied; nothing is bundled or minified.

import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { cpSync, mkdirSync, readFileSync, readdirSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { basename, join, relative } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const here = fileURLToPath(new URL(".", import.meta.url));
const root = join(here, "..");
const dist = join(here, "dist");
const making = join(here, "dist.making");

/** Golden scenes that the page draws by itself, to be held against `golden/digests.txt`. */
const GOLDEN = ["lodf/slots_variable", "cards/impostors", "digest/yew"];

const program = process.argv[2] ?? built();

rmSync(making, { recursive: true, force: true });
mkdirSync(making);
cpSync(join(here, "page"), making, { recursive: true });
cpSync(join(here, "node_modules/@bjorn3/browser_wasi_shim/dist"), join(making, "wasi"), {
  recursive: true,
  filter: (file) => !file.endsWith(".tsbuildinfo"),
});
cpSync(program, join(making, "spinney.wasm"));

const { ask, folderOf } = await import(pathToFileURL(join(making, "program.js")));
const module = await WebAssembly.compile(readFileSync(program));

const species = {};
for (const file of filesBelow(join(root, "scenes/species"))) {
  species[relative(root, file)] = readFileSync(file, "utf8");
}
const golden = Object.fromEntries(
  GOLDEN.map((name) => [`scenes/golden/${name}.toml`, readFileSync(join(root, `scenes/golden/${name}.toml`), "utf8")]),
);
const committed = readFileSync(join(root, "golden/digests.txt"), "utf8").split("\n");
const digests = GOLDEN.map((name) => {
  const line = committed.find((line) => line.startsWith(`${name} `));
  if (!line) throw new Error(`golden/digests.txt has no ${name}`);
  return line;
});

// What there is to choose from, told by the program itself.
const plants = [];
for (const path of Object.keys(species).filter((path) => !path.includes("/young/"))) {
  const { code, out, err } = await ask(module, ["inspect", "--json", path], folderOf(species));
  if (code !== 0) throw new Error(`inspect ${path}: ${err}`);
  const { name, latin, leaves, size_m, center_m } = JSON.parse(out);
  // Those that are all needles have no leaves to collapse.
  if (leaves > 0) plants.push({ path, name, latin, leaves, size_m, center_m });
}
plants.sort((a, b) => a.leaves - b.leaves || (a.path < b.path ? -1 : 1));

writeFileSync(join(making, "data.json"), JSON.stringify({ plants, species, golden, digests }));

// What the service worker keeps; its version is that of all files together.
const files = filesBelow(making).map((file) => relative(making, file));
const hash = createHash("sha256");
for (const file of files) hash.update(`${file}\n`).update(readFileSync(join(making, file)));
const kept = ["./", ...files.filter((file) => file !== "service.js")];
const bundle = { version: hash.digest("hex").slice(0, 16), files: kept };
writeFileSync(join(making, "bundle.js"), `self.BUNDLE = ${JSON.stringify(bundle)};\n`);

rmSync(dist, { recursive: true, force: true });
renameSync(making, dist);
console.log(`web/dist: ${files.length + 1} files, ${plants.length} species, ${basename(program)}`);

/** The program as CI has it. */
function built() {
  const command = [join(root, ".ci/cross"), "--build", "--target", "wasm32-wasip1"];
  const said = execFileSync(command[0], command.slice(1), { encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
  return said.trim().split("\n").pop();
}

/** All files below a folder, in order. */
function filesBelow(folder) {
  return readdirSync(folder, { withFileTypes: true })
    .sort((a, b) => (a.name < b.name ? -1 : 1))
    .flatMap((entry) => {
      const path = join(folder, entry.name);
      return entry.isDirectory() ? filesBelow(path) : [path];
    });
}
