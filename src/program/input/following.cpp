// Options of boxes that follow the contact or a path.
#include "program/input/read_case.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

static std::string LevelOption(int k, const char *name) { return Format("-level_{}{}", k, name); }

static void ReadContactFollowing(OptionReader &reader, Case *c)
{
  FollowSettings &follow = c->hierarchy.follow;
  reader.Read({"-level_cells_max", "contact: cells of the finest level in half the contact's width, above which the level ends",
               "", kPositive},
              &follow.cells_max);
  reader.Read({"-level_cells_min", "contact: cells below which a finer level begins, up to -levels", "", kNotNegative},
              &follow.cells_min);
  if (!reader.Help() && follow.cells_max < (c->hierarchy.ratio + 1) * follow.cells_min)
    reader.Refuse("-level_cells_max", follow.cells_max,
                  ">= {}, (-refinement_ratio + 1) times -level_cells_min, or levels would come and go",
                  FormatNumber((c->hierarchy.ratio + 1) * follow.cells_min));
  for (int k = 1; k <= (reader.Help() ? 1 : c->levels - 1); ++k) {
    std::vector<double> margin;
    const Option text = {LevelOption(k, "_margin"),
                         "contact: cells of the level that its box keeps free around the contact, sideways and down, or one "
                         "number for both (default: 0.6 half widths of the contact; at least what borders need)",
                         "",
                         kNotNegative,
                         1,
                         2};
    if (reader.Read(text, &margin)) follow.margins[k] = {margin.front(), margin.back()};
  }
}

static void ReadPath(OptionReader &reader, Case *c, int k)
{
  std::vector<double> times, path;
  const std::size_t dim = c->Dim();
  const std::string name = LevelOption(k, "_path");
  const Option text = {name, "path: how far the level's box has moved at each time of -level_1_times, piecewise linear", "m"};
  const bool moves = reader.Read(text, &path);
  const bool timed = ReadTimes(reader, LevelOption(k, "_times"), moves, &times);
  if (reader.Help() || (!moves && !timed)) return; // it stays
  if (path.size() != dim * times.size())
    reader.Refuse(name, Format("{} numbers", path.size()), "{} for each time in {}: {}", dim, LevelOption(k, "_times"),
                  dim * times.size());
  for (std::size_t axis = 0; axis < dim; ++axis) {
    std::vector<double> values;
    for (std::size_t t = 0; t < times.size(); ++t) values.push_back(path[dim * t + axis]);
    c->hierarchy.follow.paths[k][axis] = PiecewiseLinear(times, values);
  }
}

void ReadFollowing(OptionReader &reader, Case *c)
{
  FollowSettings &follow = c->hierarchy.follow;
  const std::vector<std::string> kinds = {"none", "contact", "path"};
  std::string kind = kinds[0];
  follow.kind = static_cast<FollowKind>(
      reader.Choice({"-level_follow", "what the boxes of levels follow: nothing, the contact, or paths"}, kinds, &kind));
  follow.margins.resize(c->levels);
  follow.paths.resize(std::max(c->levels, 2));
  if (follow.kind != FollowKind::kNone || reader.Help())
    reader.Read(
        {"-regrid_interval", "contact, path: level-0 steps between two checks whether boxes must move", "", Closed(1, 2e9)},
        &follow.interval);
  if (follow.kind == FollowKind::kContact || reader.Help()) ReadContactFollowing(reader, c);
  for (int k = 1; k <= (reader.Help() ? 1 : c->levels - 1) && follow.kind != FollowKind::kContact; ++k)
    if (follow.kind == FollowKind::kPath || reader.Help()) ReadPath(reader, c, k);
}

void CheckFollowing(OptionReader &reader, const Case &c)
{
  const FollowKind kind = c.hierarchy.follow.kind;
  if (kind == FollowKind::kNone) return;
  if (c.hierarchy.coupling == LevelCoupling::kPoints)
    reader.Refuse("-level_follow", kind == FollowKind::kContact ? "contact" : "path", "none with -level_coupling points");
  if (kind == FollowKind::kContact && (!c.model.indenter || c.model.contact.method != "pressure"))
    reader.Refuse("-level_follow", "contact", "none or path without an -indenter and -contact pressure");
}

void CheckPaths(OptionReader &reader, const Case &c)
{
  if (c.hierarchy.follow.kind != FollowKind::kPath) return;
  for (const BoxesAtTime &at : BoxesAlongPaths(c)) {
    const int k = FindMisplaced(c.hierarchy.rules, at.boxes);
    if (k == 0) continue;
    const double room = c.hierarchy.rules.Border(k - 1);
    reader.Refuse(LevelOption(k, "_path"), "",
                  "such that the level's box stays {}within level {}; on cell lines it is {} to {} at time {} s, in {} to {}",
                  room > 0 ? Format("{} m ", room) : "", k - 1, reader.Text(at.boxes[k].lower), reader.Text(at.boxes[k].upper),
                  at.time, reader.Text(at.boxes[k - 1].lower), reader.Text(at.boxes[k - 1].upper));
  }
}

} // namespace mlgimp
