#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# One door to everything: set-up, build, demo, tests, benchmarks, package. Run it without arguments for help.
set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$ROOT"
BUILD=$ROOT/build
PYTHON=/usr/bin/python3
PYTHON_LIBS=$BUILD/python # what pip brought; never the system's folders
JOBS=${ENFILADE_JOBS:-$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)}
DATA=${ENFILADE_DATA:-$ROOT/../shared/data}
# A Blender of the user's own comes before Debian's; after that Debian's tools come before anything else on PATH.
BLENDER=${ENFILADE_BLENDER:-$(command -v blender || true)}
export PATH="/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin:$PATH"
export PYTHONDONTWRITEBYTECODE=1 PYTHONNOUSERSITE=1
unset PYTHONPATH PYTHONHOME

say() { printf '\033[1m== %s\033[0m\n' "$*" >&2; }
note() { printf '   %s\n' "$*" >&2; }
die() {
    printf '\nbuild.sh: %s\n' "$*" >&2
    exit 1
}
trap 'code=$?; printf "\nbuild.sh: stopped, exit code %s, at line %s: %s\n" "$code" "$LINENO" "$BASH_COMMAND" >&2' ERR

help() {
    cat <<'TEXT'
Enfilade: what can be seen through the doors and windows of a building.

  ./build.sh demo                the sample house: found, culled, rendered, reported; a result to open in build/demo
  ./build.sh test                everything that is tested (what CI runs)

  ./build.sh deps                installs what is missing (apt on Debian 12; IfcOpenShell from PyPI into build/python)
  ./build.sh build               build/bin/enfilade and build/lib/libenfilade.so
  ./build.sh test PART ...       c | asan | tsan | shim | plain | blender | end | package | windows | lint | fuzz [SECONDS]
  ./build.sh bench [ARGS]        tables, CSV and a picture in build/bench
  ./build.sh package [windows]   build/package/enfilade-VERSION-PLATFORM.zip, the add-on as a user installs it
  ./build.sh clean               removes build/

demo, test, bench and package do the set-up they need. Environment: ENFILADE_BLENDER (a Blender to use instead of the
first on PATH), ENFILADE_NEW_BLENDER (a newer one the package tests try as well), ENFILADE_DATA (models to measure on,
default ../shared/data; what needs them is skipped without), ENFILADE_JOBS, ENFILADE_NO_DEPS=1 (install nothing).
TEXT
}

# ---- deps --------------------------------------------------------------------------------------------------
PACKAGES_BUILD=(gcc g++ libc6-dev cmake ninja-build pkg-config libjansson-dev libgmp-dev libcmocka-dev
    libembree-dev libcdd-dev libgeos-dev)
PACKAGES_DEMO=(blender python3 python3-numpy python3-openimageio openimageio-tools python3-pip ca-certificates time)
PACKAGES_TEST=(python3-pytest chromium xvfb xauth libgl1-mesa-dri clang clang-format libclang-rt-14-dev gcc-mingw-w64-x86-64-posix wine64 dpkg-dev zip unzip)
# IfcOpenShell and what its modules import, pinned; numpy is Debian's.
PYPI=(ifcopenshell==0.9.0.post1 shapely==2.2.0 isodate==0.7.2 python-dateutil==2.9.0.post0 six==1.17.0 lark==1.3.1
    pyparsing==3.3.3 typing-extensions==4.16.0)
RUFF=ruff==0.17.6

