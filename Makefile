# The targets of the project. Each one first installs the Debian packages it needs, so that a
# machine needs only make and git.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
# With it, `cd` in a script can go to another folder.
unexport CDPATH

.PHONY: help
help:  ## print this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

PREFIX ?= /usr/local
export DESTDIR

.PHONY: install
install: build  ## the command, stripped, its manual page and completion, below DESTDIR and PREFIX
	@cmake --install build --prefix "$(PREFIX)" --component command --strip

.PHONY: package
package:  ## Debian packages of the command, the libraries and the modules: build/packages
	@scripts/install-packages build package
	@packaging/build

.PHONY: test-package
test-package: package  ## the packages under lintian, and installed, used and removed in a new root
	@scripts/install-packages test-package
	@packaging/test

.PHONY: reproducible
reproducible: package  ## a second build in another folder, time and locale: the same bytes?
	@scripts/install-packages test-package
	@packaging/reproducible

.PHONY: demo
demo: build  ## simulate an encoder, damage some frames, decode the capture
	@scripts/demo

.PHONY: build
build:  ## the command: build/biss
	@scripts/install-packages build
	@cmake --preset release -DBISS_TESTS=OFF >/dev/null
	@cmake --build --preset release --target biss_command

.PHONY: test
test:  ## the checks of every change: both compilers, sanitizers, microcontroller, fuzz, the page
	@scripts/install-packages build test fuzz firmware format wasm page
	@scripts/test quick

.PHONY: test-long
test-long:  ## also: exhaustive sweeps, campaigns, all rooms under sanitizers, Cortex-M0, the page
	@scripts/install-packages build test fuzz firmware coverage long wasm view embedded python viewers
	@scripts/test long

.PHONY: test-release
test-release:  ## tests that take hours: 10^7 executions of each fuzz target, mutants, 10^9 frames, foreign lines
	@scripts/install-packages build test fuzz long linuxcnc
	@scripts/test release
	@$(MAKE) --no-print-directory fuzz fuzz-compare mutants safety-sequences foreign-lines

.PHONY: test-viewers
test-viewers: build python  ## sigrok, Saleae's analyzer: against biss decode
	@scripts/install-packages test viewers
	@cmake --preset release -DBISS_TESTS=ON -DBISS_LONG_TESTS=ON >/dev/null
	@cmake --build --preset release --target biss_saleae_drive
	@viewers/test && viewers/sigrok/test --speed

.PHONY: test-shared
test-shared:  ## the tests of captures, on those in the folder BISS_SHARED (../shared)
	@scripts/install-packages build test
	@cmake --preset release -DBISS_TESTS=ON >/dev/null
	@cmake --build --preset release --target biss_command_test biss_verbs_test
	@BISS_SHARED=$(abspath $(or $(BISS_SHARED),../shared)) GTEST_FILTER='*Captures*:*EncoderList*' ctest --preset release -R 'biss_(command|verbs)_test'

.PHONY: wasm
wasm:  ## the core in WebAssembly, for a page: build-wasm/wasm
	@scripts/install-packages build wasm
	@cmake --preset wasm >/dev/null
	@cmake --build --preset wasm

.PHONY: test-wasm
test-wasm: build wasm  ## the core in WebAssembly against the command, in Node
	@BISS=build/biss BISS_WASM=build-wasm/wasm node --test wasm/biss_test.mjs

.PHONY: view
view: wasm  ## the page that opens a capture in a browser: view/dist/biss.html
	@scripts/install-packages view
	@cd view && npm ci --silent && npm run --silent check && npm run --silent build

.PHONY: test-view
test-view: build view  ## the page in Chromium, compared with the command
	@scripts/install-packages test view
	@cd view && BISS=../build/biss npm --silent test

.PHONY: view-picture
view-picture: view  ## draws the picture of the playground again: docs/pictures/playground.png
	@cd view && node test/picture.mjs

.PHONY: view-speed
view-speed: build view  ## the page with large captures (BISS_GB: their size in GB)
	@cd view && BISS=../build/biss node test/speed.mjs

.PHONY: report-pictures
report-pictures: build view  ## reports in Chromium, Firefox and on A4, to be looked at: build/report-pictures
	@scripts/install-packages view
	@cd view && BISS=../build/biss node test/report_pictures.mjs ../build/report-pictures

