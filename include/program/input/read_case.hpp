// All options of a case, and the groups of them that fill a file of their own.
#pragma once

#include "program/case/case.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// Reads and checks all options of a case. With -help nothing is required and nothing is checked.
void ReadCase(OptionReader &reader, Case *c);

void ReadLevels(OptionReader &reader, Case *c);
/// Whether and how boxes follow.
void ReadFollowing(OptionReader &reader, Case *c);
/// What ReadFollowing could not know before the indenter was read.
void CheckFollowing(OptionReader &reader, const Case &c);
/// Each box on its path must lie in the next coarser one, as deep as its border needs.
void CheckPaths(OptionReader &reader, const Case &c);
/// The grids of the levels, once all is known that they follow.
void PlaceLevels(Case *c);
void ReadMaterials(OptionReader &reader, Case *c, std::vector<std::string> *names);
/// The constants of a crystal in the axes of the run, and Young's modulus and Poisson's ratio of their mean over all
/// orientations.
void ReadCrystal(OptionReader &reader, const std::string &prefix, GeometryKind kind, MaterialConstants *c);
/// The least of twice the energies of strains e with e : e = 1, Pa: positive, or the body would not be stable.
double LeastEigenvalue(const Stiffness &stiffness);
void ReadBodies(OptionReader &reader, const std::vector<std::string> &materials, Case *c, std::vector<std::string> *names);
/// The stress of a body at the start, and the stretches that go with it.
void ReadInitialStress(OptionReader &reader, const Model &model, Body *body);
void ReadLoads(OptionReader &reader, const std::vector<std::string> &bodies, Case *c);
void ReadIndenter(OptionReader &reader, Case *c);
/// The surface of an indenter of a kind, none with -help. Collective on all ranks where a file describes it.
void ReadTip(OptionReader &reader, const std::string &kind, Case *c);
/// Half the angle of the cone with the same area at each depth as a regular pyramid that has a name, degrees; 0 where the kind is
/// none.
double EquivalentHalfAngle(const std::string &kind);
/// What goes with a method of contact that has been chosen.
void ReadContact(OptionReader &reader, ContactSettings *contact);

/// A value of an option and the geometries that have it.
struct NamedInGeometry {
  const char *name;
  bool has[3]; ///< by GeometryKind
};

/// Kinds of -indenter.
const std::vector<NamedInGeometry> &IndenterKinds();

/// Chooses one of the values that the geometry has; -help lists all.
void ChooseInGeometry(OptionReader &reader, const Option &option, GeometryKind geometry,
                      const std::vector<NamedInGeometry> &values, std::string *value);

/// Times of a history, increasing; returns whether they were given.
bool ReadTimes(OptionReader &reader, const std::string &name, bool required, std::vector<double> *times);
/// Times and values of a piecewise-linear history.
void ReadHistory(OptionReader &reader, const std::string &times_name, const Option &values_text, PiecewiseLinear *history);

/// An empty string for a simple polygon; else what is wrong with its vertices, which the text numbers from 1.
std::string WrongPolygon(const std::vector<Vec3> &vertices);

} // namespace mlgimp
