// Initial stress of a body: the stretch whose elastic law gives it.
#include "program/input/read_case.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// The normal components of a stress.
Vec3 NormalsOf(const Sym3 &s) { return {s.xx, s.yy, s.zz}; }
double LargestMagnitude(const Vec3 &v) { return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}); }

double MisesOf(const Vec3 &s)
{
  const Sym3 stress = {s[0], s[1], s[2], 0, 0, 0}, deviator = stress - Sphere(kThird * Trace(stress));
  return std::sqrt(1.5 * Contract(deviator, deviator));
}

/// What a law says of one point.
struct Answer {
  Sym3 stress;
  std::vector<double> history;
};

/// The stress at stretches exp(log_stretch) along the axes, from the stress of before with a strain of so many times that, in no
/// time: nothing creeps.
template <class G> Answer Ask(const Material &material, const Vec3 &log_stretch, const Sym3 &before, double strain)
{
  constexpr int n = G::kDim;
  constexpr double kAtOnce = 1e-30; // rounding: s
  double F[n * n] = {}, L[n * n] = {}, stress[G::kStress], plastic_work = 0;
  Row F_rows[n * n], L_rows[n * n];
  const double hoop = std::exp(log_stretch[2]), hoop_ratio = std::exp(strain * log_stretch[2]);
  Answer answer{{}, std::vector<double>(material.Traits().history)};
  for (int d = 0; d < n; ++d) {
    F[(n + 1) * d] = std::exp(log_stretch[d]);
    L[(n + 1) * d] = std::expm1(strain * log_stretch[d]) / kAtOnce;
  }
  StoreStress<G>(before, stress);
  LoadRows<n * n>(F, 1, F_rows), LoadRows<n * n>(L, 1, L_rows);
  material.InitialHistory(answer.history.data());
  material.UpdateStress({1, kAtOnce, 1, L_rows, F_rows, G::kHoop ? &hoop : nullptr, G::kHoop ? &hoop_ratio : nullptr, stress,
                         answer.history.data(), material.Traits().history},
                        &plastic_work);
  answer.stress = LoadStress<G>(stress);
  return answer;
}
Answer Ask(const Material &material, GeometryKind kind, const Vec3 &log_stretch, const Sym3 &before, double strain)
{
  return WithGeometry(kind, [&](auto geometry) { return Ask<decltype(geometry)>(material, log_stretch, before, strain); });
}

/// Stresses that a strain brings along x, y, z where what strains is bound to each other: in plane strain nothing strains along
/// z, in axisymmetry the hoop does as the radius. A column for each free direction.
struct Response {
  int free;
  Vec3 strain[3], stress[3];

  Response(const Material &material, GeometryKind kind) : free(kind == GeometryKind::kSpatial ? 3 : 2), strain(), stress()
  {
    constexpr double kSmall = 1e-7; // rounding: errors of the stiffness only cost turns
    for (int k = 0; k < free; ++k) {
      strain[k][k] = 1;
      if (kind == GeometryKind::kAxisymmetric && k == 0) strain[k][2] = 1;
      stress[k] = (1 / kSmall) * NormalsOf(Ask(material, kind, kSmall * strain[k], {}, 1).stress);
    }
  }
  /// The sum of free strains that has these stresses along the free directions, by Cramer's rule.
  Vec3 Solve(const Vec3 &wanted) const
  {
    const auto row = [&](int i) {
      return i < free ? Vec3{stress[0][i], stress[1][i], free > 2 ? stress[2][i] : 0} : Vec3{0, 0, 1};
    };
    const auto determinant = [](const Vec3 &a, const Vec3 &b, const Vec3 &c) { return Dot(a, Cross(b, c)); };
    const Vec3 columns[3] = {
        {row(0)[0], row(1)[0], row(2)[0]}, {row(0)[1], row(1)[1], row(2)[1]}, {row(0)[2], row(1)[2], row(2)[2]}};
    const Vec3 right = {wanted[0], wanted[1], free > 2 ? wanted[2] : 0};
    const double whole = determinant(columns[0], columns[1], columns[2]);
    return (determinant(right, columns[1], columns[2]) / whole) * strain[0] +
           (determinant(columns[0], right, columns[2]) / whole) * strain[1] +
           (free > 2 ? determinant(columns[0], columns[1], right) / whole : 0) * strain[2];
  }
  /// The stress along z that goes with those along x and y.
  double AlongZ(const Vec3 &wanted) const
  {
    const Vec3 e = Solve(wanted);
    return stress[0][2] * e[0] + stress[1][2] * e[1];
  }
};

