#!/usr/bin/env python3
"""Reads the collapse sequence that `spinney build` writes, and shows any level of it.

    python3 examples/collapses.py out/oak-levels/collapses.bin             what is in it
    python3 examples/collapses.py … --leaves 500 --obj oak.obj             500 leaves as an OBJ file
    python3 examples/collapses.py … --error 0.02                           how few leaves 2 cm allow

Nothing but Python's standard library. The layout is documented at `spinney::run::collapse_file`.
"""

import argparse
import json
import struct
from array import array
from pathlib import Path
import sys

MAGIC = b"SPINNEYC"


class Collapses:
    """The header as a dictionary, and its arrays by name, each a list of tuples or of numbers."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        if data[:8] != MAGIC:
            raise ValueError(f"{path}: begins with {data[:8]!r}, wanted {MAGIC!r}")
        (length,) = struct.unpack_from("<I", data, 8)
        self.header = json.loads(data[12 : 12 + length])
        if self.header["schema"] != "spinney.collapses/1":
            raise ValueError(f"{path}: schema {self.header['schema']!r}, wanted 'spinney.collapses/1'")
        for name, entry in self.header["arrays"].items():
            count, components = entry["count"], entry["components"]
            end = entry["offset"] + 4 * count * components
            if end > len(data):
                raise ValueError(f"{path}: {name} ends at byte {end}, the file has {len(data)}")
            words = array("f" if entry["type"] == "f32" else "I")
            words.frombytes(data[entry["offset"] : end])
            if sys.byteorder == "big":
                words.byteswap()
            rows = list(words) if components == 1 else list(zip(*[iter(words)] * components))
            setattr(self, name, rows)
        self.leaves = self.header["leaves"]

    def visible(self, collapses: int) -> list[int]:
        """The leaves that show once so many collapses are done."""
        gone = {leaf for pair in self.old[:collapses] for leaf in pair}
        return [leaf for leaf in range(self.leaves + collapses) if leaf not in gone]

    def within(self, error: float) -> int:
        """The most collapses, in their order, of which none moves a leaf farther than `error` metres."""
        too_far = (number for number, found in enumerate(self.error) if found > error)
        return next(too_far, len(self.error))

    def group_of(self) -> list[int]:
        """The group of every leaf, also of those that collapses bring."""
        all_groups = enumerate(self.header["groups"])
        groups = [number for number, group in all_groups for _ in range(group["leaves"])]
        for first, _ in self.old:
            groups.append(groups[first])
        return groups

    def write_obj(self, path: Path, collapses: int) -> None:
        groups = self.group_of()
        lines = [f"# {self.header['name']}: {collapses} of {len(self.old)} collapses"]
        for number, leaf in enumerate(self.visible(collapses)):
            group = self.header["groups"][groups[leaf]]
            lines.append(f"g {group['name']}")
            for vertex, (u, v) in zip(self.corners[leaf], group["texture_corners"]):
                lines.append("v {:.6g} {:.6g} {:.6g}".format(*self.vertices[vertex]))
                lines.append(f"vt {u:.6g} {1 - v:.6g}")
            corners = range(4 * number + 1, 4 * number + 5)
            lines.append("f " + " ".join(f"{corner}/{corner}" for corner in corners))
        path.write_text("\n".join(lines) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--leaves", type=int, help="how many leaves are to show")
    parser.add_argument("--error", type=float, help="how far leaves may lie off, in metres")
    parser.add_argument("--obj", type=Path, help="an OBJ file to write")
    options = parser.parse_args()
    found = Collapses(options.file)
    done = 0
    if options.error is not None:
        done = found.within(options.error)
    elif options.leaves is not None:
        done = min(max(found.leaves - options.leaves, 0), len(found.old))
    worst = max(found.error[:done], default=0.0)
    print(f"{found.header['name']}: {found.leaves} leaves, {len(found.old)} collapses")
    print(f"after {done}: {found.leaves - done} leaves, at most {1000 * worst:.1f} mm off")
    if options.obj:
        found.write_obj(options.obj, done)


if __name__ == "__main__":
    main()
