# make demo   build, then watch a table being cleared, live at http://127.0.0.1:8765
# make build  install what is missing, configure and build
# make test   build, then run all tests
# make test-thorough   the same, every task on every robot
# make asan   the same under AddressSanitizer and UndefinedBehaviorSanitizer (build-debug)
# make asan-quick  those that end within three minutes
# make tsan   the same under ThreadSanitizer (build-tsan)
# make bench  build, then run the benchmarks; figures go to out/bench/*.json
# make fuzz   build tests/fuzz with clang and libFuzzer and run each for FUZZ_SECONDS (60)
# make docs   build, then the documentation site: out/docs/html/index.html
# make debs   build, then Debian packages: out/debs; scripts/test-debs.sh out/debs tries them in a clean Debian
# make web    rebuild the viewer's page web/dist from web/src (node 20, npm)
# make format, make check-format   clang-format
# make clean  remove build and out

.PHONY: demo build test test-thorough asan asan-quick tsan format check-format bench docs debs fuzz web clean configure packages
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
	@scripts/run-demo.sh build/bin/prehend out/demo

test: build
	@scripts/run-tests.sh build

test-thorough: build
	@PREHEND_THOROUGH_TESTS=1 scripts/run-tests.sh build

# All tests under AddressSanitizer and UndefinedBehaviorSanitizer, or under ThreadSanitizer.
asan: packages
	@cmake --preset debug --log-level=WARNING && ninja -C build-debug && scripts/run-tests.sh build-debug
# The part of it that ends within three minutes.
asan-quick: packages
	@cmake --preset debug --log-level=WARNING
	@ninja -C build-debug quick_tests && ctest --test-dir build-debug -j "$$(nproc)" --output-on-failure -L quick
tsan: packages
	@cmake --preset tsan --log-level=WARNING && ninja -C build-tsan && scripts/run-tests.sh build-tsan

bench: build
	@mkdir -p out/bench
	@for program in build/bin/bench_*; do \
	  $$program --json out/bench/$$(basename $$program).json || exit 1; \
	done

docs: build
	@scripts/make-docs.sh build out/docs

debs: build
	@scripts/make-debs.sh build out/debs

FUZZ_SECONDS ?= 60
fuzz: packages
	@cmake --preset fuzz --log-level=WARNING
	@cmake --build --preset fuzz
	@tests/fuzz/run.sh build-fuzz/bin out/fuzz $(FUZZ_SECONDS)

# web/dist is in the repository: only who changes web/src needs node.
web:
	@cd web && npm ci --no-audit --no-fund && npm run build

SOURCES = git ls-files '*.cpp' '*.h' | xargs
format:
	@$(SOURCES) clang-format -i
check-format: packages
	@$(SOURCES) clang-format --dry-run --Werror

clean:
	rm -rf build build-debug build-tsan build-fuzz out
