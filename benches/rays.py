#!/usr/bin/env python3
"""Times rays of gmlvm beside those of Embree 3, in ../shared/bench/c_flake.gml: 7381 spheres and a plane.

    cargo build --release
    python3 benches/rays.py OUT [--runs N]

The same rays on both sides, in one thread. Embree's are timed one by one, gmlvm's by what images take
in user time, less what other images take:

    eye     an image without the lamp: a ray and a constant surface function a pixel. Less an image of the
            same scene behind the eye, which has the making of rays and pixels, the scene and the process.
            Embree, by benches/embree/rays.cpp, makes each ray and calls `rtcIntersect1`.
    pixel   the same, less an image of one pixel: with the making of rays and pixels, and writing them.
            Embree does the same as before.
    shadow  an image with the lamp, less one without: with what is lit there, and how. Embree calls
            `rtcOccluded1` for rays that are made beforehand.

Embree's scene is robust (`RTC_SCENE_FLAG_ROBUST`), and its spheres are its own in single precision
(points) or a user geometry in double precision (doubles). gmlvm's are in double precision. In each round
all run once, in turn; the one who begins moves on from round to round. Ratios are medians of the rounds'
ratios, by which Embree takes longer: above 1 gmlvm is faster.

Both must meet as many spheres, as much of the plane, and block as many shadow rays, but for a share of
MAX_SHARE of all rays: outlines are elsewhere in single precision. If not, nothing is written.

Writes into the directory OUT
    rays.json    facts about the machine and the build, counts, and all times
    summary.md   the section "Rays", with medians and ratios

Without a C++ compiler or Embree 3 (Debian: libembree-dev) nothing is measured, with a message. Only the
standard library is used.
"""

import argparse
import json
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from history import SHARED, binary, write_summary
from peers import HEIGHT, WIDTH, facts_here, read_ppm, user_time

SCENE = SHARED / "bench" / "c_flake.gml"
SOURCE = Path(__file__).resolve().parent / "embree" / "rays.cpp"
LAMPS, NO_LAMPS = "[ l ] scene", "[ ] scene"
# The plane stands upright then, behind the eye as all else.
BEHIND = f"{NO_LAMPS} 90.0 rotatex 0.0 0.0 -20.0 translate"
KINDS = {"eye": "eye_s", "pixel": "eye_s", "shadow": "shadow_s"}
MAX_SHARE = 1e-4
GEOMETRIES = {"points": "Embree, points", "doubles": "Embree, doubles"}


def build_embree(folder):
    """The program with Embree's rays; none if it cannot be built here."""
    compiler = shutil.which("c++")
    if compiler is None:
        print("skipped: there is no C++ compiler", file=sys.stderr)
        return None
    include = b"#include <embree3/rtcore.h>\n"
    found = subprocess.run([compiler, "-fsyntax-only", "-x", "c++", "-"], input=include, stderr=subprocess.DEVNULL, check=False)
    if found.returncode != 0:
        print("skipped: there is no Embree 3 (Debian: libembree-dev)", file=sys.stderr)
        return None
    program = folder / "rays"
    subprocess.run([compiler, "-std=c++17", "-O3", "-march=native", "-o", program, SOURCE, "-lembree3"], check=True)
    return program


def gmlvm_commands(folder):
    """How gmlvm renders an image of a pixel, one of nothing, one without lamp, and all."""
    text = SCENE.read_text()
    if text.count(LAMPS) != 1:
        sys.exit(f"{SCENE} has no `{LAMPS}`")
    whole = f"{WIDTH}x{HEIGHT}"
    of = {}
    for name, lamps, size in (("one", NO_LAMPS, "1x1"), ("behind", BEHIND, whole), ("dark", NO_LAMPS, whole), ("lit", LAMPS, whole)):
        (folder / f"{name}.gml").write_text(text.replace(LAMPS, lamps))
        of[name] = [binary().resolve(), "run", "-q", "-j", "1", "--size", size, "--output", f"{name}.ppm", "--stats", f"{name}.json", f"{name}.gml"]
    return of


def run_embree(program, _):
    output = subprocess.run([program], stdout=subprocess.PIPE, check=True).stdout
    return {found.pop("geometry"): found for found in map(json.loads, output.splitlines())}


