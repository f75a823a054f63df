// Contact of a level's points with the rigid indenter: three methods behind one interface.
#pragma once

#include "level/nodes.hpp"
#include "level/points.hpp"
#include "pointwise/indenter.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace mlgimp
{

/// What contact needs to see of a level in a step from `time` to `time + dt`, after sides were applied.
struct ContactView {
  const Grid &grid;
  Points &points;
  const BoundaryConditions &sides;
  const Indenter &indenter;
  double thickness;   ///< m
  double mass_cutoff; ///< kg
  double time, dt;    ///< s
};

/// What contact did in a step, the same on every rank but for the count of points.
struct ContactReport {
  Vec3 impulse{};           ///< on the body, N s
  Vec3 side_impulse{};      ///< its part that sides take up at once, N s
  int local_points = 0;     ///< points of this rank under pressure
  double work = 0;          ///< of the contact forces on this rank's owned nodes, with their mean velocity of the step, J
  double half_width = 0;    ///< of the contact, m
  double peak_pressure = 0; ///< largest pressure found, Pa
  double penetration = 0;   ///< deepest place of the surface inside the indenter at `time`, m
  int set_updates = 0;      ///< of the active set
  bool fallback = false;    ///< the active set did not settle: row-sum diagonal used
  bool solved = true;       ///< false: the linear solver did not converge
};

/// Pressures that were found, by the number of their unknown.
using ContactPressures = std::map<std::int64_t, double>;

class Contact
{
public:
  virtual ~Contact() = default;
  /// What a step leaves to the next, the same on every rank of the level.
  virtual ContactPressures Pressures() const { return {}; }
  virtual void SetPressures(const ContactPressures &) {}
  /// Corrects the nodal velocities (v, dv), which must be known on ghosts too, on owned and ghost nodes. Collective.
  virtual PetscErrorCode Apply(const ContactView &view, ContactReport *report) = 0;
};

/// Names that -contact accepts besides none: pressure, point_pressure, multimesh.
std::vector<std::string> ContactMethods();
/// Reads the options of the solver under the prefix -contact_.
PetscErrorCode CreateContact(const std::string &method, bool monitor, std::unique_ptr<Contact> *contact);

/// Adds the change that contact makes to the velocity (v, dv) of a node, and adds up its work where the rank owns the node.
void ChangeVelocity(const ContactView &view, Index node, Vec3 by, ContactReport *report);

/// A piece of a deformed face, its place, outward normal and length.
struct SurfaceSegment {
  Vec3 x, normal;
  double length;
};

inline constexpr int kSegmentsPerFace = 4;
/// Nearness to the indenter, in cells, from which on surface segments take part in the contact problem.
inline constexpr double kContactRange = 2.5;

/// Distance of a point's centre from the indenter, in cells, beyond which its faces take no part.
inline constexpr double kPointRange = kContactRange + 1.5;

/// The segments of all outer faces of a point; returns their number.
int PointSegments(const PointArrays &points, int p, SurfaceSegment segments[kSides * kSegmentsPerFace]);

/// Cosine of the angle between the indenter's normal and that into the body, from which on the indenter presses on a face.
inline constexpr double kLeastFacing = 0.1;

/// True where a segment faces the indenter, so that it can be pressed by it.
inline bool Faces(const SurfaceSegment &segment, Vec3 indenter_normal)
{
  return Dot(segment.normal, indenter_normal) < -kLeastFacing;
}

/// True where a point is far enough from the indenter to be left out without looking at its faces.
bool FarFromIndenter(const ContactView &view, const PointArrays &points, int p);

} // namespace mlgimp
