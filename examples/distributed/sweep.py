#!/usr/bin/env python3
"""A sweep over plants, links and models, in shards on a Dask cluster.

  sweep.py scenes/species/young/*.toml --links agp8x,pcie5x16 --models lodf-cluster,lodf-stamps --out out/young

Every input is a species, a tree (*.glb) or a scene. Each is walked over each link by `spinney sweep`, in
shards that are tasks of Dask, and `spinney merge` joins the shards to the bytes of the unsharded walk:

  OUT/scenes/    one scene a plant and link, and copies of the plants
  OUT/shards/    a folder a shard, there whole or not at all; what is there is not drawn again
  OUT/sweeps/    a folder a scene and link, as `spinney sweep` writes it
  OUT/sweep.csv  all of their tables, in the order of the inputs, links and models

Without --scheduler, a cluster of --workers processes is started on this machine. Workers elsewhere need
the program, and the inputs and OUT under the same paths. README.md beside this file tells more.
Exit codes: 0 done, 1 a shard failed, 2 bad usage or input."""
from __future__ import annotations

import argparse
import contextlib
import csv
import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

PRIVATE = ".part-"
"""How the names of folders begin that nobody but the task that made them may look into."""


@dataclass(frozen=True)
class Sweep:
    """One walk: a scene over a link, all models."""

    scene: str
    link: str
    command: tuple[str, ...]
    """The unsharded walk, but for `--out`."""
    shards: Path
    """Where its shards are: another folder for everything that may change their bytes."""

    @property
    def name(self) -> str:
        return f"{self.scene}-{self.link}"


@dataclass(frozen=True)
class Task:
    """One shard of a walk."""

    sweep: Sweep
    index: int
    count: int

    @property
    def folder(self) -> Path:
        return self.sweep.shards / f"{self.index}-of-{self.count}"

    @property
    def command(self) -> list[str]:
        return [*self.sweep.command, "--shard", f"{self.index}/{self.count}"]

    def __str__(self) -> str:
        return f"{self.sweep.name} {self.index}/{self.count}"


def ask(command: Sequence[str]) -> str:
    """What a command prints; what it complains about is an error of the input."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise ValueError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def put(path: Path, content: bytes) -> None:
    """Writes a file whole or not at all: tasks of an array write the same scenes at the same time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, private = tempfile.mkstemp(prefix=PRIVATE, dir=path.parent)
    with os.fdopen(handle, "wb") as file:
        file.write(content)
    os.chmod(private, 0o644)
    os.replace(private, path)


def scene_of(plant: Path, kind: str, measures: dict, link: str, size: str | None) -> str:
    """A scene that shows the whole of one plant, from a distance at which its height fills six sevenths."""
    width, height, depth = measures["size_m"]
    middle = round(measures["lowest_m"] + height / 2, 3)
    distance = round(1.6 * max(width, height, depth), 3)
    key = "species" if kind == "species" else "file"
    frame = f"size = [{size.replace('x', ', ')}]\n" if size else ""
    return (
        f'schema = "spinney.scene/1"\nname = "{plant.stem}-{link}"\n{frame}\n'
        f'[[tree]]\n{key} = "plants/{plant.name}"\n\n'
        f"[camera]\nvertical_field_of_view = 40.0\n"
        f"path = [{{ eye = [0.0, {middle}, {distance}], target = [0.0, {middle}, 0.0] }}]\n\n"
        f'[device]\nlink = "{link}"\n'
    )


def digest_of(flags: Sequence[str], scene: Path) -> str:
    """Of all that decides the bytes of a walk: version and flags, the scene and the files of its plants."""
    tables = tomllib.loads(scene.read_text(encoding="utf-8"))
    files = [scene]
    for tree in [*tables.get("tree", []), *tables.get("forest", [])]:
        named = tree.get("species", tree.get("file", []))
        files += [scene.parent / name for name in ([named] if isinstance(named, str) else named)]
    parts = [hashlib.sha256(part).digest() for part in (repr(flags).encode(), *map(Path.read_bytes, files))]
    return hashlib.sha256(b"".join(parts)).hexdigest()[:12]


