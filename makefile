# mlgimp: make run | make test | make verify | make bench | make lint | make deps | make clean; see README.md.
#
# PETSc is found by pkg-config, or under PETSC_DIR/PETSC_ARCH where they are set.

CXX      := mpicxx
ARCH     ?= -march=native
PYTHON   ?= /usr/bin/python3

# SANITIZE=1 builds with the address and undefined-behaviour sanitizers, apart from the usual build.
ifdef SANITIZE
CXXFLAGS ?= -O1 -g $(ARCH) -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
BUILD    ?= build/sanitize
BIN      ?= bin/sanitize
else
CXXFLAGS ?= -O3 -g $(ARCH)
BUILD    ?= build
BIN      ?= bin
endif

HDF5     ?= hdf5-openmpi

ifdef PETSC_DIR
PKG_CONFIG := PKG_CONFIG_PATH=$(PETSC_DIR)/$(PETSC_ARCH)/lib/pkgconfig:$(PKG_CONFIG_PATH) pkg-config
else
PKG_CONFIG := pkg-config
endif
PACKAGES  = PETSc $(HDF5)
# -Wno-psabi: without 32-byte registers GCC notes how Packs are passed, but all that take one are inlined.
# -Wno-pass-failed: Clang notes loops that it does not vectorise.
FLAGS     = -std=c++17 -fopenmp-simd -fno-math-errno -fno-trapping-math -Wall -Wextra -Wpedantic -Wno-psabi -Wno-pass-failed -Iinclude -MMD -MP $(shell $(PKG_CONFIG) --cflags $(PACKAGES))
LIBRARIES = $(shell $(PKG_CONFIG) --libs $(PACKAGES)) -lmetis

SOURCES := $(filter-out src/program/main.cpp,$(wildcard src/*/*.cpp))
OBJECTS := $(SOURCES:src/%.cpp=$(BUILD)/%.o)
TESTS   := $(patsubst tests/unit/%.cpp,$(BIN)/test_%,$(wildcard tests/unit/*.cpp))

.PHONY: all programs deps run test verify bench lint clean
all: $(BIN)/mlgimp
programs: all $(TESTS) $(BIN)/faults/mlgimp

$(BIN)/mlgimp: $(BUILD)/program/main.o $(BUILD)/libmlgimp.a
	@mkdir -p $(BIN)
	$(CXX) $(CXXFLAGS) -o $@ $^ $(LIBRARIES)

# The same program with failures to order, for tests; only this file knows of them.
$(BIN)/faults/mlgimp: $(BUILD)/program/main.o $(BUILD)/faults/agree.o $(BUILD)/libmlgimp.a
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) -o $@ $^ $(LIBRARIES)

$(BUILD)/faults/agree.o: src/program/agree.cpp makefile
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) $(FLAGS) -DMLGIMP_FAULTS -c -o $@ $<

$(BUILD)/libmlgimp.a: $(OBJECTS)
	$(AR) rcs $@ $^

$(BUILD)/%.o: src/%.cpp makefile
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) $(FLAGS) -c -o $@ $<

$(BIN)/test_%: $(BUILD)/tests/%.o $(BUILD)/libmlgimp.a
	@mkdir -p $(BIN)
	$(CXX) $(CXXFLAGS) -o $@ $^ $(LIBRARIES)

$(BIN)/bench_%: tests/bench/%.cpp makefile
	@mkdir -p $(BIN)
	$(CXX) $(CXXFLAGS) -std=c++17 -Wall -Wextra -Wpedantic -Wno-psabi -Iinclude -o $@ $<

$(BUILD)/tests/%.o: tests/unit/%.cpp makefile
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) $(FLAGS) -c -o $@ $<

deps:
	@sh scripts/install_packages.sh

run: deps
	@$(MAKE) --no-print-directory $(BIN)/mlgimp
	@sh scripts/run.sh $(PYTHON)

test: deps
	@$(MAKE) --no-print-directory -j2 programs
	@MLGIMP_BIN=$(BIN) $(PYTHON) tests/run.py $(SELECT)

verify: deps
	@$(MAKE) --no-print-directory -j2 programs
	@MLGIMP_BIN=$(BIN) $(PYTHON) tests/verify.py $(SELECT)

bench: deps
	@$(MAKE) --no-print-directory $(BIN)/mlgimp $(BIN)/bench_machine
	@$(PYTHON) scripts/bench.py

# Layout and checks of the sources; needs clang-format and clang-tidy.
lint: $(SOURCES:%.cpp=$(BUILD)/%.tidy) $(BUILD)/src/program/main.tidy
	clang-format --dry-run -Werror $(wildcard src/*/*.cpp include/*/*.hpp tests/*/*.cpp tests/*/*.hpp)

$(BUILD)/%.tidy: %.cpp .clang-tidy
	@mkdir -p $(@D)
	clang-tidy --quiet $< -- -std=c++17 -Iinclude $(subst -I,-isystem ,$(shell $(PKG_CONFIG) --cflags $(PACKAGES))) && touch $@

clean:
	rm -rf build bin

-include $(OBJECTS:.o=.d) $(BUILD)/program/main.d $(BUILD)/faults/agree.d $(wildcard $(BUILD)/tests/*.d)
