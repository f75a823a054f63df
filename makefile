# mlgimp: make run | make test | make docs | make gallery | make verify | make bench | make lint | make install | make deps | make clean; see README.md.
#
# PETSc is found by pkg-config, or under PETSC_DIR/PETSC_ARCH where they are set. V=1 shows the commands whole.

ifeq ($(origin CXX),default)
CXX      := mpicxx
endif
ARCH     ?= -march=native
PYTHON   ?= /usr/bin/python3
# How many files of tests run at once. Sources are compiled on all cores, or as many at once as `make -j` was asked for.
JOBS     ?= 2
CORES     = $(shell nproc 2>/dev/null || echo 2)
ON_CORES  = --no-print-directory $(if $(filter -j%,$(MAKEFLAGS)),,-j$(CORES))

# SANITIZE=1 builds with the address and undefined-behaviour sanitizers, apart from the usual build.
ifdef SANITIZE
CXXFLAGS ?= -O1 -g1 $(ARCH) -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
BUILD    ?= build/sanitize
BIN      ?= bin/sanitize
else
CXXFLAGS ?= -O3 -g1 $(ARCH)
BUILD    ?= build
BIN      ?= bin
endif

HDF5     ?= hdf5-openmpi
PREFIX   ?= /usr/local

ifdef PETSC_DIR
PKG_CONFIG := PKG_CONFIG_PATH=$(PETSC_DIR)/$(PETSC_ARCH)/lib/pkgconfig:$(PKG_CONFIG_PATH) pkg-config
RUN_PATH    = -Wl,-rpath,$(shell $(PKG_CONFIG) --variable=libdir PETSc)
else
PKG_CONFIG := pkg-config
endif
PACKAGES   := PETSc $(HDF5)

# -Wno-psabi: without 32-byte registers GCC notes how Packs are passed, but all that take one are inlined.
# -Wno-pass-failed: Clang notes loops that it does not vectorise.
WARNINGS   := -Wall -Wextra -Wpedantic -Wno-psabi -Wno-pass-failed
# The packages are asked once, when something is built: by then they have been installed.
INCLUDES    = $(eval INCLUDES := -Iinclude $$(shell $(PKG_CONFIG) --cflags $(PACKAGES)))$(INCLUDES)
LIBRARIES   = $(eval LIBRARIES := $$(shell $(PKG_CONFIG) --libs $(PACKAGES)) -lmetis $(RUN_PATH))$(LIBRARIES)
FLAGS       = -std=c++17 -fopenmp-simd -fno-math-errno -fno-trapping-math -fno-signed-zeros $(WARNINGS) $(INCLUDES) -MMD -MP

