# SPDX-License-Identifier: MIT OR Apache-2.0
# For scripts that want packages of apt: . scripts/need.sh

# need PACKAGE COMMAND...: installs the package unless the command, which works when it is there, succeeds; fails when that
# does not help. NEED_FLAGS are further flags of apt-get.
need() {
    package=$1
    shift
    if ! "$@" >/dev/null 2>&1; then
        echo "installing $package"
        if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi
        # shellcheck disable=SC2086 # flags are words
        $sudo apt-get update -q && $sudo apt-get install -qy ${NEED_FLAGS:-} "$package"
        "$@" >/dev/null || { echo "$package is still missing" >&2; exit 1; }
    fi
}
