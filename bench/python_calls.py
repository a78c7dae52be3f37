#!/usr/bin/env python3
"""Many calls on small meshes: meander.sample against the loop in C++ (bench/sampler_calls.cpp), in processor seconds.

    PYTHONPATH=build/release/python bench/python_calls.py PROGRAM [CALLS]
"""
import subprocess
import sys
import time

import numpy

import meander


def torus(rows, columns):
    i, j = [x.ravel() for x in numpy.meshgrid(numpy.arange(rows), numpy.arange(columns), indexing="ij")]
    a, b = 2 * numpy.pi * i / rows, 2 * numpy.pi * j / columns
    r = 1 + 0.5 * numpy.cos(b)
    vertices = numpy.stack([r * numpy.cos(a), r * numpy.sin(a), 0.5 * numpy.sin(b)], axis=1)
    at = lambda i, j: i % rows * columns + j % columns
    first = numpy.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1)], axis=1)
    second = numpy.stack([at(i, j), at(i + 1, j + 1), at(i, j + 1)], axis=1)
    return vertices, numpy.stack([first, second], axis=1).reshape(-1, 3)


def seconds_of(work):
    start = time.process_time()
    work()
    return time.process_time() - start


def main():
    program = sys.argv[1]
    calls = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    print("triangles samples    C++ s  Python s  ratio  own digests")
    for rows, columns, samples in [(6, 8, 64), (16, 16, 256), (16, 16, 1024)]:
        vertices, faces = torus(rows, columns)
        contents = [bytes([c & 255, c >> 8 & 255]) + bytes(30) for c in range(calls)]

        def named():
            for content in contents:
                meander.sample(vertices, faces, samples, content=content, threads=1)

        def unnamed():
            for _ in contents:
                meander.sample(vertices, faces, samples, threads=1)

        def native():
            return float(subprocess.run([program, str(rows), str(columns), str(samples), str(calls)], check=True,
                                        capture_output=True, text=True).stdout)

        # In turn, so that a busy machine slows all three; the fastest of five rounds each.
        times = [(native(), seconds_of(named), seconds_of(unnamed)) for _ in range(5)]
        loop, python, own = (min(column) for column in zip(*times))
        print("%9d %7d %8.3f %9.3f %6.2f %12.2f" % (len(faces), samples, loop, python, python / loop, own / loop))


main()
