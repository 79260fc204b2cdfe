// The built page in headless Chromium: npm test, after npm run build.
//
// CHROMIUM names the browser, by default Debian's. Screenshots are left in web/out/, to be looked at. How
// long steps take is told, and asserted nowhere: that is a matter of the machine.

import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { join } from "node:path";

import { chromium } from "playwright-core";

import { ISOLATED, serve } from "../serve.mjs";

const here = fileURLToPath(new URL("..", import.meta.url));
const dist = join(here, "dist");
const shots = join(here, "out");
const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

/** What anything may take on a slow machine, in milliseconds. */
const PATIENCE = 120_000;

const { ask, folderOf } = await import(pathToFileURL(join(dist, "program.js")));
const data = JSON.parse(readFileSync(join(dist, "data.json"), "utf8"));

let browser;
before(async () => {
  mkdirSync(shots, { recursive: true });
  browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
});
after(() => browser.close());

/** A page of a browser that knows nothing, from a server of its own; anything that goes wrong fails the test. */
async function visit({ options = {}, headers = ISOLATED, hash = "" } = {}, look) {
  const server = await serve(dist, 0, headers);
  const origin = `http://127.0.0.1:${server.address().port}`;
  const context = await browser.newContext(options);
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  const wrong = [];
  page.on("console", (message) => message.type() === "error" && wrong.push(message.text()));
  page.on("pageerror", (error) => wrong.push(String(error)));
  context.on("request", (request) => {
    if (!request.url().startsWith(origin) && !/^(blob|data):/.test(request.url())) wrong.push(`asked ${request.url()}`);
  });
  try {
    await page.goto(`${origin}/${hash}`);
    await look(page, { server, context });
    assert.deepEqual(wrong, []);
  } finally {
    await context.close();
    server.closeAllConnections();
    server.close();
  }
}

const textOf = (page, id) => page.locator(`#${id}`).textContent();
const numberOf = async (page, id) => Number((await textOf(page, id)).replace(/[^0-9.]/g, ""));

/** Waits until a picture shows that is not the one with this digest. */
async function drawn(page, last = "–") {
  await page.waitForFunction((last) => document.getElementById("digest").textContent !== last, last);
  return textOf(page, "digest");
}

async function setLevel(page, value) {
  const last = await textOf(page, "digest");
  await page.locator("#level").fill(String(value));
  return drawn(page, last);
}

test("the yew is drawn, stepped and judged", { timeout: 5 * PATIENCE }, async (t) => {
  await visit({}, async (page) => {
    const finest = await drawn(page);
    assert.equal(await textOf(page, "leaves"), "48,160");
    // The slider by keyboard.
    await page.locator("#level").focus();
    await page.keyboard.press("ArrowRight");
    const next = await drawn(page, finest);
    assert.ok((await numberOf(page, "leaves")) < 48_160);
    assert.equal(await textOf(page, "sent"), "4 B");
    assert.equal(await textOf(page, "sent-transfers"), "in 1 transfer");
    await page.keyboard.press("Home");
    assert.equal(await drawn(page, next), finest, "back at full detail the picture is the first one");

    await page.waitForFunction(() => ["equal", "differs"].includes(document.getElementById("badge").dataset.state));
    assert.equal(await page.locator("#badge").getAttribute("data-state"), "equal", await textOf(page, "badge-text"));

    const times = [];
    for (const way of ["first", "second"]) {
      times.length = 0;
      for (let step = 1; step <= 20; step++) {
        await setLevel(page, step * 50);
        times.push(await numberOf(page, "milliseconds"));
      }
      t.diagnostic(`steps of 512², ${way} way through the levels, ms: ${times.join(" ")}`);
      await setLevel(page, 0);
    }
    for (let turn = 1; turn <= 5; turn++) {
      const last = await textOf(page, "digest");
      await page.locator("#turn").fill(String(turn));
      await drawn(page, last);
      times.push(await numberOf(page, "milliseconds"));
    }
    t.diagnostic(`all leaves, turned, ms: ${times.slice(20).join(" ")}`);
  });
});

