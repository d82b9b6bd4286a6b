# SPDX-License-Identifier: GPL-3.0-or-later
"""The batch commands: detect, cull, restore, render, preview, report (DESIGN.md section 9).

Results go to stdout, one JSON object on one line a command; everything else to stderr, Blender's own talk included.
Exit code 0 done, 1 usage, 2 bad input (or a file that can't be read or written), 3 internal error or pictures that aren't equal, 130 stopped
by Ctrl-C.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import traceback
from collections.abc import Sequence

DONE, USAGE, BAD_INPUT, INTERNAL, INTERRUPTED = 0, 1, 2, 3, 130


class UsageError(Exception):
    """The command line is wrong; the message says how."""


class BadInput(Exception):
    """The file or the scene is wrong; the message says why and what to do."""


def log(message: str) -> None:
    print(message, file=sys.stderr, flush=True)


def progress(fraction: float, label: str) -> bool:
    """A progress callback for long work: one line at each new tenth. Raises KeyboardInterrupt when Ctrl-C was pressed."""
    if getattr(progress, "stop", False):
        raise KeyboardInterrupt
    step = (int(fraction * 10), label)
    if step != getattr(progress, "last", None):
        progress.last = step  # type: ignore[attr-defined]
        log(f"  {fraction:4.0%} {label}")
    return True


def heed_interrupts() -> None:
    """Ctrl-C ends a command at its next look at the progress, between files; pressed again, at once. Blender's own handler would only
    stop renders."""

    def asked(number, frame) -> None:
        if getattr(progress, "stop", False):
            raise KeyboardInterrupt
        progress.stop = True  # type: ignore[attr-defined]
        log("stopping soon (Ctrl-C again: at once)")

    signal.signal(signal.SIGINT, asked)


def main(arguments: Sequence[str], emit=None) -> int:
    """Runs one command on the open file; returns the exit code. emit: takes the result line (default: stdout)."""
    from . import command_line

    try:
        options = command_line.parser().parse_args(list(arguments))
    except UsageError as error:
        log(str(error))
        return USAGE
    except SystemExit as stop:  # --help
        return int(stop.code or 0)
    try:
        from importlib import import_module

        module = import_module(f".{options.command}_command", __package__)
        result = module.run(options)
    except UsageError as error:
        log(f"enfilade {options.command}: {error}")
        return USAGE
    except KeyboardInterrupt:
        log(f"enfilade {options.command}: stopped; files finished by then stay")
        return INTERRUPTED
    except Exception as error:
        from ..analysis import AnalysisError
        from ..native import NativeMissing
        from ..rules.assemble import AssemblyError
        from ..scene.detect import DetectError

        if isinstance(error, BadInput | AnalysisError | DetectError | AssemblyError | NativeMissing):
            log(f"enfilade {options.command}: {error}")
            for problem in getattr(error, "problems", [])[:10]:
                log(f"  {problem.severity}: {problem.message} {problem.remedy}")
            return BAD_INPUT if not isinstance(error, NativeMissing | AnalysisError) else INTERNAL
        if isinstance(error, OSError):  # a folder that can't be made, a full disk, a file in use
            log(f"enfilade {options.command}: " + (f"{error.filename}: {error.strerror}" if error.filename else str(error)))
            return BAD_INPUT
        log(traceback.format_exc())
        return INTERNAL
    code = result.pop("exit_code", DONE)
    line = json.dumps({"command": options.command, **result}, ensure_ascii=False, sort_keys=False)
    if emit is None:
        print(line, flush=True)
    else:
        emit(line)
    return code


run = main


def run_clean(arguments: Sequence[str]) -> int:
    """`main` with stdout kept for results alone: what Blender and its renderers say there goes to the log."""
    sys.stdout.flush()
    results = os.dup(1)
    os.dup2(2, 1)
    try:
        if list(arguments[:1]) != ["render"]:  # where Blender's own handler does
            heed_interrupts()
        return main(arguments, lambda line: os.write(results, (line + "\n").encode("utf-8", "surrogateescape")))
    except BaseException:
        log(traceback.format_exc())
        return INTERNAL
    finally:
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
            os.dup2(results, 1)
            os.close(results)


def run_script(argv: Sequence[str]) -> None:
    """What plugin/batch.py calls: parses after `--`, exits with the code."""
    sys.exit(run_clean(list(argv[argv.index("--") + 1 :]) if "--" in argv else []))
