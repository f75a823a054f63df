// The table of budgets: all numbers that a run adds up, each in one row.
//
// A new budget is a row of `Budgets` and the line that adds to it, in a level, at a border of levels or where points change
// levels. Sums over ranks, checkpoints, history.csv and summary.json go by the table.
#pragma once

#include "base/petsc.hpp"
#include "base/tensor.hpp"

#include <algorithm>
#include <vector>

namespace mlgimp
{

/// What levels, borders and ranks add up to.
enum class Adds {
  kNow,         ///< the sum of what each has now
  kTotal,       ///< the sum since the start of the run: in checkpoints
  kCount,       ///< the same, of whole numbers
  kLargest,     ///< the largest that any has now
  kLargestEver, ///< since the start of the run: in checkpoints
};

/// Where users see it.
enum class Shown {
  kNowhere,
  kColumn,       ///< history.csv; the components along a third axis come after all other columns of this kind
  kHoopColumn,   ///< the same, in axisymmetry alone
  kLaterColumn,  ///< the same, after all of these: new columns go to the end
  kSlowColumn,   ///< the same, in slow tests alone
  kTestColumn,   ///< the same, in those with a clock of the test alone
  kSpringColumn, ///< the same, where something gives way between the tip and what moves it
  kSummary,      ///< summary.json
  kTransfers,    ///< `transfers` in summary.json
};

/// A row: what it is, and its numbers.
struct Budget {
  const char *name; ///< in the output
  Adds adds;
  Shown shown;
  int components;
  Vec3 value{};
  bool IsLargest() const { return adds == Adds::kLargest || adds == Adds::kLargestEver; }
  bool IsKept() const { return adds == Adds::kTotal || adds == Adds::kCount || adds == Adds::kLargestEver; }
  void Add(int component, double x) { value[component] = IsLargest() ? std::max(value[component], x) : value[component] + x; }
};

struct ScalarBudget : Budget {
  ScalarBudget(const char *name, Adds adds, Shown shown) : Budget{name, adds, shown, 1} {}
  operator double() const { return value[0]; }
  void operator=(double x) { value[0] = x; }
  void operator+=(double x) { value[0] += x; }
  void operator-=(double x) { value[0] -= x; }
};

struct VectorBudget : Budget {
  VectorBudget(const char *name, Adds adds, Shown shown) : Budget{name, adds, shown, 3} {}
  operator const Vec3 &() const { return value; }
  double operator[](int axis) const { return value[axis]; }
  double &operator[](int axis) { return value[axis]; }
  void operator+=(const Vec3 &x) { value = value + x; }
};

/// Budgets of a part of the run on one rank, or of the whole run. SI units; forces and impulses are those on the bodies.
struct Budgets {
  // history.csv, in its order. What is one number for the whole run (time, depth, load) is set in the sums.
  ScalarBudget time{"time", Adds::kNow, Shown::kColumn}, depth{"depth", Adds::kNow, Shown::kColumn},
      load{"load", Adds::kNow, Shown::kColumn};
  ScalarBudget contact_points{"contact_points", Adds::kNow, Shown::kColumn};
  ScalarBudget contact_half_width{"contact_half_width", Adds::kLargest, Shown::kColumn};
  ScalarBudget kinetic_energy{"kinetic_energy", Adds::kNow, Shown::kColumn};
  ScalarBudget strain_energy{"strain_energy", Adds::kNow, Shown::kColumn};
  ScalarBudget dissipated_energy{"dissipated_energy", Adds::kNow, Shown::kColumn}; ///< set in the sums, see Dissipated
  ScalarBudget external_work{"external_work", Adds::kTotal, Shown::kColumn};       ///< of loads and gravity
  ScalarBudget indenter_work{"indenter_work", Adds::kTotal, Shown::kColumn};
  VectorBudget momentum{"momentum", Adds::kNow, Shown::kColumn};
  VectorBudget support_impulse{"support_impulse", Adds::kTotal, Shown::kColumn}; ///< of the domain's sides
  ScalarBudget mass{"mass", Adds::kNow, Shown::kColumn}, points{"points", Adds::kNow, Shown::kColumn};
  VectorBudget contact_impulse{"contact_impulse", Adds::kTotal, Shown::kColumn};
  VectorBudget load_impulse{"load_impulse", Adds::kTotal, Shown::kColumn};
  VectorBudget gravity_impulse{"gravity_impulse", Adds::kTotal, Shown::kColumn};
  VectorBudget damping_impulse{"damping_impulse", Adds::kTotal, Shown::kColumn};
  ScalarBudget penetration{"penetration", Adds::kLargestEver, Shown::kColumn};
  /// By `pressure`, contact_half_width to the power of the contact's axes: levels add up as areas do.
  ScalarBudget contact_width_power{"contact_width_power", Adds::kNow, Shown::kNowhere},
      contact_axes{"contact_axes", Adds::kLargest, Shown::kNowhere};
  ScalarBudget contact_cells{"contact_cells", Adds::kLargestEver, Shown::kNowhere}; ///< in contact_half_width, of its level
  ScalarBudget penetration_cells{"penetration_cells", Adds::kLargestEver, Shown::kNowhere}; ///< of the level that it was on
  ScalarBudget peak_pressure{"peak_pressure", Adds::kLargest, Shown::kColumn};
  VectorBudget stagger_impulse{"stagger_impulse", Adds::kTotal, Shown::kColumn}; ///< of coarse forces' extrapolation at borders
  /// What the points got from contact: less than indenter_work by what contact takes up, more by what closing gaps gives.
  ScalarBudget contact_work{"contact_work", Adds::kTotal, Shown::kColumn};
  /// With levels coupled by nodes, and on one level with volume averages, kinetic and strain energy that points got since the
  /// start, without stress, from anything but contact, loads, body forces, damping, splitting and merging: from the coupling,
  /// from sides, and from time steps of finite length. A level adds up the kinetic energy that points get at all; SumBudgets
  /// makes this of it.
  ScalarBudget exchange_energy{"exchange_energy", Adds::kTotal, Shown::kColumn};
  ScalarBudget transfer_energy{"transfer_energy", Adds::kTotal, Shown::kColumn}; ///< by splitting and merging of points
  ScalarBudget contact_area{"contact_area", Adds::kNow, Shown::kColumn};
  ScalarBudget hoop_impulse{"hoop_impulse_x", Adds::kTotal, Shown::kHoopColumn}; ///< of the hoop stress, along the radius

