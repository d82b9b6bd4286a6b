#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Cross-builds the C core for Windows with mingw-w64 and runs its tests under wine.
#   run.sh [--build-only] [JUNIT.xml]      leaves build/windows/release/{bin,lib}
# Debian has no mingw builds of gmp, jansson and cmocka: their Debian sources are built once into build/windows/deps.
set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
HERE=$ROOT/build/windows
DEPS=$HERE/deps
HOST=x86_64-w64-mingw32
JOBS=${ENFILADE_JOBS:-$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)}
build_only=0
[ "${1:-}" != --build-only ] || {
    build_only=1
    shift
}
JUNIT=${1:-$HERE/windows.ctest.xml}

note() { printf '   %s\n' "$*" >&2; }
skip() { # the reason stands in the sum of all tests
    note "SKIPPED: $*"
    printf '%s skipped\n' "$*" >>"${JUNIT%.ctest.xml}.lines"
    exit 0
}

command -v $HOST-gcc-posix >/dev/null || skip "no mingw-w64 compiler (apt-get install gcc-mingw-w64-x86-64-posix)"
mkdir -p "$HERE"

fetch_sources() {
    local apt=$HERE/apt codename
    codename=$(. /etc/os-release && echo "${VERSION_CODENAME:-bookworm}")
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial" "$HERE/sources"
    # A sources file of our own: the system's list of sources stays as it is.
    echo "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian $codename main" \
        >"$apt/sources.list"
    local options=(-q -o Dir::Etc::SourceList="$apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
        -o Dir::State::Lists="$apt/lists" -o Dir::Cache="$apt/cache" -o Acquire::Languages=none
        -o Acquire::Retries=3 -o APT::Sandbox::User=root)
    apt-get "${options[@]}" update </dev/null >"$apt/log" 2>&1 || return 1
    (cd "$HERE/sources" && apt-get "${options[@]}" source --download-only gmp jansson cmocka </dev/null >>"$apt/log" 2>&1)
}

unpack() { # unpack NAME: dpkg-source lays out upstream's files with Debian's patches
    rm -rf "$HERE/sources/$1"
    dpkg-source --no-check -x "$HERE"/sources/"$1"_*.dsc "$HERE/sources/$1" >/dev/null
}

cross_cmake() { # cross_cmake NAME OPTIONS...
    local name=$1
    shift
    cmake -S "$HERE/sources/$name" -B "$HERE/sources/$name-build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_TOOLCHAIN_FILE="$ROOT/tests/windows/toolchain.cmake" -DENF_WINDOWS_DEPS="$DEPS.part" \
        -DCMAKE_INSTALL_PREFIX="$DEPS.part" -DBUILD_SHARED_LIBS=OFF "$@"
    cmake --build "$HERE/sources/$name-build" -j "$JOBS" --target install
}

build_deps() {
    rm -rf "$DEPS.part"
    mkdir -p "$DEPS.part"
    unpack cmocka && cross_cmake cmocka -DWITH_STATIC_LIB=ON -DWITH_EXAMPLES=OFF -DUNIT_TESTING=OFF
    # Only the static twin, under the name CMake looks for.
    rm -f "$DEPS.part/lib/libcmocka.dll.a" && mv "$DEPS.part/lib/libcmocka-static.a" "$DEPS.part/lib/libcmocka.a"
    unpack jansson && cross_cmake jansson -DJANSSON_BUILD_DOCS=OFF -DJANSSON_WITHOUT_TESTS=ON -DJANSSON_EXAMPLES=OFF
    unpack gmp
    mkdir -p "$HERE/sources/gmp-build"
    # Debian leaves the manual out and its configure still asks for it.
    [ -e "$HERE/sources/gmp/doc/Makefile.in" ] || {
        mkdir -p "$HERE/sources/gmp/doc"
        printf 'all install install-am clean distclean check:\n' >"$HERE/sources/gmp/doc/Makefile.in"
    }
    # No assembly, and so no m4: the exact fallback is rare enough not to matter.
    (cd "$HERE/sources/gmp-build" && CC=$HOST-gcc-posix CC_FOR_BUILD=gcc M4=m4-not-needed "$HERE/sources/gmp/configure" --host=$HOST --disable-assembly \
        --enable-static --disable-shared --prefix="$DEPS.part" && make -j "$JOBS" && make install)
    # Embree is opened at run time: its headers are all that building takes.
    mkdir -p "$DEPS.part/include" && cp -r /usr/include/embree3 "$DEPS.part/include/"
    rm -rf "$DEPS"
    mv "$DEPS.part" "$DEPS"
    rm -rf "$HERE/sources"
}

if [ ! -f "$DEPS/lib/libgmp.a" ] || [ ! -f "$DEPS/lib/libjansson.a" ]; then
    note "Getting the sources of gmp, jansson and cmocka from Debian"
    command -v dpkg-source >/dev/null || skip "no dpkg-source (apt-get install dpkg-dev)"
    fetch_sources || {
        tail -n 5 "$HERE/apt/log" >&2
        skip "the Debian sources of gmp, jansson and cmocka can't be had (build/windows/apt/log)"
    }
    note "Cross-building them (once; build/windows/deps.log)"
    set +e # and not "||", which would let build_deps run on after a failed step
    ( set -e; build_deps ) >"$HERE/deps.log" 2>&1 </dev/null
    code=$?
    set -e
    [ $code -eq 0 ] || {
        tail -n 20 "$HERE/deps.log" >&2
        note "cross-building the libraries failed"
        exit 1
    }
fi

wine=()
for candidate in /usr/lib/wine/wine64 "$(command -v wine64 || true)" "$(command -v wine || true)"; do
    [ -n "$candidate" ] && [ -x "$candidate" ] && wine=("$candidate") && break
done
note "Building for Windows (build/windows/release)"
cmake -S "$ROOT/csrc" -B "$HERE/release" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DENF_WERROR=ON \
    -DCMAKE_TOOLCHAIN_FILE="$ROOT/tests/windows/toolchain.cmake" -DENF_WINDOWS_DEPS="$DEPS" \
    -DENF_WINE="${wine[0]:-}" >"$HERE/configure.log" 2>&1 </dev/null || {
    tail -n 30 "$HERE/configure.log" >&2
    exit 1
}
cmake --build "$HERE/release" -j "$JOBS" -- --quiet >&2 </dev/null
[ $build_only -eq 0 ] || exit 0

[ ${#wine[@]} -gt 0 ] || skip "no wine to run the Windows tests (apt-get install wine64)"
export WINEPREFIX=$HERE/wine WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml=" DISPLAY=
export ENFILADE_DATA=${ENFILADE_DATA:-$ROOT/../shared/data}
if [ ! -d "$WINEPREFIX" ]; then
    note "Making a wine prefix (once)"
    timeout 300 "${wine[0]}" wineboot -i >"$HERE/wineboot.log" 2>&1 </dev/null || note "wineboot said no; trying all the same"
fi
code=0
ctest --test-dir "$HERE/release" -j "$JOBS" --timeout 1800 --output-on-failure --no-tests=error --test-output-size-passed 1000000 \
    --test-output-size-failed 1000000 --output-junit "$JUNIT" </dev/null >&2 || code=$?
wineserver=$(command -v wineserver || echo /usr/lib/wine/wineserver64)
[ ! -x "$wineserver" ] || "$wineserver" -k >/dev/null 2>&1 || true # of this prefix only
exit $code
