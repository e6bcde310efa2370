#!/usr/bin/env bash
# Installs what sdfprt needs on a fresh machine: system packages (Debian, Ubuntu), a virtual environment in .venv, the package.
# Usage: scripts/setup.sh [extras]      TORCH="torch==2.13.0" chooses the build of PyTorch; PYTHON chooses the interpreter.
set -euo pipefail
cd "$(dirname "$0")/.."
extras=${1:-}
python=${PYTHON:-python3}
torch=${TORCH:-torch==2.13.0}

# OpenGL without a screen: EGL and Mesa's software driver
if ! ldconfig -p | grep -q 'libEGL\.so\.1' || ! compgen -G '/usr/lib/*/dri/swrast_dri.so' >/dev/null || ! "$python" -c 'import ensurepip' 2>/dev/null; then
    if ! command -v apt-get >/dev/null; then
        echo "setup: please install EGL, Mesa's software rasteriser and Python's venv with your package manager" >&2
        exit 1
    fi
    as_root=$([ "$(id -u)" = 0 ] || echo sudo)
    $as_root apt-get update -qq
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq libegl1 libgl1-mesa-dri python3-venv >/dev/null
fi

# A browser for the tests of `sdfprt export`, a display for those of `sdfprt view`, a compiler for those of a card's warps; they are
# skipped without them
if [[ $extras == *test* ]] && command -v apt-get >/dev/null &&
    { ! command -v chromium chromium-browser google-chrome >/dev/null || ! command -v g++ >/dev/null; }; then
    as_root=$([ "$(id -u)" = 0 ] || echo sudo)
    $as_root apt-get update -qq && $as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends chromium xvfb g++ libc6-dev >/dev/null || {
        echo "setup: no chromium, no Xvfb or no g++; their tests will be skipped" >&2
        [ -z "${SDFPRT_NO_SKIPS:-}" ] || exit 1
    }
fi

# The environment is made anew only when what it depends on has changed
stamp=.venv/.sdfprt-setup
state="$torch $(cksum <pyproject.toml) $(cksum <scripts/setup.sh)"
want="$state [$extras]"
have=$(cat "$stamp" 2>/dev/null || true)
if [ "$have" != "$want" ] && ! { [ -z "$extras" ] && [[ $have == "$state ["* ]]; }; then
    [ -x .venv/bin/python ] || "$python" -m venv .venv
    echo "setup: installing into .venv (a few minutes the first time)"
    .venv/bin/pip install -q --disable-pip-version-check "$torch"
    .venv/bin/pip install -q --disable-pip-version-check -e ".${extras:+[$extras]}"
    echo "$want" >"$stamp"
fi
