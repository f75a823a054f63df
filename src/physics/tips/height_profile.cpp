// Tips by a table of heights.
#include "physics/tips/height_profile.hpp"

#include "physics/tips/profile.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mlgimp
{

HeightProfile::HeightProfile(double reach, const std::function<HeightAndSlope(double)> &curve) : reach_(reach)
{
  for (std::size_t k = 0; k <= static_cast<std::size_t>(kPieces); ++k) nodes_.push_back(curve(Place(k)));
}

HeightAndSlope HeightProfile::At(double s) const
{
  if (s >= reach_) return {nodes_.back().height + nodes_.back().slope * (s - reach_), nodes_.back().slope};
  const std::size_t k = static_cast<std::size_t>(kPieces * std::sqrt(s / reach_));
  const double length = Place(k + 1) - Place(k), t = std::clamp((s - Place(k)) / length, 0.0, 1.0), u = 1 - t;
  const HeightAndSlope &a = nodes_[k], &b = nodes_[k + 1];
  const double mean = (b.height - a.height) / length;
  return {u * u * (1 + 2 * t) * a.height + t * t * (1 + 2 * u) * b.height + t * u * length * (u * a.slope - t * b.slope),
          6 * t * u * mean + u * (1 - 3 * t) * a.slope + t * (1 - 3 * u) * b.slope};
}

double HeightProfile::Reach(double height) const
{
  if (height >= nodes_.back().height) return reach_ + (height - nodes_.back().height) / nodes_.back().slope;
  const auto above = std::upper_bound(nodes_.begin(), nodes_.end(), height,
                                      [](double value, const HeightAndSlope &node) { return value < node.height; });
  const std::size_t k = std::max<std::ptrdiff_t>(above - nodes_.begin(), 1);
  double low = Place(k - 1), high = Place(k);
  for (int halved = 0; halved < 60; ++halved) { // rounding
    const double middle = (low + high) / 2;
    (At(middle).height <= height ? low : high) = middle;
  }
  return low;
}

double HeightProfile::Farthest(double outward, double up) const
{
  std::size_t farthest = 0;
  double most = 0;
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    if (const double along = outward * Place(k) + up * nodes_[k].height; along > most) most = along, farthest = k;
  return farthest + 1 == nodes_.size() ? HUGE_VAL : Place(farthest);
}

HeightProfile ProfileThrough(const std::vector<double> &x, const std::vector<double> &z)
{
  const std::size_t n = x.size();
  const auto mean = [&](std::size_t k) { return (z[k + 1] - z[k]) / (x[k + 1] - x[k]); };
  std::vector<double> slopes(n, mean(n - 2));
  slopes[0] = mean(0);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double before = x[k] - x[k - 1], after = x[k + 1] - x[k], weight = (before + 2 * after) / (3 * (before + after));
    slopes[k] = mean(k - 1) * mean(k) / (weight * mean(k) + (1 - weight) * mean(k - 1));
  }
  return {x.back(), [&](double s) -> HeightAndSlope {
            const std::size_t k = std::clamp<std::ptrdiff_t>(std::upper_bound(x.begin(), x.end(), s) - x.begin() - 1, 0, n - 2);
            const double length = x[k + 1] - x[k], t = (s - x[k]) / length, u = 1 - t;
            return {u * u * (1 + 2 * t) * z[k] + t * t * (1 + 2 * u) * z[k + 1] +
                        t * u * length * (u * slopes[k] - t * slopes[k + 1]),
                    6 * t * u * mean(k) + u * (1 - 3 * t) * slopes[k] + t * (1 - 3 * u) * slopes[k + 1]};
          }};
}

