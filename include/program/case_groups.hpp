// The groups of options that ReadCase is made of, where they fill a file of their own.
#pragma once

#include "program/case.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

void ReadLevels(OptionReader &reader, Case *c);
/// Whether and how boxes follow.
void ReadFollowing(OptionReader &reader, Case *c);
/// What ReadFollowing could not know before the indenter was read.
void CheckFollowing(OptionReader &reader, const Case &c);
/// Boxes of all levels at a time, s.
struct BoxesAtTime {
  double time;
  std::vector<Box> boxes;
};
/// Those on paths, at the beginning and end of the run and at times between.
std::vector<BoxesAtTime> LooksAlongPaths(const Case &c);
/// Each box on its path must lie in the next coarser one, as deep as its border needs.
void CheckPaths(OptionReader &reader, const Case &c);
/// The grids of the levels, once all is known that they follow.
void PlaceLevels(Case *c);
void ReadMaterials(OptionReader &reader, Case *c, std::vector<std::string> *names);
void ReadBodies(OptionReader &reader, const std::vector<std::string> &materials, Case *c, std::vector<std::string> *names);
/// Warns where less than a cell lies between a body and others, or a side that holds it: they have nodes in common, and move as
/// if they touched.
void WarnOfGaps(OptionReader &reader, const Case &c, const Body &body);
void ReadLoads(OptionReader &reader, const std::vector<std::string> &bodies, Case *c);
void ReadIndenter(OptionReader &reader, Case *c);
/// Height of a body under or above x along an axis; false where there is none.
bool SurfaceAbove(const Region &region, Vec3 x, int up, double *height);
inline constexpr double kLargestSpeed = 0.1; ///< of an indenter, of the speed of waves; no indentation is as fast
/// Refuses or warns of what is wrong with an indenter of that kind once all of it has been read.
void CheckIndenterInput(OptionReader &reader, const Case &c, const std::string &kind);
/// A level that the tip meets must hold it with the band of its border for the whole run, also where its box follows a path.
void CheckLevelsHoldTip(OptionReader &reader, const Case &c);
/// Warns of bodies with fewer than two cells in their thickness where a load or the indenter presses them, and of a finest level
/// whose box does not hold the surface under the tip.
void WarnOfCells(OptionReader &reader, const Case &c);
/// What goes with a method of contact that has been chosen.
void ReadContact(OptionReader &reader, ContactSettings *contact);
/// -quasi_static and what goes with it; has_indenter: there is one that it could move.
void ReadQuasiStatic(OptionReader &reader, bool has_indenter, QuasiStaticPlan *plan);
/// Time of a wave from the contact to the support, or to any end of the bodies where nothing holds them, s.
double TransitOf(const Case &c);
/// Warns of a run that is too long, of loads after its end, and of an indenter or a load that is fast beside waves.
void CheckTimes(OptionReader &reader, const Case &c);
/// Puts a slow schedule with the same turns in place of the one that was read; end_time: what the user gave, or infinity.
void PlanQuasiStatic(OptionReader &reader, double end_time, Case *c);

/// A value of an option and the geometries that have it.
struct NamedInGeometry {
  const char *name;
  bool has[3]; ///< by GeometryKind
};

/// Chooses one of the values that the geometry has; -help lists all.
void ChooseInGeometry(OptionReader &reader, const OptionText &option, GeometryKind geometry,
                      const std::vector<NamedInGeometry> &values, std::string *value);

/// Times of a history, increasing; returns whether they were given.
bool ReadTimes(OptionReader &reader, const std::string &name, bool required, std::vector<double> *times);
/// Times and values of a piecewise-linear history.
void ReadHistory(OptionReader &reader, const std::string &times_name, const OptionText &values_text, const Range &range,
                 PiecewiseLinear *history);

} // namespace mlgimp
