"""The command `meander` of the wheel: gives way to the program in the package, which it does not import."""
import os
import sys

PROGRAM = os.path.join(os.path.dirname(os.path.abspath(__file__)), "meander", "bin", "meander")


def main():
    os.execv(PROGRAM, [PROGRAM] + sys.argv[1:])
