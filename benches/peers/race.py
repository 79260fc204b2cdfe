#!/usr/bin/env python3
"""Spinney beside other rasterizers in software: every scene, both sides in turn, one table at the end.

  race.py --peers FOLDER [--out FOLDER] [--only REGEX] [--pairs 5] [--threads 2] [--trilinear] [--no-setup]
          [--fastest NAME] [--realtime]

FOLDER holds scene.py, llvmpipe_foliage.py, wgpu_foliage.py and setup.sh; SPINNEY_PEERS may name it
instead. README.md tells what is measured. Needs Linux, Python 3.9, cargo, and what setup.sh installs."""
import argparse
import csv
import json
import os
import re
import statistics
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
CACHE = os.path.expanduser("~/.cache/spinney-peers")
VENV = os.environ.get("PEERS_VENV", os.path.join(CACHE, "venv"))
SWIFTSHADER = os.environ.get("PEERS_SWIFTSHADER", os.path.join(CACHE, "swiftshader"))
LAVAPIPE = os.environ.get("PEERS_LVP_ICD", "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json")

SMALL, LARGE = ["--width", "1024", "--height", "768"], ["--width", "1920", "--height", "1080"]
FOREST = ["--synthetic", "75000", "--instances", "100", *LARGE]
SLOW = ["--frames", "3", "--warmup", "1"]
LINES = ["--lines", "4400000", "--width", "1920", "--height", "945"]
# What a scene is, how many frames are drawn a run, and how many times faster spinney should be.
SCENES = {
    "tree-opaque-1024": (["--synthetic", "48160", *SMALL], ["--frames", "15"], 8),
    "tree-mask-1024": (["--synthetic", "48160", "--alpha", *SMALL], ["--frames", "15"], 8),
    "tree-opaque-1080p": (["--synthetic", "48160", *LARGE], ["--frames", "15"], 8),
    "tree-mask-1080p": (["--synthetic", "48160", "--alpha", *LARGE], ["--frames", "15"], 8),
    "forest-opaque": (FOREST, SLOW, 20),
    "forest-mask": ([*FOREST, "--alpha"], SLOW, 20),
    "impostors-far": (["--impostors", "2000", *LARGE], ["--frames", "11"], 5),
    "impostors-near": (["--impostors", "2000", "--zoom", "4", *LARGE], ["--frames", "7"], 5),
    "lines": (LINES, SLOW, 8),
}
# Scenes of spinney's own: exported by `spinney run --export-frame`.
OWN = {"yew-1024": ("yew.toml", ["--frames", "15"], 8)}
PEERS = {
    "llvmpipe": ("llvmpipe_foliage.py", []),
    "lavapipe": ("wgpu_foliage.py", ["--icd", LAVAPIPE]),
    "swiftshader": ("wgpu_foliage.py", ["--icd", os.path.join(SWIFTSHADER, "vk_swiftshader_icd.json")]),
}


class Side:
    """Runs commands on as many processors as there are threads."""

    def __init__(self, threads, realtime):
        self.cpus = sorted(os.sched_getaffinity(0))[:threads]
        self.realtime = realtime
        self.environment = {**os.environ, "LP_NUM_THREADS": str(threads), "RAYON_NUM_THREADS": str(threads)}

    def settle(self):
        os.sched_setaffinity(0, self.cpus)
        if self.realtime:
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))

    def run(self, command, what):
        done = subprocess.run([str(part) for part in command], env=self.environment, capture_output=True, text=True,
                              preexec_fn=self.settle)
        if done.returncode:
            lines = done.stderr.strip().splitlines()
            raise RuntimeError(f"{what}: {lines[-1] if lines else 'no message'}")
        lines = done.stdout.strip().splitlines()
        return json.loads(lines[-1]) if lines else None


