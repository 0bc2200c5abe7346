"""The command `cotree` of the wheel: the same program as the one that cargo builds."""

import os
import signal
import sys
from pathlib import Path

from . import _cotree


def main() -> int:
    """Runs the command line of this process."""
    # The program has no Python code to interrupt: Ctrl-C and a closed pipe end it as they would end it alone.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # The program looks beside itself, and that is Python's folder.
    runtimes = Path(__file__).parent / "runtimes"
    if runtimes.is_dir():
        os.environ.setdefault("COTREE_RUNTIMES", str(runtimes))
    return _cotree.command(["cotree", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
