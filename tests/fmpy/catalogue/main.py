"""Every dynamic case of the catalogue through fmpy, each in a process of its own.

usage: main.py FOLDER       the folder of an unpacked FMU

Prints a line for each case: its name, `pass`, `fail` or `nothing` (the model has nothing that the case is about), and why.
"""

import os
import signal
import sys
import tempfile
import traceback

from cases import CASES
from fmu import Fmu

PATIENCE = 300  # seconds; a case that takes longer hangs


def work(check, folder, report):
    """In the child: runs a case and writes how it ended."""
    try:
        reason = check(Fmu(folder))
        report.write(f"nothing\t{reason}" if reason else "pass\t")
    except BaseException:
        report.write("fail\t" + traceback.format_exc())
    report.flush()
    os._exit(0)


def run(check, folder):
    """How a case ended."""
    with tempfile.TemporaryFile("w+") as report:
        child = os.fork()
        if child == 0:
            signal.alarm(PATIENCE)
            work(check, folder, report)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        report.seek(0)
        return report.read() if code == 0 else f"fail\tended with {code}"


def main(folder):
    for name, check in CASES.items():
        # One line for one case.
        print(f"{name}\t{run(check, folder)}".replace("\n", " | "), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
