"""The one entry: words of the command line go there, everything else opens the window."""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Sequence
from pathlib import Path

__all__ = ["main"]

NO_SCREEN = (
    "error: there is no screen here, so no window can open. Use the command line "
    "(bozzetto --help), for example: bozzetto samples -o out/"
)
EXIT_ERROR = 2

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
"""Our systems are small, a few hundred unknowns: the threads of the linear algebra would wait
for each other by spinning, which doubles a solve on two cores and takes them from the pen."""


PLAIN = argparse.Namespace(document=None, no_plugins=False, viewport=None)
"""What no arguments mean."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command, or open the window on an optional document.

    Parameters
    ----------
    argv : sequence of str, optional
        Default: the arguments of the process.

    Returns
    -------
    int
        The process's exit code.
    """
    for name in ONE_THREAD:  # read when numpy is first imported
        os.environ.setdefault(name, "1")
    from bozzetto.cli import COMMANDS, SWITCHES

    words = list(sys.argv[1:] if argv is None else argv)
    first = next((word for word in words if word not in SWITCHES), None)
    if first in COMMANDS or (words and words[0] in ("-h", "--help", "--version")):
        from bozzetto.cli.main import main as run

        return run(words)
    options = make_parser().parse_args(words) if words else PLAIN  # to make one takes a moment
    if not _has_screen():
        print(NO_SCREEN, file=sys.stderr)
        return EXIT_ERROR
    if options.viewport:
        os.environ["BOZZETTO_VIEWPORT"] = options.viewport
    gc.disable()  # nothing of what is imported now is garbage; `Tidier` collects later
    try:
        from bozzetto_app.source_search import leave_module_sources_unread

        leave_module_sources_unread()
        from bozzetto_app.startup import start
    except ImportError as problem:
        print(f"error: Qt cannot be loaded ({problem}). {_mend()}", file=sys.stderr)
        return EXIT_ERROR
    return start(options.document, plugins=not options.no_plugins)


def make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="bozzetto", description="Open the window; see “bozzetto --help” for the commands."
    )
    parser.add_argument("document", nargs="?", type=Path, help="a drawing, mesh or .bozz file")
    parser.add_argument("--no-plugins", action="store_true", help="start with no plugin at all")
    parser.add_argument("--viewport", choices=("software", "gl"), help="how shapes are drawn")
    return parser


def _has_screen() -> bool:
    """Whether a window can open: on Linux the xcb plugin would abort the process otherwise."""
    if sys.platform in ("win32", "darwin") or os.environ.get("QT_QPA_PLATFORM"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _mend() -> str:
    if sys.platform.startswith("linux"):
        return "Run “python3 bootstrap.py run”: it says which system libraries are missing."
    return "Install the program again."


if __name__ == "__main__":
    sys.exit(main())
