// Keeps the whole page for when there is no network, and says that it is isolated from other origins,
// without which browsers share no memory with workers: static hosts that cannot set headers need that.

importScripts("bundle.js"); // BUNDLE: { version, files }, by the build

const cacheName = `spinney-${BUNDLE.version}`;

self.addEventListener("install", (event) => {
  const fetched = async () => {
    const cache = await caches.open(cacheName);
    // Past the browser's own cache: a version is of one piece.
    await cache.addAll(BUNDLE.files.map((file) => new Request(file, { cache: "reload" })));
    await self.skipWaiting();
  };
  event.waitUntil(fetched());
});

self.addEventListener("activate", (event) => {
  const swept = async () => {
    const names = await caches.keys();
    const old = names.filter((name) => name.startsWith("spinney-") && name !== cacheName);
    await Promise.all(old.map((name) => caches.delete(name)));
    await self.clients.claim();
  };
  event.waitUntil(swept());
});

self.addEventListener("fetch", (event) => {
  if (new URL(event.request.url).origin !== self.location.origin) return;
  event.respondWith(answer(event.request));
});

async function answer(request) {
  const cache = await caches.open(cacheName);
  const found = (await cache.match(request, { ignoreSearch: true })) ?? (await fetch(request));
  const headers = new Headers(found.headers);
  headers.set("Cross-Origin-Opener-Policy", "same-origin");
  headers.set("Cross-Origin-Embedder-Policy", "require-corp");
  headers.set("Cross-Origin-Resource-Policy", "same-origin");
  return new Response(found.body, { status: found.status, statusText: found.statusText, headers });
}
