// Contact of a level's points with the rigid indenter: three methods behind one interface.
#pragma once

#include "contact/group.hpp"
#include "contact/settings.hpp"
#include "grid/nodes.hpp"
#include "physics/body_table.hpp"
#include "physics/indenter.hpp"
#include "points/points.hpp"
#include "surface/pieces.hpp"
#include "surface/surface_motion.hpp"

#include <cstdint>
#include <map>
#include <memory>

namespace mlgimp
{

class NodeMotion;

/// A step from `time` to `time + dt`, s, and the way of the indenter's tip in it.
struct ContactStep {
  double time, dt;
  TipStep tip{};
};

/// What contact did in a step. Impulses, work and counts are this rank's part; the shape of the contact is known alike on all
/// ranks of the group.
struct ContactReport {
  Vec3 impulse{};                        ///< on the body, N s
  Vec3 side_impulse{};                   ///< what sides take up of it at once, N s
  Vec3 friction_impulse{};               ///< the part of the impulse that tractions give, N s
  double friction_work = 0;              ///< heat that slipping makes, -sum tau . s, J
  std::vector<NodeChange> contact_nodes; ///< owned nodes that contact has moved
  double penetration = 0;                ///< deepest place of the surface inside the indenter at `time`, m
  int local_points = 0;                  ///< points under pressure; of `pressure` faces that points had at the start
  int set_updates = 0;                   ///< turns of the active set; on the group's first rank alone
  bool solved = true;                    ///< false: the linear solver did not converge
  double travel = 0;                     ///< of a tip that is free, downward; the same on all ranks, m
  bool limited = false;                  ///< the tip would have gone farther, so that the load is not the one set
  double half_width = 0;                 ///< of the contact, in space sqrt(area/pi), m
  double reach = 0;                      ///< of `pressure`: from the tip to the farthest loaded column along a horizontal axis, m
  bool crosses_border = false;           ///< of `pressure`: a loaded column is at the border to the coarser level, or beyond it
  double clearance = 0; ///< of `pressure`, where nothing touches: what the surface and the indenter may still move toward
                        ///< each other until something can; the same on all ranks, m
  bool may_reach_coarser_level = true; ///< nodes of the coarser level may have been pushed; the same on all ranks
  double area = 0;          ///< of the contact, projected on the plane normal to the indenter's axis; of `pressure` only, m2
  double peak_pressure = 0; ///< largest pressure found, Pa
  std::vector<PressedColumn> columns; ///< of `pressure`, where the share is not 0; the same on all ranks of the group
  double stored = 0; ///< energy of what lies between the nodes, of `pressure`; on the group's first rank alone, J
};

/// Pressures that were found, and tractions beside them, by the key of their unknown.
using ContactPressures = std::map<std::int64_t, double>;

/// What points under a column of the grid have flowed in a step. Doubles throughout but for the key.
struct ColumnStrain {
  std::int64_t key;
  double strain, weight; ///< sums of the equivalent plastic strain times mass, and of mass, kg
};

class Contact
{
public:
  /// group: the ranks that meet in the calls below, which must stay.
  explicit Contact(const ContactGroup &group) : group_(group) {}
  virtual ~Contact() = default;
  /// Reads the options of its solver under the prefix -contact_.
  virtual PetscErrorCode Create(const ContactSettings &) { return PETSC_SUCCESS; }
  /// What a step leaves to the next, the same on every rank of the group.
  virtual ContactPressures Pressures() const { return {}; }
  virtual void SetPressures(const ContactPressures &) {}
  /// Corrects the velocities (v, dv) of owned nodes. Collective on the group.
  virtual PetscErrorCode Apply(const SurfaceInputs &surface, const NodeMotion &nodes, const ContactStep &step,
                               ContactReport *report) = 0;
  /// Lets the surface between the nodes flow by what the points under it have flowed since the last Apply, of which each rank
  /// knows a part. work: that pressures do on it, on the first rank alone, J. Collective on the group.
  virtual PetscErrorCode Flow(std::vector<ColumnStrain>, Surface *, double * /*work*/) { return PETSC_SUCCESS; }
  /// Pressure of the last Apply on this rank's points where they are now, the mean over the part of their outer faces that is
  /// turned at the indenter with its tip there; 0 elsewhere, [points] Pa. Empty where a method has no pressures.
  virtual PetscErrorCode PressuresOnPoints(const SurfaceInputs &, Vec3 /*tip*/, std::vector<double> *pressures)
  {
    pressures->clear();
    return PETSC_SUCCESS;
  }
  /// The same of this rank's patches, [patches] Pa.
  virtual PetscErrorCode PressuresOnPatches(const SurfaceInputs &, Vec3 /*tip*/, std::vector<double> *pressures)
  {
    pressures->clear();
    return PETSC_SUCCESS;
  }

protected:
  const ContactGroup &group_;
};

/// A pressure on each segment of the surface (docs/contact.md): the default.
std::unique_ptr<Contact> MakePressureContact(const ContactGroup &group);
/// One pressure per material point, gap at its centre: the paper's Eq. 11 as printed, for comparison.
std::unique_ptr<Contact> MakePointPressureContact(const ContactGroup &group);
/// Hu & Chen's (2003) multi-mesh contact at nodes that body and indenter share, for comparison.
std::unique_ptr<Contact> MakeMultimeshContact(const ContactGroup &group);

/// The method that the settings name.
PetscErrorCode CreateContact(const ContactSettings &settings, const ContactGroup &group, std::unique_ptr<Contact> *contact);

/// Distance of a point's centre from the indenter, in cells, beyond which nothing presses on it: with pressures of segments
/// that of those that may be candidates; the other methods read nodes and points.
inline double TouchRange(const ContactSettings &settings)
{
  return settings.method == "pressure" ? kCandidateGap + kPointRange - kContactRange : kPointRange;
}
} // namespace mlgimp
