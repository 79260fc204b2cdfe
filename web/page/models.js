// The models and modes to choose from, by the labels that `spinney step` knows; `begins` is what a scene
// calls those that it can begin with.

export const MODELS = [
  { label: "lodf-stamps", name: "LoDF, stamps", about: "every record once; a change sends one counter" },
  { label: "lodf-slots", name: "LoDF, slots", about: "one transfer for every slot that differs" },
  { label: "lodf-slots-gathered", name: "LoDF, slots, gathered", about: "the slots that differ, in one transfer" },
  { label: "lodf-cluster", name: "LoDF, cluster", about: "the papers’ mode: each changed cluster’s leaves anew" },
  { label: "lodf-host", name: "LoDF, host", about: "nothing resident; every draw fetches every visible leaf" },
  { label: "lodf-stamps-u16", name: "LoDF, stamps, 8-byte records", about: "half the resident records" },
  { label: "lodf-device", name: "LoDF, device", about: "the device chooses; needs a card that computes" },
  { label: "vdf-indices", name: "VDF, indices", about: "all visible leaves’ indices, anew at each change" },
  { label: "vdf-host", name: "VDF, host", about: "nothing resident; every draw fetches" },
  { label: "impostors-direct", name: "Impostors", about: "cards in the planes of leaf clusters, at three levels; baking them takes a while" },
  { label: "octahedral-hemisphere", name: "Octahedral impostor", about: "one card with views from all around, no levels; baking them takes a while" },
  { label: "crossed-fixed", name: "Crossed cards", about: "two pictures that cross; no levels" },
  { label: "full", name: "Full detail", about: "the yardstick: no levels" },
];
