# SPDX-License-Identifier: MIT OR Apache-2.0
"""A farm of four workers bakes 210 probes; one worker is killed. Nothing is lost, nothing is baked twice.

Usage: check.py PROGRAM OPENJD FOLDER. Prints a line a check, and ends with 1 at the first that fails.
"""

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path

import jsonschema

PROGRAM, OPENJD, STUDIO = sys.argv[1], sys.argv[2], Path(sys.argv[3])
PROBES = 210
CHUNK = 15
WORKERS = 4
RECIPE = """#:schema ../../../docs/recipe.schema.json
output = "baked"

[[env]]
input = "probes/**/*.hdr"
output = "{folder}/{name}.ktx2"
size = 8
irradiance = "{folder}/{name}_diffuse.dds"
irradiance-size = 4
"""


def check(fact, what):
    print(("ok    " if fact else "WRONG ") + what, flush=True)
    if not fact:
        sys.exit(1)


def write_probes():
    """Radiance pictures of 16 x 8 texels, each with its lamp elsewhere."""
    for i in range(PROBES):
        path = STUDIO / "probes" / f"room{i % 7}" / f"probe{i:03}.hdr"
        path.parent.mkdir(parents=True, exist_ok=True)
        texels = bytearray(b"\x40\x50\x60\x80" * 128)
        texels[4 * (i % 128) : 4 * (i % 128) + 4] = bytes([200, 180, 160, 132 + i // 128])
        path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + texels)


def bake(*arguments, **variables):
    """Runs the recipe; the reports of its items."""
    command = [PROGRAM, "run", "recipe.toml", "--device", "cpu", "--json", "--quiet", *arguments]
    done = subprocess.run(command, cwd=STUDIO, env=os.environ | variables, capture_output=True, text=True)
    check(done.returncode == 0, f"run {' '.join(arguments)}{done.stderr and ': ' + done.stderr}")
    return reports(done.stdout)


def reports(log):
    """The items in what a process wrote, whatever stands before them in a line."""
    found = [json.loads(m[0]) for m in re.finditer(r'\{"item":.*\}', log)]
    return [(r["item"], r["outcome"]) for r in found]


def content(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.suffix != ".part"}


def state(folder):
    """Of probes that are done, to the last of their files: which file it is, and when it was written."""
    done = [Path(str(last).removesuffix("_diffuse.dds.baked.json") + ".ktx2") for last in folder.rglob("*.baked.json")]
    return {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in done}


class Worker(threading.Thread):
    """Takes tasks from the queue, as a farm hands them out, each in a session of openjd."""

    def __init__(self, queue, name):
        super().__init__()
        self.queue, self.log, self.process, self.task, self.dies = queue, STUDIO / f"{name}.log", None, None, False

    def run(self):
        while not self.dies:
            try:
                self.task = self.queue.pop(0)
            except IndexError:
                return
            command = [OPENJD, "run", "job.yaml", "--step", "Bake", "--task-param", f"Items={self.task}"]
            command += ["-p", f"Program={PROGRAM}", "-p", "Device=cpu", "-p", f"Output={STUDIO / 'farm'}"]
            with open(self.log, "a") as log:
                self.process = subprocess.Popen(command, cwd=STUDIO, stdout=log, stderr=log, start_new_session=True)
                code = self.process.wait()
            if self.dies:
                return
            if code != 0:
                print(self.log.read_text())
            check(code == 0, f"{self.log.stem} baked {self.task}")
            self.task = None


def descendants(process):
    """A process and all that it started, from /proc."""
    children = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
        except (OSError, IndexError):
            continue  # it has ended
        children.setdefault(parent, []).append(int(stat.parent.name))
    found = [process]
    for one in found:
        found += children.get(one, [])
    return found


def check_cancel():
    """A task that is cancelled ends long before the farm would kill it, and leaves nothing."""
    folder = STUDIO / "cancelled"
    folder.mkdir()
    (folder / "long.toml").write_text('[[bake]]\ntable = "split-sum"\nsize = 4096\noutput = "out.ktx2"\n')
    subprocess.run([PROGRAM, "run", "long.toml", "--emit-openjd", "job.yaml"], cwd=folder, check=True)
    command = [OPENJD, "run", "job.yaml", "--step", "Bake", "-p", f"Program={PROGRAM}", "-p", "Device=cpu"]
    log = STUDIO / "cancelled.log"
    with open(log, "w") as out:
        session = subprocess.Popen(command, cwd=folder, stdout=out, stderr=out)
        while "openjd_status: item 1" not in log.read_text() and session.poll() is None:
            time.sleep(0.05)
        start = time.monotonic()
        session.send_signal(signal.SIGINT)
        code = session.wait()
    took = time.monotonic() - start
    said = "error: cancelled" in log.read_text() and "exited with code: 130" in log.read_text()
    check(code != 0 and said and took < 8, f"a cancelled task ended after {took:.1f} s, with the session")
    check(sorted(p.name for p in folder.iterdir()) == ["job.yaml", "long.toml"], "it left no file")


def main():
    STUDIO.mkdir(parents=True)
    write_probes()
    (STUDIO / "recipe.toml").write_text(RECIPE)
    schema = json.loads((Path(__file__).parents[2] / "docs/recipe.schema.json").read_text())
    jsonschema.validate(tomllib.loads(RECIPE), schema)
    print("ok    the recipe fits its schema")

    emit = [PROGRAM, "run", "recipe.toml", "--emit-openjd", "job.yaml"]
    check(subprocess.run(emit, cwd=STUDIO).returncode == 0, "the job is written")
    done = subprocess.run([OPENJD, "check", "job.yaml"], cwd=STUDIO, capture_output=True, text=True)
    check(done.returncode == 0, f"openjd check: {done.stdout.strip()}")

    # What one process bakes is what all others must come to.
    alone = bake("-o", "alone")
    check(sorted(alone) == [(i, "baked") for i in range(1, PROBES + 1)], f"{PROBES} probes in one process")
    wanted = content(STUDIO / "alone")

    # Four workers; the first is killed, with all that it started, when it has baked a few.
    queue = [f"{first}-{min(first + CHUNK - 1, PROBES)}" for first in range(1, PROBES + 1, CHUNK)]
    workers = [Worker(queue, f"worker{i}") for i in range(WORKERS)]
    for worker in workers:
        worker.start()
    victim = workers[0]
    start = time.monotonic()
    while not victim.log.exists() or victim.log.read_text().count('"outcome":"baked"') < 4:
        if time.monotonic() - start > 120:
            check(False, "the first worker is at work")
        time.sleep(0.002)
    victim.dies = True
    task = victim.task
    for process in descendants(victim.process.pid):
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass  # it ended by itself
    victim.join()
    first, last = map(int, task.split("-"))
    before = state(STUDIO / "farm")
    cut = [item for item, outcome in reports(victim.log.read_text()) if first <= item <= last]
    check(0 < len(cut) < CHUNK, f"one worker of {WORKERS} was killed in the middle of {task}, after {len(cut)} items")

    # The farm gives the task to another.
    queue.append(task)
    heir = Worker(queue, "heir")
    heir.start()
    for worker in [*workers[1:], heir]:
        worker.join()

    found = content(STUDIO / "farm")
    check(found.keys() == wanted.keys(), f"all {len(wanted)} files are there")
    check(found == wanted, "each has the bytes that one process writes")
    logs = [log for worker in [*workers, heir] for log in reports(worker.log.read_text() if worker.log.exists() else "")]
    baked = [item for item, outcome in logs if outcome == "baked"]
    check(len(baked) == len(set(baked)), f"{len(baked)} reports of {PROBES} items: none was baked twice")
    after = state(STUDIO / "farm")
    check(all(after[path] == before[path] for path in before), f"the {len(before)} probes that were done by then were not written again")
    check({item for item, _ in logs} == set(range(1, PROBES + 1)), "every item was reported")
    progress = re.findall(r"openjd_progress: (\d+\.\d+)", heir.log.read_text())
    check(progress[-1:] == ["100.00"], "progress went to 100")

    # The same in shares, as Slurm numbers them.
    for index in range(3):
        slurm = {"ID": index + 1, "MIN": 1, "STEP": 1, "COUNT": 3}
        bake("-o", "shares", "--shard", "auto", **{f"SLURM_ARRAY_TASK_{key}": str(n) for key, n in slurm.items()})
    check(content(STUDIO / "shares") == wanted, "three shares come to the same bytes")

    check_cancel()


main()
