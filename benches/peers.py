#!/usr/bin/env python3
"""Times gmlvm beside POV-Ray and beside pictures written by hand, on the same pictures.

    cargo build --release
    python3 benches/peers.py OUT [--runs N] [--scenes a_spheres,b_csg]

Each scene of ../shared/bench is rendered by gmlvm, by POV-Ray, which has the same picture as
NAME.pov, and for some scenes by the program of ../shared/bench/limit, which is written by hand for
that picture alone. In each round each renders once, in turn, in a process with one thread; the one
who begins moves on from round to round. What counts is the user time of the whole process. Ratios
are medians of the rounds' ratios: above 1 is how many times as long the other took.

All images of a scene must be of one size, and those of others must differ from gmlvm's by at most
MAX_MEAN levels of 255 a channel on average, and in at most MAX_GROSS of all channels by more than one
level. If one does not, nothing is written.

Writes into the directory OUT
    peers.json   facts about the machine and the build, and all times
    summary.md   the section "Peers", with medians and ratios

Whoever is not there is left out, with a message. Only the standard library is used.
"""

import argparse
import datetime
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from history import SHARED, binary, write_summary

BENCH = SHARED / "bench"
WIDTH, HEIGHT = 800, 600

# The pictures that ../shared/bench/limit has, by the words for them.
LIMIT_WORDS = {"a_spheres": "a", "d_flat": "flat", "d_marble": "d", "e_mirror": "e"}

# A colour may be rounded up by one and down by the other, which is a level.
MAX_MEAN = 1.0

# Outlines, where a ray meets one thing or the other, and highlights, where POV-Ray's model is nearly
# ours, differ by more; a room of mirrors, of which each pixel may show some outline, has 0.5 %.
MAX_GROSS = 0.01


def contenders(scene, folder, povray, limit):
    """Who renders a scene: by name, a command and the file that it writes into the folder."""
    of = {"gmlvm": ([binary().resolve(), "run", "-q", "-j", "1", "-o", folder, "--output", "gmlvm.ppm", BENCH / f"{scene}.gml"], "gmlvm.ppm")}
    if povray:
        # Linear colours, as gmlvm writes them.
        options = ["+FP", f"+W{WIDTH}", f"+H{HEIGHT}", "-A", "-D", "+WT1", "-GA", "File_Gamma=1.0"]
        of["povray"] = ([povray, f"+I{BENCH / scene}.pov", f"+O{folder}/povray.ppm", *options], "povray.ppm")
    word = LIMIT_WORDS.get(scene)
    if limit and word:
        of["limit"] = ([limit, word, "1"], f"limit_{word}.ppm")
    return of


def user_time(command, folder):
    """User and system time of a process in seconds."""
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{command[0]} ended with exit code {process.returncode}\n{errors.decode(errors='replace')}")
    return round(usage.ru_utime, 6), round(usage.ru_stime, 6)


def read_ppm(path):
    """The bytes of a binary PPM file of 255 levels and of the size expected."""
    data = path.read_bytes()
    words, at = [], 0
    while len(words) < 4:
        if data[at:at + 1] == b"#":
            at = data.index(b"\n", at)
        elif data[at:at + 1].isspace():
            at += 1
        else:
            end = at
            while not data[end:end + 1].isspace():
                end += 1
            words.append(data[at:end])
            at = end
    expected = [b"P6", str(WIDTH).encode(), str(HEIGHT).encode(), b"255"]
    pixels = data[at + 1:]
    if words != expected or len(pixels) != 3 * WIDTH * HEIGHT:
        sys.exit(f"{path.name} is {words}, {len(pixels)} bytes, and should be {expected}")
    return pixels


def difference(a, b):
    """The mean absolute difference of a channel in levels, and the share of channels off by more than
    one level."""
    levels = [abs(x - y) for x, y in zip(a, b)]
    return {
        "mean": round(sum(levels) / len(levels), 4),
        "gross": round(sum(level > 1 for level in levels) / len(levels), 6),
    }


