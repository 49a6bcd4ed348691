#!/usr/bin/env python3
"""Measures what docs/goals.md promises, where a test cannot, and prints a line for each.

    cargo build --release
    python3 benches/goals.py [--gmlvm PATH] [--only kills,signals,hostile,memory,start,view] [--runs N]

kills    kill -9 at random times: images and parts are whole or absent, and a resumed run has the same bytes
signals  from SIGINT to the end of a run at 1920x1080, 50th, 99th percentile and longest
hostile  time and memory of `check --untrusted` for texts made to take much of either
memory   what `--max-memory` stops, by the memory of the process beyond that of an empty program
start    from the start to the first pixel of a 1x1 image, interpreted and as machine code
view     from saving a scene to its new image of 320x240 on the live page; at most 20 times each

Ends with 1 if a file is torn. Only the standard library is used; Linux only.
"""

import argparse
import hashlib
import itertools
import json
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "scenes" / "showpiece.gml"


def run(args, **kwargs):
    return subprocess.run([str(a) for a in args], capture_output=True, **kwargs)


def kills(gmlvm, folder, n_runs):
    """Kills runs that write an image over an older one, or parts, at times spread over their length."""
    size = ["--size", "240x160", "-q"]
    whole = folder / "whole.ppm"
    begun = time.monotonic()
    run([gmlvm, SCENE, *size, "--output", whole], check=True)
    length = time.monotonic() - begun
    wanted = hashlib.sha256(whole.read_bytes()).hexdigest()
    out = folder / "out"
    torn = completed = 0
    for number in range(n_runs):
        options = [] if number % 2 else ["--parts", folder / f"parts{number}"]
        args = [gmlvm, SCENE, *size, "--output", out / "a.ppm", *options]
        child = subprocess.Popen([str(a) for a in args], stderr=subprocess.DEVNULL)
        time.sleep(random.uniform(0, 1.1 * length))
        completed += child.poll() is not None
        child.kill()
        child.wait()
        for path in out.glob("*") if out.exists() else []:
            torn += hashlib.sha256(path.read_bytes()).hexdigest() != wanted
        if options:
            run(args, check=True)
            torn += hashlib.sha256((out / "a.ppm").read_bytes()).hexdigest() != wanted
    print(f"kills    {n_runs} runs killed, {completed} of them too late: {torn} torn or different files")
    return torn


def signals(gmlvm, folder, n_runs):
    # What is ignored here, as in the background of a shell, would be ignored by gmlvm too.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    times = []
    args = [gmlvm, SCENE, "--size", "1920x1080", "--samples", "8", "-q", "--output", folder / "big.ppm"]
    for _ in range(n_runs):
        child = subprocess.Popen([str(a) for a in args], stderr=subprocess.DEVNULL)
        time.sleep(random.uniform(0.1, 0.6))
        begun = time.monotonic()
        child.send_signal(signal.SIGINT)
        code = child.wait()
        times.append(1000 * (time.monotonic() - begun))
        assert code == 130, code
    times.sort()
    p99 = times[min(len(times) - 1, int(0.99 * len(times)))]
    left = [path.name for path in folder.glob("*big*")] + list(folder.glob(".gmlvm*"))
    print(
        f"signals  {n_runs} runs: {statistics.median(times):.1f} ms median, {p99:.1f} ms p99, "
        f"{times[-1]:.1f} ms longest; files left: {len(left)}"
    )
    return len(left)


