// The warnings of a run, one function each: each returns its line, or an empty string where its condition does not hold.
#include "program/advice/warning_lines.hpp"

#include "program/system/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mlgimp
{

namespace
{

/// Share of the energy that bodies were given from which on a loss that no work explains is a fault.
constexpr double kUnexplained = 0.15;

/// Energies below so many times the rounding of bodies at rest are none.
constexpr double kRoundings = 1e6; // rounding

/// A viscosity that is too strong for the step gives energy in place of taking it, and the run comes to a wrong end.
std::string ViscosityWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxGain = 0.01; // of what bodies have taken; energy of strain is below zero by rounding where there is none
  const double energy = budgets.kinetic_energy + std::abs(budgets.strain_energy) + budgets.plastic_work;
  if (budgets.short_wave_dissipation >= -kMaxGain * std::max(energy, watched.given)) return "";
  return Format("-short_wave_viscosity {},{}: has given {} J{} where it should take energy: the results are wrong from here; try "
                "a smaller second number or a smaller -cfl",
                FormatNumber(c.model.short_wave.a), FormatNumber(c.model.short_wave.b), -budgets.short_wave_dissipation,
                When(budgets));
}

/// The largest work, or what the bodies brought: what contact gives or takes by mistake is a share of it, J.
double EnergyToCompare(const Budgets &budgets, const Watched &watched)
{
  return std::max({watched.indenter_work, std::abs(watched.had_at_start), std::abs(budgets.external_work), watched.floor});
}

/// Contact gives more than the indenter where points make noise of it, and under a tip that tears the surface of a metal open: it
/// comes down with little load or none, and blows where it meets points again.
std::string ContactWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxExcess =
      0.1; // of the largest work, or what the bodies brought; steep cones on a few cells are seen to give 0.05
  if (!c.model.indenter || c.model.contact.method == "none") return "";
  const double given = budgets.GivenByContact() + budgets.friction_work - budgets.indenter_work;
  const double work = EnergyToCompare(budgets, watched);
  if (given <= kMaxExcess * work) return "";
  return Format("-indenter: contact has given the bodies {} J more work than the indenter has done, {} % of their energy,{}: "
                "contact covers few cells so far, or {}",
                given, 100 * given / work, When(budgets),
                c.model.Flows() ? "has torn the surface open, and the load is wrong; try smaller cells or a blunter tip"
                                : "its work becomes noise of the points, and the load is wrong; try smaller cells, "
                                  "-xpic_fraction 0.02 or a smaller -cfl");
}

/// Contact takes a little where surface meets the indenter, in blows. Where it lets go of a surface under tension that sticks,
/// and catches it again, it takes much.
std::string ContactLossWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxLoss = 0.15; // of the largest work, or what the bodies brought; runs that touch well are seen to take 0.1
  constexpr int kFirstSteps = 100;  // of contact, before which it is all first touch
  if (!c.model.indenter || budgets.contact_steps < kFirstSteps) return "";
  const double taken = budgets.indenter_work - budgets.GivenByContact() - budgets.friction_work;
  const double work = EnergyToCompare(budgets, watched);
  if (taken <= kMaxLoss * work) return "";
  return Format("-indenter: contact has taken {} J, {} % of the bodies' energy,{}: the surface has struck the tip, or has parted "
                "from it and come back, and the load is wrong; try smaller cells, a slower indenter{}",
                taken, 100 * taken / work, When(budgets),
                std::isinf(c.model.contact.friction) ? " or a finite -indenter_friction" : "");
}

/// Velocities of points that vary within a cell do not reach the grid and soften plastic flow: in metals their energy must stay
/// small beside the work.
std::string NoiseWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxNoise = 0.005;
  if (!c.model.Flows() || !c.model.indenter || c.model.contact.method == "none") return "";
  if (budgets.plastic_work <= 0 || watched.noise <= kMaxNoise * watched.indenter_work) return "";
  return Format("-xpic_fraction {}: noise of the points' velocities holds {} % of the indenter's work{}, which softens plastic "
                "flow: try a larger fraction or a slower indenter",
                FormatNumber(c.model.nodal.xpic_fraction), 100 * watched.noise / watched.indenter_work, When(budgets));
}

/// Steps that are too long make energy without limit. What contact gives is no part of it; in the middle of a blow a tenth is
/// seen, and more in the first steps of a touch, as velocities are half a step behind stresses.
std::string EnergyWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxGain = 0.25; // of what they were given
  if (watched.made <= kMaxGain * std::max(watched.given, kRoundings * watched.floor)) return "";
  const std::string option = c.time.time_step > 0 ? Format("-time_step {}", FormatNumber(c.time.time_step))
                                                  : Format("-cfl {}", FormatNumber(c.time.cfl));
  return Format(
      "{}: the bodies have made {} J{}, where they had or got {} J: steps are too long, and the results wrong; try a smaller one",
      option, watched.made, When(budgets), watched.given);
}