namespace
{

class ProfileTip : public Profile<ProfileTip>
{
public:
  ProfileTip(GeometryKind geometry, HeightProfile profile, HeightRange known)
      : Profile(geometry), profile_(std::move(profile)), known_(known)
  {
  }
  /// To first order the distance from a graph z(rho).
  ProfileGap At(double rho, double height) const
  {
    const HeightAndSlope at = profile_.At(rho);
    const double up = 1 / std::sqrt(1 + at.slope * at.slope);
    return {(at.height - height) * up, at.slope * up, -up};
  }
  double Radius(double height) const { return profile_.Reach(height); }
  ProfilePlace FarthestAt(double outward, double up) const
  {
    const double s = profile_.Farthest(outward, up);
    return {s, std::isfinite(s) ? profile_.At(s).height : s};
  }
  HeightRange KnownHeights() const override { return known_; }

private:
  HeightProfile profile_;
  HeightRange known_;
};

class ProfilePyramid : public IndenterSurface
{
public:
  ProfilePyramid(HeightProfile profile, int faces, double turn, HeightRange known)
      : profile_(std::move(profile)), known_(known), to_corner_(1 / std::cos(M_PI / faces))
  {
    for (int k = 0; k < faces; ++k) {
      const double face = turn + 2 * M_PI * k / faces, corner = face + M_PI / faces;
      faces_.push_back({std::cos(face), std::sin(face), 0});
      corners_.push_back({std::cos(corner), std::sin(corner), 0});
    }
  }
  /// At a corner between faces the normal is the mean of theirs.
  SurfaceGap Gap(Vec3 x) const override
  {
    constexpr double kEdge = 1e-6; // rounding; of the distance from the axis
    Vec3 across = x, outward{};
    across[2] = 0;
    const double s = Most(faces_, across), room = kEdge * Norm(across);
    int nearest = 0;
    for (const Vec3 &face : faces_)
      if (Dot(face, across) >= s - room) outward = outward + face, ++nearest;
    const HeightAndSlope at = profile_.At(std::max(s, 0.0));
    const double up = 1 / std::sqrt(1 + at.slope * at.slope);
    return {(at.height - x[2]) * up, (at.slope * up / nearest) * outward + Vec3{0, 0, -up}};
  }
  double Width(double height) const override { return 2 * profile_.Reach(height); }
  bool MayBeMirrored(int axis) const override
  {
    constexpr double kRounding = 1e-6; // rounding: of typed angles
    return std::all_of(faces_.begin(), faces_.end(), [&](Vec3 mirrored) {
      mirrored[axis] = -mirrored[axis];
      return Most(faces_, mirrored) > 1 - kRounding;
    });
  }
  Vec3 Farthest(Vec3 direction) const override
  {
    const auto along = [&](const Vec3 &a, const Vec3 &b) { return Dot(a, direction) < Dot(b, direction); };
    const Vec3 corner = to_corner_ * *std::max_element(corners_.begin(), corners_.end(), along);
    const double s = profile_.Farthest(Dot(corner, direction), direction[2]);
    if (!std::isfinite(s)) return {s, s, s};
    return s * corner + Vec3{0, 0, profile_.At(s).height};
  }
  HeightRange KnownHeights() const override { return known_; }

private:
  static double Most(const std::vector<Vec3> &normals, Vec3 x)
  {
    double most = -HUGE_VAL;
    for (const Vec3 &normal : normals) most = std::max(most, Dot(normal, x));
    return most;
  }

  HeightProfile profile_;
  HeightRange known_;
  double to_corner_;
  std::vector<Vec3> faces_, corners_; ///< horizontal directions
};

} // namespace

std::unique_ptr<IndenterSurface> CreateProfileTip(GeometryKind geometry, HeightProfile profile, HeightRange known)
{
  return std::make_unique<ProfileTip>(geometry, std::move(profile), known);
}

std::unique_ptr<IndenterSurface> CreateProfilePyramid(HeightProfile profile, int faces, double turn, HeightRange known)
{
  return std::make_unique<ProfilePyramid>(std::move(profile), faces, turn * M_PI / 180, known);
}

} // namespace mlgimp
