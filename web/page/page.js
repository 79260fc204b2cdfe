// The page: choices in, wishes to the worker, answers to figures.

import { MODELS } from "./models.js";
import { SIDE, sceneText } from "./scene.js";
import { FRAMES, LEVELS, mailbox, wish } from "./wish.js";

const at = (id) => document.getElementById(id);

const LINKS = { agp8x: "AGP 8x", pcie1x16: "PCIe 1.0 x16", pcie3x16: "PCIe 3.0 x16", pcie5x16: "PCIe 5.0 x16" };
const FIRST_TREE = "scenes/species/taxus_baccata.toml";

/** Where the program puts each picture: a folder of its own, since it looks for what was left beside it. */
const PICTURE = "out/picture.rgba";

/** Steps of the walk from all leaves to the fewest. */
const WALK_STEPS = 20;

/** Endings of files that hold a tree; what else is dropped with one lies beside it, such as its pictures. */
const TREE_FILE = /\.(glb|gltf)$/i;

let data, module;
/** The run of the program that shows: { worker, memory, leaves, row, waiting }. */
let stage;
/** Files that somebody opened: path → bytes, and the tree among them. */
let own;

start().catch((error) => say(String(error), true));

async function start() {
  if (!self.crossOriginIsolated) {
    await isolate();
    return;
  }
  keepForLater();
  fill(at("link"), Object.entries(LINKS).map(([value, text]) => ({ value, text })), "pcie1x16");
  fill(at("model"), MODELS.map(({ name }, value) => ({ value, text: name })), 0);
  const program = fetch("spinney.wasm").then(WebAssembly.compileStreaming);
  data = await (await fetch("data.json")).json();
  listTrees(FIRST_TREE);
  restore();
  module = await program;
  listen();
  await begin();
}

// ---- what the browser has to allow --------------------------------------------------------------

/** Lets the service worker say what the server did not, and loads the page once more. */
async function isolate() {
  const hopeless = "This browser shares no memory between a page and its workers, which the page needs. "
    + "Serve it from localhost or by HTTPS.";
  if (!navigator.serviceWorker || sessionStorage.isolating) {
    delete sessionStorage.isolating;
    say(hopeless, true);
    return;
  }
  sessionStorage.isolating = "once";
  await navigator.serviceWorker.register("service.js");
  await navigator.serviceWorker.ready;
  location.reload();
}

function keepForLater() {
  delete sessionStorage.isolating;
  // Without it the page works as long as there is a network.
  navigator.serviceWorker?.register("service.js").catch(() => {});
}

// ---- choices -------------------------------------------------------------------------------------

function fill(select, options, chosen) {
  select.replaceChildren(...options.map(({ value, text }) => new Option(text, value, false, value === chosen)));
}

function listTrees(chosen) {
  const species = data.plants.map((plant) => ({
    value: plant.path,
    text: `${plant.latin ?? plant.name}, ${count(plant.leaves)} leaves`,
  }));
  fill(at("tree"), [...(own ? [{ value: own.file, text: own.file }] : []), ...species], chosen);
}

/** Choices that a link to this page carries. */
function restore() {
  const given = new URLSearchParams(location.hash.slice(1));
  const tree = data.plants.find(({ path }) => path.endsWith(`/${given.get("tree")}`));
  if (tree) at("tree").value = tree.path;
  const model = MODELS.findIndex(({ label }) => label === given.get("model"));
  if (model >= 0) at("model").value = model;
  if (given.get("link") in LINKS) at("link").value = given.get("link");
  for (const id of ["level", "turn"]) {
    if (given.has(id)) at(id).value = Number(given.get(id)) || 0;
  }
}

function remember() {
  const choices = new URLSearchParams({
    tree: at("tree").value.split("/").pop(),
    model: MODELS[at("model").value].label,
    link: at("link").value,
    level: at("level").value,
    turn: at("turn").value,
  });
  history.replaceState(null, "", `#${choices}`);
}

function listen() {
  for (const id of ["level", "turn", "model"]) {
    at(id).addEventListener("input", () => {
      delete stage.refused;
      want();
    });
  }
  for (const id of ["tree", "link"]) at(id).addEventListener("change", begin);
  at("choices").addEventListener("submit", (event) => event.preventDefault());
  at("walk").addEventListener("click", walk);
  at("file").addEventListener("change", () => open(at("file").files));
  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) document.body.classList.remove("dropping");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    open(event.dataTransfer.files);
  });
  turnByDragging(at("picture"));
}

/** Dragging the picture turns the tree: once around along its width. */
function turnByDragging(picture) {
  let from;
  picture.addEventListener("pointerdown", (event) => {
    from = { x: event.clientX, turn: Number(at("turn").value) };
    picture.setPointerCapture(event.pointerId);
  });
  picture.addEventListener("pointermove", (event) => {
    if (!picture.hasPointerCapture(event.pointerId)) return;
    const by = Math.round(((from.x - event.clientX) / picture.clientWidth) * FRAMES);
    at("turn").value = (((from.turn + by) % FRAMES) + FRAMES) % FRAMES;
    want();
  });
}

