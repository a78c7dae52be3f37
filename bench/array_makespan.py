#!/usr/bin/env python3
"""The makespan that array_simulation.py foresees, beside the measured one.

    bench/array_makespan.py PROGRAM INPUT... [-- OPTIONS OF meander plan]

Plans INPUT as 64 shards, runs them one after the other, simulates two tasks at once from the time of each, then runs
the array again with two tasks at once: the next shard is started when a task ends. Prints both makespans and the sum of
plan, shards and merge beside one `meander run -j 1` in processor seconds; the stores must be the same.
"""
import filecmp
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time

from array_simulation import makespan

SHARDS, TASKS, ROUNDS = 64, 2, 3


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def call(*words):
    # 3: some items have failed, and are recorded.
    if subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode not in (0, 3):
        sys.exit("failed: " + " ".join(words))


def run_array(program, store, inputs, options, tasks):
    """Wall seconds of the shards in their order, and of all of them with `tasks` at once; with plan and merge the
    processor seconds."""
    begin_processor = processor_seconds()
    call(program, "plan", *inputs, "-o", store, "--shards", str(SHARDS), *options)
    seconds, lock, left = [0.0] * SHARDS, threading.Lock(), list(range(SHARDS))

    def work():
        while True:
            with lock:
                if not left:
                    return
                shard = left.pop(0)
            begin = time.perf_counter()
            call(program, "run", store + ".run", "--shard", f"{shard}/{SHARDS}", "-j", "1", "--progress", "none")
            seconds[shard] = time.perf_counter() - begin

    begin = time.perf_counter()
    workers = [threading.Thread(target=work) for _ in range(tasks)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    span = time.perf_counter() - begin
    call(program, "merge", store + ".run")
    return seconds, span, processor_seconds() - begin_processor


def main():
    words, options = sys.argv[1:], []
    if "--" in words:
        words, options = words[:words.index("--")], words[words.index("--") + 1:]
    if len(words) < 2:
        sys.exit(__doc__)
    program, inputs = os.path.abspath(words[0]), words[1:]
    with tempfile.TemporaryDirectory() as folder:
        print(f"{SHARDS} shards: simulated and measured makespan of {TASKS} tasks, processor s of array and run")
        for round_ in range(ROUNDS):
            paths = [os.path.join(folder, f"{name}{round_}.h5") for name in ("one", "two", "run")]
            seconds, _, _ = run_array(program, paths[0], inputs, options, 1)
            _, span, cost = run_array(program, paths[1], inputs, options, TASKS)
            begin = processor_seconds()
            call(program, "run", *inputs, "-o", paths[2], "-j", "1", "--progress", "none", *options)
            whole = processor_seconds() - begin
            if not (filecmp.cmp(paths[0], paths[1], False) and filecmp.cmp(paths[0], paths[2], False)):
                sys.exit("the stores differ")
            foreseen = makespan(seconds, TASKS)
            print(f"  {foreseen:7.2f} {span:7.2f} s   measured / simulated {span / foreseen:.3f}"
                  f"   {cost:7.2f} {whole:7.2f} s   array / run {cost / whole:.3f}", flush=True)
            for path in paths:
                os.remove(path)


if __name__ == "__main__":
    main()