def plan(options: argparse.Namespace) -> list[Sweep]:
    """Writes the scenes, and answers the walks in their order."""
    program, out = options.program, Path(options.out).resolve()
    version = ask([program, "--version"]).split()[-1]
    flags = ["--steps", str(options.steps)]
    flags += ["--models", options.models] if options.models else []
    flags += ["--size", options.size] if options.size else []
    sweeps: dict[str, Sweep] = {}
    for given in options.inputs:
        path = Path(given).resolve()
        told = json.loads(ask([program, "inspect", "--json", str(path)]))
        kind = told["kind"]
        if kind not in ("scene", "species", "plant"):
            raise ValueError(f"{given}: is a {kind}, wanted a scene, species or plant")
        if kind != "scene":
            put(out / "scenes" / "plants" / path.name, path.read_bytes())
        for link in options.links:
            name, scene = f"{path.stem}-{link}", path
            if name in sweeps:
                raise ValueError(f"{given} over {link}: there is a sweep {name} already, wanted files of other names")
            if kind != "scene":
                scene = out / "scenes" / f"{name}.toml"
                put(scene, scene_of(path, kind, told, link, options.size).encode())
            decides = [*flags, "--link", link]
            command = (program, "sweep", str(scene), *decides, "--threads", str(options.threads), "--quiet")
            shards = out / "shards" / f"{name}-{digest_of([version, *decides], scene)}"
            sweeps[name] = Sweep(path.stem, link, command, shards)
    return list(sweeps.values())


def draw(command: list[str], folder: str) -> None:
    """Writes the folder of a shard whole or not at all.

    The program writes into a private folder beside it, which takes the name when it is done. So a task may be
    killed at any time, and may run twice, even at once: who is second finds the same bytes and leaves them."""
    target = Path(folder)
    if target.is_dir():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=PRIVATE, dir=target.parent) as private:
        drawn = Path(private) / "shard"
        done = subprocess.run([*command, "--out", str(drawn)], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"exit code {done.returncode}: {done.stderr.strip()}")
        try:
            drawn.rename(target)
        except OSError:
            if not target.is_dir():
                raise


def draw_on_dask(tasks: Sequence[Task], options: argparse.Namespace) -> None:
    """Draws shards on a cluster. A task whose worker dies goes to another one."""
    try:
        from distributed import Client, LocalCluster, as_completed
    except ImportError as error:
        raise ValueError(f"{len(tasks)} shards are missing and {error.name} is too: "
                       "pip install -r requirements.txt, or draw them with --only") from error
    failed = []
    with contextlib.ExitStack() as stack:
        local = dict(n_workers=options.workers, threads_per_worker=1, dashboard_address=None)
        client = stack.enter_context(Client(options.scheduler or stack.enter_context(LocalCluster(**local))))
        # Twice more where the program fails, since it may have run out of memory beside another one.
        futures = {client.submit(draw, task.command, str(task.folder), pure=False, retries=2): task for task in tasks}
        for number, future in enumerate(as_completed(futures), 1):
            task, error = futures[future], future.exception()
            if error is None and not task.folder.is_dir():
                error = FileNotFoundError(f"no {task.folder}: does the worker write to another disk?")
            print(f"{number}/{len(tasks)} {task}: {'failed' if error else 'drawn'}", flush=True)
            if error is not None:
                failed.append(f"{task}: {error}")
    if failed:
        raise RuntimeError("\n".join(failed))


