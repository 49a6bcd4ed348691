#!/usr/bin/env python3
"""Times gmlvm and writes the tables of a folder of benches/history.

    cargo build --release
    python3 benches/history.py OUT [--runs N] [--only kernels,scenes,pairs] [--skip c_flake]

writes into the directory OUT
    kernels.csv  what `cargo bench --bench surfaces` prints, once for each of three runs
    scenes.csv   one line for each run of each scene of scenes/ and ../shared/scenes, with 1 thread,
                 2 threads and 1 thread of the interpreter in turn: wall and processor time, and the
                 phases that --stats tells
    pairs.csv    the same for ../shared/bench, with 1 thread and 1 thread of the interpreter
    summary.md   medians

Folders that are not there are left out. A scene whose first run takes longer than --patience
seconds is run once. Only the standard library is used.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared"
SCENE_FOLDERS = [
    ("own", ROOT / "scenes"),
    ("contest", SHARED / "scenes" / "contest"),
    ("chicago", SHARED / "scenes" / "chicago"),
]
PHASES = ["read", "compile", "run", "build", "jit", "trace", "write"]
RAYS = ["primary", "reflected", "shadow", "surface_calls"]
FIELDS = ["set", "scene", "engine", "threads", "run_idx", "wall_s", "cpu_s", *PHASES, "images", "pixels", *RAYS]


def binary():
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    path = target / "release" / "gmlvm"
    if not path.exists():
        sys.exit(f"there is no {path}; `cargo build --release` makes it")
    return path


def time_scene(gmlvm, scene, engine, threads):
    """One run in a directory of its own: wall and processor time in seconds, and the statistics."""
    with tempfile.TemporaryDirectory() as folder:
        stats = Path(folder) / "stats.json"
        command = [gmlvm, "run", "-q", "--engine", engine, "-j", str(threads), "-o", folder]
        command += ["--stats", stats, scene]
        start = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"{scene} ended with exit code {process.returncode}")
        return wall, usage.ru_utime + usage.ru_stime, json.loads(stats.read_text())


def time_scenes(folders, variants, args, writer):
    """Writes a line for each run; returns the lines.

    All scenes are run once before any is run again, so that a burst of other work on the machine
    falls on one run of many scenes and not on all runs of one.
    """
    gmlvm = binary()
    skipped = set(args.skip.split(","))
    scenes = [(name, scene) for name, folder in folders for scene in sorted(folder.glob("*.gml"))]
    scenes = [(name, scene) for name, scene in scenes if scene.stem not in skipped]
    lines = []
    for run_idx in range(args.runs):
        slow = set()
        for name, scene in scenes:
            for engine, threads in variants:
                wall, cpu, stats = time_scene(gmlvm, scene, engine, threads)
                if wall > args.patience:
                    slow.add(scene)
                line = {
                    "set": name, "scene": scene.stem, "engine": engine, "threads": threads,
                    "run_idx": run_idx, "wall_s": f"{wall:.5f}", "cpu_s": f"{cpu:.5f}",
                    "images": stats["counts"]["images"], "pixels": stats["counts"]["pixels"],
                }
                line |= {phase: f"{stats['phases'][phase]:.6f}" for phase in PHASES}
                line |= {kind: stats["rays"][kind] for kind in RAYS}
                lines.append(line)
        scenes = [(name, scene) for name, scene in scenes if scene not in slow]
        print(f"run {run_idx + 1} of {args.runs}", file=sys.stderr)
    order = list(dict.fromkeys((line["set"], line["scene"]) for line in lines))
    lines.sort(key=lambda line: order.index((line["set"], line["scene"])))
    writer.writerows(lines)
    return lines


def median(lines, field, **wanted):
    values = [
        float(line[field]) for line in lines if all(line[k] == v for k, v in wanted.items())
    ]
    return statistics.median(values) if values else None


def scene_table(lines, variants):
    """A table in Markdown of medians. Processor time bears other work on the machine far better
    than wall time does, so the engines are compared by it."""
    columns = ["auto, processor (ms)", "interp, processor (ms)", "interp / auto", "ns a pixel"]
    columns += [f"{engine}, {n} thread{'s'[: n > 1]}, wall (ms)" for engine, n in variants]
    columns += ["1 / 2 threads", "rays", "runs"]
    yield "| scene | " + " | ".join(columns) + " |"
    yield "| --- |" + " ---: |" * len(columns)
    for name, scene in dict.fromkeys((line["set"], line["scene"]) for line in lines):
        of = {"set": name, "scene": scene}
        plain = of | {"engine": "auto", "threads": 1}
        auto = median(lines, "cpu_s", **plain)
        interp = median(lines, "cpu_s", **of | {"engine": "interp", "threads": 1})
        pixels = median(lines, "pixels", **of)
        cells = [f"{1e3 * auto:.1f}", f"{1e3 * interp:.1f}", f"{interp / auto:.2f}"]
        cells.append(f"{1e9 * auto / pixels:.0f}" if pixels else "–")
        walls = {v: median(lines, "wall_s", engine=v[0], threads=v[1], **of) for v in variants}
        cells += [f"{1e3 * wall:.1f}" for wall in walls.values()]
        both = walls.get(("auto", 2))
        cells.append(f"{walls['auto', 1] / both:.2f}" if both else "–")
        cells.append(f"{sum(median(lines, kind, **of) for kind in RAYS[:3]):.0f}")
        cells.append(str(sum(1 for line in lines if plain.items() <= line.items())))
        yield f"| {name}/{scene} | " + " | ".join(cells) + " |"


def run_kernels(out):
    """Three runs of the kernel benchmark; returns the fields of its lines behind the run's number."""
    rows = []
    for run_idx in range(3):
        command = ["cargo", "bench", "--quiet", "--bench", "surfaces"]
        text = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
        rows += [[str(run_idx), *line.split()] for line in text.splitlines()[1:]]
    with open(out / "kernels.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["run_idx", "function", "engine", "median_ns", "min_ns", "of_rust"])
        writer.writerows(rows)
    return rows


def kernel_table(rows):
    yield "| function | engine | ns (median of the runs' medians) | fastest | of Rust (median) |"
    yield "| --- | --- | ---: | ---: | ---: |"
    for function, engine in dict.fromkeys((row[1], row[2]) for row in rows):
        runs = [row[3:] for row in rows if row[1:3] == [function, engine]]
        ns = statistics.median(float(run[0]) for run in runs)
        fastest = min(float(run[1]) for run in runs)
        ratios = [float(run[2]) for run in runs if run[2] != "-"]
        ratio = f"{statistics.median(ratios):.3f}" if ratios else "–"
        yield f"| {function} | {engine} | {ns:.2f} | {fastest:.2f} | {ratio} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--runs", type=int, default=5, help="runs of each scene")
    parser.add_argument("--patience", type=float, default=30.0, help="seconds; slower is run once")
    parser.add_argument("--only", default="kernels,scenes,pairs")
    parser.add_argument("--skip", default="", help="names of scenes to leave out")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    wanted = args.only.split(",")
    parts = []
    if "kernels" in wanted:
        parts.append(("Kernels", list(kernel_table(run_kernels(args.out)))))
    sets = [
        ("scenes", "Scenes", SCENE_FOLDERS, [("auto", 1), ("auto", 2), ("interp", 1)]),
        ("pairs", "Benchmark scenes", [("bench", SHARED / "bench")], [("auto", 1), ("interp", 1)]),
    ]
    for part, title, folders, variants in sets:
        if part not in wanted:
            continue
        with open(args.out / f"{part}.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
            writer.writeheader()
            lines = time_scenes(folders, variants, args, writer)
        if lines:
            parts.append((title, list(scene_table(lines, variants))))
    write_summary(args.out, parts)


def write_summary(out, parts):
    """Sections made by this run replace those of the same title; others stay."""
    path = out / "summary.md"
    sections = {}
    for section in path.read_text().split("\n## ")[1:] if path.exists() else []:
        title, body = section.split("\n", 1)
        sections[title] = body.strip()
    for title, lines in parts:
        sections[title] = "\n".join(lines)
    order = ["Kernels", "Scenes", "Benchmark scenes"]
    titles = [title for title in order if title in sections]
    titles += [title for title in sections if title not in order]
    text = "".join(f"\n## {title}\n\n{sections[title]}\n" for title in titles)
    path.write_text(f"# Medians\n{text}")


if __name__ == "__main__":
    main()