test("all models of leaves show the same picture, and send what the program says elsewhere", { timeout: 5 * PATIENCE }, async () => {
  const hash = "#tree=pistacia_lentiscus.toml&level=400&turn=10";
  await visit({ hash }, async (page) => {
    const digest = await drawn(page);
    for (const label of ["lodf-slots", "lodf-cluster", "lodf-host", "lodf-device", "vdf-indices"]) {
      await page.locator("#model").selectOption(await modelNumber(page, label));
      await page.waitForFunction((label) => document.querySelector("tr.now td")?.textContent === label, label);
      assert.equal(await textOf(page, "digest"), digest, label);
    }
    assert.ok((await numberOf(page, "sent")) > 1000, "indices of all visible leaves are sent");
    // The same lines in Node, where nothing of the browser takes part.
    const scene = await page.evaluate(async () => {
      const { sceneText } = await import("./scene.js");
      const { plants } = await (await fetch("data.json")).json();
      const plant = plants.find(({ path }) => path.endsWith("/pistacia_lentiscus.toml"));
      const background = getComputedStyle(document.documentElement).getPropertyValue("--sky").trim();
      return sceneText({ tree: { ...plant, species: plant.path }, link: "pcie1x16", background });
    });
    const { Fd } = await import(pathToFileURL(join(dist, "wasi/index.js")));
    const { run } = await import(pathToFileURL(join(dist, "program.js")));
    const text = new TextEncoder().encode("model vdf-indices\n0.4 10\n");
    const lines = [];
    const code = await run(await program(), {
      args: ["step", "scene.toml"],
      folder: folderOf({ ...data.species, "scene.toml": scene }),
      stdin: Object.assign(new Fd(), { at: 0, fd_read(size) {
        const part = text.slice(this.at, this.at + size);
        this.at += part.length;
        return { ret: 0, data: part };
      } }),
      out: (line) => lines.push(JSON.parse(line)),
      err: (line) => assert.fail(line),
    });
    assert.equal(code, 0);
    assert.equal(lines.at(-1).image_digest, digest);
    const view = lines.at(-1).by_cause.view.payload_bytes;
    assert.equal(await numberOf(page, "sent"), lines.at(-1).upload.payload_bytes - view);
  });
});

test("once visited, it works with no network", { timeout: 5 * PATIENCE }, async () => {
  const hash = "#tree=pistacia_lentiscus.toml";
  await visit({ hash }, async (page, { server, context }) => {
    const digest = await drawn(page);
    // Everything is kept before the worker says that it is ready.
    await page.evaluate(() => navigator.serviceWorker.ready);
    await context.setOffline(true);
    server.closeAllConnections();
    await new Promise((closed) => server.close(closed));
    await page.reload();
    assert.equal(await drawn(page), digest);
    await page.locator("#tree").selectOption("scenes/species/betula_lenta.toml");
    assert.notEqual(await drawn(page), digest);
  });
});

test("a server that sets no headers will do", { timeout: 5 * PATIENCE }, async () => {
  await visit({ headers: {}, hash: "#tree=pistacia_lentiscus.toml" }, async (page) => {
    await drawn(page);
    assert.ok(await page.evaluate(() => self.crossOriginIsolated));
  });
});

test("own trees are drawn, and refused with the program's words", { timeout: 5 * PATIENCE }, async () => {
  const folder = folderOf(data.species);
  const { code, err } = await ask(await program(), ["grow", "scenes/species/pistacia_lentiscus.toml", "-o", "own/tree.glb"], folder);
  assert.equal(code, 0, err);
  const buffer = Buffer.from(folder.dir.contents.get("own").contents.get("tree.glb").data);
  await visit({ hash: "#tree=pistacia_lentiscus.toml" }, async (page) => {
    const species = await drawn(page);
    const leaves = await textOf(page, "leaves");
    await page.locator("#file").setInputFiles({ name: "tree.glb", mimeType: "model/gltf-binary", buffer });
    await page.waitForFunction(() => document.getElementById("tree").value === "tree.glb");
    // Out to a file and in again it is the same tree.
    assert.equal(await drawn(page), species);
    assert.equal(await textOf(page, "leaves"), leaves);
    await page.locator("#file").setInputFiles({ name: "broken.glb", mimeType: "model/gltf-binary", buffer: buffer.subarray(0, 999) });
    await page.locator("#status.wrong").waitFor();
    assert.match(await textOf(page, "status"), /broken\.glb/);
  });
});

for (const [name, viewport] of [["desktop", { width: 1280, height: 900 }], ["phone", { width: 360, height: 740 }]]) {
  for (const colorScheme of ["light", "dark"]) {
    test(`${name}, ${colorScheme}: nothing leaves the screen`, { timeout: 5 * PATIENCE }, async () => {
      const hash = "#tree=taxus_baccata.toml&level=300&turn=4";
      await visit({ hash, options: { viewport, colorScheme, deviceScaleFactor: name === "phone" ? 2 : 1 } }, async (page) => {
        let last = await drawn(page);
        for (const label of ["lodf-cluster", "impostors-direct", "lodf-slots-gathered"]) {
          await page.locator("#model").selectOption(await modelNumber(page, label));
          await page.waitForFunction((label) => document.querySelector("tr.now td")?.textContent === label, label);
          last = await setLevel(page, label === "lodf-cluster" ? 600 : 300 + label.length);
        }
        await page.waitForFunction(() => document.getElementById("badge").dataset.state === "equal");
        await page.screenshot({ path: join(shots, `${name}-${colorScheme}.png`), fullPage: true });
        await page.locator("#badge summary").click();
        await page.screenshot({ path: join(shots, `${name}-${colorScheme}-badge.png`) });
        const [scroll, inner] = await page.evaluate(() => [document.scrollingElement.scrollWidth, innerWidth]);
        assert.ok(scroll <= inner, `${scroll} pixels wide on a screen of ${inner}`);
      });
    });
  }
}

function program() {
  return WebAssembly.compile(readFileSync(join(dist, "spinney.wasm")));
}

async function modelNumber(page, label) {
  const number = await page.evaluate(async (label) => {
    const { MODELS } = await import("./models.js");
    return MODELS.findIndex((model) => model.label === label);
  }, label);
  return String(number);
}