/// The same of bodies that fly, at the end: those that turn pass through the cells, and their motion becomes what nodes do not
/// see. Not where energy is made or lost, which has another cause.
std::string MotionWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxNoise = 0.05;
  if (c.model.indenter || std::abs(watched.made) > kMaxNoise * watched.given) return "";
  if (budgets.noise_energy <= kMaxNoise * std::max(watched.given, kRoundings * watched.floor)) return "";
  return Format("-bodies: noise of the points' velocities holds {} J{}, where the bodies had or got {} J: bodies that turn, or "
                "collide, have too few cells for it, and lose their motion; try smaller cells",
                budgets.noise_energy, When(budgets), watched.given);
}

/// The same of elastic bodies, at the end: a surface that a tip slides along with friction feeds it, the more the smaller steps
/// are, and bodies that are bent far have it at their surfaces.
std::string ElasticNoiseWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxNoise = 0.01,
                   kMinOfMotion = 0.3; // of the strain energy; of the kinetic energy, which is more in fast tests
  if (c.model.Flows() || budgets.noise_energy <= kMaxNoise * budgets.strain_energy) return "";
  if (budgets.noise_energy <= kMinOfMotion * budgets.kinetic_energy || !MotionWarning(c, budgets, watched).empty()) return "";
  if (!EnergyWarning(c, budgets, watched).empty()) return "";
  if (budgets.contact_points == 0 && std::abs(watched.made) > kUnexplained * watched.given) return ""; // see LossWarning
  return Format("-xpic_fraction {}: noise of the points' velocities holds {} % of the strain energy{}: stresses and pressures "
                "are uneven; try {}{}; smaller steps alone make it worse",
                FormatNumber(c.model.nodal.xpic_fraction), 100 * budgets.noise_energy / budgets.strain_energy, When(budgets),
                c.model.nodal.xpic_fraction < 0.02 ? "0.02" : "a larger fraction",
                c.model.indenter ? ", or a slower indenter" : "");
}

/// Inertia and damping add too much to a slow test.
std::string SpeedWarning(const Case &c, const Budgets &, const Watched &watched)
{
  constexpr double kMaxKinetic = 0.01, kMaxAdded = 2; // of energy; of the tolerance
  const double share = watched.slow.SoFar().load_share, kinetic = watched.slow.SoFar().kinetic_share;
  if (share <= kMaxAdded * c.quasi_static.tolerance && kinetic <= std::max(kMaxKinetic, c.quasi_static.tolerance)) return "";
  return Format("-quasi_static_tolerance {}: inertia and damping have added up to {} % to the load, and kinetic energy was up to "
                "{} % of the body's energy: try a smaller tolerance, or less -damping where that was given",
                FormatNumber(c.quasi_static.tolerance), 100 * share, 100 * kinetic);
}

/// Whether an indenter presses in a test whose speed the user has chosen.
bool HasFastIndenter(const Case &c) { return c.model.indenter && c.model.contact.method != "none" && !c.quasi_static.on; }

/// Damping that is strong beside the indenter's motion carries a part of the load. For metals see DragWarning.
std::string DampingWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxDamping = 0.2;
  if (!HasFastIndenter(c) || c.model.Flows()) return "";
  if (budgets.damping_work <= kMaxDamping * std::max(watched.given, watched.floor)) return "";
  return Format("-damping {}: has taken {} J{}, where the bodies had or got {} J, and carries a part of the load: try less, or a "
                "slower indenter",
                FormatNumber(c.model.nodal.damping), budgets.damping_work, When(budgets), watched.given);
}

constexpr double kMaxOfMotion = 0.01; // of the load or the plastic work: a metal does not forget what drag and inertia did

/// The same in metals, from a smaller share on.
std::string DragWarning(const Case &c, const Budgets &, const Watched &watched)
{
  const double share = watched.motion.DragOfLoad();
  if (!HasFastIndenter(c) || !c.model.Flows() || share < kMaxOfMotion) return "";
  return Format("-damping {}: its drag adds some {} % to the load at the largest depth: try less, or a slower indenter "
                "(-quasi_static chooses both)",
                FormatNumber(c.model.nodal.damping), 100 * share);
}

