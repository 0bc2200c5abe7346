"""The command `cotree` of the wheel: the same program as the one that cargo builds."""

import signal
import sys

from . import _cotree


def main() -> int:
    """Runs the command line of this process."""
    # The program has no Python code to interrupt: Ctrl-C and a closed pipe end it as they would end it alone.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _cotree.command(["cotree", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
