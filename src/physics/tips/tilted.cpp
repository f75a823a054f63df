// Tilted indenters: what they were upright, turned about their lowest place.
#include "physics/tips/tilted.hpp"

#include <cmath>
#include <utility>

namespace mlgimp
{

namespace
{

class Tilted : public IndenterSurface
{
public:
  Tilted(std::unique_ptr<IndenterSurface> upright, double angle, double toward)
      : upright_(std::move(upright)), toward_{std::cos(toward), std::sin(toward), 0}, sine_(std::sin(angle)),
        cosine_(std::cos(angle)), tip_(upright_->Farthest(ToUpright({0, 0, -1})))
  {
  }
  /// Whether it has a lowest point.
  bool HasTip() const { return std::isfinite(tip_[2]); }

  SurfaceGap Gap(Vec3 x) const override
  {
    const SurfaceGap gap = upright_->Gap(ToUpright(x) + tip_);
    return {gap.distance, Turned(gap.normal, sine_)};
  }
  /// That of the upright one, which is less by the square of the angle.
  double Width(double height) const override { return upright_->Width(height); }
  bool MayBeMirrored(int axis) const override
  {
    constexpr double kRounding = 1e-6; // rounding: of typed angles
    return std::abs(sine_ * toward_[axis]) < kRounding && upright_->MayBeMirrored(axis);
  }
  Vec3 Farthest(Vec3 direction) const override { return Turned(upright_->Farthest(ToUpright(direction)) - tip_, sine_); }
  HeightRange KnownHeights() const override
  {
    const HeightRange known = upright_->KnownHeights();
    return {known.least, cosine_ * (known.largest - tip_[2])};
  }

private:
  /// In the plane of z and the direction of the tilt, z turned toward it by the angle whose sine is given.
  Vec3 Turned(Vec3 x, double sine) const
  {
    const double along = Dot(x, toward_), up = x[2];
    Vec3 turned = x + (cosine_ * along + sine * up - along) * toward_;
    turned[2] = cosine_ * up - sine * along;
    return turned;
  }
  Vec3 ToUpright(Vec3 x) const { return Turned(x, -sine_); }

  std::unique_ptr<IndenterSurface> upright_;
  Vec3 toward_;
  double sine_, cosine_;
  Vec3 tip_; ///< the lowest point, where the surface is upright
};

} // namespace

std::unique_ptr<IndenterSurface> CreateTilted(std::unique_ptr<IndenterSurface> upright, double angle, double toward)
{
  auto tilted = std::make_unique<Tilted>(std::move(upright), angle * M_PI / 180, toward * M_PI / 180);
  if (!tilted->HasTip()) return nullptr;
  return tilted;
}

} // namespace mlgimp
