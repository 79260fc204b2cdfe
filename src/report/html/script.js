"use strict";
(() => {
  const all = (root, selector) => [...root.querySelectorAll(selector)];
  const grouped = (count) => String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f");
  document.documentElement.classList.add("js");

  // Tables sort by a heading: upwards, downwards, then as they came. What has no number, or nothing at all,
  // stays at the end.
  const key = (row, index, numbers) => {
    const cell = row.cells[index];
    const text = cell ? cell.textContent : "\u2013";
    if (!numbers) return text === "\u2013" ? null : text;
    const number = parseFloat(text.replace(/[\u202f,]/g, ""));
    return Number.isNaN(number) ? null : number;
  };
  const inOrder = (one, other) => {
    if (typeof one === "number") return one - other;
    return one.localeCompare(other, "en", { numeric: true });
  };
  for (const table of all(document, "table")) {
    const body = table.tBodies[0];
    const rows = [...body.rows];
    if (rows.length < 2) continue;
    const headings = [...table.tHead.rows[0].cells];
    headings.forEach((heading, index) => {
      if (!heading.textContent) return;
      const button = document.createElement("button");
      button.type = "button";
      button.append(...heading.childNodes);
      heading.append(button);
      heading.setAttribute("aria-sort", "none");
      button.addEventListener("click", () => {
        const next = { none: "ascending", ascending: "descending", descending: "none" };
        const order = next[heading.getAttribute("aria-sort")];
        for (const other of headings) {
          if (other.hasAttribute("aria-sort")) other.setAttribute("aria-sort", "none");
        }
        heading.setAttribute("aria-sort", order);
        const sign = { none: 0, ascending: 1, descending: -1 }[order];
        const numbers = heading.classList.contains("n");
        const keyed = rows.map((row) => [key(row, index, numbers), row]);
        keyed.sort(([one], [other]) => {
          if (sign === 0) return 0;
          if (one === null || other === null) return (one === null) - (other === null);
          return sign * inOrder(one, other);
        });
        body.append(...keyed.map(([, row]) => row));
      });
    });
  }

  // A picture's bytes R, G, B, A.
  const pixels = (image) => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, canvas.width, canvas.height).data;
  };

  // Where two pictures of one size differ: how many pixels, by how much at most, and each byte's distance.
  const difference = (one, other) => {
    const [a, b] = [pixels(one), pixels(other)];
    const distances = new Uint8ClampedArray(a.length);
    let [count, largest] = [0, 0];
    for (let at = 0; at < a.length; at += 4) {
      let most = 0;
      for (let channel = at; channel < at + 4; channel += 1) {
        distances[channel] = Math.abs(a[channel] - b[channel]);
        most = Math.max(most, distances[channel]);
      }
      count += most > 0 ? 1 : 0;
      largest = Math.max(largest, most);
    }
    return { distances, count, largest, of: a.length / 4 };
  };

  const compare = (root) => {
    const images = all(root, ".thumbs img");
    const shows = root.dataset.shows.split(";").map((row) => row.split(",").map(Number));
    const [stage] = all(root, ".stage");
    const [canvas] = all(root, "canvas");
    const [divider] = all(root, ".divider");
    const tags = all(root, ".tag");
    const [toggle] = all(root, ".toggle");
    const [gains] = all(root, ".gain");
    const [told] = all(root, ".bar output");
    const context = canvas.getContext("2d");
    const sides = all(root, ".side").map((side) => ({
      way: side.querySelector("select"),
      place: side.querySelector("input"),
      name: side.querySelector("output"),
    }));
    let [split, gain, known] = [50, 4, null];

    const chosen = ({ way, place, name }) => {
      const column = place ? Number(place.value) : 0;
      const words = [];
      if (way) words.push(way.selectedOptions[0].textContent);
      if (place) {
        name.textContent = place.list.options[column].label;
        place.setAttribute("aria-valuetext", name.textContent);
        words.push(place.dataset.name + " " + name.textContent);
      }
      return { image: images[shows[way ? way.selectedIndex : 0][column]], words: words.join(", ") };
    };
    const isOn = () => toggle.getAttribute("aria-pressed") === "true";

    const paint = () => {
      const [one, other] = sides.map((side) => chosen(side).image);
      const [width, height] = [one.naturalWidth, one.naturalHeight];
      if (canvas.width !== width || canvas.height !== height) {
        [canvas.width, canvas.height] = [width, height];
        stage.style.maxWidth = `min(${2 * width}px, ${(80 * width) / height}vh)`;
      }
      if (isOn() && known) {
        const shown = context.createImageData(width, height);
        known.distances.forEach((distance, at) => {
          shown.data[at] = at % 4 === 3 ? 255 : gain * distance;
        });
        context.putImageData(shown, 0, 0);
      } else {
        const cut = Math.round((split / 100) * width);
        context.clearRect(0, 0, width, height);
        context.save();
        context.beginPath();
        context.rect(0, 0, cut, height);
        context.clip();
        context.drawImage(one, 0, 0);
        context.restore();
        context.beginPath();
        context.rect(cut, 0, width - cut, height);
        context.save();
        context.clip();
        context.drawImage(other, 0, 0, width, height);
        context.restore();
      }
      divider.style.left = split + "%";
      divider.setAttribute("aria-valuenow", String(Math.round(split)));
      canvas.classList.toggle("crisp", canvas.clientWidth * devicePixelRatio >= width);
    };

    const choose = () => {
      const [one, other] = sides.map(chosen);
      tags.forEach((tag, index) => (tag.textContent = [one, other][index].words));
      canvas.setAttribute("aria-label", `A: ${one.words}; B: ${other.words}`);
      const sameSize = one.image.naturalWidth === other.image.naturalWidth
        && one.image.naturalHeight === other.image.naturalHeight;
      known = sameSize ? difference(one.image, other.image) : null;
      toggle.disabled = !known;
      if (!known) {
        told.textContent = "The pictures differ in size.";
        press(false);
      } else if (known.count === 0) {
        told.textContent = "No pixel differs.";
      } else {
        const share = (100 * known.count) / known.of;
        const percent = share < 0.01 ? "below 0.01" : share.toFixed(share < 1 ? 2 : 1);
        told.textContent = `${grouped(known.count)} of ${grouped(known.of)} pixels differ (${percent}\u202f%), `
          + `by at most ${known.largest} of 255.`;
      }
      paint();
    };

    const press = (on) => {
      toggle.setAttribute("aria-pressed", String(on));
      stage.classList.toggle("differs", on);
      gains.hidden = !on;
    };
    toggle.addEventListener("click", () => {
      press(!isOn());
      paint();
    });
    for (const button of gains.children) {
      button.addEventListener("click", () => {
        gain = Number(button.value);
        for (const other of gains.children) other.setAttribute("aria-pressed", String(other === button));
        paint();
      });
    }

    const move = (to) => {
      split = Math.min(100, Math.max(0, to));
      paint();
    };
    const follow = (event) => {
      const box = stage.getBoundingClientRect();
      move((100 * (event.clientX - box.left)) / box.width);
    };
    stage.addEventListener("pointerdown", (event) => {
      if (!event.isPrimary || event.button !== 0 || isOn()) return;
      stage.setPointerCapture(event.pointerId);
      divider.focus({ preventScroll: true });
      follow(event);
      event.preventDefault();
    });
    stage.addEventListener("pointermove", (event) => {
      if (stage.hasPointerCapture(event.pointerId)) follow(event);
    });
    divider.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 10 : 1;
      const to = {
        ArrowLeft: split - step, ArrowDown: split - step, ArrowRight: split + step, ArrowUp: split + step,
        PageDown: split - 10, PageUp: split + 10, Home: 0, End: 100,
      }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      move(to);
    });
    for (const { way, place } of sides) {
      if (way) way.addEventListener("change", choose);
      if (place) place.addEventListener("input", choose);
    }
    addEventListener("resize", paint);
    for (const part of all(root, ".controls")) part.hidden = false;
    choose();
  };
  for (const root of all(document, ".compare[data-shows]")) {
    const ready = all(root, ".thumbs img").map((image) => image.decode());
    // Without its pictures a comparison stays as it is without a script.
    Promise.all(ready).then(() => compare(root), () => {});
  }

  for (const source of all(document, "details.source")) {
    const [text] = all(source, "code");
    const button = document.createElement("button");
    [button.type, button.className, button.textContent] = ["button", "copy", "Copy"];
    const done = () => {
      button.textContent = "Copied";
      setTimeout(() => (button.textContent = "Copy"), 1500);
    };
    const byHand = () => {
      getSelection().selectAllChildren(text);
      if (document.execCommand("copy")) done();
    };
    button.addEventListener("click", () => {
      if (!navigator.clipboard) return byHand();
      navigator.clipboard.writeText(text.textContent).then(done, byHand);
    });
    source.append(button);
  }

  // On paper everything is open.
  const closed = all(document, "details:not([open])");
  addEventListener("beforeprint", () => closed.forEach((part) => (part.open = true)));
  addEventListener("afterprint", () => closed.forEach((part) => (part.open = false)));
})();