def measured(args):
    """Exit code, seconds, seconds of processors and MiB of a process. What this script itself takes counts
    as the process's as long as that is not more, so the script must be small."""
    begun = time.monotonic()
    child = subprocess.Popen([str(a) for a in args], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    busy = usage.ru_utime + usage.ru_stime
    return child.returncode, time.monotonic() - begun, busy, usage.ru_maxrss / 1024


def nested_uses(n_names, depth):
    """A function whose parameters are used within many others."""
    names = [f"a{n} " for n in range(n_names)]
    return ["{ ", *("/" + name for name in names), "{ " * depth, *names, "} " * depth, "} "]


def conditions(n_values, depth):
    """A function that leaves values and decides what else, condition within condition."""
    return ["{ /x ", "x " * n_values, "x { } { " * depth, "} if " * depth, "} "]


def hostile(gmlvm, folder, _):
    million = 10**6
    texts = {
        "10^6 nested {": ("{" for _ in range(million)),
        "10^6 nested { }": (c for c in "{}" for _ in range(million)),
        "10^6 nested [": ("[ " for _ in range(million)),
        "10^6 union": ("{ } sphere /s s " if n == 0 else "s union " for n in range(million)),
        "100 MB of words": ("1 " * 1000 for _ in range(50_000)),
        "60 MB of words": ("1 " * 1000 for _ in range(30_000)),
        "60 MB in a string": ('"' if n in (0, 60_001) else "a" * 1000 for n in range(60_002)),
        "60 MB in a comment": ("%" + "a" * 999 for _ in range(60_000)),
        "60 MB of lines": ("\n" * 1000 for _ in range(60_000)),
        "integer of 10^6 digits": ("1" for _ in range(million)),
        "literals of 10^92, 10^5 of them": ("9" * 92 + " " for _ in range(10**5)),
        "262 144 words": ("1 " for _ in range(1 << 18)),
        "131 072 functions": ("{ } " for _ in range(1 << 17)),
        "131 072 bindings": (f"1 /n{i} " for i in range(1 << 17)),
        "262 144 unknown names": (f"n{i} " for i in range(1 << 18)),
        "names of 60 000 letters": (c * 60_000 + " " for c in ["1 /a", "b"]),
        "20 000 names used 490 deep": nested_uses(20_000, 490),
        "a name of a constant used 490 deep": ("1 /x ", "{ " * 490, "x " * 260_000, "} " * 490),
        "unknown names 490 deep": ("{ " * 490, "x " * 260_000, "} " * 490),
        "480 conditions behind 40 000 values": conditions(40_000, 480),
        "ends of 480 conditions, behind 32 values": itertools.chain.from_iterable(
            conditions(32, 480) for _ in range(77)
        ),
        "200 000 values 490 deep in arrays": ("{ /x ", "[ " * 490, "x x addi " * 80_000, "] " * 490, "} "),
    }
    for name, pieces in texts.items():
        path = folder / "hostile.gml"
        with path.open("w") as file:
            for piece in pieces:
                file.write(piece)
        code, seconds, busy, memory = measured([gmlvm, "check", "--untrusted", path])
        verdict = "" if busy <= 1 and memory <= 256 else "  MORE"
        print(f"hostile  {name:32} exit {code}  {seconds:5.2f} s, {busy:5.2f} s of processor, {memory:4.0f} MiB{verdict}")
    return 0


def memory(gmlvm, folder, _):
    path = folder / "memory.gml"
    path.write_text("")
    _, _, _, empty = measured([gmlvm, "eval", path])
    arrays = "{ /self /a [ a " + "0 " * 1000 + "] self self apply } /f 1 f f apply "
    programs = {
        "arrays": (arrays, ["eval"]),
        "operands": ("{ /self 1 2 3 4 5 6 7 8 9 self self apply } /f f f apply", ["eval"]),
        "calls": ("{ /self self self apply 1 } /f f f apply", ["eval"]),
        "a surface call": (
            "{ /v /u /face " + arrays + "} sphere 0.0 0.0 3.0 translate /s "
            '1.0 1.0 1.0 point [ ] s 1 60.0 1 1 "m.ppm" render',
            ["run", "-q", "-j1", "-o", folder],
        ),
    }
    for (name, (text, command)), limit in itertools.product(programs.items(), (66, 250, 500)):
        path.write_text(text)
        limits = ["--max-memory", f"{limit}M", "--max-depth", 10**9]
        code, _, _, used = measured([gmlvm, *command, path, *limits])
        over = 100 * (used - empty - limit) / limit
        print(f"memory   {name} --max-memory {limit}M: exit {code}, {used - empty:.0f} MiB beyond an empty program, {over:+.1f} %")
    return 0


def start(gmlvm, folder, n_runs):
    for engine in ("interp", "jit"):
        args = [gmlvm, ROOT / "scenes" / "hello.gml", "--size", "1x1", "--engine", engine, "-q"]
        times = [1000 * measured([*args, "--output", folder / "one.ppm"])[1] for _ in range(n_runs)]
        times.sort()
        print(f"start    {engine}: {statistics.median(times):.1f} ms median, {times[0]:.1f} ms least")
    return 0


def view(gmlvm, folder, n_runs):
    """Saves scenes as an editor does, and waits for the event of the whole image."""
    shutil.copytree(ROOT / "scenes", folder / "scenes")
    for name in ("hello", "marble", "die", "mirror-room"):
        scene = folder / "scenes" / f"{name}.gml"
        text = scene.read_text()
        server = subprocess.Popen(
            [str(a) for a in (gmlvm, "view", scene, "--size", "320x240")],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )
        try:
            events = urllib.request.urlopen(server.stdout.readline().strip() + "events")
            run = await_event(events, "picture")["run"]
            times = []
            for number in range(min(n_runs, 20)):
                # What is told of the image before is out of the way by then.
                time.sleep(random.uniform(1.5, 2.0))
                begun = time.monotonic()
                scene.write_text(f"{text}% {number}\n")
                while (event := await_event(events, "picture"))["run"] == run:
                    pass
                run = event["run"]
                times.append(1000 * (time.monotonic() - begun))
        finally:
            server.kill()
            server.wait()
        print(f"view     {name}: {statistics.median(times):.0f} ms median, {max(times):.0f} ms longest of {len(times)}")
    return 0


def await_event(events, kind):
    """The next event of a kind."""
    for line in events:
        if line.startswith(b"data:") and (event := json.loads(line[5:]))["event"] == kind:
            return event
    raise EOFError(kind)


def main():
    checks = {"kills": kills, "signals": signals, "hostile": hostile, "memory": memory, "start": start, "view": view}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmlvm", type=Path, default=ROOT / "target" / "release" / "gmlvm")
    parser.add_argument("--only", default=",".join(checks))
    parser.add_argument("--runs", type=int, default=200)
    args = parser.parse_args()
    wrong = 0
    for name in args.only.split(","):
        with tempfile.TemporaryDirectory() as folder:
            wrong += checks[name](args.gmlvm.resolve(), Path(folder), args.runs)
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main())