/// What the user wants, with the component along z that goes with it where it is not given.
Vec3 ReadWanted(OptionReader &reader, const std::string &name, GeometryKind kind, const std::vector<double> &given)
{
  const bool is_space = kind == GeometryKind::kSpatial;
  if (is_space && given.size() < 3) reader.Refuse(name, Format("{} values", given.size()), "3 values in -geometry 3d: xx,yy,zz");
  if (kind == GeometryKind::kAxisymmetric && given.size() == 3 && given[2] != given[0])
    reader.Refuse(name, FormatVector({given[0], given[1], given[2]}, 3),
                  "with zz = xx: in axisymmetry no other hoop stress is at rest");
  return {given[0], given[1], given.size() > 2 ? given[2] : kind == GeometryKind::kAxisymmetric ? given[0] : NAN};
}

/// Refuses what the material cannot have.
void CheckAnswer(const OptionReader &reader, const std::string &name, GeometryKind kind, const Answer &answer, const Vec3 &wanted,
                 const Vec3 &left, const std::string &text)
{
  constexpr double kSame = 1e-9; // rounding: of the largest component
  const double limit = kSame * LargestMagnitude(wanted);
  const Sym3 &s = answer.stress;
  if (LargestMagnitude({s.xy, s.yz, s.xz}) > limit)
    reader.Refuse(name, text,
                  "a stress without shear in the crystal's axes: as the crystal lies, stretches along the axes that have it "
                  "shear, with {} Pa",
                  LargestMagnitude({s.xy, s.yz, s.xz}));
  if (LargestMagnitude({left[0], left[1], kind == GeometryKind::kPlaneStrain ? 0 : left[2]}) > limit ||
      !std::isfinite(s.xx + s.yy + s.zz))
    reader.Refuse(name, text, "a stress that the law of the material can have; of metals, the yield stress bounds J times it");
  if (std::abs(left[2]) > limit)
    reader.Refuse(name, text, "with zz = {} in plane strain, which goes with xx and yy in an elastic body; or leave zz out",
                  FormatNumber(s.zz));
}

} // namespace

void ReadInitialStress(OptionReader &reader, const Model &model, Body *body)
{
  constexpr int kMaxTurns = 200;  // rounding
  constexpr double kSame = 1e-15; // rounding: of the largest component
  const std::string name = Format("-{}_initial_stress", body->name);
  std::vector<double> given;
  const bool stressed =
      reader.Read({name, "xx,yy, in 3d xx,yy,zz, of a uniform stress at the start; tension is positive (default: none)", "Pa",
                   kAnyNumber, 2, 3},
                  &given);
  if (!stressed || reader.Help()) return;
  const GeometryKind kind = model.geometry.kind;
  const Material &material = *model.materials[body->material];
  Vec3 wanted = ReadWanted(reader, name, kind, given);
  const bool any_z = std::isnan(wanted[2]);
  const Response response(material, kind);
  if (any_z) wanted[2] = response.AlongZ(wanted);
  Sym3 carried = {wanted[0], wanted[1], wanted[2], 0, 0, 0};
  Vec3 log_stretch{}, left{};
  const std::string text = FormatVector({given[0], given[1], given.back()}, static_cast<int>(given.size()));
  if (MisesOf(wanted) > material.FlowStress(0))
    reader.Refuse(name, text, "within yield: von Mises' stress of it is {} Pa, and the yield stress {} Pa", MisesOf(wanted),
                  material.FlowStress(0));
  Answer answer{};
  double before = HUGE_VAL;
  for (int turn = 0; turn < kMaxTurns; ++turn) {
    answer = Ask(material, kind, log_stretch, carried, 0);
    left = wanted - NormalsOf(answer.stress);
    if (any_z) left[2] = 0;
    const double off = LargestMagnitude({left[0], left[1], kind == GeometryKind::kSpatial ? left[2] : 0});
    const bool at_end = turn + 1 == kMaxTurns || (turn > kMaxTurns / 2 && off >= before); // of what doubles can say
    if (!(off > kSame * LargestMagnitude(wanted)) || at_end) break;
    before = off;
    log_stretch = log_stretch + response.Solve(left);
  }
  CheckAnswer(reader, name, kind, answer, wanted, left, text);
  body->stress = answer.stress, body->history = answer.history;
  for (int d = 0; d < 3; ++d) body->stretch[d] = std::exp(log_stretch[d]);
}

} // namespace mlgimp
