#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Installs what brdf-baker needs besides Rust: a Vulkan loader, a Vulkan driver
# (Mesa's CPU driver serves where there is no graphics card), Vulkan's
# validation layers, a C++ compiler and the shader compiler "shaderc".
#
#   scripts/setup.sh                 look, install what is missing
#   scripts/setup.sh --cargo-flags   print the flags cargo needs on this machine
#
# What is missing is found out by looking at files, never by asking the package
# manager, so a run that has nothing to do is over in a moment and needs
# neither network nor root.
#
# Variables:
#   BRDF_BAKER_SHADERC   force a way to get shaderc: "merged" (one archive made
#                        of the distribution's static parts), "system" (the
#                        distribution's library as it is) or "source" (cargo
#                        builds it, slow)
#   BRDF_BAKER_ROOT      the checkout; default: the parent of this folder
#   VULKAN_SDK, SHADERC_LIB_DIR
#                        where set and holding a shaderc library, it is used
set -eu

root=${BRDF_BAKER_ROOT:-$(dirname -- "$0")/..}
root=$(cd -- "$root" && pwd)

deps=$root/.deps/shaderc
archive=$deps/libshaderc_combined.a
choice_file=$deps/choice
cargo_config=$root/.cargo/config.toml
marker='# Written by scripts/setup.sh.'

# Folders of ldconfig and rustup that are often missing from a user's PATH.
PATH=$PATH:/usr/sbin:/sbin:${HOME:-/root}/.cargo/bin
export PATH

say() { printf 'setup: %s\n' "$*"; }
die() {
	printf 'setup: %s\n' "$*" >&2
	exit 1
}
have() { command -v "$1" >/dev/null 2>&1; }

# any_file PATTERN...: whether one of the (already expanded) names is a file.
any_file() {
	for any_file_name in "$@"; do
		[ -f "$any_file_name" ] && return 0
	done
	return 1
}

# ---------------------------------------------------------------- what is here

brew_prefix=
if [ "$(uname -s)" = Darwin ] && have brew; then
	brew_prefix=$(brew --prefix)
fi

have_loader() {
	if [ -n "$brew_prefix" ]; then
		any_file "$brew_prefix"/lib/libvulkan*.dylib ${VULKAN_SDK:+"$VULKAN_SDK"/lib/libvulkan*.dylib}
		return
	fi
	any_file /usr/lib/*/libvulkan.so.1 /usr/lib64/libvulkan.so.1 /usr/lib/libvulkan.so.1 \
		/usr/local/lib/libvulkan.so.1 /usr/local/lib/*/libvulkan.so.1 && return
	# Other folders, as the dynamic linker knows them.
	have ldconfig && ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1'
}

# The loader's own search folders for driver and layer descriptions.
vulkan_json() {
	for vulkan_dir in /usr/share/vulkan /usr/local/share/vulkan /etc/vulkan \
		/usr/local/etc/vulkan "${XDG_DATA_HOME:-${HOME:-/root}/.local/share}/vulkan" \
		"${VULKAN_SDK:-/nonexistent}/share/vulkan" \
		${brew_prefix:+"$brew_prefix/share/vulkan"} ${brew_prefix:+"$brew_prefix/etc/vulkan"}; do
		# The pattern is meant to expand.
		# shellcheck disable=SC2086
		any_file "$vulkan_dir/$1/"$2 && return 0
	done
	return 1
}

# split_exists LIST: whether one entry of a colon-separated list of files exists.
split_exists() {
	split_ifs=$IFS
	IFS=:
	# The list is meant to be split.
	# shellcheck disable=SC2086
	set -- $1
	IFS=$split_ifs
	any_file "$@"
}

have_driver() {
	split_exists "${VK_DRIVER_FILES:-}:${VK_ICD_FILENAMES:-}" && return
	vulkan_json icd.d '*.json'
}

have_layers() {
	any_file "${VK_LAYER_PATH:-/nonexistent}/VkLayer_khronos_validation.json" && return
	vulkan_json explicit_layer.d VkLayer_khronos_validation.json
}

# Rust's linker step for shaderc needs a C++ compiler and its standard library.
have_cxx() { have cc && have c++; }

have_source_tools() {
	have cmake && have git && have_cxx && { have python3 || have python; }
}

# holds_shaderc FOLDER: a library that the shaderc crate accepts is in it.
holds_shaderc() {
	any_file "$1"/libshaderc.so "$1"/libshaderc_shared.so "$1"/libshaderc_combined.a \
		"$1"/libshaderc.dylib "$1"/libshaderc_shared.dylib
}

recorded() {
	if [ -f "$choice_file" ]; then cat "$choice_file"; fi
}

