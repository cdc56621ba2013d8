# `make render` shows a picture; `make test` passes the tests. Both set up what is missing on a Debian or Ubuntu with Rust.

CARGO ?= cargo
OSLCL := target/release/oslcl
OUT := out

.PHONY: help render test hard-cases osl-suite build device spirv-tools lint clean

help: ## List the targets
	@grep -E '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed 's/:.*## /\t/'

render: device ## Build, then render the gallery of shipped materials to out/gallery.png
	mkdir -p $(OUT)
	$(OSLCL) render scenes/gallery.toml -o $(OUT)/gallery.png

test: lint device spirv-tools ## Format, lints, documentation and every test
	CARGO=$(CARGO) scripts/run-tests

hard-cases: device ## Run all hard cases on every OpenCL device found, write what they measure to docs/reports/stability.md; lobes in all arithmetics; and force each effect
	OSLCL_SLOW_TESTS=1 OSLCL_REPORT=docs/reports/stability.md $(CARGO) test --release --package oslcl-tests --no-fail-fast --test 'hard_cases_*' --test bsdf --test effects

osl-suite: device ## Run the reference implementation's suite (a checkout that OSL_SUITE_DIR names) and write its report
	python3 tests/osl-suite/run.py --oslcl $(OSLCL) --quiet --report docs/reports/osl-suite.md

build: ## Build the oslcl command
	$(CARGO) build --release --package oslcl-runtime

device: build ## Make sure that there is an OpenCL device, from the system's packages when there is none
	scripts/ensure-device $(OSLCL)

spirv-tools: ## Make sure that the tools of the SPIR-V road are there, from the system's packages
	scripts/ensure-spirv-tools

lint: ## Format, clippy and rustdoc, each where its tool is installed
	scripts/lint

clean: ## Remove what was built and rendered
	$(CARGO) clean
	rm -rf $(OUT)