async function open(files) {
  const list = [...files];
  const tree = list.find(({ name }) => TREE_FILE.test(name)) ?? list[0];
  if (!tree) return;
  const contents = await Promise.all(list.map((file) => file.arrayBuffer()));
  own = {
    file: tree.name,
    files: Object.fromEntries(list.map(({ name }, number) => [name, new Uint8Array(contents[number])])),
  };
  at("file").value = "";
  listTrees(own.file);
  await begin();
}

// ---- the program ---------------------------------------------------------------------------------

/** Runs the program to its end beside the page: { code, out, err }. */
function inBackground(args, files) {
  const worker = new Worker("worker.js", { type: "module" });
  return new Promise((resolve, reject) => {
    worker.onmessage = ({ data }) => resolve(data);
    worker.onerror = (event) => reject(new Error(event.message));
    worker.postMessage({ module, args, files });
  }).finally(() => worker.terminate());
}

/** Begins anew with the chosen tree. */
async function begin() {
  stage?.worker.terminate();
  stage?.waiting?.();
  const mine = (stage = { worker: new Worker("worker.js", { type: "module" }), memory: mailbox() });
  const chosen = at("tree").value;
  const isOwn = chosen === own?.file;
  say(isOwn ? `Reading ${chosen} …` : "Growing the tree and collapsing its leaves …");
  at("tried").replaceChildren();
  at("digest").textContent = "–";
  at("picture").classList.add("past");
  let tree = { ...data.plants.find(({ path }) => path === chosen), species: chosen };
  const files = { ...(isOwn ? own.files : data.species) };
  if (isOwn) {
    const { code, out, err } = await inBackground(["inspect", "--json", chosen], files);
    if (stage !== mine) return;
    if (code !== 0) return say(err, true);
    tree = { ...JSON.parse(out), file: chosen };
    say([`Collapsing ${count(tree.leaves)} leaves …`, ...tree.remarks].join("\n"));
  }
  const background = getComputedStyle(document.documentElement).getPropertyValue("--sky").trim();
  files["scene.toml"] = sceneText({ tree, link: at("link").value, background });
  mine.worker.onmessage = ({ data }) => stage === mine && take(data);
  mine.worker.onerror = (event) => say(event.message, true);
  mine.worker.postMessage({
    module,
    args: ["step", "scene.toml", "-o", PICTURE],
    files,
    mailbox: mine.memory,
    picture: PICTURE,
  });
  want();
}

/** Tells the worker what is wanted now. */
function want() {
  at("level-text").value = `${(at("level").value / 10).toFixed(1)} %`;
  at("turn-text").value = `${at("turn").value * (360 / FRAMES)}°`;
  at("about").textContent = MODELS[at("model").value].about;
  remember();
  wish(stage.memory, {
    level: Math.round((at("level").value / at("level").max) * LEVELS),
    frame: Number(at("turn").value),
    model: Number(at("model").value),
  });
  // Most answers are there before anybody could read this.
  clearTimeout(stage.busy);
  if (stage.sums) stage.busy = setTimeout(() => say("Drawing …"), 700);
}

/** What the worker says. */
function take({ line, picture, milliseconds, code, err }) {
  clearTimeout(stage.busy);
  if (line?.schema) return beginSession(line);
  if (picture) return show(line, picture, milliseconds);
  // The model that was asked for cannot be had; the one before it shows.
  if (line?.error) return refuse(line.error);
  if (code !== 0) say(err || `the program ended with ${code}`, true);
}

/** A session begins: a model is resident, at full detail. */
function beginSession(line) {
  // A session that was left before it drew anything makes room.
  const row = stage.row?.cells.length === 0 ? stage.row : at("tried").insertRow();
  for (const other of at("tried").rows) other.classList.toggle("now", other === row);
  const { initial, leaves } = line;
  Object.assign(stage, {
    leaves,
    link: LINKS[line.link] ?? line.link,
    sums: { model: line.model, initial: initial.upload.payload_bytes, changes: 0, bytes: 0, transfers: 0, fetched: 0, ns: 0 },
    row,
  });
}

/** Says why a model cannot be had, and goes on with the one that shows. */
function refuse(error) {
  const shown = MODELS.findIndex(({ label }) => label === stage.sums.model);
  if (shown >= 0) at("model").value = shown;
  want();
  say(error, true);
  stage.refused = error;
}

