# SPDX-License-Identifier: MIT OR Apache-2.0
# Shortcuts around cargo. `make setup` gets what cargo cannot; after it plain
# cargo commands work too.

# rustup's default place is often missing from the PATH of non-login shells.
export PATH := $(HOME)/.cargo/bin:$(PATH)

# On a machine of continuous integration a missing Vulkan device is a failure,
# not a reason to skip tests.
ifneq ($(CI),)
export REQUIRE_GPU := 1
endif

# What `make demo` writes.
DEMO_DIR ?= demo-out
export DEMO_DIR

# Expanded only when a recipe runs, after setup has decided how to get shaderc.
CARGO_FLAGS = --locked $(shell sh scripts/setup.sh --cargo-flags)

.PHONY: help setup build demo test test-readers test-report test-view test-engines test-farm test-package test-wheel wheel spirv package bench clean-demo

help:
	@echo 'make setup       install what is missing: Vulkan loader and driver, validation layers, shaderc'
	@echo 'make build       build target/release/brdf-baker'
	@echo 'make demo        bake two tables and an environment into $(DEMO_DIR)/, verify and draw them'
	@echo 'make test        run all tests'
	@echo 'make test-readers  read every format back with OpenImageIO, OpenEXR, Pillow and ktx-parse'
	@echo 'make test-report  open reports of verify in headless Chromium'
	@echo 'make test-view    use a page of view in headless Chromium and compare it with preview'
	@echo 'make test-engines  draw spheres in real engines and compare them with an f64 reference (ENGINES="three bevy")'
	@echo 'make test-package  build the published crate as its user does (GAME=game: and a game that bakes as it is built)'
	@echo 'make wheel       write the program as a Python wheel, target/wheels/*.whl'
	@echo 'make test-wheel  install that with pip into an empty environment, bake and verify'
	@echo 'make package     write the crate to publish, target/package/*.crate'
	@echo 'make test-farm   bake 210 probes in four workers of a render farm, one of which is killed'
	@echo 'make bench       run the benchmarks'
	@echo 'make clean-demo  delete $(DEMO_DIR)/'

setup:
	@sh scripts/setup.sh

build: setup
	cargo build --release $(CARGO_FLAGS)

demo: build
	CARGO_DEMO_FLAGS="$$(sh scripts/setup.sh --cargo-flags)" sh scripts/demo.sh

# The release profile here too, so that everything is compiled only once.
test: setup
	cargo test --release $(CARGO_FLAGS)

# Needs Python and node, which the script installs where apt can.
test-readers: setup
	sh tests/readers/run.sh

# Needs Chromium and node, which the script installs where apt can.
test-report: setup
	sh tests/report/run.sh

# Needs Chromium and node, too.
test-view: setup
	sh tests/view/run.sh

# Needs Chromium, node and npm, which the script installs where apt can, and the engines' packages.
test-engines: setup
	sh tests/engines/run.sh $(ENGINES)

# Builds from the packaged crate, away from the checkout.
test-package: build
	sh tests/package/run.sh $(GAME)

# The compiled shaders, which the package holds and git does not.
spirv: setup
	cargo run --quiet --release $(CARGO_FLAGS) --bin pack-spirv -- write spirv

# Cargo builds what it packages once, as a check. `cargo publish -p brdf-baker` uploads it.
package: spirv
	cargo package --locked -p brdf-baker

# Needs Python, and maturin from PyPI, which the script installs.
wheel: build
	sh scripts/wheel.sh

test-wheel: wheel
	sh tests/wheel/run.sh

# Needs Python, and openjd-cli from PyPI, which the script installs.
test-farm: setup
	sh tests/farm/run.sh

bench: setup
	cargo bench $(CARGO_FLAGS)

clean-demo:
	rm -rf -- '$(DEMO_DIR)'
