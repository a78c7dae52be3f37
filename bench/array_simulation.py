#!/usr/bin/env python3
"""How long an array of tasks takes, from the costs of its shards, and what it needs of disk and merge time.

  array_simulation.py --models 10000000 --samples 2048 --tasks 1000 --shards 16000
  meander run STORE.run --shard ... --json >> shards.jsonl;  array_simulation.py --measured shards.jsonl --tasks 2

Tasks are started in the order of the shard numbers, the next one whenever one ends, as schedulers do it. Without
measured shards the costs of the models are drawn from a log-normal distribution (--sigma, of the logarithm) around
--milliseconds, cut into contiguous shards of about equal estimated cost as `meander plan` does it (estimates are off
by a log-normal factor of --error), and numbered by falling estimate.
"""
import argparse
import heapq
import json
import math
import random


def cut(costs, shards):
    """Contiguous ranges of about equal cost: their sums, as lists of first and last model."""
    block = 256
    while block > 1 and len(costs) < 16 * block * shards:
        block //= 2
    left, row, ranges = sum(costs), 0, []
    for s in range(shards):
        share, begin, total = left / (shards - s), row, 0.0
        while row < len(costs):
            cost = sum(costs[row:row + block])
            if s + 1 < shards and total > 0 and total + 0.5 * cost > share:
                break
            total += cost
            row += block
        row = min(row, len(costs))
        ranges.append((begin, row, total))
        left -= total
    return ranges


def makespan(seconds, tasks):
    busy = [0.0] * tasks
    for cost in seconds:
        heapq.heapreplace(busy, busy[0] + cost)
    return max(busy)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=int, default=100000)
    parser.add_argument("--samples", type=int, default=2048)
    parser.add_argument("--milliseconds", type=float, default=20.0, help="of one task for a model, in the median")
    parser.add_argument("--sigma", type=float, default=1.0)
    parser.add_argument("--error", type=float, default=0.5)
    parser.add_argument("--tasks", type=int, default=64, help="at work at once")
    parser.add_argument("--shards", type=int, default=1024)
    parser.add_argument("--start", type=float, default=0.05, help="seconds that a task takes to start and to end")
    parser.add_argument("--row-bytes", type=float, default=26.0, help="of a sample in the store")
    parser.add_argument("--merge-rate", type=float, default=200e6, help="bytes a second")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--measured", help="lines that `meander run STORE.run --json` printed")
    options = parser.parse_args()
    if options.measured:
        with open(options.measured) as lines:
            shards = sorted((json.loads(line) for line in lines), key=lambda shard: shard["shard"])
        seconds = [shard["seconds"] + options.start for shard in shards]
        models = sum(shard["rows"] for shard in shards)
    else:
        draw = random.Random(options.seed)
        # Blocks of models stand for models where there are very many: their sum is what counts.
        per_draw = max(1, options.models // 1000000)
        true = [sum(draw.lognormvariate(math.log(options.milliseconds * 1e-3), options.sigma)
                    for _ in range(per_draw)) for _ in range(options.models // per_draw)]
        estimated = [cost * draw.lognormvariate(0, options.error) for cost in true]
        ranges = sorted(cut(estimated, options.shards), key=lambda r: -r[2])
        seconds = [sum(true[begin:end]) + options.start for begin, end, _ in ranges]
        models = options.models
    total, longest = sum(seconds), max(seconds)
    span = makespan(seconds, options.tasks)
    bound = max(total / options.tasks, longest)
    size = models * options.samples * options.row_bytes
    print(f"{models} models, {len(seconds)} shards, {options.tasks} tasks at once")
    print(f"  work {total:.1f} s of one task, longest shard {longest:.1f} s, mean {total / len(seconds):.1f} s")
    print(f"  makespan {span:.1f} s, {span / bound:.3f} of the lower bound")
    print(f"  store about {size / 1e9:.1f} GB, twice that on disk while it is merged; merge {size / options.merge_rate:.0f} s")


if __name__ == "__main__":
    main()