function show(line, picture, milliseconds) {
  const context = at("picture").getContext("2d");
  at("picture").classList.remove("past");
  context.putImageData(new ImageData(new Uint8ClampedArray(picture), SIDE, SIDE), 0, 0);
  // What was refused stays to be read until something else is chosen.
  say(stage.refused ?? "", Boolean(stage.refused));

  // The camera's 100-odd bytes are no cost of detail.
  const view = line.by_cause.view ?? { transfers: 0, payload_bytes: 0 };
  const bytes = line.upload.payload_bytes - view.payload_bytes;
  const transfers = line.upload.transfers - view.transfers;
  const ns = line.upload.bus_ns + line.fetch.bus_ns;
  const { sums } = stage;
  sums.changes += transfers > 0 || line.collapses + line.splits > 0 ? 1 : 0;
  sums.bytes += bytes;
  sums.transfers += transfers;
  sums.fetched += line.fetch.payload_bytes;
  sums.ns += ns;

  const { leaves } = stage;
  at("leaves").textContent = count(line.leaves);
  at("leaves-of").textContent = `of ${count(leaves)}`;
  at("leaves-meter").value = leaves ? line.leaves / leaves : 0;
  at("sent").textContent = `${count(bytes)} B`;
  at("sent-transfers").textContent = `in ${plural(transfers, "transfer")}`;
  at("sent-all").textContent = `${count(sums.bytes)} B`;
  at("sent-all-transfers").textContent = `in ${plural(sums.transfers, "transfer")}`;
  at("fetched").textContent = `${count(line.fetch.payload_bytes)} B`;
  at("bus").textContent = time(ns);
  at("bus-link").textContent = stage.link;
  at("resident").textContent = `${count(line.resident_bytes)} B`;
  at("initial").textContent = `${count(sums.initial)} B sent at first`;
  at("triangles").textContent = count(line.triangles);
  at("draws").textContent = `in ${plural(line.draws, "draw")}`;
  at("milliseconds").textContent = `${milliseconds.toFixed(0)} ms`;
  at("digest").textContent = line.image_digest;
  const cells = [sums.model, `${count(sums.initial)} B`, count(sums.changes), `${count(sums.bytes)} B`,
    count(sums.transfers), `${count(sums.fetched)} B`, time(sums.ns)];
  stage.row.replaceChildren(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));

  stage.waiting?.({ line, milliseconds });
  delete stage.waiting;
  // Once the tree shows: judging takes a while, and a second thread.
  if (!judging) judging = judge().catch((error) => rule("differs", String(error)));
}

/** The slider's whole way in equal steps, each drawn: what models are compared by. */
async function walk() {
  at("walk").disabled = true;
  const { max } = at("level");
  const mine = stage;
  for (let step = 0; step <= WALK_STEPS && stage === mine; step++) {
    const value = String(Math.round((step / WALK_STEPS) * max));
    // What shows already is not drawn again.
    if (value === at("level").value) continue;
    const drawn = new Promise((resolve) => (mine.waiting = resolve));
    at("level").value = value;
    want();
    await drawn;
  }
  at("walk").disabled = false;
}

// ---- the badge -----------------------------------------------------------------------------------

let judging;

/** Draws golden scenes here and holds their digests against the committed ones. */
async function judge() {
  rule("waiting", "digests: drawing golden scenes …");
  const { code, out, err } = await inBackground(
    ["golden", "digests", "scenes/golden"],
    { ...data.species, ...data.golden },
  );
  if (code !== 0) return rule("differs", err);
  const here = new Map(out.split("\n").map((line) => [line.split(" ")[0], line]));
  const images = (line) => /images=(\S+)/.exec(line ?? "")?.[1] ?? "none";
  const rows = data.digests.map((committed) => {
    const scene = committed.split(" ")[0];
    return [scene, images(here.get(scene)), images(committed)];
  });
  at("badge-rows").replaceChildren(
    ...rows.map((texts) => {
      const row = document.createElement("tr");
      for (const text of texts) row.insertCell().textContent = text;
      return row;
    }),
  );
  // The whole lines: plants, collapses, models, pictures and ledgers.
  const equal = data.digests.filter((line) => here.get(line.split(" ")[0]) === line).length;
  const all = data.digests.length;
  if (equal === all) rule("equal", `✓ ${all} golden scenes: digests equal the committed ones`);
  else rule("differs", `✗ ${all - equal} of ${all} golden scenes differ from the committed digests`);
}

function rule(state, text) {
  at("badge").dataset.state = state;
  at("badge-text").textContent = text;
}

// ---- words and numbers ---------------------------------------------------------------------------

function say(text, isWrong = false) {
  at("status").textContent = text;
  at("status").classList.toggle("wrong", isWrong);
}

const grouped = new Intl.NumberFormat("en");

function count(value) {
  return grouped.format(value);
}

function plural(value, noun) {
  return `${count(value)} ${noun}${value === 1 ? "" : "s"}`;
}

function time(nanoseconds) {
  const [value, unit] = nanoseconds < 1e6 ? [nanoseconds / 1e3, "µs"] : [nanoseconds / 1e6, "ms"];
  return `${value < 100 ? value.toPrecision(3) : count(Math.round(value))} ${unit}`;
}