  ScalarBudget plastic_work{"plastic_work", Adds::kTotal, Shown::kLaterColumn};
  /// Of what damps short waves; set in the sums, see Viscous.
  ScalarBudget viscous_work{"viscous_work", Adds::kNow, Shown::kLaterColumn};
  ScalarBudget damping_work{"damping_work", Adds::kTotal, Shown::kLaterColumn};
  /// Kinetic energy of the points less that of the nodes they make, at the start of the last step: motion that the grid cannot
  /// see.
  ScalarBudget noise_energy{"noise_energy", Adds::kNow, Shown::kLaterColumn};
  VectorBudget tip{"tip", Adds::kNow, Shown::kLaterColumn};                       ///< of the indenter, set in the sums
  ScalarBudget friction_work{"friction_work", Adds::kTotal, Shown::kLaterColumn}; ///< heat
  ScalarBudget friction_force{"friction_force", Adds::kNow, Shown::kLaterColumn}; ///< set in the sums
  ScalarBudget contact_plastic_work{"contact_plastic_work", Adds::kTotal,
                                    Shown::kLaterColumn}; ///< likewise, part of plastic_work
  ScalarBudget contact_strain_energy{"contact_strain_energy", Adds::kNow,
                                     Shown::kLaterColumn}; ///< between the nodes; part of strain_energy
  /// Set in the sums of a slow test, see QuasiStaticWatch.
  ScalarBudget load_quasi_static{"load_quasi_static", Adds::kNow, Shown::kSlowColumn};
  ScalarBudget test_time{"test_time", Adds::kNow, Shown::kTestColumn};
  /// Set in the sums where something gives way between the tip and what moves it: the depth that an instrument measures, and what
  /// that stores.
  ScalarBudget measured_depth{"measured_depth", Adds::kNow, Shown::kSpringColumn},
      spring_energy{"spring_energy", Adds::kNow, Shown::kSpringColumn};
  ScalarBudget schedule{"schedule", Adds::kNow, Shown::kNowhere}; ///< time of the indenter's schedule