def race(scene, args, povray, limit):
    """All rounds of a scene: times by name, and how far images are from gmlvm's."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        of = contenders(scene, folder, povray, limit)
        times = {name: {"user": [], "system": []} for name in of}
        for round_idx in range(args.runs + 1):
            for turn in range(len(of)):
                name = list(of)[(turn + round_idx) % len(of)]
                user, system = user_time(of[name][0], folder)
                # The first round brings files into memory.
                if round_idx > 0:
                    times[name]["user"].append(user)
                    times[name]["system"].append(system)
        images = {name: read_ppm(folder / file) for name, (_, file) in of.items()}
    differences = {name: difference(images["gmlvm"], image) for name, image in images.items() if name != "gmlvm"}
    for name, found in differences.items():
        if found["mean"] > MAX_MEAN or found["gross"] > MAX_GROSS:
            sys.exit(f"{scene}: {name}'s is another image: {found}, and the bounds are {MAX_MEAN} and {MAX_GROSS}")
    return {"scene": scene, "times": times, "differences": differences}


def build_limit(folder):
    """The program of ../shared/bench/limit, built in another folder; none if it cannot be."""
    source = BENCH / "limit"
    if not source.is_dir():
        print(f"no {source}: nothing written by hand takes part", file=sys.stderr)
        return None
    copy = Path(folder) / "limit"
    # Its own flags for the compiler come along, in `.cargo`; files may be read-only there.
    shutil.copytree(source, copy, copy_function=shutil.copyfile, ignore=shutil.ignore_patterns("target"))
    unset = [name for name in os.environ if name in ("RUSTFLAGS", "CARGO_TARGET_DIR") or name.startswith("CARGO_PROFILE_")]
    environment = {name: value for name, value in os.environ.items() if name not in unset}
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=copy, env=environment, check=True)
    return copy / "target" / "release" / "limit"


def find_povray():
    povray = shutil.which("povray")
    if povray is None:
        print("no POV-Ray is installed, so it takes no part", file=sys.stderr)
    return povray


def version(command, name):
    """What a program says of its version, in a line that begins with its name."""
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    lines = result.stdout.decode(errors="replace").splitlines()
    return next((line.strip() for line in lines if line.startswith(name)), name)


def facts_here(build):
    """The day, the machine, and gmlvm as it was built."""
    names = [line.split(":", 1)[1].strip() for line in cpu_lines()]
    return {
        "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
        "cpu": names[0] if names else platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
        "load": round(os.getloadavg()[0], 2),
        "gmlvm": version([binary(), "--version"], "gmlvm"),
        "build": build,
    }


def about(args, povray):
    return facts_here(args.build) | {
        "povray": version([povray, "--version"], "POV-Ray") if povray else None,
        "width": WIDTH,
        "height": HEIGHT,
        "max_mean": MAX_MEAN,
        "max_gross": MAX_GROSS,
    }


def cpu_lines():
    path = Path("/proc/cpuinfo")
    text = path.read_text() if path.exists() else ""
    return [line for line in text.splitlines() if line.startswith("model name")]


def ratio(result, name):
    """How many times as long another takes as gmlvm: median, least and largest of the rounds."""
    pairs = zip(result["times"][name]["user"], result["times"]["gmlvm"]["user"])
    # A process that ends before the first tick of the clock has used no time that counts.
    ratios = sorted(other / ours for other, ours in pairs if ours > 0)
    return (statistics.median(ratios), ratios[0], ratios[-1]) if ratios else None


def table(results, facts):
    """The results in Markdown."""
    yield f"{facts['gmlvm']} ({facts['build']}); {facts['povray'] or 'no POV-Ray'}; {facts['cpu']}, load {facts['load']:.1f}. User time of whole processes, one thread, {WIDTH}x{HEIGHT}, medians; in brackets the least and the largest ratio of a round. The images differ by at most so many levels on average, and in at most so many channels by more than one level."
    yield ""
    yield "| scene | gmlvm (ms) | ns a pixel | POV-Ray (ms) | POV-Ray / gmlvm | by hand (ms) | gmlvm / by hand | levels | gross (%) | runs |"
    yield "| --- |" + " ---: |" * 9
    for result in results:
        times = result["times"]
        middle = {name: statistics.median(of["user"]) for name, of in times.items()}
        cells = [f"{1e3 * middle['gmlvm']:.0f}", f"{1e9 * middle['gmlvm'] / (WIDTH * HEIGHT):.0f}"]
        for name, is_inverse in (("povray", False), ("limit", True)):
            found = ratio(result, name) if name in times else None
            if found is None or is_inverse and found[1] == 0:
                cells += ["–", "–"]
                continue
            center, low, high = (1 / found[0], 1 / found[2], 1 / found[1]) if is_inverse else found
            cells += [f"{1e3 * middle[name]:.0f}", f"{center:.2f} [{low:.2f}, {high:.2f}]"]
        differences = result["differences"].values()
        mean, gross = (max((of[key] for of in differences), default=0) for key in ("mean", "gross"))
        cells += [f"{mean:.2f}", f"{100 * gross:.2f}", str(len(times["gmlvm"]["user"]))]
        yield f"| {result['scene']} | " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--runs", type=int, default=7, help="rounds that count")
    parser.add_argument("--scenes", default="", help="names, with commas between; without it all")
    parser.add_argument("--build", default="release build", help="how gmlvm was built, for the record")
    args = parser.parse_args()
    if args.runs < 1:
        parser.error("there must be a round that counts")
    scenes = sorted(path.stem for path in BENCH.glob("*.pov")) if BENCH.is_dir() else []
    if not scenes:
        print(f"skipped: there are no scenes in {BENCH}", file=sys.stderr)
        return
    wanted = [name for name in args.scenes.split(",") if name] or scenes
    unknown = set(wanted) - set(scenes)
    if unknown:
        parser.error(f"no such scene: {', '.join(sorted(unknown))}; there are {', '.join(scenes)}")
    povray = find_povray()
    with tempfile.TemporaryDirectory() as folder:
        limit = build_limit(folder)
        if povray is None and limit is None:
            print("skipped: there is nobody to compare with", file=sys.stderr)
            return
        facts = about(args, povray)
        results = []
        for scene in wanted:
            results.append(race(scene, args, povray, limit))
            print(f"{scene} done", file=sys.stderr)
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "peers.json").write_text(json.dumps({"about": facts, "results": results}, indent=1) + "\n")
    lines = list(table(results, facts))
    write_summary(args.out, [("Peers", lines)])
    print("\n".join(lines))


if __name__ == "__main__":
    main()
