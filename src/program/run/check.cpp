// The facts of a case before it runs, as text and as JSON.
#include "program/run/check.hpp"

#include "program/advice/case_checks.hpp"
#include "program/advice/warnings.hpp"
#include "program/system/agree.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

namespace mlgimp
{

namespace
{

using Json = nlohmann::ordered_json;

// Largest errors that were seen against 20 cells, of load and of the true area, times the cells in half the width of the contact;
// and by which share a block makes moduli too large, times its width in those of the contact: see docs/indentation.md.
constexpr double kLoadError = 0.3, kAreaError = 0.6, kBlockError = 1.09; // size: what is printed of a case
constexpr double kLongWay = 0.1; // size: what is printed of a case; share of the time before the tip touches

Json Vector(Vec3 x, int dim)
{
  Json list = Json::array();
  for (int axis = 0; axis < dim; ++axis) list.push_back(x[axis]);
  return list;
}

/// A quantity for people: three to four digits, with the prefix that leaves 1 to 1000 of the unit.
std::string Quantity(double value, const std::string &unit)
{
  constexpr const char *kPrefixes[] = {"f", "p", "n", "u", "m", "", "k", "M", "G", "T"}; // exact
  constexpr int kPlain = 5, kLast = 9;                                                   // exact: places of none and of the last
  if (value == 0 || !std::isfinite(value)) return Format("{} {}", value, unit);
  int place = kPlain + static_cast<int>(std::floor(std::log10(std::abs(value) * (1 + kRounding)) / 3));
  place = std::min(std::max(place, 0), kLast);
  return Format("{} {}{}", value / std::pow(10, 3 * (place - kPlain)), kPrefixes[place], unit);
}

/// Seconds as people say them.
std::string Duration(double seconds)
{
  constexpr double kMinute = 60, kHour = 3600, kDay = 86400; // exact
  if (seconds < 2 * kMinute) return Format("{} s", std::round(seconds * 10) / 10);
  if (seconds < 2 * kHour) return Format("{} min", std::round(seconds / kMinute));
  return seconds < 2 * kDay ? Format("{} h", std::round(10 * seconds / kHour) / 10)
                            : Format("{} days", std::round(10 * seconds / kDay) / 10);
}

/// The steps of level 0 that a run takes if waves stay as fast as they are now.
double StepsOf(const Case &c, const RunState &state)
{
  const double by_time =
      std::isfinite(c.time.end_time) ? std::ceil(c.time.end_time / state.time_step * (1 - kRounding)) : HUGE_VAL;
  return c.time.max_steps > 0 ? std::min<double>(by_time, c.time.max_steps) : by_time;
}

/// The time until which the motion that is known goes on.
double LastTime(const Case &c) { return std::min(c.time.end_time, c.model.indenter->motion.turning_time); }

/// The largest depth that the motion is known to reach, m, with a compliance that of the whole; not a number where it follows
/// from a load.
double LargestDepth(const Case &c)
{
  if (!c.model.indenter || c.model.indenter->by_load) return NAN;
  const Indenter &indenter = *c.model.indenter;
  if (c.quasi_static.depth > 0) return c.quasi_static.depth;
  return std::isfinite(LastTime(c)) ? indenter.Depth(indenter.Tip(LastTime(c))) : NAN;
}

/// How far the model reaches from the tip, in the direction across in which that is least, m.
double RoomBesideTip(const Case &c)
{
  double room = HUGE_VAL;
  for (int axis = 0; axis < c.model.indenter->up; ++axis) {
    const double x = c.model.indenter->tip[axis];
    room = std::min(room, std::max(x - c.domain.lower[axis], c.domain.upper[axis] - x));
  }
  return room;
}

/// The way to a body that takes much of the time, as a line; empty where there is none.
std::vector<std::string> EmptyWay(const Case &c)
{
  constexpr int kSamples = 1000; // size
  if (!c.model.indenter || c.model.indenter->by_load || !std::isfinite(LastTime(c))) return {};
  const Indenter &indenter = *c.model.indenter;
  int sample = 0;
  while (sample <= kSamples && indenter.Tip(LastTime(c) * sample / kSamples)[indenter.up] > indenter.initial_surface) ++sample;
  const double share = LastTime(c) * sample / kSamples / c.time.end_time;
  if (sample > kSamples || !(share > kLongWay)) return {};
  return {Format("the tip starts {} above the body: {} % of the time goes by before it touches",
                 Quantity(indenter.tip[indenter.up] - indenter.initial_surface, "m"), std::round(100 * share))};
}

/// A tip that comes near to the lower end of the domain, as a line; empty where it does not.
std::vector<std::string> DeepWay(const Case &c)
{
  constexpr double kDeep = 0.5; // size: what is printed of a case
  const double depth = LargestDepth(c);
  if (!(depth > 0)) return {};
  const double share = depth / (c.model.indenter->initial_surface - c.domain.lower[c.model.indenter->up]);
  if (!(share > kDeep)) return {};
  return {Format("the largest depth is {} % of the height from the domain's lower end to the surface", std::round(100 * share))};
}

/// The cells under the tip at the end, m: where boxes follow the contact, finest levels end as it grows.
double CellAtEnd(const Case &c, double half_width)
{
  const FollowSettings &follow = c.hierarchy.follow;
  int level = c.LevelAtTip();
  while (follow.kind == FollowKind::kContact && level > 0 && half_width / c.CellSize(level) > follow.cells_max) --level;
  return c.CellSize(level);
}

Json ContactJson(const Case &c)
{
  const double depth = LargestDepth(c);
  if (!(depth > 0)) return nullptr;
  const double half = c.model.indenter->HalfWidth(depth), cells = half / CellAtEnd(c, half);
  const bool plane = c.model.geometry.kind == GeometryKind::kPlaneStrain;
  return {{"depth", depth},
          {"surface", c.model.indenter->initial_surface},
          {"half_width", half},
          {"cells", cells},
          {"load_error", kLoadError / cells},
          {"area_error", kAreaError / cells},
          {"block_error", plane ? Json(nullptr) : Json(kBlockError * half / RoomBesideTip(c))}, // there depths have no limit
          {"at_most", c.model.indenter->compliance.Any()}};
}

Json LevelsJson(Hierarchy &hierarchy, const Case &c)
{
  std::vector<double> points, largest;
  ExitOnError(hierarchy.Connected().CountPoints(&points, &largest));
  Json levels = Json::array();
  for (int l = 0; l < c.levels; ++l)
    levels.push_back({{"cell_size", c.CellSize(l)},
                      {"lower", Vector(c.boxes[l].lower, c.Dim())},
                      {"upper", Vector(c.boxes[l].upper, c.Dim())},
                      {"points", points[l]},
                      {"active", l < hierarchy.Levels()}});
  return levels;
}

/// "level 1  cells of 250 nm, 3200 points, from (0, 20e-6) to ...".
std::string LevelLine(const Json &level, std::size_t number)
{
  std::vector<std::string> edges;
  for (std::size_t axis = 0; axis < level["lower"].size(); ++axis)
    edges.push_back(Quantity(level["upper"][axis].get<double>() - level["lower"][axis].get<double>(), "m"));
  return Format("level {}     cells of {}, {} points, {}", number, Quantity(level["cell_size"].get<double>(), "m"),
                FormatNumber(level["points"].get<double>()), Join(edges, " x "));
}

std::string ContactLine(const Json &contact)
{
  if (contact.is_null()) return "contact     its width follows from the load and is not known before the run";
  const auto percent = [&](const char *name) { return std::round(1000 * contact[name].get<double>()) / 10; };
  const std::string block =
      contact["block_error"].is_null() ? "" : Format("; the block makes moduli up to {} % too large", percent("block_error"));
  return Format("contact     at the largest depth, {}{}, half as wide as {}, {} cells: errors of up to {} % of the load, {} % of "
                "the area{}",
                Quantity(contact["depth"].get<double>(), "m"),
                contact["at_most"].get<bool>() ? " less what frame and tip take of it (what follows is without that)" : "",
                Quantity(contact["half_width"].get<double>(), "m"), std::round(10 * contact["cells"].get<double>()) / 10,
                percent("load_error"), percent("area_error"), block);
}

std::string Text(const Json &json)
{
  std::vector<std::string> lines = {
      Format("case        {}, {}", json["case"].get<std::string>(), json["geometry"].get<std::string>())};
  for (std::size_t l = 0; l < json["levels"].size(); ++l) lines.push_back(LevelLine(json["levels"][l], l));
  if (json["has_indenter"].get<bool>()) lines.push_back(ContactLine(json["contact"]));
  lines.push_back(Format("steps       {} of {} on level 0, {} on the finest", FormatNumber(json["steps"].get<double>()),
                         Quantity(json["time_step"].get<double>(), "s"), FormatNumber(json["finest_steps"].get<double>())));
  const int ranks = json["ranks"].get<int>();
  lines.push_back(Format("memory      {}{}", Quantity(json["bytes_per_rank"].get<double>(), "B"),
                         ranks > 1 ? Format(" on each of {} ranks", ranks) : ""));
  lines.push_back(Format("time        about {}, {} a step{}", Duration(json["seconds"].get<double>()),
                         Quantity(json["seconds_per_step"].get<double>(), "s"),
                         json["changes"].get<bool>() ? "; boxes that follow and holds in which a body creeps change it" : ""));
  for (const auto &line : json["notes"]) lines.push_back(Format("note        {}", line.get<std::string>()));
  for (const auto &line : json["warnings"]) lines.push_back(Format("warning     {}", line.get<std::string>()));
  return Join(lines, "\n");
}

} // namespace

std::string DescribeCase(const Case &c, Hierarchy &hierarchy, const RunState &state, const MeasuredSteps &measured,
                         const std::vector<std::string> &warnings)
{
  const double steps = StepsOf(c, state), each = measured.steps > 0 ? measured.seconds / measured.steps : 0;
  const int ranks = RanksOf(hierarchy.Comm());
  const Json contact = ContactJson(c);
  std::vector<std::string> notes = EmptyWay(c), doubts = warnings;
  notes.insert(notes.begin(), c.notes.begin(), c.notes.end());
  for (std::string &line : DeepWay(c)) doubts.push_back(std::move(line));
  if (!contact.is_null()) {
    const std::vector<std::string> foreseen = ForeseenWarnings(c, contact["half_width"].get<double>(), LastTime(c));
    doubts.insert(doubts.end(), foreseen.begin(), foreseen.end());
  }
  const Json json = {{"case", c.name},
                     {"geometry", kGeometryNames[static_cast<int>(c.model.geometry.kind)]},
                     {"levels", LevelsJson(hierarchy, c)},
                     {"has_indenter", c.model.indenter.has_value()},
                     {"contact", contact},
                     {"steps", steps},
                     {"time_step", state.time_step},
                     {"finest_steps", steps * std::pow(c.hierarchy.ratio, hierarchy.Levels() - 1)},
                     {"end_time", std::min(c.time.end_time, steps * state.time_step)},
                     {"ranks", ranks},
                     {"bytes_per_rank", BytesNeeded(c) / ranks},
                     {"seconds_per_step", each},
                     {"seconds", steps * each},
                     {"changes", c.hierarchy.follow.kind != FollowKind::kNone || c.quasi_static.test.On()},
                     {"notes", notes},
                     {"warnings", doubts}};
  return ShareText(hierarchy.Comm(), c.output.check == "json" ? json.dump() : Text(json));
}

} // namespace mlgimp