def cargo(manifest, *switches):
    """Builds a package in release, and answers where its programs are."""
    subprocess.run(["cargo", "build", "--release", "--locked", "--manifest-path", manifest, *switches], check=True)
    told = subprocess.run(["cargo", "metadata", "--format-version", "1", "--no-deps", "--manifest-path", manifest],
                          check=True, capture_output=True, text=True)
    return os.path.join(json.loads(told.stdout)["target_directory"], "release")


class Race:
    def __init__(self, options):
        self.options = options
        self.python = os.path.join(VENV, "bin", "python")
        self.peer = [self.python, os.path.join(HERE, "peer.py"), os.path.abspath(options.peers)]
        self.side = Side(options.threads, options.realtime)
        self.ours = os.path.join(cargo(os.path.join(HERE, "Cargo.toml")), "spinney-peers")
        self.spinney = None
        self.rows = []

    def scene(self, name):
        """The switches by which a peer draws a scene, how many frames, and the folder of its dump."""
        folder = os.path.join(self.options.out, "scenes", name)
        if name in OWN:
            file, frames, goal = OWN[name]
            frame = os.path.join(self.options.out, "frames", name)
            if self.spinney is None:
                self.spinney = os.path.join(cargo(os.path.join(HERE, "../../Cargo.toml"), "--bin", "spinney"), "spinney")
            run = os.path.join(self.options.out, "runs", name)
            subprocess.run([self.spinney, "run", os.path.join(HERE, file), "--quiet", "-o", run, "--export-frame", frame],
                           check=True, stdout=subprocess.DEVNULL)
            switches = ["--glb", os.path.join(frame, "frame-0000.glb"), "--camera", os.path.join(frame, "frame-0000.camera.json")]
        else:
            switches, frames, goal = SCENES[name]
        if name in OWN or not os.path.exists(os.path.join(folder, "scene.json")):
            self.side.run([*self.peer, "dump", folder, *switches], f"{name}, dump")
        return switches, frames, goal, folder

    def run_peer(self, peer, switches, frames, out=None):
        script, own = PEERS[peer]
        command = "run-trilinear" if self.options.trilinear else "run"
        picture = ["--out", out] if out else []
        return self.side.run([*self.peer, command, script, *own, *switches, *frames, *picture], peer)

    def run_ours(self, folder, frames, out=None):
        picture = ["--out", out] if out else []
        threads = ["--threads", self.options.threads]
        return self.side.run([self.ours, "draw", folder, *threads, *frames, *picture], "spinney")

    def fastest(self, name, switches, frames):
        """The peer whose median is the least, in one run each."""
        if self.options.fastest:
            return self.options.fastest
        found = {}
        for peer in PEERS:
            try:
                found[peer] = self.run_peer(peer, switches, frames)
            except RuntimeError as fault:
                print(f"{name}: {fault}", file=sys.stderr)
                continue
            self.keep(name, peer, "trial", 0, found[peer])
        if not found:
            raise RuntimeError(f"{name}: no peer runs")
        return min(found, key=lambda peer: found[peer]["ms_median"])

    def keep(self, scene, side, kind, pair, run):
        keys = ("frames", "ms_median", "ms_min", "ms_max", "cpu_ms_per_frame", "others_cpu", "fragments_passed", "covered_px", "renderer")
        self.rows.append({"scene": scene, "side": side, "kind": kind, "pair": pair, **{key: run.get(key, "") for key in keys}})

    def race(self, name):
        switches, frames, goal, folder = self.scene(name)
        peer = self.fastest(name, switches, frames)
        out = os.path.join(self.options.out, "pictures")
        os.makedirs(out, exist_ok=True)
        files = [os.path.join(out, f"{name}-{side}.png") for side in ("spinney", "peer")]
        pairs = []
        for pair in range(self.options.pairs):
            first = pair == 0
            sides = [lambda: self.run_ours(folder, frames, files[0] if first else None),
                     lambda: self.run_peer(peer, switches, frames, files[1] if first else None)]
            # Who begins changes, so that neither always has the warmer or the busier machine.
            order = (0, 1) if pair % 2 == 0 else (1, 0)
            runs = {}
            for place in order:
                runs[place] = sides[place]()
            self.keep(name, "spinney", "pair", pair + 1, runs[0])
            self.keep(name, peer, "pair", pair + 1, runs[1])
            pairs.append((runs[0], runs[1]))
        beside = os.path.join(out, f"{name}.png")
        looks = self.side.run([*self.peer, "pictures", *files, beside], f"{name}, pictures")
        return Result(name, peer, goal, pairs, looks)


