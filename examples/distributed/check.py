#!/usr/bin/env python3
"""Whether a sweep in shards is the sweep, byte for byte, whoever draws the shards and whatever is killed.

  check.py [--program spinney] [--out FOLDER]

Walks two young trees over two links with three models: without shards; on Dask with two workers; with one of
them killed while it draws; with the program that it runs killed; as tasks of a Slurm array; by the commands of
ci-matrix.yml; and once more where a shard is missing. Prints a table, and exits with 1 on any difference.

Slurm itself and GitHub's runners are not needed: their variables are set and the commands run one after another."""
from __future__ import annotations

import argparse
import contextlib
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import yaml

import sweep

HERE = Path(__file__).resolve().parent
YOUNG = HERE.parent.parent / "scenes" / "species" / "young"
PLANTS = [YOUNG / "betula_populifolia.toml", YOUNG / "ilex_aquifolium.toml"]
LINKS, MODELS, STEPS, SIZE, SHARDS = ["agp8x", "pcie5x16"], "vdf-host,lodf-cluster,lodf-stamps", 30, "480x360", 3
TASKS = len(PLANTS) * len(LINKS) * SHARDS


class Check:
    """Runs of one job, each in a folder of its own below `root`."""

    def __init__(self, program: str, root: Path) -> None:
        self.program, self.root = program, root
        # The user's cache is left alone, and the matrix calls the program by its name.
        tools = root / "bin"
        tools.mkdir(parents=True)
        (tools / "spinney").symlink_to(program)
        path = f"{tools}{os.pathsep}{os.environ['PATH']}"
        self.environment = {**os.environ, "SPINNEY": program, "PATH": path, "XDG_CACHE_HOME": str(root / "cache"),
                            "PYTHONDONTWRITEBYTECODE": "1"}

    def words(self, out: Path) -> list[str]:
        return [*map(str, PLANTS), "--links", ",".join(LINKS), "--models", MODELS, "--steps", str(STEPS), "--size", SIZE,
                "--shards", str(SHARDS), "--workers", "2", "--program", self.program, "--out", str(out)]

    def sweeps(self, out: Path) -> list[sweep.Sweep]:
        return sweep.plan(sweep.arguments(self.words(out)))

    def run(self, command: list[str], **more: str) -> str:
        done = subprocess.run(command, env={**self.environment, **more}, text=True, stdout=subprocess.PIPE, check=True)
        return done.stdout

    def start(self, out: Path) -> subprocess.Popen[str]:
        command = [sys.executable, str(HERE / "sweep.py"), *self.words(out)]
        return subprocess.Popen(command, env=self.environment, text=True, stdout=subprocess.PIPE)

    def without_shards(self, out: Path) -> str:
        sweeps = self.sweeps(out)
        for one in sweeps:
            self.run([*one.command, "--out", str(out / "sweeps" / one.name)])
        sweep.table(sweeps, out)
        return f"{len(sweeps)} times `spinney sweep`"

    def on_dask(self, out: Path, wanted: int = TASKS, victim: str | None = None) -> str:
        with self.start(out) as process:
            note = "" if victim is None else kill_while_drawing(process, victim)
            said, _ = process.communicate()
        if process.returncode or f"{wanted} of {TASKS} shards to draw" not in said:
            raise SystemExit(f"exit code {process.returncode}, wanted {wanted} of {TASKS} shards to draw:\n{said}")
        return note or f"{wanted} of {TASKS} shards drawn"

    def once_more(self, out: Path) -> str:
        """After `on_dask` in the same folder: a shard is lost, and what was joined with it."""
        shards = sorted((out / "shards").glob("*/*-of-*"))
        shutil.rmtree(shards[4])
        shutil.rmtree(out / "sweeps")
        before = {shard: shard.stat().st_mtime_ns for shard in shards if shard.exists()}
        note = self.on_dask(out, wanted=1)
        if before != {shard: shard.stat().st_mtime_ns for shard in before}:
            raise SystemExit("shards that were there have changed")
        return note

    def as_array(self, out: Path) -> str:
        # From the last to the first, and one of them twice, as after a node was lost.
        for task in [*range(TASKS - 1, -1, -1), 1]:
            self.run(["bash", str(HERE / "slurm.sh"), *self.words(out)],
                     SLURM_ARRAY_TASK_ID=str(task), SWEEP=str(HERE / "sweep.py"))
        return self.on_dask(out, wanted=0)

    def as_matrix(self, out: Path) -> str:
        """Runs what ci-matrix.yml runs; its artefacts are folders here."""
        jobs = yaml.safe_load((HERE / "ci-matrix.yml").read_text())["jobs"]

        def command_of(job: str, name: str) -> list[str]:
            found = [step["run"] for step in jobs[job]["steps"] if step.get("name") == name]
            return ["bash", "-e", "-c", f"cd {out}\n{found[0]}"]

        sweeps = self.sweeps(out)
        names = out / "names"
        for one in sweeps:
            for shard in range(SHARDS):
                self.run(command_of("shard", "draw"), SCENE=f"scenes/{one.name}.toml", LINK=one.link, STEPS=str(STEPS),
                         MODELS=MODELS, SIZE=SIZE, SHARD=str(shard), SHARDS=str(SHARDS), GITHUB_OUTPUT=str(names))
                artefact = names.read_text().splitlines()[-1].removeprefix("name=")
                (out / "parts").mkdir(exist_ok=True)
                # As artefacts are kept, without hidden files.
                (out / "part" / ".spinney").unlink()
                (out / "part").rename(out / "parts" / f"part-{artefact}-{shard}")
        self.run(command_of("merge", "join"))
        # Scenes are called by plant and link already, and the matrix adds the link.
        for one in sweeps:
            (out / "sweeps" / f"{one.name}-{one.link}").rename(out / "sweeps" / one.name)
        sweep.table(sweeps, out)
        return f"{TASKS} jobs and a last one"


