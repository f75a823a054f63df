// The option reader: values, defaults, and the one line that refuses what is not allowed.
#include "program/options/options.hpp"
#include "program/input/read_case.hpp"
#include "program/options/command_line.hpp"
#include "program/options/nearest.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <unistd.h>
#include <vector>

using namespace mlgimp;

namespace
{

using Read = std::function<void(OptionReader &)>;

PetscErrorCode InGroup(OptionReader &reader, const Read &read)
{
  PetscFunctionBeginUser;
  PetscOptionsBegin(PETSC_COMM_SELF, nullptr, "unit test", nullptr);
  reader.SetItems(PetscOptionsObject);
  read(reader);
  PetscOptionsEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Reads from options of its own; returns the message of a refusal, or nothing.
std::string Refusal(const std::string &options, const Read &read, bool help = false)
{
  PetscOptions own;
  OptionReader reader(PETSC_COMM_SELF, help);
  std::string message;
  PetscCallAbort(PETSC_COMM_SELF, PetscOptionsCreate(&own));
  PetscCallAbort(PETSC_COMM_SELF, PetscOptionsInsertString(own, options.c_str()));
  PetscCallAbort(PETSC_COMM_SELF, PetscOptionsPush(own));
  try {
    PetscCallAbort(PETSC_COMM_SELF, InGroup(reader, read));
  } catch (const Refused &refused) {
    message = refused.what();
  }
  PetscCallAbort(PETSC_COMM_SELF, PetscOptionsPop());
  PetscCallAbort(PETSC_COMM_SELF, PetscOptionsDestroy(&own));
  return message;
}

std::string ReadNumber(const std::string &options, double *value, const Range &range = kPositive, bool required = false)
{
  return Refusal(options, [&](OptionReader &reader) { return reader.Read({"-size", "edge", "m", range}, value, required); });
}

std::string ReadInteger(const std::string &options, int *value)
{
  return Refusal(options, [&](OptionReader &reader) { return reader.Read({"-count", "number", "", Closed(1, 16)}, value); });
}

std::string ReadNames(const std::string &options, std::vector<std::string> *names)
{
  return Refusal(options, [&](OptionReader &reader) { return reader.Read({"-bodies", "names", ""}, names); });
}

std::string CheckWords(std::vector<std::string> words)
{
  std::vector<char *> arguments;
  words.insert(words.begin(), "program");
  for (std::string &word : words) arguments.push_back(word.data());
  return ReadCommandLine(static_cast<int>(arguments.size()), arguments.data()).problem;
}

/// What is wrong with an options file of this text.
std::string CheckFile(const std::string &text)
{
  const std::string path = testing::TempDir() + "mlgimp_unit_options_" + std::to_string(getpid()) + ".opts";
  std::ofstream(path, std::ios::binary) << text;
  const std::string found = CheckWords({"-options_file", path});
  std::remove(path.c_str());
  const std::size_t at = found.find(path);
  return at == std::string::npos ? found : found.substr(0, at) + "FILE" + found.substr(at + path.size());
}

/// Reads an indenter that comes down on nothing with a tip at the origin; returns the message of a refusal.
std::string ReadOneIndenter(GeometryKind geometry, const std::string &options,
                            std::unique_ptr<IndenterSurface> *surface = nullptr)
{
  const bool space = geometry == GeometryKind::kSpatial;
  Case c;
  c.model.geometry.kind = geometry;
  c.cell_size = 1e-3;
  c.time.max_steps = 1;
  const std::string motion =
      std::string(" -indenter_tip 0,0") + (space ? ",0" : "") + " -indenter_times 0 -indenter_velocities 1";
  return Refusal("-indenter " + options + motion, [&](OptionReader &reader) {
    reader.SetDim(c.Dim());
    ReadIndenter(reader, &c);
    RefuseUnused(reader.Known());
    if (surface) *surface = std::move(c.model.indenter->surface);
  });
}

TEST(Options, IndentersOfGeometries)
{
  constexpr GeometryKind kPlane = GeometryKind::kPlaneStrain, kRound = GeometryKind::kAxisymmetric,
                         kSpace = GeometryKind::kSpatial;
  EXPECT_EQ(ReadOneIndenter(kPlane, "wedge -indenter_half_angle 70 -indenter_tip_radius 1"), "");
  EXPECT_EQ(ReadOneIndenter(kPlane, "flat_punch -indenter_width 1"), "");
  EXPECT_EQ(ReadOneIndenter(kRound, "cone -indenter_half_angle 70"), "");
  EXPECT_EQ(ReadOneIndenter(kRound, "flat_punch -indenter_radius 1"), "");
  EXPECT_EQ(ReadOneIndenter(kSpace, "sphere -indenter_radius 1"), "");
  EXPECT_EQ(ReadOneIndenter(kSpace, "pyramid -indenter_half_angle 60 -indenter_faces 5 -indenter_turn -20"), "");
  EXPECT_EQ(ReadOneIndenter(kPlane, "cone"),
            "-indenter cone: must be one of none, wedge, cylinder, flat_punch, polygon, profile in -geometry plane_strain");
  EXPECT_EQ(ReadOneIndenter(kRound, "wedge"),
            "-indenter wedge: must be one of none, flat_punch, cone, sphere, area_function, profile in -geometry axisymmetric");
  EXPECT_EQ(ReadOneIndenter(kRound, "vickers"),
            "-indenter vickers: must be one of none, flat_punch, cone, sphere, area_function, profile in -geometry axisymmetric");
  EXPECT_EQ(ReadOneIndenter(kSpace, "pyramid -indenter_half_angle 60 -indenter_faces 2"),
            "-indenter_faces 2: must be a whole number in [3, 360]");
  EXPECT_EQ(ReadOneIndenter(kSpace, "cone -indenter_half_angle -60"), "-indenter_half_angle -60: must be in (0, 90)");
  EXPECT_NE(ReadOneIndenter(kSpace, "flat_punch -indenter_width 1").find("-indenter_radius"), std::string::npos);
  EXPECT_NE(ReadOneIndenter(kSpace, "vickers -indenter_half_angle 60").find("-indenter_half_angle"), std::string::npos);
  EXPECT_NE(ReadOneIndenter(kSpace, "cone -indenter_half_angle 60 -indenter_turn 3").find("-indenter_turn"), std::string::npos);
}

/// Named pyramids have the angles from the axis that their standards give.
TEST(Options, NamedPyramids)
{
  const std::pair<const char *, double> names[] = {{"berkovich", 65.27}, {"vickers", 68}, {"cube_corner", 35.26}};
  for (const auto &[name, angle] : names) {
    std::unique_ptr<IndenterSurface> surface;
    ASSERT_EQ(ReadOneIndenter(GeometryKind::kSpatial, name, &surface), "");
    EXPECT_NEAR(std::asin(-surface->Gap({1, 0, 0}).normal[2]) * 180 / M_PI, angle, 0.005) << name;
  }
}

} // namespace

TEST(Options, Numbers)
{
  double value = 3;
  EXPECT_EQ(ReadNumber("", &value), "");
  EXPECT_EQ(value, 3) << "the default";
  EXPECT_EQ(ReadNumber("-size 2.5e-6", &value), "");
  EXPECT_EQ(value, 2.5e-6);
  EXPECT_EQ(ReadNumber("-size -1", &value, kAnyNumber), "");
  EXPECT_EQ(value, -1);
  EXPECT_EQ(ReadNumber("-size 1,2", &value), "-size 1,2: must be > 0; one number, and not 2 with commas");
  for (const char *bad : {"0", "-1"})
    EXPECT_EQ(ReadNumber(std::string("-size ") + bad, &value), std::string("-size ") + bad + ": must be > 0");
  for (const std::string bad : {"nan", "inf", "1e999", "0x1p"})
    EXPECT_EQ(ReadNumber("-size " + bad, &value), "-size " + bad + ": must be > 0; " + bad + " is no finite number");
  EXPECT_EQ(ReadNumber("-size 1um", &value), "");
  EXPECT_EQ(value, 1e-6);
  EXPECT_EQ(ReadNumber("-size 1kg", &value),
            "-size 1kg: must be a number, or one with its unit; kg is a mass, -size is a length");
  EXPECT_EQ(ReadNumber("-size", &value), "-size (nothing): must be > 0");
  EXPECT_EQ(ReadNumber("-size 1", &value, Open(0, 1)), "-size 1: must be in (0, 1)");
  EXPECT_EQ(ReadNumber("-size 1", &value, Closed(0, 1)), "");
  EXPECT_EQ(ReadNumber("", &value, kPositive, true), "-size: must be given: edge");
}

TEST(Options, HelpRequiresNothing)
{
  double value = 3;
  const Read read = [&](OptionReader &reader) { return reader.Read({"-size", "edge", "m", kPositive}, &value, kRequired); };
  EXPECT_EQ(Refusal("", read, true), "");
}

TEST(Options, WholeNumbers)
{
  int value = 7;
  EXPECT_EQ(ReadInteger("", &value), "");
  EXPECT_EQ(value, 7);
  EXPECT_EQ(ReadInteger("-count 16", &value), "");
  EXPECT_EQ(value, 16);
  for (const char *bad : {"0", "17", "1.5", "-1", "two", "4294967297"})
    EXPECT_EQ(ReadInteger(std::string("-count ") + bad, &value),
              std::string("-count ") + bad + ": must be a whole number in [1, 16]");
}

TEST(Options, ListsAndVectors)
{
  std::vector<double> values = {9};
  Vec3 vector{};
  const Read read = [&](OptionReader &reader) { return reader.Read({"-times", "t", "s", kNotNegative, 2}, &values); };
  const Read pair = [&](OptionReader &reader) { return reader.Read({"-tip", "place", "m"}, &vector, kRequired); };
  EXPECT_EQ(Refusal("-times 0,1e-3,4", read), "");
  EXPECT_EQ(values, (std::vector<double>{0, 1e-3, 4}));
  EXPECT_EQ(Refusal("-times 1", read), "-times 1: must be at least 2 numbers >= 0");
  EXPECT_EQ(Refusal("-times 1,,2", read), "-times 1,,2: must be at least 2 numbers >= 0; (nothing) is no finite number");
  EXPECT_EQ(Refusal("-times 1,-2", read), "-times 1,-2: must be at least 2 numbers >= 0");
  EXPECT_EQ(Refusal("-tip 1,-2", pair), "");
  EXPECT_EQ(vector, (Vec3{1, -2}));
  const std::pair<const char *, const char *> pairs[] = {
      {"1", ""}, {"1,2,3", ""}, {"1,", "; (nothing) is no finite number"}, {"a,b", "; a is no finite number"}};
  for (const auto &[bad, why] : pairs)
    EXPECT_EQ(Refusal(std::string("-tip ") + bad, pair),
              std::string("-tip ") + bad + ": must be 2 numbers separated by commas" + why);
}

TEST(Options, WordsAndFlags)
{
  std::string kind = "box";
  bool on = true;
  const Read choose = [&](OptionReader &reader) { return reader.Choice({"-kind", "shape", ""}, {"box", "disk"}, &kind); };
  const Read flag = [&](OptionReader &reader) { return reader.Read({"-on", "flag", ""}, &on); };
  EXPECT_EQ(Refusal("", choose), "");
  EXPECT_EQ(kind, "box");
  EXPECT_EQ(Refusal("-kind disk", choose), "");
  EXPECT_EQ(kind, "disk");
  EXPECT_EQ(Refusal("-kind Disk", choose), "-kind Disk: must be disk, which is nearest, or another of box, disk");
  EXPECT_EQ(Refusal("-kind ball", choose), "-kind ball: must be one of box, disk");
  EXPECT_EQ(Refusal("-on false", flag), "");
  EXPECT_FALSE(on);
  EXPECT_EQ(Refusal("-on", flag), "");
  EXPECT_TRUE(on);
  EXPECT_EQ(Refusal("-on maybe", flag), "-on maybe: must be true or false (or yes, no, on, off, 1, 0)");
}

TEST(Options, Names)
{
  std::vector<std::string> names;
  EXPECT_EQ(ReadNames("-bodies disk,block_2", &names), "");
  EXPECT_EQ(names, (std::vector<std::string>{"disk", "block_2"}));
  for (const char *bad : {"a,a", "2b", "a,", "a-b", "_a"})
    EXPECT_EQ(ReadNames(std::string("-bodies ") + bad, &names),
              std::string("-bodies ") + bad +
                  ": must be different names of letters, digits and underscores, separated by commas");
}

TEST(Options, NoNameTwice)
{
  double value = 1;
  const Read twice = [&](OptionReader &reader) {
    reader.Read({"-size", "edge", "m", kPositive}, &value);
    reader.Read({"-size", "edge", "m", kPositive}, &value);
  };
  EXPECT_EQ(Refusal("", twice), "-size: must be an option of one body, material or load; rename one of those that it belongs to");
}

TEST(Options, NearestIsAlsoANameOfWhichThatIsTheBeginning)
{
  const std::vector<std::string> known = {"-ti_preset", "-ti_yield_stress", "-frames", "-frame_precision"};
  EXPECT_EQ(Nearest("-ti_yeild", known), "-ti_yield_stress");
  EXPECT_EQ(Nearest("-frame", known), "-frames");
  EXPECT_EQ(Nearest("-ti_presets", known), "-ti_preset");
}

TEST(Options, WhatNothingReads)
{
  double value = 1;
  const Read read = [&](OptionReader &reader) {
    reader.Read({"-cell_size", "h", "m", kPositive}, &value);
    reader.Read({"-thickness", "t", "m", kPositive}, &value);
    RefuseUnused(reader.Known());
  };
  EXPECT_EQ(Refusal("-cell_size 1", read), "");
  EXPECT_EQ(Refusal("-cell_siez 1", read),
            "-cell_siez: unknown or unused option in this case; the nearest known name is -cell_size");
  EXPECT_EQ(Refusal("-cell_sezi_of 1", read), // near to no name that this case reads
            "-cell_sezi_of: unknown or unused option in this case; another kind of indenter, law, geometry or test has it");
  EXPECT_EQ(Refusal("-thickness=2 -cell_size 1", read),
            "-thickness=2: a blank must be between an option's name and its value, not =");
}

/// 1 and 1.0 are the same case; what does not count for it is left out.
TEST(Options, Identity)
{
  double value = 5;
  std::vector<std::string> identity;
  const Read read = [&](OptionReader &reader) {
    reader.Read({"-size", "edge", "m", kPositive}, &value);
    reader.Identify(false);
    reader.Read({"-frames", "n", "", kPositive}, &value);
    identity = reader.Identity();
  };
  EXPECT_EQ(Refusal("-size 1.0 -frames 3", read), "");
  EXPECT_EQ(identity, std::vector<std::string>{"-size 1"});
}

TEST(Options, CommandLine)
{
  EXPECT_EQ(CheckWords({}), "");
  EXPECT_EQ(CheckWords({"-cell_size", "1", "-overwrite", "-tip", "-1,2"}), "");
  EXPECT_EQ(CheckWords({"word"}), "'word': must follow an option that takes it; options begin with a dash");
  EXPECT_EQ(CheckWords({"-size", "1", "2"}), "'2': must follow an option that takes it; options begin with a dash");
  EXPECT_EQ(CheckWords({"-size", "1", "-size", "2"}), "") << "the later one counts";
  EXPECT_NE(CheckWords({"-size", std::string(70000, '1')}).find("65535 characters"), std::string::npos);
  EXPECT_EQ(CheckWords({"-options_file", "/nowhere/at.opts"}),
            "-options_file /nowhere/at.opts: must be a readable file with options");
}

TEST(Options, Files)
{
  EXPECT_EQ(CheckFile("# a comment\n-cell_size 1 # another\n\n-overwrite\n-tip -1,2\n"), "");
  EXPECT_EQ(CheckFile(""), "-options_file FILE: must be a readable file with options");
  EXPECT_EQ(CheckFile("-size 1\nsize 2\n"), "-options_file FILE: line 2: must be '-name value', found 'size'");
  EXPECT_EQ(CheckFile("-tip 0, 1\n"), "-options_file FILE: line 1: must be '-name value' with no blanks in the value, found '1'");
  EXPECT_EQ(CheckFile("-size 1\n-size 2\n"),
            "-size 2: must be given once, found again in line 2 of FILE (capitals make no difference)");
  EXPECT_EQ(CheckFile("-options_file b.opts\n"),
            "-options_file FILE: line 1: must not name another options file; give both on the command line");
  EXPECT_EQ(CheckFile("-size \x1b[31m\n"), "-options_file FILE: line 1: must be text, found '-size ?[31m'");
}

TEST(Options, Texts)
{
  EXPECT_EQ(OneLine("a\nb\x1b"
                    "c"),
            "a?b?c");
  EXPECT_EQ(Shortened("short"), "short");
  EXPECT_EQ(Shortened(std::string(300, 'x')), std::string(200, 'x') + "... (300 characters)");
}