/// Inertia of a metal adds to the load, because the indenter is fast.
std::string InertiaWarning(const Case &c, const Budgets &, const Watched &watched)
{
  const double share = watched.motion.InertiaOfLoad();
  if (!HasFastIndenter(c) || !c.model.Flows() || share < kMaxOfMotion) return "";
  return Format(
      "{}: inertia carries some {} % of the load at the largest depth: try a slower indenter (-quasi_static chooses its speed)",
      c.model.indenter->by_load ? "-indenter_loads" : "-indenter_velocities", 100 * share);
}

/// Pressures that are there before a metal has come to rest under them: it flows on by its motion, and does not come back.
std::string OvershootWarning(const Case &c, const Budgets &, const Watched &watched)
{
  const double share = watched.motion.ShareOfPlasticWork();
  if (c.model.loads.empty() || c.model.indenter || !c.model.Flows() || share < kMaxOfMotion) return "";
  return Format("-{}_pressures: the bodies' motion adds some {} % to the plastic work, as they still move when pressures are at "
                "their largest: let these rise over a longer time, or give -damping",
                c.load_names[0], 100 * share);
}

/// The load, or the depth under load control, still changes at the end of a hold.
std::string HoldWarning(const Case &c, const Budgets &, const Watched &watched)
{
  const double drift = watched.slow.SoFar().hold_drift;
  if (!c.quasi_static.on || drift <= c.quasi_static.tolerance) return "";
  return Format("-quasi_static_tolerance {}: the {} changes by {} % in the last transit of a hold, because waves still run; try "
                "a smaller tolerance",
                FormatNumber(c.quasi_static.tolerance), c.quasi_static.depth > 0 ? "load" : "depth", 100 * drift);
}

/// Bodies whose points part or crumple, whose waves few cells see, or whose turning XPIC takes for noise, lose energy that no
/// work has.
std::string LossWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  if (-watched.made <= kUnexplained * std::max(watched.given, kRoundings * watched.floor)) return "";
  if (!ElasticNoiseWarning(c, budgets, watched).empty()) return ""; // which has taken it
  return Format(
      "-bodies: energy balance: {} J are missing{}, where they had or got {} J: cells are too few for how they turn and for "
      "their waves, or points have parted or crumpled; look at the last frames, and try smaller cells or steps{}{}",
      -watched.made, When(budgets), watched.given, c.model.nodal.xpic_fraction > 0 ? ", or a smaller -xpic_fraction" : "",
      c.model.VolumeAverages() > 0 && !c.model.Flows() ? ", or no -NAME_volume_average, which takes vibrations" : "");
}

/// All warnings of a run. Each is printed once; those at the end have too little work to compare with before. Checkpoints know
/// them by their places here, so new ones come last.
enum Due { kEachRow, kAtEnd };
constexpr struct {
  std::string (*line)(const Case &, const Budgets &, const Watched &);
  Due due;
} kRunWarnings[] = {{PenetrationWarning, kEachRow},    // -cell_size: the surface lies more than a cell inside the indenter
                    {ViscosityWarning, kEachRow},      // -short_wave_viscosity: it gives energy
                    {ContactWarning, kAtEnd},          // -indenter: contact gives more work than the indenter
                    {NoiseWarning, kAtEnd},            // -xpic_fraction: noise of the points softens a metal
                    {SpeedWarning, kAtEnd},            // -quasi_static_tolerance: a slow test is too fast
                    {WidestContactWarning, kEachRow},  // -levels: contact gets too wide for levels that follow it
                    {NarrowestContactWarning, kAtEnd}, // -levels, -cell_size: few cells in the contact
                    {EnergyWarning, kAtEnd},           // -cfl, -time_step: the bodies make energy
                    {DampingWarning, kAtEnd},          // -damping: it carries a part of the load, elastic
                    {LoadWarning, kAtEnd},             // -indenter_loads: the tip does not come to carry them
                    {LossWarning, kAtEnd},             // -bodies: energy is missing
                    {TouchWarning, kAtEnd},            // -indenter_tip: it has touched nothing
                    {BorderWarning, kEachRow},         // -level_K_lower, _upper: contact crosses a border of levels
                    {MotionWarning, kAtEnd},           // -bodies: motion of free bodies becomes noise
                    {ElasticNoiseWarning, kAtEnd},     // -xpic_fraction: noise in elastic bodies
                    {MirrorWarning, kEachRow},         // -indenter_tip: contact meets its mirror image
                    {ContactLossWarning, kAtEnd},      // -indenter: contact takes work
                    {DragWarning, kAtEnd},             // -damping: it adds to the load of a metal
                    {InertiaWarning, kAtEnd},          // -indenter_velocities, _loads: inertia adds to the load of a metal
                    {OvershootWarning, kAtEnd},        // -LOAD_pressures: motion adds to the plastic work
                    {HoldWarning, kAtEnd}};            // -quasi_static_tolerance: the load still changes at the end of a hold

} // namespace