SOURCES := $(filter-out src/program/run/main.cpp,$(wildcard src/*/*.cpp src/*/*/*.cpp))
OBJECTS := $(SOURCES:src/%.cpp=$(BUILD)/%.o)
# tests/unit/*.cpp make one program of fast tests, each of tests/simulation/*.cpp one of its own.
UNITS   := $(patsubst %.cpp,$(BUILD)/%.o,$(wildcard tests/unit/*.cpp))
TESTS   := $(BIN)/test_units $(patsubst tests/simulation/%.cpp,$(BIN)/test_%,$(wildcard tests/simulation/*.cpp))

ifdef V
RUN = $(1)
else
RUN = @echo "$(2)"; $(1)
endif
COMPILE = $(call RUN,$(CXX) $(CXXFLAGS) $(FLAGS) $(1) -c -o $@ $<,CXX $<)
LINK    = $(call RUN,$(CXX) $(CXXFLAGS) -o $@ $^ $(1) $(LIBRARIES),LINK $@)

.PHONY: all programs deps run test docs gallery verify bench lint install clean anew
.SECONDARY:
all: $(BIN)/mlgimp
programs: all $(TESTS) $(BIN)/faults/mlgimp

# What objects are made with; where it changes they are made anew.
BUILT_WITH = $(CXX) $(CXXFLAGS) $(HDF5) $(PETSC_DIR) $(PETSC_ARCH)
$(BUILD)/flags: anew
	@mkdir -p $(@D); echo '$(BUILT_WITH)' | cmp -s - $@ || echo '$(BUILT_WITH)' > $@
anew:

$(BIN)/mlgimp: $(BUILD)/program/run/main.o $(BUILD)/libmlgimp.a
	@mkdir -p $(BIN)
	$(call LINK)

# The same program with failures to order, for tests; only this file knows of them.
$(BIN)/faults/mlgimp: $(BUILD)/program/run/main.o $(BUILD)/faults/agree.o $(BUILD)/libmlgimp.a
	@mkdir -p $(@D)
	$(call LINK)

$(BUILD)/faults/agree.o: src/program/system/agree.cpp makefile $(BUILD)/flags
	@mkdir -p $(@D)
	$(call COMPILE,-DMLGIMP_FAULTS)

$(BUILD)/libmlgimp.a: $(OBJECTS)
	@rm -f $@
	$(call RUN,$(AR) rcs $@ $^,AR $@)

$(BUILD)/%.o: src/%.cpp makefile $(BUILD)/flags
	@mkdir -p $(@D)
	$(call COMPILE)

$(BUILD)/tests/%.o: tests/%.cpp makefile $(BUILD)/flags
	@mkdir -p $(@D)
	$(call COMPILE,-Itests)

$(BIN)/test_units: $(UNITS) $(BUILD)/libmlgimp.a
	@mkdir -p $(BIN)
	$(call LINK,-lgtest)

$(BIN)/test_%: $(BUILD)/tests/simulation/%.o $(BUILD)/libmlgimp.a
	@mkdir -p $(BIN)
	$(call LINK,-lgtest)

$(BIN)/bench_%: tests/bench/%.cpp makefile
	@mkdir -p $(BIN)
	$(call RUN,$(CXX) $(CXXFLAGS) -std=c++17 $(WARNINGS) -Iinclude -o $@ $<,CXX $<)

deps:
	@sh scripts/install_packages.sh

run: deps
	@$(MAKE) $(ON_CORES) $(BIN)/mlgimp
	@sh scripts/run.sh $(PYTHON)

# SELECT="word word": only tests whose name, with that of their file, contains one of the words. PROGRAMS: what they need.
PROGRAMS ?= programs
EMPTY :=
WORDS = $(subst $(EMPTY) $(EMPTY), or ,$(strip $(SELECT)))
test: deps
	@$(MAKE) $(ON_CORES) $(PROGRAMS)
	@MLGIMP_BIN=$(BIN) $(PYTHON) -m pytest -n $(JOBS) --dist loadfile $(if $(WORDS),-k "$(WORDS)")

# SELECT="word word": only studies whose name contains one of the words; BOOK="word word": those of such pages of the verification book.
verify: deps
	@$(MAKE) $(ON_CORES) programs
	@MLGIMP_BIN=$(BIN) $(PYTHON) tests/verify.py $(if $(BOOK),--book $(BOOK),$(SELECT))

# The book, from README.md, docs/ and the pictures of the gallery that are there.
PAGES         = output/docs
PAGE_PACKAGES = python3-sphinx python3-myst-parser furo python3-sphinx-copybutton libjs-katex fonts-katex
docs:
	@sh scripts/install_packages.sh $(PAGE_PACKAGES)
	@rm -rf $(PAGES)
	@$(PYTHON) -m sphinx -q -E -n -W --keep-going -c docs -d $(BUILD)/docs . $(PAGES)
	@echo "$(PAGES)/index.html"

# SELECT="NAME NAME": runs and draws only these cases of the gallery, without the pictures of the other documents.
gallery: deps
	@$(MAKE) $(ON_CORES) $(BIN)/mlgimp
	@MLGIMP_BIN=$(BIN) $(PYTHON) scripts/gallery.py $(SELECT)
	@$(if $(SELECT),,MLGIMP_BIN=$(BIN) $(PYTHON) scripts/illustrations.py)

bench: deps
	@$(MAKE) $(ON_CORES) $(BIN)/mlgimp $(BIN)/bench_machine
	@$(PYTHON) scripts/bench.py
	@$(PYTHON) tests/bench/accuracy.py
	@$(PYTHON) -m pytest tests/bench

# Layout and checks of the sources; needs clang-format and clang-tidy. Fewer nodes than the analyser's own 225000 halve its time.
ANALYSER := -Xclang -analyzer-config -Xclang max-nodes=40000
lint: $(SOURCES:%.cpp=$(BUILD)/%.tidy) $(BUILD)/src/program/run/main.tidy
	clang-format --dry-run -Werror $(wildcard src/*/*.cpp src/*/*/*.cpp include/*/*.hpp include/*/*/*.hpp tests/*/*.cpp tests/*/*.hpp)

$(BUILD)/%.tidy: %.cpp .clang-tidy
	@mkdir -p $(@D)
	clang-tidy --quiet $< -- -std=c++17 $(subst -I/,-isystem /,$(INCLUDES)) $(ANALYSER) && touch $@

# Scripts and documents find the program, the options and each other beside them, as they do here.
SHARE     = $(DESTDIR)$(PREFIX)/share
INSTALLED = options scripts python examples docs README.md CONTRIBUTING.md CHANGELOG.md CITATION.cff LICENSE
install: $(BIN)/mlgimp
	install -D $< "$(DESTDIR)$(PREFIX)/bin/mlgimp"
	install -d "$(SHARE)/mlgimp" "$(SHARE)/man/man1"
	tar c --exclude=__pycache__ $(INSTALLED) | tar x --no-same-owner -C "$(SHARE)/mlgimp"
	ln -sfn ../../bin "$(SHARE)/mlgimp/bin"
	MLGIMP_BIN=$(BIN) $(PYTHON) scripts/man_page.py > "$(SHARE)/man/man1/mlgimp.1"

clean:
	rm -rf build bin

-include $(OBJECTS:.o=.d) $(BUILD)/program/run/main.d $(BUILD)/faults/agree.d $(wildcard $(BUILD)/tests/*/*.d)