def join(sweeps: Sequence[Sweep], tasks: Sequence[Task], program: str, out: Path) -> None:
    """Makes each walk of its shards, and one table of all."""
    for sweep in sweeps:
        folders = [str(task.folder) for task in tasks if task.sweep is sweep]
        ask([program, "merge", *folders, "--out", str(out / "sweeps" / sweep.name), "--quiet"])
        # What tasks that were killed have left.
        for left in sweep.shards.glob(PRIVATE + "*"):
            shutil.rmtree(left, ignore_errors=True)
    table(sweeps, out)


def table(sweeps: Sequence[Sweep], out: Path) -> None:
    """Writes the tables of all walks as one."""
    rows: list[dict[str, str]] = []
    for sweep in sweeps:
        with open(out / "sweeps" / sweep.name / "sweep.csv", newline="", encoding="utf-8") as file:
            rows += [{"scene": sweep.scene, "link": sweep.link, **row} for row in csv.DictReader(file)]
    columns = list(dict.fromkeys(column for row in rows for column in row))
    text = io.StringIO()
    lines = [columns, *([row.get(column, "") for column in columns] for row in rows)]
    csv.writer(text, lineterminator="\n").writerows(lines)
    put(out / "sweep.csv", text.getvalue().encode())


def arguments(words: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument

    def count(text: str) -> int:
        if int(text) < 1:
            raise argparse.ArgumentTypeError(f"{text}, wanted at least 1")
        return int(text)

    add("inputs", nargs="+", metavar="FILE", help="species, trees (*.glb) or scenes")
    add("--links", default="pcie1x16", type=lambda text: text.split(","), help="links, such as agp8x,pcie5x16")
    add("--models", help="models, such as lodf-cluster,lodf-stamps; default all that fit")
    add("--steps", type=count, default=100, help="steps of a walk (default %(default)s)")
    add("--size", metavar="WxH", help="pixels of a frame, in place of the scene's")
    add("--shards", type=count, default=4, metavar="N", help="shards of a walk (default %(default)s)")
    add("--out", default="out/distributed", help="folder to write (default %(default)s)")
    add("--scheduler", metavar="ADDRESS", help="a running Dask scheduler; default processes on this machine")
    add("--workers", type=count, default=os.cpu_count() or 1, help="how many processes (default %(default)s)")
    add("--threads", type=count, default=1, help="threads of each spinney; they change no byte (default %(default)s)")
    add("--program", default=os.environ.get("SPINNEY", "spinney"), help="spinney (default $SPINNEY or from PATH)")
    add("--count", action="store_true", help="print how many shards there are in all, and draw nothing")
    add("--only", type=int, metavar="K", help="draw shard K of all, from 0, here and without Dask; join nothing")
    options = parser.parse_args(words)
    if options.size and not re.fullmatch("[0-9]+x[0-9]+", options.size):
        parser.error(f"--size {options.size}: wanted such as 640x480")
    if shutil.which(options.program) is None:
        parser.error(f"no program {options.program}: --program or SPINNEY says where spinney is")
    if os.sep in options.program:
        options.program = str(Path(options.program).resolve())
    return options


def main() -> int:
    options = arguments()
    try:
        sweeps = plan(options)
        tasks = [Task(sweep, index, options.shards) for sweep in sweeps for index in range(options.shards)]
        if options.count:
            print(len(tasks))
            return 0
        if options.only is not None:
            if not 0 <= options.only < len(tasks):
                raise ValueError(f"--only {options.only}: there are {len(tasks)} shards, from 0")
            draw(tasks[options.only].command, str(tasks[options.only].folder))
            return 0
        missing = [task for task in tasks if not task.folder.is_dir()]
        print(f"{len(missing)} of {len(tasks)} shards to draw", flush=True)
        if missing:
            draw_on_dask(missing, options)
        join(sweeps, tasks, options.program, Path(options.out).resolve())
        print(f"{options.out}: {len(sweeps)} sweeps and sweep.csv")
        return 0
    except (OSError, RuntimeError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1 if isinstance(error, RuntimeError) else 2


if __name__ == "__main__":
    sys.exit(main())