class Result:
    def __init__(self, name, peer, goal, pairs, looks):
        self.name, self.peer, self.goal, self.pairs, self.looks = name, peer, goal, pairs, looks

    def row(self):
        ours, theirs = zip(*self.pairs)
        ratios = [their["ms_median"] / our["ms_median"] for our, their in self.pairs]
        cpu = [their["cpu_ms_per_frame"] / max(our["cpu_ms_per_frame"], 0.01) for our, their in self.pairs]
        middle = statistics.median
        primitives = ours[0].get("triangles") or ours[0]["lines"]
        others = max(run["others_cpu"] for pair in self.pairs for run in pair)
        return [self.name, f"{primitives:,}", self.peer, f"{middle(run['ms_median'] for run in theirs):.1f}",
                f"{middle(run['ms_median'] for run in ours):.1f}", f"{min(ratios):.2f}", f"**{middle(ratios):.2f}**", f"{max(ratios):.2f}",
                f"{min(cpu):.2f}", f"**{middle(cpu):.2f}**", f"{max(cpu):.2f}", f"{self.goal}", f"{others:.2f}", f"{self.looks['mean_difference']}", f"{100 * self.looks['pixels_beyond_32']:.2f} %"]

    HEAD = ["scene", "primitives", "fastest peer", "its ms", "our ms", "ratio min", "median", "max", "of CPU time min", "median", "max", "wanted", "others' cores, most",
            "mean difference of 255", "pixels beyond 32"]


def write(options, rows, results):
    with open(os.path.join(options.out, "runs.csv"), "w", newline="") as file:
        table = csv.DictWriter(file, fieldnames=list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    lines = [Result.HEAD, ["---"] + ["---:" if column != "fastest peer" else "---" for column in Result.HEAD[1:]]]
    lines += [result.row() for result in results]
    text = "".join("| " + " | ".join(line) + " |\n" for line in lines)
    with open(os.path.join(options.out, "race.md"), "w") as file:
        file.write(text)
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", default=os.environ.get("SPINNEY_PEERS"))
    parser.add_argument("--out", default=os.path.join(HERE, "../../out/peers"))
    parser.add_argument("--only", default=".", help="scenes whose name this regular expression is found in")
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--trilinear", action="store_true", help="leave the peers their two mip levels")
    parser.add_argument("--fastest", choices=list(PEERS), help="race this peer without trying the others")
    parser.add_argument("--realtime", action="store_true", help="both sides before all other processes (as root), where others compute")
    parser.add_argument("--no-setup", action="store_true", help="do not call setup.sh")
    options = parser.parse_args()
    if not options.peers:
        parser.error("--peers or SPINNEY_PEERS must name the folder of the peers' scripts")
    if not options.no_setup:
        subprocess.run(["bash", os.path.join(options.peers, "setup.sh")], check=True)
    options.out = os.path.abspath(options.out)
    os.makedirs(options.out, exist_ok=True)
    race = Race(options)
    results, text = [], ""
    for name in [name for name in [*SCENES, *OWN] if re.search(options.only, name)]:
        try:
            results.append(race.race(name))
        except RuntimeError as fault:
            print(f"{name}: {fault}", file=sys.stderr)
            continue
        text = write(options, race.rows, results)
        print("| " + " | ".join(results[-1].row()) + " |", flush=True)
    print("\n" + text)


if __name__ == "__main__":
    main()