def race(folder, program, n_runs):
    """The times of all rounds, by who took them and for what, and what Embree counts."""
    of = {name: (user_time, command) for name, command in gmlvm_commands(folder).items()}
    of["embree"] = (run_embree, program)
    times = {name: {kind: [] for kind in KINDS} for name in ("gmlvm", *GEOMETRIES)}
    for round_idx in range(n_runs + 1):
        results = {}
        for turn in range(len(of)):
            name = list(of)[(turn + round_idx) % len(of)]
            run, command = of[name]
            results[name] = run(command, folder)
        # The first round brings files into memory.
        if round_idx == 0:
            continue
        one, behind, dark, lit = (results[name][0] for name in ("one", "behind", "dark", "lit"))
        for kind, seconds in (("eye", dark - behind), ("pixel", dark - one), ("shadow", lit - dark)):
            times["gmlvm"][kind].append(seconds)
            for geometry in GEOMETRIES:
                times[geometry][kind].append(results["embree"][geometry][KINDS[kind]])
    return times, results["embree"]


def gmlvm_counts(folder):
    """What gmlvm's rays have met, by the colours of its dark image, and by what it counts itself."""
    if any(read_ppm(folder / "behind.ppm")):
        sys.exit("something is seen of what should be behind the eye")
    pixels = read_ppm(folder / "dark.ppm")
    colours = [pixels[at:at + 3] for at in range(0, len(pixels), 3)]
    # Nothing else is bluish grey.
    n_plane = sum(red == green < blue for red, green, blue in colours)
    n_black = colours.count(bytes(3))
    rays = json.loads((folder / "lit.json").read_text())["rays"]
    return {"spheres": len(colours) - n_plane - n_black, "plane": n_plane, "shadow": rays["shadow"], "blocked": rays["shadow_blocked"]}


def check_counts(ours, theirs):
    for geometry, counts in theirs.items():
        for what, n in ours.items():
            if abs(counts[what] - n) > MAX_SHARE * WIDTH * HEIGHT:
                sys.exit(f"{GEOMETRIES[geometry]}: other rays, {what}: {counts[what]}, and gmlvm has {n}")


def table(results, facts):
    """The results in Markdown."""
    times, counts = results["times"], results["counts"]
    n_rays = {"eye": WIDTH * HEIGHT, "pixel": WIDTH * HEIGHT, "shadow": counts["gmlvm"]["shadow"]}
    yield f"{facts['gmlvm']} ({facts['build']}); {facts['cpu']}, load {facts['load']:.1f}. Nanoseconds of user time a ray, one thread, {WIDTH}x{HEIGHT}, medians of {len(times['gmlvm']['eye'])} rounds; in brackets the least and the largest ratio of a round."
    yield ""
    yield "| rays | number | gmlvm | " + " | ".join(f"{name} | ratio" for name in GEOMETRIES.values()) + " |"
    yield "| --- |" + " ---: |" * (2 + 2 * len(GEOMETRIES))
    for kind, n in n_rays.items():
        cells = [str(n)] + [f"{1e9 * statistics.median(times['gmlvm'][kind]) / n:.0f}"]
        for geometry in GEOMETRIES:
            pairs = zip(times[geometry][kind], times["gmlvm"][kind])
            # On a busy machine a difference may be anything.
            ratios = sorted(theirs / max(ours, 1e-9) for theirs, ours in pairs)
            cells += [f"{1e9 * statistics.median(times[geometry][kind]) / n:.0f}", f"{statistics.median(ratios):.2f} [{ratios[0]:.2f}, {ratios[-1]:.2f}]"]
        yield f"| {kind} | " + " | ".join(cells) + " |"
    yield ""
    yield "Met: " + "; ".join(f"{name} " + ", ".join(f"{what} {of[what]}" for what in counts["gmlvm"]) for name, of in counts.items()) + "."


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--runs", type=int, default=9, help="rounds that count")
    parser.add_argument("--build", default="release build", help="how gmlvm was built, for the record")
    args = parser.parse_args()
    if args.runs < 1:
        parser.error("there must be a round that counts")
    if not SCENE.exists():
        print(f"skipped: there is no {SCENE}", file=sys.stderr)
        return
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        program = build_embree(folder)
        if program is None:
            return
        times, embree = race(folder, program, args.runs)
        ours = gmlvm_counts(folder)
    check_counts(ours, embree)
    facts = facts_here(args.build) | {"max_share": MAX_SHARE}
    counts = {"gmlvm": ours} | {geometry: {what: embree[geometry][what] for what in ours} for geometry in GEOMETRIES}
    results = {"about": facts, "counts": counts, "times": times}
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "rays.json").write_text(json.dumps(results, indent=1) + "\n")
    lines = list(table(results, facts))
    write_summary(args.out, [("Rays", lines)])
    print("\n".join(lines))


if __name__ == "__main__":
    main()
