#!/bin/sh
# Makes the virtual environment $1 and installs this checkout into it, editable, with its development tools.
# PYTHON names the interpreter; without it the first one of version 3.11 or newer on the path is taken.
set -eu
venv=$1
candidates=${PYTHON:-python3 python python3.11 python3.12 python3.13 python3.14}

python=
for candidate in $candidates; do
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
        python=$candidate
        break
    fi
done
if [ -z "$python" ]; then
    echo "symdyn needs Python 3.11 or newer; none of these is: $candidates" >&2
    echo "install one, or name it: make PYTHON=/path/to/python3.12" >&2
    exit 1
fi

# An environment that was moved, or whose interpreter is gone, is made anew; pip is what it must be able to run.
if ! "$venv/bin/python" -m pip --version >/dev/null 2>&1; then
    echo "making $venv with $("$python" --version)"
    rm -rf "$venv"
    if ! "$python" -m venv "$venv"; then
        rm -rf "$venv"
        echo "$python cannot make virtual environments; on Debian and Ubuntu: apt install python3-venv" >&2
        exit 1
    fi
fi
echo "installing symdyn and its tools into $venv (once; some minutes on a slow line)"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
