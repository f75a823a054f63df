// The paper's Eq. 11 as printed: one pressure per material point that would pass the indenter's surface.
//
//   V^c_p = dt sum_i S_ip/m_i sum_q T_iq P_q,  T_iq = int_face S_i ds,  gap at the point's centre (its Fig. 2).
// With several points per cell the matrix is rank deficient, so 1e-2 of its diagonal is added.
#include "level/contact_methods.hpp"
#include "level/contact_system.hpp"
#include "level/loads.hpp"

namespace mlgimp
{

namespace
{

constexpr double kDiagonalShift = 1e-2;

class PointPressureContact : public Contact
{
public:
  PetscErrorCode Create(bool monitor) { return system_.Create(false, kDiagonalShift, monitor); }

  ContactPressures Pressures() const override { return system_.Pressures(); }
  void SetPressures(const ContactPressures &pressures) override { system_.SetPressures(pressures); }

  PetscErrorCode Apply(const ContactView &view, ContactReport *report) override
  {
    const std::vector<int> *surface = nullptr;
    PointArrays points;
    PetscFunctionBeginUser;
    rows_.clear();
    entries_.clear();
    *report = {};
    PetscCall(view.points.Arrays(&points));
    PetscCall(view.points.SurfacePoints(&surface));
    for (int p : *surface)
      if (!FarFromIndenter(view, points, p)) AddPoint(view, points, p, report);
    PetscCall(system_.Solve(view, rows_, entries_, 0, report));
    for (const ContactRow &row : rows_) report->local_points += static_cast<int>(system_.Pressures().count(row.key));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  void AddPoint(const ContactView &view, const PointArrays &points, int p, ContactReport *report)
  {
    const Vec3 x = points.Position(p);
    const SurfaceGap gap = view.indenter.Gap(x, view.time + view.dt);
    SurfaceSegment segments[kSides * kSegmentsPerFace];
    const int count = PointSegments(points, p, segments);
    double length = 0;
    for (int s = 0; s < count; ++s)
      if (Faces(segments[s], gap.normal)) length += segments[s].length;
    if (length == 0) return;
    report->penetration = std::max(report->penetration, -view.indenter.Gap(x, view.time).distance);
    rows_.push_back({points.id[p], 1, gap.distance, x[0], x[0] - 0.5 * length, x[0] + 0.5 * length});
    AxisStencils<2> w;
    ComputeAxisStencils<PlaneStrain, ContiguousGimp>(view.grid.IndexSpace(), 1, points.position + 2 * p, points.half_size + 2 * p,
                                                     points.F + 4 * p, w);
    const Index nearest = view.grid.Nearest(x);
    ForEach({{-1, -1, 0}, {2, 2, 1}}, [&](Index k) {
      const double S = w.w[0][k[0] + 1][0] * w.w[1][k[1] + 1][0];
      const Index node = nearest + k;
      if (S > 0) entries_.push_back({points.id[p], node[0], node[1], S * gap.normal, S * length * view.thickness * gap.normal});
    });
  }

  ContactSystem system_;
  std::vector<ContactRow> rows_;
  std::vector<ContactEntry> entries_;
};

} // namespace

PetscErrorCode CreatePointPressureContact(bool monitor, std::unique_ptr<Contact> *contact)
{
  PetscFunctionBeginUser;
  auto created = std::make_unique<PointPressureContact>();
  PetscCall(created->Create(monitor));
  *contact = std::move(created);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
