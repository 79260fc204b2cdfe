// From a tree and choices to a scene, as the program reads it.

import { FRAMES } from "./wish.js";

/** Pixels of a side. */
export const SIDE = 512;

/** Texels of a side of an impostor, enough for its share of the picture: at 512 baking takes a minute. */
const CARD_SIDE = 128;

const FIELD_OF_VIEW = 40;

const number = (value) => value.toFixed(4);
const text = (value) => JSON.stringify(value);

/**
 * A scene with one tree that the camera goes around in `FRAMES` frames.
 *
 * `tree`: { species } or { file }, paths from the scene, and where it stands as `spinney inspect --json`
 * tells it, in metres: `size_m` [x, y, z] and `center_m` { x, y, z }.
 */
export function sceneText({ tree, link, background }) {
  const [width, height, depth] = tree.size_m;
  const { x, y, z } = tree.center_m;
  // A sphere around the cylinder that the tree turns in, seen whole; a little air around it.
  const radius = Math.max(0.5 * Math.hypot(Math.max(width, depth), height), 0.05);
  const distance = (0.96 * radius) / Math.sin(((FIELD_OF_VIEW / 2) * Math.PI) / 180);
  const path = Array.from({ length: FRAMES }, (_, frame) => {
    const angle = (2 * Math.PI * frame) / FRAMES;
    const eye = [x + distance * Math.sin(angle), y + 0.12 * distance, z + distance * Math.cos(angle)];
    return `    { frame = ${frame}, eye = [${eye.map(number).join(", ")}], target = [${[x, y, z].map(number).join(", ")}] },`;
  });
  const source = tree.species ? `species = ${text(tree.species)}` : `file = ${text(tree.file)}`;
  return `schema = "spinney.scene/1"
size = [${SIDE}, ${SIDE}]
frames = ${FRAMES}
background = ${text(background)}

[[tree]]
${source}

[camera]
vertical_field_of_view = ${number(FIELD_OF_VIEW)}
path = [
${path.join("\n")}
]

[light]
direction = [0.4, 0.8, 0.45]

[model]
name = "lodf"
mode = "stamps"

[cards]
texture = ${CARD_SIDE}

[device]
link = ${text(link)}
card = "gtx770"
`;
}
