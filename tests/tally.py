# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums the result files of all suites and ends with one line: `N passed, N failed, N skipped`.

    tally.py FOLDER [SUITE THAT ENDED BADLY ...]

Reads `*.ctest.xml` (ctest's JUnit, with cmocka's lines inside: each case counts), other `*.xml` (pytest's JUnit)
and `*.lines` ("name passed|failed|skipped"). A suite that ended badly without a failed case counts as one failure.
"""

from __future__ import annotations

import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

CASE = re.compile(r"^\[\s*(OK|FAILED|SKIPPED)\s*\]\s+(?!.*test\(s\))(\S+?)[:,]?(?:\s.*)?$", re.MULTILINE)


class Tally:
    def __init__(self) -> None:
        self.passed = 0
        self.failed: list[str] = []
        self.skipped: list[str] = []

    def ctest(self, path: Path) -> None:
        for case in ElementTree.parse(path).iter("testcase"):
            where = f"{path.name.split('.')[0]}: {case.get('name')}"
            seen: dict[str, set[str]] = {"OK": set(), "FAILED": set(), "SKIPPED": set()}
            for word, name in CASE.findall(case.findtext("system-out") or ""):
                seen[word].add(name)
            bad = case.find("failure") is not None or case.get("status") in ("fail", "notrun")
            if case.find("skipped") is not None:
                self.skipped.append(where)
                continue
            self.skipped += [f"{where}: {name}" for name in sorted(seen["SKIPPED"])]
            self.failed += [f"{where}: {name}" for name in sorted(seen["FAILED"])]
            self.passed += len(seen["OK"] - seen["FAILED"])
            if bad and not seen["FAILED"]:
                self.failed.append(f"{where}: ended badly")
            elif not any(seen.values()):
                self.passed += 1

    def pytest(self, path: Path) -> None:
        for case in ElementTree.parse(path).iter("testcase"):
            name = f"{path.stem}: {case.get('classname')}::{case.get('name')}"
            if case.find("failure") is not None or case.find("error") is not None:
                self.failed.append(name)
            elif case.find("skipped") is not None:
                reason = (case.find("skipped").get("message") or "").splitlines()
                self.skipped.append(f"{name}: {reason[0] if reason else ''}")
            else:
                self.passed += 1

    def lines(self, path: Path) -> None:
        for line in path.read_text().splitlines():
            name, _, word = line.rpartition(" ")
            if word == "passed":
                self.passed += 1
            else:
                (self.skipped if word == "skipped" else self.failed).append(f"{path.stem}: {name}")


def main(folder: str, *broken: str) -> int:
    tally = Tally()
    for path in sorted(Path(folder).iterdir()):
        try:
            if path.name.endswith(".ctest.xml"):
                tally.ctest(path)
            elif path.suffix == ".xml":
                tally.pytest(path)
            elif path.suffix == ".lines":
                tally.lines(path)
        except ElementTree.ParseError as error:
            tally.failed.append(f"{path.name} can't be read: {error}")
    if len(broken) > len(tally.failed):  # a suite that never came to report its cases
        tally.failed += [f"suite '{name}' ended badly" for name in broken][len(tally.failed) :]
    for title, names in (("skipped", tally.skipped), ("FAILED", tally.failed)):
        for name in names:
            print(f"{title}  {name}")
    for name in broken:
        print(f"ENDED BADLY  {name}")
    print(f"{tally.passed} passed, {len(tally.failed)} failed, {len(tally.skipped)} skipped")
    return 1 if tally.failed or broken else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