  // summary.json
  ScalarBudget points_entered{"entered", Adds::kCount, Shown::kTransfers}, points_left{"left", Adds::kCount, Shown::kTransfers};
  ScalarBudget points_split{"split", Adds::kCount, Shown::kTransfers};
  ScalarBudget points_merged{"merged", Adds::kCount, Shown::kTransfers};           ///< parents put together again
  ScalarBudget points_unsplit{"unsplit", Adds::kCount, Shown::kTransfers};         ///< as no numbers are left for children
  ScalarBudget transfer_mass_error{"mass_error", Adds::kTotal, Shown::kTransfers}; ///< absolute values
  ScalarBudget transfer_momentum_error{"momentum_error", Adds::kTotal, Shown::kTransfers};
  ScalarBudget points_adrift{"points_adrift", Adds::kTotal, Shown::kTransfers}; ///< sent less received: zero over all ranks
  ScalarBudget mass_adrift{"mass_adrift", Adds::kTotal, Shown::kTransfers};
  VectorBudget momentum_adrift{"momentum_adrift", Adds::kTotal, Shown::kTransfers};
  ScalarBudget contact_steps{"contact_steps", Adds::kCount, Shown::kSummary};
  ScalarBudget contact_set_updates{"contact_set_updates", Adds::kCount, Shown::kSummary};
  ScalarBudget contact_fallbacks{"contact_fallbacks", Adds::kCount, Shown::kSummary}; ///< 0: kept for those who read it
  ScalarBudget clamped_sizes{"clamped_half_sizes", Adds::kCount, Shown::kSummary};    ///< counted once a step
  /// Work of the stress on growth of volume that points did not take, as the mean over their cell replaced it.
  ScalarBudget averaging_work{"averaging_work", Adds::kTotal, Shown::kSummary};

  // What others are made of
  ScalarBudget points_made{"points_made", Adds::kCount, Shown::kNowhere};   ///< children less parents, by splitting
  ScalarBudget points_spent{"points_spent", Adds::kCount, Shown::kNowhere}; ///< the same by merging
  ScalarBudget short_wave_dissipation{"short_wave_dissipation", Adds::kTotal, Shown::kNowhere};
  ScalarBudget xpic_dissipation{"xpic_dissipation", Adds::kTotal, Shown::kNowhere};
  VectorBudget xpic_impulse{"xpic_impulse", Adds::kTotal, Shown::kNowhere};           ///< change of momentum by XPIC
  VectorBudget xpic_side_impulse{"xpic_side_impulse", Adds::kTotal, Shown::kNowhere}; ///< of sides on what XPIC mixes in
  ScalarBudget transfer_strain_energy{"transfer_strain_energy", Adds::kTotal, Shown::kNowhere}; ///< part of transfer_energy
  VectorBudget friction_impulse{"friction_impulse", Adds::kTotal, Shown::kNowhere}; ///< the part of tractions in contact_impulse
  ScalarBudget hoop_force{"hoop_force", Adds::kNow, Shown::kNowhere};               ///< along the radius, in the last sweep
  /// The finest level in contact, and by how many levels the coarsest one is below the number of all; set in the sums. A contact
  /// that comes to its level's border is also on the next coarser one: of a level's own, 1 if it does.
  ScalarBudget contact_level{"contact_level", Adds::kLargest, Shown::kNowhere},
      contact_coarseness{"contact_coarseness", Adds::kLargest, Shown::kNowhere};
  ScalarBudget failed{"failed", Adds::kLargest, Shown::kNowhere}; ///< 1 where the run cannot go on

  Budget *begin() { return reinterpret_cast<Budget *>(this); }
  Budget *end() { return begin() + sizeof(Budgets) / sizeof(Budget); }
  const Budget *begin() const { return reinterpret_cast<const Budget *>(this); }
  const Budget *end() const { return begin() + sizeof(Budgets) / sizeof(Budget); }

  double Viscous() const { return short_wave_dissipation + xpic_dissipation + averaging_work; }
  /// What contact has given to bodies: work on points, and between the nodes.
  double GivenByContact() const { return contact_work + contact_strain_energy + contact_plastic_work; }
  double Dissipated() const { return Viscous() + plastic_work + damping_work + friction_work; }
  /// Adds another part's.
  void Add(const Budgets &part);
  /// Appends what the next run needs to go on.
  void AppendKept(std::vector<double> *numbers) const;
  /// Adds what AppendKept has appended, and returns the place after it; null where a count is none.
  const double *AddKept(const double *numbers);
};

static_assert(sizeof(ScalarBudget) == sizeof(Budget) && sizeof(VectorBudget) == sizeof(Budget) &&
              sizeof(Budgets) % sizeof(Budget) == 0); // rows one after the other

/// Makes each of some rows that of all ranks together, on every rank; all ranks must have as many. Collective: two reductions,
/// however many rows.
PetscErrorCode AddRanks(MPI_Comm comm, std::vector<Budgets> *rows);

} // namespace mlgimp
