// The warnings of a run, one function each: a line where there is something to tell, else empty.
#include "program/warnings.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mlgimp
{

namespace
{

/// What rows have told so far. Energies in J: what bodies have that no work explains, the most that they had or were given, what
/// they had at the start, and the largest of the indenter's work and of the noise; floor: where rounding begins.
struct Watched {
  const QuasiStaticWatch &slow;
  double made, given, had, indenter_work, noise, floor;
  double asked, carried; ///< largest loads, N
};

/// Energies below so many times the rounding of bodies at rest are none.
constexpr double kFloors = 1e6;

std::string When(const Budgets &budgets) { return " by time " + FormatRounded(budgets.time) + " s"; }

/// The surface lies deeper inside the indenter than a sharp tip between two columns explains.
std::string OfPenetration(const Case &c, const Budgets &budgets, const Watched &)
{
  if (!c.model.indenter || c.model.contact.method == "none") return "";
  const int level = c.LevelAtTip();
  const bool follows = c.hierarchy.follow.kind == FollowKind::kContact;
  if (budgets.penetration_cells <= 1) return "";
  return "-cell_size " + FormatNumber(c.cell_size) + ": the surface lies " + FormatRounded(budgets.penetration) +
         " m inside the indenter" + When(budgets) + ", more than a cell" + (follows ? "" : " of level " + std::to_string(level)) +
         ": the indenter is too slender or too fast for the cells, and the load too small";
}

/// A viscosity that is too strong for the step gives energy in place of taking it, and the run comes to a wrong end.
std::string OfViscosity(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kGiven = 0.01; // of what bodies have taken; energy of strain is below zero by rounding where there is none
  const double energy = budgets.kinetic_energy + std::abs(budgets.strain_energy) + budgets.plastic_work;
  if (budgets.short_wave_dissipation >= -kGiven * std::max(energy, watched.given)) return "";
  return "-short_wave_viscosity " + FormatNumber(c.model.short_wave.a) + "," + FormatNumber(c.model.short_wave.b) +
         ": has given " + FormatRounded(-budgets.short_wave_dissipation) + " J" + When(budgets) +
         " where it should take energy: the results are wrong from here; try a smaller second number or a smaller -cfl";
}

/// Contact gives more than the indenter where points make noise of it, and under a tip that tears the surface of a metal open: it
/// comes down with little load or none, and blows where it meets points again.
std::string OfContact(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost =
      0.1; // of the largest work, or what the bodies brought; steep cones on a few cells are seen to give 0.05
  if (!c.model.indenter || c.model.contact.method == "none") return "";
  const double given = budgets.contact_work + budgets.friction_work - budgets.indenter_work;
  const double work = std::max({watched.indenter_work, watched.had, std::abs(budgets.external_work), watched.floor});
  if (given <= kMost * work) return "";
  return "-indenter: contact has given the bodies " + FormatRounded(given) + " J more work than the indenter has done, " +
         FormatRounded(100 * given / work) + " % of what they got or brought," + When(budgets) +
         ": it has met few cells so far, or " +
         (c.model.HasMetal()
              ? "has torn the surface open, and the load is wrong; try smaller cells or a blunter tip"
              : "points make noise of it, and the load is wrong; try smaller cells, -xpic_fraction 0.02 or a smaller -cfl");
}

/// Contact takes a little where surface meets the indenter, in blows. Where it lets go of a surface under tension that sticks,
/// and catches it again, it takes much.
std::string OfContactLoss(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost = 0.15; // of the largest work, or what the bodies brought; runs that touch well are seen to take 0.1
  constexpr int kSteps = 100;    // of contact, before which it is all first touch
  if (!c.model.indenter || budgets.contact_steps < kSteps) return "";
  const double taken = budgets.indenter_work - budgets.contact_work - budgets.friction_work;
  const double work = std::max({watched.indenter_work, watched.had, std::abs(budgets.external_work), watched.floor});
  if (taken <= kMost * work) return "";
  return "-indenter: contact has taken " + FormatRounded(taken) + " J, " + FormatRounded(100 * taken / work) +
         " % of what the bodies were to get or brought," + When(budgets) +
         ": the surface has met the tip in blows, or let go of it and come back, and the load is wrong; try smaller cells, a "
         "slower "
         "indenter" +
         (std::isinf(c.model.contact.friction) ? " or a finite -indenter_friction" : "");
}

/// Motion of points that the grid cannot see softens flow: in metals it must stay small beside the work.
std::string OfNoise(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost = 0.005;
  if (!c.model.HasMetal() || !c.model.indenter || c.model.contact.method == "none") return "";
  if (budgets.plastic_work <= 0 || watched.noise <= kMost * watched.indenter_work) return "";
  return "-xpic_fraction " + FormatNumber(c.model.nodal.xpic_fraction) + ": noise of the points' velocities holds " +
         FormatRounded(100 * watched.noise / watched.indenter_work) + " % of the indenter's work" + When(budgets) +
         ", which softens plastic flow: try a larger fraction or a slower indenter";
}

/// The same of bodies that fly, at the end: those that turn pass through the cells, and their motion becomes what nodes do not
/// see. Not where energy is made or lost, which has another cause.
std::string OfMotion(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost = 0.05;
  if (c.model.indenter || std::abs(watched.made) > kMost * watched.given) return "";
  if (budgets.noise_energy <= kMost * std::max(watched.given, kFloors * watched.floor)) return "";
  return "-bodies: noise of the points' velocities holds " + FormatRounded(budgets.noise_energy) + " J" + When(budgets) +
         ", where the bodies had or got " + FormatRounded(watched.given) +
         " J: bodies that turn, or collide, have too few cells for it, and lose their motion; try smaller cells";
}

/// The same of elastic bodies, at the end: a surface that a tip slides along with friction feeds it, the more the smaller steps
/// are, and bodies that are bent far have it at their surfaces.
std::string OfElasticNoise(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost = 0.01, kLeastShare = 0.3; // of the strain energy; of the kinetic energy, which is more in fast tests
  if (c.model.HasMetal() || budgets.noise_energy <= kMost * budgets.strain_energy) return "";
  if (budgets.noise_energy <= kLeastShare * budgets.kinetic_energy || !OfMotion(c, budgets, watched).empty()) return "";
  return "-xpic_fraction " + FormatNumber(c.model.nodal.xpic_fraction) + ": noise of the points' velocities holds " +
         FormatRounded(100 * budgets.noise_energy / budgets.strain_energy) + " % of the strain energy" + When(budgets) +
         ": stresses and pressures are uneven; try " + (c.model.nodal.xpic_fraction < 0.02 ? "0.02" : "a larger fraction") +
         (c.model.indenter ? ", or a slower indenter" : "") + "; smaller steps alone make it worse";
}

/// Where contact crosses a border of levels, columns of both press the same nodes, and share the load as they happen to. Where
/// the surface there comes to a line of nodes, points may still split, and make energy.
std::string OfBorder(const Case &c, const Budgets &budgets, const Watched &)
{
  const int coarsest = c.levels - static_cast<int>(budgets.contact_coarseness), finest = static_cast<int>(budgets.contact_level);
  if (c.hierarchy.follow.kind != FollowKind::kNone || budgets.contact_level == 0 || coarsest == finest) return "";
  const std::string level = "-level_" + std::to_string(finest);
  return level + "_lower, " + level + "_upper: contact crosses a border of levels" + When(budgets) +
         ": contact_area, contact_half_width, peak_pressure and pressures on points are uneven there, and so may stress and load "
         "be where the surface comes to a line of cells; try a box that holds all of the contact";
}

/// Levels that follow the contact, and are too few for how wide it gets.
std::string OfWidest(const Case &c, const Budgets &budgets, const Watched &)
{
  const FollowSettings &follow = c.hierarchy.follow;
  const double cells = budgets.contact_half_width / c.CellSize(0);
  if (follow.kind != FollowKind::kContact || cells <= follow.cells_max) return "";
  return "-levels " + std::to_string(c.levels) + ": half the contact's width is " + FormatRounded(cells) + " cells of level 0" +
         When(budgets) + ", more than -level_cells_max, and no level is coarser: try more levels and a larger -cell_size";
}

/// Finest cells in half the contact's width from which the load is no more that of the cells. With fewer than two it is some 10 %
/// off, and a third before, as the tip stands between columns; metal rises beside a steep tip column by column for longer.
double EnoughCells(const Case &c)
{
  constexpr double kNear = 4, kSteep = 4; // a half angle of 63 degrees
  const double height = kNear * c.CellSize(c.levels - 1);
  return c.model.HasMetal() && c.model.indenter->surface->Width(height) < kSteep * height ? 6 : 2;
}

/// A contact that never gets wide. Not that of a flat indenter over the whole end of a body.
std::string OfNarrowest(const Case &c, const Budgets &budgets, const Watched &)
{
  if (budgets.contact_cells == 0) return "";
  const FollowSettings &follow = c.hierarchy.follow;
  const bool follows = follow.kind == FollowKind::kContact;
  const double cells = budgets.contact_cells, finest = c.CellSize(c.levels - 1);
  const double least = follows ? follow.cells_min : EnoughCells(c);
  if (cells >= least || c.model.indenter->surface->Width(0) > 2 * (cells + 1) * finest) return "";
  return (follows ? "-levels " + std::to_string(c.levels) : "-cell_size " + FormatNumber(c.cell_size)) +
         ": half the contact's width is at most " + FormatRounded(cells) + " of the finest cells, fewer than " +
         (follows ? "-level_cells_min" : FormatNumber(least)) + ": the load is that of the cells; try " +
         (follows ? "more levels" : "smaller ones, or more -levels");
}

/// Contact that reaches a side of symmetry which the tip is beside meets its mirror image. A plate over all of the domain has
/// none.
std::string OfMirrorImage(const Case &c, const Budgets &budgets, const Watched &)
{
  if (!c.model.indenter || budgets.contact_half_width == 0) return "";
  const Indenter &indenter = *c.model.indenter;
  const Vec3 tip = indenter.Tip(budgets.time);
  const double reach = budgets.contact_half_width * (1 - kRounding), flat = indenter.surface->Width(0);
  for (int s = c.model.geometry.HasHoop() ? 2 * indenter.up : 0; s < 2 * indenter.up; ++s) {
    const Side side = static_cast<Side>(s);
    const int axis = AxisOf(side);
    const double off = std::abs(tip[axis] - c.domain.At(side));
    const bool covers = flat > 2 * (c.domain.upper[axis] - c.domain.lower[axis]);
    if (c.model.sides[s] == BoundaryKind::kSymmetry && c.SideAtTip(axis) != side && off < reach && !covers)
      return "-indenter_tip " + FormatVector(indenter.tip, c.Dim()) + ": contact has reached " + kSideNames[s] + When(budgets) +
             ", a side of symmetry " + FormatRounded(off) + " m beside the tip: the load is that of two indenters, one of them " +
             "mirrored, that have met; put the tip on the side, or farther away";
  }
  return "";
}

/// A slow test that is not slow.
std::string OfSpeed(const Case &c, const Budgets &, const Watched &watched)
{
  constexpr double kLeast = 0.01, kMostAdded = 2; // of energy; of the tolerance
  const double share = watched.slow.LoadShare(), kinetic = watched.slow.KineticShare();
  if (share <= kMostAdded * c.quasi_static.tolerance && kinetic <= std::max(kLeast, c.quasi_static.tolerance)) return "";
  return "-quasi_static_tolerance " + FormatNumber(c.quasi_static.tolerance) + ": inertia and damping have added up to " +
         FormatRounded(100 * share) + " % to the load, and kinetic energy was up to " + FormatRounded(100 * kinetic) +
         " % of what the body has taken: try a smaller one, or less -damping where that was given";
}

/// A load that the tip, at its largest speed, has not come to carry.
std::string OfLoad(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMet = 0.5; // the load of a row is the mean of its step
  if (!c.model.indenter || !c.model.indenter->by_load) return "";
  const double asked = c.model.indenter->by_load->force.Value(budgets.time);
  const bool missed = watched.carried < kMet * watched.asked;
  if (budgets.load >= kMet * asked && !missed) return "";
  return "-indenter_loads: " + FormatRounded(missed ? watched.asked : asked) + " N are asked for" +
         (missed ? ", and the tip carries at most " : " at the end, and the tip carries ") +
         FormatRounded(missed ? watched.carried : budgets.load) +
         " N: it may not move faster than a tenth of the waves; try longer -indenter_times";
}

/// An indenter that has met no body: it is deep, beside all bodies, or has gone up. Where a load moves it, OfLoad tells.
std::string OfTouch(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kDeep = 0.5; // cells; the tip of a wedge between two columns is a fifth of a cell deep before it touches
  if (!c.model.indenter || c.model.contact.method == "none" || c.model.indenter->by_load || watched.carried > 0) return "";
  const Indenter &indenter = *c.model.indenter;
  const auto is_below = [&](const Body &body) {
    const Box bounds = body.region->Bounds();
    bool below = true;
    for (int axis = 0; axis < indenter.up; ++axis)
      below = below && indenter.tip[axis] >= bounds.lower[axis] && indenter.tip[axis] <= bounds.upper[axis];
    return below;
  };
  const bool above_body = std::any_of(c.model.bodies.begin(), c.model.bodies.end(), is_below);
  const bool came_down = budgets.depth >= indenter.Depth(indenter.tip);
  if (above_body && came_down && budgets.depth <= kDeep * c.CellSize(c.LevelAtTip())) return "";
  return "-indenter_tip " + FormatVector(indenter.tip, c.Dim()) + ": the indenter has touched nothing: is it above a body?";
}

/// Damping that is strong beside the indenter's motion carries a part of the load.
std::string OfDamping(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost = 0.2;
  if (!c.model.indenter || c.model.contact.method == "none" || c.quasi_static.on) return "";
  if (budgets.damping_work <= kMost * std::max(watched.given, watched.floor)) return "";
  return "-damping " + FormatNumber(c.model.nodal.damping) + ": has taken " + FormatRounded(budgets.damping_work) + " J" +
         When(budgets) + ", where the bodies had or got " + FormatRounded(watched.given) +
         " J, and carries a part of the load: try less, or a slower indenter";
}

/// Steps that are too long make energy without limit. What contact gives is no part of it; in the middle of a blow a tenth is
/// seen, and more in the first steps of a touch, as velocities are half a step behind stresses.
std::string OfEnergy(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost = 0.25; // of what they were given
  if (watched.made <= kMost * std::max(watched.given, kFloors * watched.floor)) return "";
  const std::string option =
      c.time.time_step > 0 ? "-time_step " + FormatNumber(c.time.time_step) : "-cfl " + FormatNumber(c.time.cfl);
  return option + ": the bodies have made " + FormatRounded(watched.made) + " J" + When(budgets) + ", where they had or got " +
         FormatRounded(watched.given) + " J: steps are too long, and the results wrong; try a smaller one";
}

/// Bodies whose points part or crumple, whose waves few cells see, or whose turning XPIC takes for noise, lose energy that no
/// work has.
std::string OfLoss(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMost = 0.15; // of what they were given
  if (-watched.made <= kMost * std::max(watched.given, kFloors * watched.floor)) return "";
  if (!OfElasticNoise(c, budgets, watched).empty()) return ""; // which has taken it
  return "-bodies: have lost " + FormatRounded(-watched.made) + " J that no work explains" + When(budgets) +
         ", where they had or got " + FormatRounded(watched.given) +
         " J: cells are too few for how they turn and for their waves, or points have parted or crumpled; look at the last "
         "frames, and try smaller cells or steps" +
         (c.model.nodal.xpic_fraction > 0 ? ", or a smaller -xpic_fraction" : "") +
         (c.model.VolumeAverages() > 0 && !c.model.HasMetal() ? ", or no -NAME_volume_average, which takes vibrations" : "");
}

} // namespace

void Warnings::Tell(MPI_Comm comm, const std::vector<std::string> &lines)
{
  for (const std::string &line : lines) {
    Warn(comm, line);
    const bool kept = std::any_of(told_.begin(), told_.end(), [&](const Told &one) { return one.line == line; });
    if (!kept) told_.push_back({kAtStart, false, line});
  }
}

void Warnings::Look(MPI_Comm comm, const Case &c, const Budgets &budgets, const QuasiStaticWatch &slow, bool ended)
{
  constexpr struct {
    std::string (*line)(const Case &, const Budgets &, const Watched &);
    bool at_end; ///< while little work is done, there is little to compare with
  } kAll[] = {{OfPenetration, false}, {OfViscosity, false}, {OfContact, true}, {OfNoise, true},   {OfSpeed, true},
              {OfWidest, false},      {OfNarrowest, true},  {OfEnergy, true},  {OfDamping, true}, {OfLoad, true},
              {OfLoss, true},         {OfTouch, true},      {OfBorder, false}, {OfMotion, true},  {OfElasticNoise, true},
              {OfMirrorImage, false}, {OfContactLoss, true}};
  const auto raise = [this](Kept which, double value) { numbers_[which] = std::max(numbers_[which], value); };
  const double energy = budgets.kinetic_energy + budgets.strain_energy;
  const double unexplained =
      energy + budgets.dissipated_energy - budgets.external_work - budgets.contact_work - budgets.friction_work;
  if (numbers_[kLooked] == 0) numbers_[kHadAtStart] = unexplained, numbers_[kGiven] = energy, numbers_[kLooked] = 1;
  raise(kGiven, std::max(std::abs(budgets.external_work), std::abs(budgets.contact_work)));
  raise(kIndenterWork, std::abs(budgets.indenter_work));
  raise(kNoise, budgets.noise_energy);
  raise(kCarried, budgets.load);
  if (c.model.indenter && c.model.indenter->by_load)
    raise(kAsked, c.model.indenter->by_load->force.LargestMagnitude(0, budgets.time));
  constexpr double kRounding = 1e-15; // of mass times the square of the speed of waves
  double stiffness = 0;
  for (const auto &material : c.model.materials)
    stiffness = std::max(stiffness, budgets.mass * std::pow(material->SpeedOfSound(), 2));
  const Watched watched = {slow,
                           unexplained - numbers_[kHadAtStart],
                           numbers_[kGiven],
                           std::abs(numbers_[kHadAtStart]),
                           numbers_[kIndenterWork],
                           numbers_[kNoise],
                           kRounding * stiffness,
                           numbers_[kAsked],
                           numbers_[kCarried]};
  for (std::size_t k = 0; k < std::size(kAll); ++k) {
    const bool told = std::any_of(told_.begin(), told_.end(), [k](const Told &one) { return one.kind == k; });
    if (told || (kAll[k].at_end && !ended)) continue;
    const std::string line = kAll[k].line(c, budgets, watched);
    if (line.empty()) continue;
    told_.push_back({k, kAll[k].at_end, line});
    Warn(comm, line);
  }
}

std::vector<std::string> Warnings::Lines() const
{
  std::vector<std::string> lines;
  for (const Told &told : told_) lines.push_back(told.line);
  return lines;
}

std::vector<std::string> Warnings::KeptLines() const
{
  std::vector<std::string> lines;
  for (const Told &told : told_)
    if (!told.at_end) lines.push_back(told.line);
  return lines;
}

std::vector<double> Warnings::State() const
{
  std::vector<double> state = numbers_;
  for (const Told &told : told_)
    if (!told.at_end) state.push_back(static_cast<double>(told.kind));
  return state;
}

void Warnings::SetState(const std::vector<double> &state, const std::vector<std::string> &lines)
{
  numbers_.assign(state.begin(), state.begin() + kNumbers);
  told_.clear();
  for (std::size_t k = 0; k < lines.size(); ++k)
    told_.push_back({static_cast<std::size_t>(state[kNumbers + k]), false, lines[k]});
}

bool Warnings::IsState(const std::vector<double> &state, const std::vector<std::string> &lines)
{
  constexpr double kMostKinds = kAtStart + 1;
  const auto is_kind = [](double kind) { return kind >= 0 && kind < kMostKinds && kind == std::floor(kind); };
  return state.size() == kNumbers + lines.size() && std::all_of(state.begin() + kNumbers, state.end(), is_kind);
}

} // namespace mlgimp