def kill_while_drawing(process: subprocess.Popen[str], victim: str) -> str:
    """Kills (SIGKILL) a worker of `process`, or the program that it runs, in the middle of a shard."""
    root = psutil.Process(process.pid)
    while process.poll() is None:
        for child in root.children(recursive=True):
            # Processes come and go while they are looked at.
            with contextlib.suppress(psutil.NoSuchProcess, psutil.ZombieProcess, ValueError):
                words = child.cmdline()
                shard, out = words[words.index("--shard") + 1], Path(words[words.index("--out") + 1])
                worker = child.parent()
                time.sleep(0.2)
                if worker is None or not child.is_running() or child.status() == psutil.STATUS_ZOMBIE:
                    continue
                (worker if victim == "worker" else child).kill()
                target = out.parent.parent / shard.replace("/", "-of-")
                if target.exists():
                    raise SystemExit(f"{target} was drawn before its {victim} was killed")
                return f"killed while it drew {target.parent.name.rsplit('-', 1)[0]} {shard}"
        time.sleep(0.005)
    raise SystemExit(f"it ended before a {victim} could be killed")


def contents(out: Path) -> dict[str, tuple[int, str]]:
    """Length and SHA-256 of every file of a result, and of the scenes that it is of."""
    files = [out / "sweep.csv", *(out / "scenes").rglob("*"), *(out / "sweeps").rglob("*")]
    return {path.relative_to(out).as_posix(): (path.stat().st_size, hashlib.sha256(path.read_bytes()).hexdigest())
            for path in sorted(files) if path.is_file()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.environ.get("SPINNEY", "spinney"))
    parser.add_argument("--out", type=Path, help="a new folder to keep everything in; default one that is removed")
    options = parser.parse_args()
    program = shutil.which(options.program)
    if program is None:
        parser.error(f"{options.program}: no such program; --program or SPINNEY says where spinney is")
    with contextlib.ExitStack() as stack:
        root = options.out or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="spinney-distributed-")))
        check = Check(str(Path(program).resolve()), root.resolve())
        dask = root.resolve() / "dask"
        runs: list[tuple[str, Path, Callable[[Path], str]]] = [
            ("without shards", root / "whole", check.without_shards),
            ("Dask, 2 workers", dask, check.on_dask),
            ("a worker killed", root / "worker", lambda out: check.on_dask(out, victim="worker")),
            ("the program killed", root / "program", lambda out: check.on_dask(out, victim="program")),
            ("a shard lost", dask, check.once_more),
            ("Slurm array", root / "slurm", check.as_array),
            ("CI matrix", root / "matrix", check.as_matrix),
        ]
        wanted: dict[str, tuple[int, str]] = {}
        different = 0
        lines = ["", f"{'run':20}{'files':>6}{'bytes':>12}{'s':>6}  SHA-256 of all  same"]
        for name, out, run in runs:
            start = time.monotonic()
            note = run(out.resolve())
            seconds, found = time.monotonic() - start, contents(out)
            wanted = wanted or found
            wrong = sorted(path for path in wanted.keys() | found.keys() if wanted.get(path) != found.get(path))
            different += bool(wrong)
            digest = hashlib.sha256(repr(found).encode()).hexdigest()[:14]
            lines.append(f"{name:20}{len(found):6}{sum(size for size, _ in found.values()):12,}{seconds:6.0f}  "
                         f"{digest}  {'NO: ' + ', '.join(wrong) if wrong else 'yes'}  ({note})")
            print(f"{name}: {note}", flush=True)
        print("\n".join(lines))
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
