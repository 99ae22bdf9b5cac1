# SPDX-License-Identifier: MIT OR Apache-2.0
# For scripts that want packages of PyPI: . "$ENGINES/venv.sh"

# venv FOLDER PYTHON PACKAGE...: a virtual environment with these packages, made unless it is there already.
venv() {
    folder=$1 python=$2
    shift 2
    if [ ! -f "$folder/installed" ] || [ "$(cat "$folder/installed")" != "$*" ]; then
        rm -rf "$folder"
        "$python" -m venv "$folder"
        "$folder/bin/pip" install -q --disable-pip-version-check "$@"
        echo "$*" >"$folder/installed"
    fi
}