.PHONY: python
python:  ## the Python module: build/python
	@scripts/install-packages build python
	@cmake --preset release -DBISS_PYTHON=ON -DPython3_EXECUTABLE=/usr/bin/python3 >/dev/null
	@cmake --build --preset release --target biss_python_module

.PHONY: test-python
test-python: build python  ## the Python module against the command
	@python/test

.PHONY: python-speed
python-speed: build python  ## 10^6 request cycles from an array, against the command
	@python/speed

.PHONY: wheel
wheel: python  ## the Python module as a wheel: build/dist
	@cd python && /usr/bin/python3 -m build --wheel --no-isolation --outdir ../build/dist

.PHONY: explain-matrix
explain-matrix:  ## how often biss explain finds each cause on lines of the simulator
	@scripts/install-packages build test
	@cmake --preset release -DBISS_TESTS=ON >/dev/null
	@cmake --build --preset release --target biss_explain_matrix
	@build/tests/explain/biss_explain_matrix

.PHONY: pictures
pictures: build  ## draws the pictures of the documents again: docs/pictures
	@scripts/pictures build/biss

.PHONY: simulators
simulators:  ## encoders and masters for Icarus Verilog, Verilator and GHDL: build/simulators
	@scripts/install-packages build simulators
	@cmake --preset release >/dev/null
	@cmake --build --preset release --target biss_testbench biss_vpi

.PHONY: bench
bench:  ## the benchmarks, at full optimisation
	@scripts/install-packages build bench
	@cmake --preset bench >/dev/null
	@cmake --build --preset bench
	@scripts/bench

.PHONY: fuzz
fuzz:  ## the fuzz targets, FUZZ_RUNS executions each
	@scripts/install-packages build fuzz
	@fuzz/run

.PHONY: fuzz-compare
fuzz-compare:  ## the targets that compare two ways of decoding, without sanitizers
	@scripts/install-packages build fuzz
	@FUZZ_PRESET=fuzz fuzz/run clean_cycles flow

.PHONY: coverage
coverage:  ## branch coverage of crc, frame, safety, timing, turns; fails below 100 %
	@scripts/install-packages build test coverage
	@scripts/coverage

.PHONY: mutants
mutants:  ## makes the changes of scripts/mutants.txt, one at a time; a test must fail with each
	@scripts/install-packages build test coverage
	@scripts/mutants

.PHONY: firmware-sizes
firmware-sizes:  ## flash, RAM, instructions on Cortex-M; renews docs/firmware.md, guide-firmware.md
	@scripts/install-packages build firmware
	@firmware/sizes --write docs/firmware.md --write docs/guide-firmware.md

.PHONY: embedded
embedded:  ## packages for PlatformIO, Arduino, ESP-IDF and Zephyr: build/embedded
	@embedded/assemble

.PHONY: test-embedded
test-embedded:  ## these packages, and the examples for boards in rp2040js and QEMU
	@scripts/install-packages build firmware embedded
	@firmware/boards/test
	@embedded/test

.PHONY: identify-tables
identify-tables:  ## what is taken for which protocol; renews lab/reports/identify.md
	@scripts/install-packages build test
	@cmake --preset release -DBISS_TESTS=ON >/dev/null
	@cmake --build --preset release --target biss_protocol_table biss_format_table
	@scripts/report-tables --write identify

.PHONY: foreign-lines
foreign-lines: build  ## identify and explain on 4000 lines each of another generator; fails below the limits
	@scripts/report-tables foreign

.PHONY: foreign-tables
foreign-tables: build  ## the same; renews lab/reports
	@scripts/report-tables --write foreign

.PHONY: safety-sequences
safety-sequences: build  ## the safety monitor before 10^9 frames a counter and 10^6 faults a kind
	@nice -n 10 build/biss safety sequences -f fs-36-28 --frames 1000000000 --faults 1000000

.PHONY: format
format:  ## rewrite every C++ file by .clang-format
	@scripts/install-packages format
	@scripts/check-format --fix

.PHONY: clean
clean:  ## remove every build folder
	@rm -rf build build-*/
