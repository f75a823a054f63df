// The paper's Eq. 11 as printed: one pressure per material point that would pass the indenter's surface.
//
//   V^c_p = dt sum_i S_ip/m_i sum_q T_iq P_q,  T_iq = int_face S_i ds,  gap at the point's centre (its Fig. 2).
// With several points per cell the matrix is rank deficient, so 1e-2 of its diagonal is added.
#include "level/contact/methods.hpp"

#include "base/exchange.hpp"
#include "level/contact/system.hpp"
#include "level/contact/width.hpp"

#include <algorithm>

namespace mlgimp
{

namespace
{

constexpr double kDiagonalShift = 1e-2;

/// An unknown and what it covers.
struct PressedPoint {
  ContactUnknown unknown;
  SurfaceRange range;
};

class PointPressureContact : public Contact
{
public:
  PetscErrorCode Create(const ContactSettings &settings) override { return system_.Create(false, kDiagonalShift, settings); }

  ContactPressures Pressures() const override { return system_.Pressures(); }
  void SetPressures(const ContactPressures &pressures) override { system_.SetPressures(pressures); }

  PetscErrorCode Apply(const ContactView &view, ContactReport *report) override
  {
    std::vector<PressedPoint> pressed;
    std::vector<ContactUnknown> unknowns;
    std::vector<SurfaceRange> ranges;
    PetscFunctionBeginUser;
    couplings_.clear();
    *report = {};
    const PointArrays points = view.points.Arrays();
    const std::vector<int> &surface = view.points.SurfacePoints();
    for (int p : surface)
      if (!FarFromIndenter(view, points, p)) AddPoint(view, points, p, &pressed, report);
    std::vector<std::int64_t> own;
    for (const PressedPoint &point : pressed) own.push_back(point.unknown.key);
    PetscCall(GatherByKey(view.group.Comm(), &pressed));
    for (const PressedPoint &point : pressed) unknowns.push_back(point.unknown), ranges.push_back(point.range);
    for (ContactCoupling &c : couplings_) c.unknown = Find(unknowns, own[c.unknown]);
    PetscCall(system_.Solve(view, unknowns, couplings_, kAnyToAny, report));
    for (std::int64_t key : own) report->local_points += static_cast<int>(system_.Pressures().count(key));
    for (double pressure : system_.Lambda()) report->peak_pressure = std::max(report->peak_pressure, pressure);
    const double rounding = 1e-6 * view.grid.Geometry().spacing;
    report->half_width = HalfWidth(ranges, system_.Lambda(), false, view.tip.start[0], rounding);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode PressuresOnPoints(const ContactView &view, std::vector<double> *pressures) override
  {
    PetscFunctionBeginUser;
    const PointArrays points = view.points.Arrays();
    pressures->assign(points.count, 0.0);
    for (int p : view.points.SurfacePoints())
      if (const auto found = system_.Pressures().find(points.id[p]); found != system_.Pressures().end())
        (*pressures)[p] = found->second;
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  /// Couplings get the place of the point among `pressed` for the unknown.
  void AddPoint(const ContactView &view, const PointArrays &points, int p, std::vector<PressedPoint> *pressed,
                ContactReport *report)
  {
    const Vec3 x = points.Position(p);
    const SurfaceGap gap = view.indenter.Gap(x, view.tip.end);
    double length = 0, area = 0;
    ForEachSegment(points, p, view.geometry, 0, [&](const SurfaceSegment &segment) {
      if (Faces(segment, gap.normal)) length += 2 * segment.half_width, area += segment.area;
    });
    if (length == 0) return;
    report->penetration = std::max(report->penetration, -view.indenter.Gap(x, view.tip.start).distance);
    const int unknown = static_cast<int>(pressed->size());
    pressed->push_back({{points.id[p], gap.distance}, {x[0], x[0] - 0.5 * length, x[0] + 0.5 * length}});
    AxisStencils<2> w;
    ComputeAxisStencils<PlaneStrain, ContiguousGimp>(
        view.grid.IndexSpace(), 1, Extents<2>(1, points.position + 2 * p, points.half_size + 2 * p, points.F + 4 * p), w);
    const Index nearest = view.grid.Nearest(x);
    ForEach({{-1, -1, 0}, {2, 2, 1}}, [&](Index k) {
      const double S = w.w[0][k[0] + 1][0] * w.w[1][k[1] + 1][0];
      if (S > 0) couplings_.push_back({nearest + k, unknown, S * gap.normal, S * area * gap.normal});
    });
  }

  /// The points of all ranks, by their keys. Collective.
  static PetscErrorCode GatherByKey(MPI_Comm comm, std::vector<PressedPoint> *pressed)
  {
    std::vector<PressedPoint> all;
    PetscFunctionBeginUser;
    PetscCall(GatherRecords(comm, *pressed, &all));
    std::sort(all.begin(), all.end(), [](const PressedPoint &a, const PressedPoint &b) { return a.unknown.key < b.unknown.key; });
    *pressed = std::move(all);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  static int Find(const std::vector<ContactUnknown> &unknowns, std::int64_t key)
  {
    const auto before = [](const ContactUnknown &unknown, std::int64_t k) { return unknown.key < k; };
    return static_cast<int>(std::lower_bound(unknowns.begin(), unknowns.end(), key, before) - unknowns.begin());
  }

  ContactSystem system_;
  std::vector<ContactCoupling> couplings_;
};

} // namespace

std::unique_ptr<Contact> MakePointPressureContact() { return std::make_unique<PointPressureContact>(); }

} // namespace mlgimp
