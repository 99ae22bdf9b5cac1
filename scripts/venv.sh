# SPDX-License-Identifier: MIT OR Apache-2.0
# For scripts that want packages of PyPI: . scripts/need.sh; . scripts/venv.sh

# venv FOLDER REQUIREMENTS: a virtual environment of Python with what the file names, made unless it is there already.
# Python's venv comes from apt when it is missing.
venv() {
    need python3-venv python3 -c 'import ensurepip, venv'
    if ! cmp -s "$2" "$1/requirements.txt"; then
        rm -rf "$1"
        python3 -m venv "$1"
        "$1/bin/pip" install -q --disable-pip-version-check -r "$2"
        cp "$2" "$1/requirements.txt"
    fi
}
