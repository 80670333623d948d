# Makes .venv from requirements.lock: sh workflow/environment.sh PYTHON
set -eu
python=$1
refuse() { echo "$1" >&2; exit 1; }

version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) ||
    refuse "There is no working Python called '$python': install Python 3.11 or newer, or name one with make PYTHON=..."
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    refuse "'$python' is Python $version, but this needs 3.11 or newer: name one with make PYTHON=python3.12."
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    refuse "'$python' cannot make virtual environments (its modules venv and ensurepip are missing): install them, or name another with make PYTHON=..."

bin=.venv/bin
echo "Making .venv for Python $version from requirements.lock"
"$python" -m venv .venv
if ! [ -x $bin/uv ]; then
    sed -n '/^uv==/,/[^\\]$/p' requirements.lock > .venv/uv.txt
    $bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r .venv/uv.txt
fi
export VIRTUAL_ENV="$PWD/.venv"
$bin/uv pip sync --quiet --python $bin/python --require-hashes requirements.lock
$bin/uv pip install --quiet --python $bin/python --no-deps --no-build-isolation --editable .
# Python reads the path of the library in the locale's encoding, which may not know the checkout's name: say it from there.
# `benchmarks` lies beside it.
for path in .venv/lib/python*/site-packages/*microfacet.pth; do printf '%s\n' ../../../../lib ../../../.. > "$path"; done
