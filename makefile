# mlgimp: make run | make test | make verify | make bench | make deps | make clean; see README.md.
#
# PETSc is found by pkg-config, or under PETSC_DIR/PETSC_ARCH where they are set.

CXX      := mpicxx
ARCH     ?= -march=native
CXXFLAGS ?= -O3 -g $(ARCH)
PYTHON   ?= /usr/bin/python3

HDF5     ?= hdf5-openmpi

ifdef PETSC_DIR
PKG_CONFIG := PKG_CONFIG_PATH=$(PETSC_DIR)/$(PETSC_ARCH)/lib/pkgconfig:$(PKG_CONFIG_PATH) pkg-config
else
PKG_CONFIG := pkg-config
endif
PACKAGES  = PETSc $(HDF5)
# -Wno-psabi: without 32-byte registers GCC notes how Packs are passed, but all that take one are inlined.
FLAGS     = -std=c++17 -fopenmp-simd -fno-math-errno -fno-trapping-math -Wall -Wextra -Wpedantic -Wno-psabi -Iinclude -MMD -MP $(shell $(PKG_CONFIG) --cflags $(PACKAGES))
LIBRARIES = $(shell $(PKG_CONFIG) --libs $(PACKAGES)) -lmetis

SOURCES := $(filter-out src/program/main.cpp,$(wildcard src/*/*.cpp))
OBJECTS := $(SOURCES:src/%.cpp=build/%.o)
TESTS   := $(patsubst tests/unit/%.cpp,bin/test_%,$(wildcard tests/unit/*.cpp))

.PHONY: all deps run test verify bench clean
all: bin/mlgimp

bin/mlgimp: build/program/main.o build/libmlgimp.a
	@mkdir -p bin
	$(CXX) $(CXXFLAGS) -o $@ $^ $(LIBRARIES)

build/libmlgimp.a: $(OBJECTS)
	$(AR) rcs $@ $^

build/%.o: src/%.cpp makefile
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) $(FLAGS) -c -o $@ $<

bin/test_%: build/tests/%.o build/libmlgimp.a
	@mkdir -p bin
	$(CXX) $(CXXFLAGS) -o $@ $^ $(LIBRARIES)

bin/bench_%: tests/bench/%.cpp makefile
	@mkdir -p bin
	$(CXX) $(CXXFLAGS) -std=c++17 -Wall -Wextra -Wpedantic -Wno-psabi -Iinclude -o $@ $<

build/tests/%.o: tests/unit/%.cpp makefile
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) $(FLAGS) -c -o $@ $<

deps:
	@sh scripts/install_packages.sh

run: deps
	@$(MAKE) --no-print-directory bin/mlgimp
	@sh scripts/run.sh $(PYTHON)

test: deps
	@$(MAKE) --no-print-directory -j2 bin/mlgimp $(TESTS)
	@$(PYTHON) tests/run.py $(SELECT)

verify: deps
	@$(MAKE) --no-print-directory -j2 bin/mlgimp $(TESTS)
	@$(PYTHON) tests/verify.py $(SELECT)

bench: deps
	@$(MAKE) --no-print-directory bin/mlgimp bin/bench_machine
	@$(PYTHON) scripts/bench.py

clean:
	rm -rf build bin

-include $(OBJECTS:.o=.d) build/program/main.d $(wildcard build/tests/*.d)
