#!/usr/bin/env python3
"""Runs a peer's script with the mip level that spinney has, and dumps what it draws.

  peer.py PEERS run SCRIPT.py SWITCHES...     the script, with the nearest mip level in place of two
  peer.py PEERS run-trilinear SCRIPT.py ...   the script as it is
  peer.py PEERS dump FOLDER SWITCHES...       the arrays of the scene of these switches, for spinney-peers
  peer.py PEERS pictures A.png B.png OUT.png  how two pictures differ, and both beside their difference

PEERS is the folder of scene.py, llvmpipe_foliage.py and wgpu_foliage.py. Needs numpy and Pillow, and
for `run` what the script needs: the environment that the peers' setup.sh makes."""
import json
import os
import runpy
import sys


def nearest_mips():
    """Both APIs read the nearest mip level bilinearly from now on: four texels, not eight."""
    try:
        import moderngl

        moderngl.LINEAR_MIPMAP_LINEAR = moderngl.LINEAR_MIPMAP_NEAREST
    except ImportError:
        pass
    try:
        from wgpu.backends import wgpu_native
    except ImportError:
        return
    make = wgpu_native.GPUDevice.create_sampler

    def create_sampler(self, **options):
        options["mipmap_filter"] = "nearest"
        return make(self, **options)

    wgpu_native.GPUDevice.create_sampler = create_sampler


def run(peers, script, switches):
    path = os.path.join(peers, script)
    sys.argv = [path, *switches]
    runpy.run_path(path, run_name="__main__")


def dump(peers, folder, switches):
    import argparse

    import numpy as np

    import scene as S

    parser = argparse.ArgumentParser()
    S.add_args(parser)
    options = parser.parse_args(switches)
    os.makedirs(folder, exist_ok=True)

    def arrays(number, found):
        listed = {}
        for name, array in found.items():
            if array is None:
                continue
            array = np.ascontiguousarray(array)
            file = f"{number}-{name}.bin"
            array.astype(array.dtype.newbyteorder("<"), copy=False).tofile(os.path.join(folder, file))
            listed[name] = {"file": file, "shape": list(array.shape)}
        return listed

    if options.lines:
        size = options.width, options.height
        xy, rgba = S.synthetic_lines(options.lines, *size, options.seg_px)
        unit = [float(x) for x in np.eye(4).reshape(-1)]
        camera = {"width": size[0], "height": size[1], "view": unit, "proj": unit}
        batch = {"mode": "BLEND", "cutoff": 0.0, "color": [1.0] * 4, "wrap": ["clamp"] * 2}
        batches = [{**batch, "arrays": arrays(0, {"xy": xy, "rgba": rgba})}]
        clear = [0.0, 0.0, 0.0, 1.0]
    else:
        built = S.build(options)
        S.save_camera(os.path.join(folder, "camera.json"), built["camera"])
        camera = json.load(open(os.path.join(folder, "camera.json")))
        batches = []
        for number, b in enumerate(built["batches"]):
            found = {name: b[name] for name in ("pos", "nrm", "uv", "idx", "layer", "tex")}
            # The peers' matrices are row by row.
            found["inst"] = b["inst"].transpose(0, 2, 1).astype(np.float32)
            batches.append({"mode": b["mode"], "cutoff": float(b["cutoff"]), "color": [float(x) for x in b["color"]],
                            "wrap": list(b["wrap"]), "arrays": arrays(number, found)})
        clear = list(S.CLEAR)
    with open(os.path.join(folder, "scene.json"), "w") as file:
        json.dump({"camera": camera, "clear": clear, "batches": batches}, file, indent=1)


def pictures(one, other, out):
    """Prints one JSON object; OUT is both and where they differ, eight times as strong."""
    import numpy as np
    from PIL import Image

    a, b = (np.asarray(Image.open(file).convert("RGB")).astype(int) for file in (one, other))
    away = np.abs(a - b)
    most = away.max(-1)
    Image.fromarray(np.concatenate([a, b, np.minimum(8 * away, 255)], 1).astype(np.uint8)).save(out)
    error = (away ** 2).mean()
    print(json.dumps({"mean_difference": round(float(away.mean()), 3), "psnr_db": round(float(10 * np.log10(255 ** 2 / max(error, 1e-9))), 1),
                      "pixels_beyond_8": round(float((most > 8).mean()), 5), "pixels_beyond_32": round(float((most > 32).mean()), 5)}))


def main():
    peers, command, *rest = sys.argv[1:]
    sys.path.insert(0, os.path.abspath(peers))
    if command in ("run", "run-trilinear"):
        if command == "run":
            nearest_mips()
        run(os.path.abspath(peers), rest[0], rest[1:])
    elif command == "dump":
        dump(peers, rest[0], rest[1:])
    elif command == "pictures":
        pictures(*rest)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