void Warnings::Issue(MPI_Comm comm, const std::vector<std::string> &lines)
{
  for (const std::string &line : lines) {
    Warn(comm, line);
    const bool kept = std::any_of(issued_.begin(), issued_.end(), [&](const Issued &one) { return one.line == line; });
    if (!kept) issued_.push_back({kAtStart, false, line});
  }
}

/// Takes up a row of the history; returns the bodies' energy less all works, J.
double Warnings::Record(const Case &c, const Budgets &budgets)
{
  const auto raise = [](double *largest, double value) { *largest = std::max(*largest, value); };
  const double energy = budgets.kinetic_energy + budgets.strain_energy;
  const double unexplained =
      energy + budgets.dissipated_energy - budgets.external_work - budgets.GivenByContact() - budgets.friction_work;
  if (state_.begun == 0) state_.had_at_start = unexplained, state_.given = energy, state_.begun = 1;
  raise(&state_.given, std::max(std::abs(budgets.external_work), std::abs(budgets.contact_work)));
  raise(&state_.indenter_work, std::abs(budgets.indenter_work));
  raise(&state_.noise, budgets.noise_energy);
  raise(&state_.carried, budgets.load);
  if (c.model.indenter && c.model.indenter->by_load)
    raise(&state_.asked, c.model.indenter->by_load->LargestMagnitude(0, budgets.schedule));
  double pressure = 0;
  for (const Load &load : c.model.loads) pressure += std::abs(load.pressure.Value(budgets.time));
  motion_.Record(budgets, pressure);
  return unexplained;
}

void Warnings::Check(MPI_Comm comm, const Case &c, const Budgets &budgets, const QuasiStaticWatch &slow, bool ended)
{
  const double unexplained = Record(c, budgets);
  constexpr double kRounding = 1e-15; // rounding: of mass times the square of the speed of waves
  double stiffness = 0;
  for (const auto &material : c.model.materials)
    stiffness = std::max(stiffness, budgets.mass * std::pow(material->SpeedOfSound(), 2));
  const Watched watched = {state_, slow, motion_, unexplained - state_.had_at_start, kRounding * stiffness};
  for (std::size_t k = 0; k < std::size(kRunWarnings); ++k) {
    const bool issued = std::any_of(issued_.begin(), issued_.end(), [k](const Issued &one) { return one.kind == k; });
    if (issued || (kRunWarnings[k].due == kAtEnd && !ended)) continue;
    const std::string line = kRunWarnings[k].line(c, budgets, watched);
    if (line.empty()) continue;
    issued_.push_back({k, kRunWarnings[k].due == kAtEnd, line});
    Warn(comm, line);
  }
}

std::vector<std::string> Warnings::Lines() const
{
  std::vector<std::string> lines;
  for (const Issued &one : issued_) lines.push_back(one.line);
  return lines;
}

std::vector<std::string> Warnings::KeptLines() const
{
  std::vector<std::string> lines;
  for (const Issued &one : issued_)
    if (!one.at_end) lines.push_back(one.line);
  return lines;
}

std::vector<double> Warnings::State() const
{
  std::vector<double> state = ToNumbers(state_);
  const std::vector<double> motion = ToNumbers(motion_.Now());
  state.insert(state.end(), motion.begin(), motion.end());
  for (const Issued &one : issued_)
    if (!one.at_end) state.push_back(static_cast<double>(one.kind));
  return state;
}

static constexpr std::size_t kOwn = kNumbersOf<WarningState>, kFirstKind = kOwn + kNumbersOf<MotionWatch::State>;

void Warnings::SetState(const std::vector<double> &state, const std::vector<std::string> &lines)
{
  state_ = FromNumbers<WarningState>(state.data());
  motion_.SetState(FromNumbers<MotionWatch::State>(&state[kOwn]));
  issued_.clear();
  for (std::size_t k = 0; k < lines.size(); ++k)
    issued_.push_back({static_cast<std::size_t>(state[kFirstKind + k]), false, lines[k]});
}

bool Warnings::IsState(const std::vector<double> &state, const std::vector<std::string> &lines)
{
  constexpr double kMaxKinds = kAtStart + 1; // size
  const auto is_kind = [](double kind) { return kind >= 0 && kind < kMaxKinds && kind == std::floor(kind); };
  return state.size() == kFirstKind + lines.size() && std::all_of(state.begin() + kFirstKind, state.end(), is_kind);
}

} // namespace mlgimp