# The way to shaderc that works on this machine as it is now; empty: none yet.
shaderc_way() {
	way_wanted=${BRDF_BAKER_SHADERC:-}
	if [ -z "$way_wanted" ]; then
		if [ -n "${SHADERC_LIB_DIR:-}" ] && holds_shaderc "$SHADERC_LIB_DIR"; then
			echo given
			return
		elif [ -n "${VULKAN_SDK:-}" ] && holds_shaderc "$VULKAN_SDK/lib"; then
			echo given
			return
		fi
		way_wanted=$(recorded)
	elif [ "$way_wanted" != "$(recorded)" ]; then
		return
	fi
	case $way_wanted in
	merged)
		if [ -f "$archive" ] && config_names_shaderc; then echo merged; fi
		;;
	system)
		if config_names_shaderc && holds_shaderc "$(config_folder)"; then echo system; fi
		;;
	source)
		if have_source_tools; then echo source; fi
		;;
	esac
}

config_names_shaderc() { grep -q '^SHADERC_LIB_DIR' "$cargo_config" 2>/dev/null; }

config_folder() {
	sed -n 's/^SHADERC_LIB_DIR = { value = "\([^"]*\)".*/\1/p' "$cargo_config"
}

# ------------------------------------------------------------------ installing

manager=
for candidate in apt-get dnf pacman brew; do
	if have "$candidate"; then
		manager=$candidate
		break
	fi
done

# package PART: this package manager's names for a part.
package() {
	case $manager:$1 in
	apt-get:loader) echo libvulkan1 ;;
	apt-get:driver) echo mesa-vulkan-drivers ;;
	apt-get:layers) echo vulkan-validationlayers ;;
	apt-get:cxx) echo gcc g++ libc6-dev ;;
	# The static parts are spread over these; newer releases move
	# SPIRV-Tools' to a package that glslang-dev depends on.
	apt-get:shaderc) echo libshaderc-dev glslang-dev spirv-tools ;;
	apt-get:source) echo cmake git python3 ninja-build ;;

	dnf:loader) echo vulkan-loader ;;
	dnf:driver) echo mesa-vulkan-drivers ;;
	dnf:layers) echo vulkan-validation-layers ;;
	dnf:cxx) echo gcc gcc-c++ ;;
	dnf:shaderc) echo libshaderc-devel ;;
	dnf:source) echo cmake git python3 ninja-build ;;

	pacman:loader) echo vulkan-icd-loader ;;
	pacman:driver) echo vulkan-swrast ;;
	pacman:layers) echo vulkan-validation-layers ;;
	pacman:cxx) echo gcc ;;
	pacman:shaderc) echo shaderc ;;
	pacman:source) echo cmake git python ninja ;;

	brew:loader) echo vulkan-loader ;;
	brew:driver) echo molten-vk ;;
	brew:layers) echo vulkan-validationlayers ;;
	brew:cxx) ;; # Comes with the command line tools.
	brew:shaderc) echo shaderc ;;
	brew:source) echo cmake git python3 ninja ;;
	esac
}

as_root() {
	if [ "$(id -u)" = 0 ]; then
		"$@"
	elif have sudo; then
		sudo "$@"
	else
		return 1
	fi
}

# need_root PACKAGE...: stops when there is no way to install packages.
need_root() {
	if [ "$manager" != brew ] && [ "$(id -u)" != 0 ] && ! have sudo; then
		die "installing packages needs root or sudo; as root, install these and run this again: $*"
	fi
}

lists_are_fresh=

# install PACKAGE...: install them all; fails when that is not possible.
install() {
	[ $# -gt 0 ] || return 0
	need_root "$@"
	say "installing $*"
	case $manager in
	apt-get)
		if [ -z "$lists_are_fresh" ]; then
			lists_are_fresh=yes
			# One broken extra source makes the update fail although the
			# packages can be had; the install below decides.
			as_root apt-get -q -o Acquire::Retries=3 update ||
				say "apt-get update reported an error; trying to install nevertheless"
		fi
		as_root env DEBIAN_FRONTEND=noninteractive apt-get -q \
			-o Acquire::Retries=3 -o DPkg::Lock::Timeout=120 \
			install -y --no-install-recommends "$@"
		;;
	dnf) as_root dnf install -y "$@" ;;
	pacman) as_root pacman -S --needed --noconfirm "$@" ;;
	brew) brew install "$@" ;;
	esac
}

# must_install PACKAGE...: install them all, or stop.
must_install() {
	install "$@" || die "installing failed; install these by hand and run this again: $*"
}

# ----------------------------------------------------- the merged static archive

