# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the zip a user installs: the add-on with the shim and the C library of one platform inside, and nothing beside it.

    package.py --library build/lib/libenfilade.so --out build/package [--platform linux-x64]

The same zip installs as an add-on (Blender 3.4 to 4.1) and as an extension (4.2 and newer). Same input, same bytes.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TOP = "enfilade"
# The earliest date a zip can hold: the content alone decides the bytes.
DATE = (1980, 1, 1, 0, 0, 0)
# By the library's first bytes: its format and processor, so that a zip's name never lies about what is in it.
ELF_MACHINES = {62: "linux-x64", 183: "linux-arm64"}
PE_MACHINES = {0x8664: "windows-x64", 0xAA64: "windows-arm64"}

# Name, and Debian's package: its copyright file goes with it.
EMBREE = (("libembree3.so.3", "libembree3-3"), ("libtbb.so.12", "libtbb12"))
LINKED_IN = ("libgmp-dev", "libjansson-dev")


def platform_of(library: Path) -> str:
    head = library.read_bytes()[:4096]
    if head[:4] == b"\x7fELF":
        found = ELF_MACHINES.get(int.from_bytes(head[18:20], "little"))
    elif head[:2] == b"MZ":
        start = int.from_bytes(head[60:64], "little")
        found = PE_MACHINES.get(int.from_bytes(head[start + 4 : start + 6], "little"))
    elif head[:4] in (b"\xcf\xfa\xed\xfe", b"\xfe\xed\xfa\xcf"):
        found = "macos-arm64" if int.from_bytes(head[4:8], "little") == 0x0100000C else "macos-x64"
    else:
        found = None
    if found is None:
        sys.exit(f"package.py: {library} is no library of a platform Blender runs on")
    return found


def stripped(library: Path, folder: Path) -> bytes:
    """The library without debug sections, where a fitting strip is at hand; else as it is."""
    tool = "x86_64-w64-mingw32-strip" if library.suffix == ".dll" else "strip"
    if shutil.which(tool) is None or library.suffix == ".dylib":
        return library.read_bytes()
    out = folder / library.name
    done = subprocess.run([tool, "--strip-debug", "-o", str(out), str(library)], capture_output=True, text=True)
    return out.read_bytes() if done.returncode == 0 else library.read_bytes()


def bundled(platform: str) -> dict[str, Path]:
    """What triangles are met by (csrc/raycast/embree.c), and what that needs; without it, all but meshes in previews works. And
    the notices of all libraries inside."""
    embree = EMBREE if platform == "linux-x64" else ()
    listing = subprocess.run(["/sbin/ldconfig", "-p"], capture_output=True, text=True).stdout if embree else ""
    found = {line.split()[0]: Path(line.split()[-1]).resolve() for line in listing.splitlines() if "=>" in line and "x86-64" in line}
    files = {name: found.get(name, Path(name)) for name, _ in embree}
    packages = [*LINKED_IN, *(package for _, package in embree)]
    files |= {f"{package}.copyright": Path("/usr/share/doc") / package / "copyright" for package in packages}
    missing = [str(path) for path in files.values() if not path.is_file()]
    if missing:
        sys.exit(f"package.py: {', '.join(missing)} not found (apt-get install {' '.join(packages)})")
    return files


def sources(folder: Path) -> list[Path]:
    """Files of a package folder, without what Python leaves behind."""
    return sorted(p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts and p.suffix != ".pyc")


def manifest(text: str, platform: str, version: str) -> str:
    if re.search(r'^version = "' + re.escape(version) + '"$', text, re.M) is None:
        sys.exit(f"package.py: blender_manifest.toml doesn't have the version of VERSION, {version}")
    # Before the first table: afterwards the key would belong to [permissions].
    return text.replace("\n[permissions]", f'\nplatforms = ["{platform}"]\n\n[permissions]', 1)


def build(library: Path, out: Path, platform: str | None) -> Path:
    version = (ROOT / "VERSION").read_text().strip()
    library = library.resolve()
    platform = platform or platform_of(library)
    addon, shim = ROOT / "plugin" / TOP, ROOT / "python_shim" / "enfilade_native"
    content: dict[str, bytes] = {f"{TOP}/{p.relative_to(addon).as_posix()}": p.read_bytes() for p in sources(addon)}
    for path in sources(shim):
        content[f"{TOP}/enfilade_native/{path.relative_to(shim).as_posix()}"] = path.read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        # The shim looks for one name a platform; cross-built libraries keep theirs.
        content[f"{TOP}/enfilade_native/lib/{library.name}"] = stripped(library, Path(folder))
        for name, path in bundled(platform).items():
            content[f"{TOP}/enfilade_native/lib/{name}"] = path.read_bytes()  # Debian strips its libraries
    content[f"{TOP}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    name = f"{TOP}/blender_manifest.toml"
    content[name] = manifest(content[name].decode(), platform, version).encode()
    out.mkdir(parents=True, exist_ok=True)
    target = out / f"enfilade-{version}-{platform}.zip"
    part = target.with_suffix(".part")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(content):
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            entry.create_system = 3
            archive.writestr(entry, content[name])
    part.replace(target)
    return target


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--library", type=Path, required=True, help="the C library to bundle")
    parser.add_argument("--out", type=Path, required=True, help="folder of the zip")
    parser.add_argument("--platform", help="as Blender names it; default: read from the library")
    arguments = parser.parse_args()
    if not arguments.library.is_file():
        sys.exit(f"package.py: {arguments.library} is not there: ./build.sh build makes it")
    target = build(arguments.library, arguments.out, arguments.platform)
    print(f"{target} ({target.stat().st_size / 1e6:.2f} MB)")


if __name__ == "__main__":
    main()
