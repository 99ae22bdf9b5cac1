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

.PHONY: help setup build demo test bench clean-demo

help:
	@echo 'make setup       install what is missing: Vulkan loader and driver, validation layers, shaderc'
	@echo 'make build       build target/release/brdf-baker'
	@echo 'make demo        bake a set of example tables into $(DEMO_DIR)/'
	@echo 'make test        run all tests'
	@echo 'make bench       run the benchmarks'
	@echo 'make clean-demo  delete $(DEMO_DIR)/'

setup:
	@sh scripts/setup.sh

build: setup
	cargo build --release $(CARGO_FLAGS)

demo: build
	sh scripts/demo.sh

# The release profile here too, so that everything is compiled only once.
test: setup
	cargo test --release $(CARGO_FLAGS)

bench: setup
	cargo bench $(CARGO_FLAGS)

clean-demo:
	rm -rf -- '$(DEMO_DIR)'