# find_archive NAME: print the full path of the compiler's libNAME.a.
find_archive() {
	found=$(cc -print-file-name="lib$1.a" 2>/dev/null) || return 1
	# The compiler prints the bare name back when it finds nothing.
	case $found in
	/*) [ -f "$found" ] && echo "$found" ;;
	*) return 1 ;;
	esac
}

# links_and_runs FLAGS...: a C program that compiles a compute shader with
# shaderc links with these flags, runs, and gets SPIR-V. The program declares
# the few functions it calls, so it needs no headers.
links_and_runs() {
	cat >"$work/probe.c" <<'EOF'
#include <stddef.h>
#include <string.h>
typedef void *handle;
extern handle shaderc_compiler_initialize(void);
extern handle shaderc_compile_into_spv(handle, const char *, size_t, int,
                                       const char *, const char *, handle);
extern int shaderc_result_get_compilation_status(handle);
extern size_t shaderc_result_get_length(handle);
extern const char *shaderc_result_get_bytes(handle);
extern handle shaderc_compile_options_initialize(void);
extern void shaderc_compile_options_set_optimization_level(handle, int);
int main(void) {
    const char *text = "#version 450\n"
                       "layout(local_size_x = 1) in;\n"
                       "layout(std430, binding = 0) buffer B { float x[]; };\n"
                       "void main() { x[gl_GlobalInvocationID.x] = sqrt(2.0); }\n";
    const int compute_shader = 2, for_speed = 2;
    unsigned magic = 0;
    handle compiler = shaderc_compiler_initialize();
    handle options = shaderc_compile_options_initialize();
    handle result;
    if (!compiler || !options) return 1;
    shaderc_compile_options_set_optimization_level(options, for_speed);
    result = shaderc_compile_into_spv(compiler, text, strlen(text), compute_shader,
                                      "probe.comp", "main", options);
    if (!result || shaderc_result_get_compilation_status(result) != 0) return 2;
    if (shaderc_result_get_length(result) < 20) return 3;
    memcpy(&magic, shaderc_result_get_bytes(result), sizeof magic);
    return magic == 0x07230203u ? 0 : 4;
}
EOF
	cc -o "$work/probe" "$work/probe.c" "$@" >"$work/probe.log" 2>&1 &&
		"$work/probe" >>"$work/probe.log" 2>&1
}

# Debian's libshaderc_combined.a is not combined: it holds shaderc alone, while
# the shaderc crate links just that one file (and its shared library leaves
# symbols of glslang undefined). So put the parts together. glslang 14 and later
# have fewer, larger parts, hence the optional ones.
make_merged() {
	{
		echo 'CREATE libshaderc_combined.a'
		for part in shaderc_combined glslang SPIRV-Tools-opt SPIRV-Tools; do
			found_part=$(find_archive "$part") || {
				say "the static library lib$part.a is not in the installed packages" >&2
				return 1
			}
			echo "ADDLIB $found_part"
		done
		for part in MachineIndependent GenericCodeGen OSDependent OGLCompiler SPIRV HLSL \
			glslang-default-resource-limits; do
			if found_part=$(find_archive "$part"); then echo "ADDLIB $found_part"; fi
		done
		echo SAVE
		echo END
	} >"$work/merge.mri"
	# ar reads the names in its script literally and trips over blanks, so
	# the new archive is named relative to the folder it is made in.
	(cd "$work" && ar -M <merge.mri) || return 1
	links_and_runs "$work/libshaderc_combined.a" -lstdc++ -lm -lpthread || {
		say "the merged shaderc archive does not link:" >&2
		head -n 5 "$work/probe.log" >&2
		return 1
	}
	mv -f "$work/libshaderc_combined.a" "$archive"
}

# Prints the folder of a system library of shaderc that links as it is.
system_shaderc() {
	if [ -n "$brew_prefix" ]; then
		system_folders=$brew_prefix/opt/shaderc/lib
	else
		system_folders="/usr/lib/$(uname -m)-linux-gnu /usr/lib64 /usr/lib /usr/local/lib"
	fi
	for folder in $system_folders; do
		holds_shaderc "$folder" || continue
		# The same order in which the shaderc crate chooses.
		if any_file "$folder"/libshaderc.so "$folder"/libshaderc.dylib; then
			library=-lshaderc
		elif any_file "$folder"/libshaderc_shared.so "$folder"/libshaderc_shared.dylib; then
			library=-lshaderc_shared
		elif [ -n "$brew_prefix" ]; then
			library="-lshaderc_combined -lc++"
		else
			library="-lshaderc_combined -lstdc++ -lm -lpthread"
		fi
		# The flags are meant to be split.
		# shellcheck disable=SC2086
		if links_and_runs -L"$folder" $library; then
			echo "$folder"
			return 0
		fi
	done
	return 1
}

# write_config VALUE: tell cargo where shaderc lies, so that plain cargo
# commands work. VALUE is the inline table's content.
write_config() {
	mkdir -p "$root/.cargo"
	if [ -f "$cargo_config" ] && ! grep -qF "$marker" "$cargo_config"; then
		config_names_shaderc && return 0
		die ".cargo/config.toml exists and is not this script's. Add to its [env] section: SHADERC_LIB_DIR = { $1 }"
	fi
	cat >"$work/config.toml" <<EOF
$marker Safe to delete; the next run writes it again.
# Tells the shaderc crate where its native library lies.
[env]
SHADERC_LIB_DIR = { $1 }
EOF
	mv -f "$work/config.toml" "$cargo_config"
}

record() {
	echo "$1" >"$work/choice"
	mv -f "$work/choice" "$choice_file"
}

# Installs the distribution's shaderc where it is not installed. That it has none
# is no failure: cargo can still build shaderc from source.
shaderc_packages() {
	case $manager in
	apt-get)
		if find_archive shaderc_combined && find_archive glslang &&
			find_archive SPIRV-Tools-opt; then
			return 0
		fi >/dev/null
		;;
	*) if system_shaderc >/dev/null; then return 0; fi ;;
	esac
	# The names are meant to be split.
	# shellcheck disable=SC2046
	install $(package shaderc) || say "the packages of shaderc could not be installed"
}

get_shaderc() {
	mkdir -p "$deps"
	# Inside the checkout, so that the final moves stay on one file system
	# and are atomic.
	work=$(mktemp -d "$root/.deps/work.XXXXXX")
	trap 'rm -rf "$work"' EXIT
	trap 'exit 130' INT
	trap 'exit 143' TERM

	case ${BRDF_BAKER_SHADERC:-} in
	'') if [ "$manager" = apt-get ]; then ways='merged system source'; else ways='system source'; fi ;;
	merged | system | source) ways=$BRDF_BAKER_SHADERC ;;
	*) die "BRDF_BAKER_SHADERC must be merged, system or source" ;;
	esac

	for way in $ways; do
		case $way in
		merged)
			shaderc_packages
			if make_merged; then
				# Relative to the folder that holds .cargo: the
				# checkout can be moved.
				write_config 'value = ".deps/shaderc", relative = true'
				record merged
				say "shaderc: merged the distribution's static libraries into .deps/shaderc"
				return
			fi
			;;
		system)
			shaderc_packages
			if folder=$(system_shaderc); then
				write_config "value = \"$folder\""
				record system
				say "shaderc: using the library in $folder"
				return
			fi
			;;
		source)
			if ! have_source_tools; then
				# The names are meant to be split.
				# shellcheck disable=SC2046
				must_install $(package source)
			fi
			record source
			say "shaderc: no usable library, cargo will build it from source (10 minutes or more, once)"
			say "shaderc: make passes the needed flag; call cargo by hand with: --features build-shaderc"
			return
			;;
		esac
	done
	die "no usable shaderc library was found in this way: $ways"
}

# ------------------------------------------------------------------------- main

case ${1:-} in
--cargo-flags)
	if [ "$(recorded)" = source ] && [ "$(shaderc_way)" = source ]; then
		echo '--features glsl,build-shaderc'
	else
		echo '--features glsl'
	fi
	exit 0
	;;
'') ;;
*) die "unknown argument: $1 (known: --cargo-flags)" ;;
esac

missing=
have_loader || missing="$missing loader"
have_driver || missing="$missing driver"
have_layers || missing="$missing layers"
have_cxx || missing="$missing cxx"
if [ -z "$(shaderc_way)" ]; then missing="$missing shaderc"; fi

if [ -n "$missing" ]; then
	if [ -z "$manager" ]; then
		die "no package manager that this script knows (apt-get, dnf, pacman, brew). Install by hand: \
the Vulkan loader, a Vulkan driver such as Mesa's lavapipe, the Khronos validation layers, \
a C++ compiler, and shaderc (then set SHADERC_LIB_DIR to its folder). Missing:$missing"
	fi
	packages=
	for part in $missing; do
		if [ "$part" != shaderc ]; then packages="$packages $(package "$part")"; fi
	done
	# The names are meant to be split.
	# shellcheck disable=SC2046,SC2086
	if [ -n "$packages" ]; then
		# Where it stops here, name everything at once.
		case $missing in
		*shaderc*) need_root $packages $(package shaderc) ;;
		esac
		must_install $packages
	fi

	have_loader || die "the Vulkan loader is still missing after installing it"
	have_driver || die "a Vulkan driver is still missing after installing one"
	have_layers || die "the Vulkan validation layers are still missing after installing them"
	have_cxx || die "a C and C++ compiler (cc and c++) is still missing after installing them"
	if [ -z "$(shaderc_way)" ]; then get_shaderc; fi
fi

if ! have cargo; then
	die "Rust is missing: install it (https://rustup.rs, or your distribution's rustup), then run this again"
fi

if [ -n "$missing" ]; then
	say "done"
else
	say "everything is there"
fi
