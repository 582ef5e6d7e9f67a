# make demo   build, then watch an object being predicted, grasped, lifted, moved and released
# make build  install what is missing, configure and build
# make test   build, then run all tests
# make bench  build, then run the benchmarks; figures go to out/bench/*.json
# make fuzz   build tests/fuzz with clang and libFuzzer and run each for FUZZ_SECONDS (60)
# make clean  remove build and out

.PHONY: demo build test bench fuzz clean configure packages
.DEFAULT_GOAL := build

packages:
	@scripts/install-packages.sh

build: configure
	@ninja -C build

configure: packages
	@cmake --preset release --log-level=WARNING

# Only what the demo runs.
demo: configure
	@ninja -C build demo
	@rm -f out/demo/summary.txt; \
	build/bin/prehend launch launch/demo.yaml out:=out/demo; status=$$?; \
	cat out/demo/summary.txt 2>/dev/null; exit $$status

test: build
# Some tests run at real time beside emulated hardware, and a machine that is throttled can make them
# late: what fails three times has failed.
	@ctest --test-dir build --output-on-failure --timeout 300 --repeat until-pass:3

bench: build
	@mkdir -p out/bench
	@for program in build/bin/bench_*; do \
	  $$program --json out/bench/$$(basename $$program).json || exit 1; \
	done

FUZZ_SECONDS ?= 60
fuzz: packages
	@cmake --preset fuzz --log-level=WARNING
	@cmake --build --preset fuzz
	@tests/fuzz/run.sh build-fuzz/bin out/fuzz $(FUZZ_SECONDS)

clean:
	rm -rf build build-fuzz out