deps_apt() {
    local missing=() package
    for package in "$@"; do
        [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)" = installed ] || missing+=("$package")
    done
    [ ${#missing[@]} -gt 0 ] || return 0
    local as=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || die "these Debian packages are missing and neither root nor sudo is at hand: ${missing[*]}"
        as=(sudo)
    fi
    say "Installing ${#missing[@]} Debian packages: ${missing[*]}"
    local apt=("${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -q -o Dpkg::Use-Pty=0 -o Acquire::Retries=3)
    "${apt[@]}" update </dev/null >&2 || note "apt-get update failed; trying with the lists at hand"
    "${apt[@]}" install --no-install-recommends "${missing[@]}" </dev/null >&2 ||
        die "apt-get could not install: ${missing[*]} (its reason stands above)"
}

deps_ifc() {
    local stamp=$PYTHON_LIBS/.installed
    [ "$(cat "$stamp" 2>/dev/null || true)" = "${PYPI[*]}" ] && return 0
    say "Installing IfcOpenShell from PyPI into build/python"
    rm -rf "$PYTHON_LIBS" "$PYTHON_LIBS.part"
    if ! "$PYTHON" -m pip install --quiet --no-input --disable-pip-version-check --root-user-action=ignore --no-compile \
        --retries 2 --timeout 30 --no-deps --only-binary=:all: --target "$PYTHON_LIBS.part" "${PYPI[@]}" </dev/null >&2; then
        rm -rf "$PYTHON_LIBS.part"
        note "IfcOpenShell could not be had from PyPI (no network?). IFC files can't be read; all else works."
        note "Try again later with: ./build.sh deps"
        return 0
    fi
    mv "$PYTHON_LIBS.part" "$PYTHON_LIBS"
    local probe="import sys; sys.path.append('$PYTHON_LIBS'); import ifcopenshell.geom, ifcopenshell.util.element, ifcopenshell.util.placement"
    "$PYTHON" -c "$probe" || die "IfcOpenShell was installed into build/python but $PYTHON can't import it (reason above)"
    if [ -n "$BLENDER" ]; then
        "$BLENDER" -b --factory-startup --python-exit-code 3 --python-expr "$probe" >"$BUILD/ifc-probe.log" 2>&1 ||
            note "IfcOpenShell doesn't import in $BLENDER's Python (see build/ifc-probe.log): IFC needs a matching Python there"
    fi
    printf '%s' "${PYPI[*]}" >"$stamp"
}

# The style checker; tests skip, saying so, without it.
deps_tools() {
    [ -x "$BUILD/tools/bin/ruff" ] && return 0
    say "Installing ruff from PyPI into build/tools"
    "$PYTHON" -m pip install --quiet --no-input --disable-pip-version-check --root-user-action=ignore --no-deps \
        --only-binary=:all: --target "$BUILD/tools" "$RUFF" </dev/null >&2 || note "ruff could not be had from PyPI; style isn't checked"
}

# deps build|demo|all: only what that much needs, so that a demo doesn't wait for a browser and a Windows compiler.
deps() {
    mkdir -p "$BUILD"
    [ "${ENFILADE_NO_DEPS:-}" = 1 ] && return 0
    local wanted=("${PACKAGES_BUILD[@]}")
    [ "$1" = build ] || wanted+=("${PACKAGES_DEMO[@]}")
    [ "$1" = all ] && wanted+=("${PACKAGES_TEST[@]}")
    if command -v apt-get >/dev/null && command -v dpkg-query >/dev/null; then
        deps_apt "${wanted[@]}"
    else
        note "This is no Debian: nothing is installed. Needed: ${wanted[*]}"
    fi
    [ -n "$BLENDER" ] || BLENDER=$(command -v blender || true)
    [ "$1" = build ] || deps_ifc
    [ "$1" != all ] || deps_tools
}

need_blender() { [ -n "$BLENDER" ] || die "no Blender found: install one (Debian: apt-get install blender) or set ENFILADE_BLENDER"; }

# ---- build -------------------------------------------------------------------------------------------------
# configure_and_build FOLDER [CMAKE OPTIONS]
configure_and_build() {
    local folder=$1
    shift
    command -v cmake >/dev/null || die "cmake is missing: run ./build.sh deps"
    mkdir -p "$folder"
    local log=$folder/configure.log
    cmake -S csrc -B "$folder" -G Ninja "$@" >"$log" 2>&1 || {
        tail -n 30 "$log" >&2
        die "cmake could not configure ${folder#"$ROOT"/} (whole log: $log). If a library is missing: ./build.sh deps; if the folder was moved: ./build.sh clean"
    }
    cmake --build "$folder" -j "$JOBS" -- --quiet >&2 || die "compiling ${folder#"$ROOT"/} failed (reason above)"
}

build() {
    deps build
    say "Building the C core (build/release)"
    configure_and_build "$BUILD/release" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DENF_WERROR=ON -DENF_TESTS=ON
    mkdir -p "$BUILD/bin" "$BUILD/lib"
    ln -sfn ../release/bin/enfilade "$BUILD/bin/enfilade"
    ln -sfn ../release/lib/libenfilade.so "$BUILD/lib/libenfilade.so"
    note "build/bin/enfilade, build/lib/libenfilade.so"
}

# ---- demo --------------------------------------------------------------------------------------------------
batch() { # batch FILE.blend COMMAND OPTIONS...
    local file=$1
    shift
    note "blender -b ${file#"$ROOT"/} -P plugin/batch.py -- $*"
    "$BLENDER" -b --factory-startup "$file" --python-exit-code 3 -P plugin/batch.py -- "$@" </dev/null
}

demo() {
    deps demo
    need_blender
    build
    local out=$BUILD/demo
    rm -rf "$out"
    mkdir -p "$out"
    say "Rooms, doors and windows of the sample house"
    batch sample_blends/house.blend detect --save "$out/house.blend" --scene-json "$out/house.enf.json"
    say "The same building without Blender"
    "$BUILD/bin/enfilade" info "$out/house.enf.json"
    say "What each camera sees: the report"
    batch "$out/house.blend" report --out "$out/report"
    say "A culled view, saved to open in Blender"
    batch "$out/house.blend" cull --save "$out/house_culled.blend"
    say "One culled frame rendered beside the whole one and compared"
    batch "$out/house.blend" render --out "$out/render" --verify
    say "Done. Open"
    note "build/demo/report/report.html     who sees what, through which openings, in pictures (any browser)"
    note "build/demo/house_culled.blend     the house as the camera needs it (Blender)"
    note "build/demo/render/                the culled and the whole picture, and their comparison"
}

# ---- test --------------------------------------------------------------------------------------------------
RESULTS=${ENFILADE_RESULTS:-$BUILD/test-results}
HANGS=1800 # s after which a test counts as hung: many times what the slowest takes, for machines that are slow or shared
BROKEN=()

# suite NAME COMMAND...: runs it, goes on whatever happens; the sum is made from the result files at the end.
suite() {
    local name=$1 begin=$SECONDS code=0
    shift
    say "$name"
    trap - ERR
    set +e
    ( set -e; "$@" ) </dev/null
    code=$?
    set -e
    trap 'printf "\nbuild.sh: stopped at line %s: %s\n" "$LINENO" "$BASH_COMMAND" >&2' ERR
    [ $code -eq 0 ] || BROKEN+=("$name")
    note "$name: exit code $code, $((SECONDS - begin)) s"
}

# Old sanitizer runtimes can't map their shadow under high-entropy address randomisation: switch it off where allowed.
still() {
    if setarch "$(uname -m)" -R true 2>/dev/null; then setarch "$(uname -m)" -R "$@"; else "$@"; fi
}

run_ctest() { # run_ctest FOLDER RESULT
    export ENFILADE_DATA="$DATA"
    export ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1
    # Embree and its tasks aren't instrumented: what they synchronise by, the sanitizer can't see.
    export TSAN_OPTIONS=halt_on_error=1:ignore_noninstrumented_modules=1
    still ctest --test-dir "$1" -j "$JOBS" --timeout "$HANGS" --output-on-failure --no-tests=error \
        --test-output-size-passed 1000000 --test-output-size-failed 1000000 --output-junit "$RESULTS/$2.ctest.xml" >&2
}

test_c() { run_ctest "$BUILD/release" c; }
test_asan() {
    configure_and_build "$BUILD/asan" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DENF_WERROR=ON -DENF_SANITIZE=address,undefined
    local code=0
    run_ctest "$BUILD/asan" asan || code=$?
    # The same library under the shim's tests: what ctypes hands over is what real callers hand over. Python itself leaks.
    local preload # read by run_pytest
    preload=$(gcc -print-file-name=libasan.so):$(gcc -print-file-name=libubsan.so)
    ENFILADE_LIBRARY=$BUILD/asan/lib/libenfilade.so run_pytest shim-asan tests/shim --deselect tests/shim/test_library.py \
        -k "not compiler" || code=$?
    return $code
}
test_tsan() {
    configure_and_build "$BUILD/tsan" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DENF_WERROR=ON -DENF_SANITIZE=thread
    run_ctest "$BUILD/tsan" tsan
}

run_pytest() { # run_pytest RESULT FOLDER-OR-FILE...
    local result=$1
    shift
    local python=("$PYTHON")
    [ -z "${preload:-}" ] || python=(env LD_PRELOAD="$preload" ASAN_OPTIONS=detect_leaks=0 "$PYTHON")
    ENFILADE_BLENDER=$BLENDER ENFILADE_DATA=$DATA still "${python[@]}" -m pytest -q -p no:cacheprovider \
        --junit-xml "$RESULTS/$result.xml" "$@" >&2
}
test_shim() { run_pytest shim tests/shim tests/test_layers.py; }
test_plain() { run_pytest plain tests/plugin_plain; }
test_blender() {
    need_blender
    ENFILADE_DATA=$DATA "$BLENDER" -b --factory-startup --python-exit-code 3 -P tests/blender/run.py -- \
        --junit-xml "$RESULTS/blender.xml" >&2
}
test_end() {
    need_blender
    run_pytest end tests/end_to_end
}
test_package() {
    need_blender
    package
    run_pytest package tests/package
}
test_lint() { run_pytest lint tests/test_lint.py; }
test_windows() { tests/windows/run.sh "$RESULTS/windows.ctest.xml"; }

# What each target is asked when no time is given: the same questions on every machine, so that a change is judged and not the dice
# or the clock. About 2 s each.
declare -A QUESTIONS=([fuzz_decomposition]=6000 [fuzz_detect]=20000 [fuzz_portal_view]=6000 [fuzz_raycast]=500 [fuzz_rays]=900
    [fuzz_region_state]=2500 [fuzz_region_vis]=4000 [fuzz_scene_api]=40000 [fuzz_scene_json]=60000 [fuzz_scene_prt]=120000)

test_fuzz() { # test_fuzz [SECONDS] (for all targets together; without: QUESTIONS)
    local seconds=${1:-} targets target
    command -v clang >/dev/null || die "clang is missing: run ./build.sh deps"
    configure_and_build "$BUILD/fuzz" -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=RelWithDebInfo -DENF_FUZZ=ON -DENF_TESTS=OFF \
        -DENF_SANITIZE=fuzzer-no-link,address,undefined
    targets=("$BUILD"/fuzz/bin/fuzz_*)
    [ -x "${targets[0]}" ] || die "no fuzz target was built (tests/fuzz/fuzz_*.c)"
    local failed=0
    mkdir -p "$BUILD/fuzz/findings"
    for target in "${targets[@]}"; do
        local name=${target##*/} questions=() seeds=()
        if [ -n "$seconds" ]; then # what was found on the way is where the next run goes on
            mkdir -p "$BUILD/fuzz/corpus/$name"
            questions=(-max_total_time=$((seconds / ${#targets[@]} + 1)) -timeout=60)
            seeds=("$BUILD/fuzz/corpus/$name")
        else
            questions=(-seed=1 -runs="${QUESTIONS[$name]:-1000}" -timeout="$HANGS")
        fi
        if [ "$name" = fuzz_scene_json ]; then # by name: folders have an order of their own
            questions+=("-seed_inputs=$(cd "$BUILD/fuzz" && find ../../tests/scenes -type f | LC_ALL=C sort | paste -sd,)")
        fi
        [ ! -f "tests/fuzz/$name.dict" ] || questions+=("-dict=$ROOT/tests/fuzz/$name.dict")
        note "$name${seconds:+, $((seconds / ${#targets[@]} + 1)) s}"
        # In a folder of its own: some targets write files.
        if ! (cd "$BUILD/fuzz" && still "$target" "${questions[@]}" -rss_limit_mb=3000 -print_final_stats=1 -verbosity=0 \
            -artifact_prefix="$BUILD/fuzz/findings/$name-" "${seeds[@]}") >"$BUILD/fuzz/$name.log" 2>&1; then
            failed=1
            tail -n 40 "$BUILD/fuzz/$name.log" >&2
            note "$name found something: build/fuzz/findings/"
            printf '%s failed\n' "$name" >>"$RESULTS/fuzz.lines"
        else
            grep -E 'number_of_executed_units' "$BUILD/fuzz/$name.log" >&2 || true
            printf '%s passed\n' "$name" >>"$RESULTS/fuzz.lines"
        fi
    done
    return $failed
}

test_all() {
    deps all
    mkdir -p "$RESULTS"
    rm -f "$RESULTS"/*.xml "$RESULTS"/*.lines
    local parts=("$@")
    [ ${#parts[@]} -gt 0 ] || parts=(c asan tsan shim plain lint blender end package windows fuzz)
    build
    local part fuzz_seconds
    while [ ${#parts[@]} -gt 0 ]; do
        part=${parts[0]}
        parts=("${parts[@]:1}")
        case $part in
            c) suite "C tests, release" test_c ;;
            asan) suite "C tests under address and undefined-behaviour sanitizers" test_asan ;;
            tsan) suite "C tests under the thread sanitizer" test_tsan ;;
            shim) suite "Python shim and layers" test_shim ;;
            plain) suite "Plugin, the half without Blender" test_plain ;;
            lint) suite "Style and what must not be in the tree" test_lint ;;
            blender) suite "Inside Blender" test_blender ;;
            end) suite "End to end: the commands of README" test_end ;;
            package) suite "The zip as installed" test_package ;;
            windows) suite "Windows build under wine" test_windows ;;
            fuzz)
                fuzz_seconds=
                if [[ ${parts[0]:-} =~ ^[0-9]+$ ]]; then
                    fuzz_seconds=${parts[0]}
                    parts=("${parts[@]:1}")
                fi
                suite "Fuzzing${fuzz_seconds:+, $fuzz_seconds s}" test_fuzz "$fuzz_seconds"
                ;;
            *) die "test: no part named '$part' (c asan tsan shim plain lint blender end package windows fuzz [SECONDS])" ;;
        esac
    done
    say "Sum after $SECONDS s"
    trap - ERR
    "$PYTHON" tests/tally.py "$RESULTS" "${BROKEN[@]}"
}

# ---- the rest ----------------------------------------------------------------------------------------------
bench() {
    deps demo
    build
    [ -f tests/bench/run.py ] || die "tests/bench/run.py is missing"
    ENFILADE_BLENDER=$BLENDER ENFILADE_DATA=$DATA "$PYTHON" tests/bench/run.py --out "$BUILD/bench" "$@"
}

package() {
    deps demo
    build
    say "Packaging the add-on"
    "$PYTHON" plugin/package.py --library "$BUILD/release/lib/libenfilade.so" --out "$BUILD/package"
    [ "${1:-}" = windows ] || return 0
    deps all
    tests/windows/run.sh --build-only
    [ -f "$BUILD/windows/release/bin/libenfilade.dll" ] || die "no Windows library was built (reason above)"
    "$PYTHON" plugin/package.py --library "$BUILD/windows/release/bin/libenfilade.dll" --out "$BUILD/package"
}

command=${1:-help}
[ $# -eq 0 ] || shift
case $command in
    deps) deps all && say "Everything is there" ;;
    build | demo | package) "$command" "$@" ;;
    test) test_all "$@" ;;
    bench) bench "$@" ;;
    clean) say "Removing build/" && rm -rf "$BUILD" ;;
    help | -h | --help) help ;;
    *)
        help >&2
        die "no command named '$command'"
        ;;
esac
