// Cones, balls and flat punches.
#include "physics/tips/profiles.hpp"

#include "physics/tips/profile.hpp"

#include <cmath>

namespace mlgimp
{

double RoundedRadius(double height, double half_angle, double radius)
{
  const double sine = std::sin(half_angle);
  if (height < radius * (1 - sine)) return std::sqrt(height * (2 * radius - height));
  return std::tan(half_angle) * (height + (radius > 0 ? radius / sine - radius : 0));
}

namespace
{

class Cone : public Profile<Cone>
{
public:
  Cone(GeometryKind geometry, double half_angle, double tip_radius)
      : Profile(geometry), half_angle_(half_angle), sine_(std::sin(half_angle)), cosine_(std::cos(half_angle)),
        radius_(tip_radius)
  {
  }

  /// From the centre of the ball, all that lies before the normal of the flank through it is nearest to the ball.
  ProfileGap At(double rho, double height) const
  {
    const double up = height - radius_;
    if (radius_ > 0 && rho * sine_ + up * cosine_ < 0) {
      const double distance = std::sqrt(rho * rho + up * up);
      return {distance - radius_, rho / distance, up / distance};
    }
    return {rho * cosine_ - up * sine_ - radius_, cosine_, -sine_};
  }
  double Radius(double height) const { return RoundedRadius(height, half_angle_, radius_); }
  ProfilePlace FarthestAt(double outward, double up) const
  {
    if (outward * sine_ + up * cosine_ > 0) return {HUGE_VAL, HUGE_VAL};
    return {radius_ * outward, radius_ * (1 + up)};
  }

private:
  double half_angle_, sine_, cosine_, radius_;
};

class Ball : public Profile<Ball>
{
public:
  Ball(GeometryKind geometry, double radius) : Profile(geometry), radius_(radius) {}

  ProfileGap At(double rho, double height) const
  {
    const double up = height - radius_, distance = std::sqrt(rho * rho + up * up);
    if (distance == 0) return {-radius_, 0, -1};
    return {distance - radius_, (1 / distance) * rho, (1 / distance) * up};
  }
  double Radius(double height) const { return height < radius_ ? std::sqrt(height * (2 * radius_ - height)) : radius_; }
  ProfilePlace FarthestAt(double outward, double up) const { return {radius_ * outward, radius_ * (1 + up)}; }

private:
  double radius_;
};

/// A level disk whose edge is a quarter of a circle, and a wall above.
class FlatPunch : public Profile<FlatPunch>
{
public:
  FlatPunch(GeometryKind geometry, double radius, double edge) : Profile(geometry), radius_(radius), edge_(edge) {}

  ProfileGap At(double rho, double height) const
  {
    const double across = rho - (radius_ - edge_), up = height - edge_;
    if (across > 0 && up < 0 && edge_ > 0) {
      const double distance = std::sqrt(across * across + up * up);
      return {distance - edge_, across / distance, up / distance};
    }
    if (rho - radius_ > -height) return {rho - radius_, 1, 0};
    return {-height, 0, -1};
  }
  double Radius(double height) const
  {
    return height < edge_ ? radius_ - edge_ + std::sqrt(height * (2 * edge_ - height)) : radius_;
  }
  ProfilePlace FarthestAt(double outward, double up) const
  {
    return outward > 0 ? ProfilePlace{radius_ - edge_ + edge_ * outward, edge_ * (1 + up)} : ProfilePlace{0, 0};
  }

private:
  double radius_, edge_;
};

} // namespace

std::unique_ptr<IndenterSurface> CreateCone(GeometryKind geometry, double half_angle, double tip_radius)
{
  return std::make_unique<Cone>(geometry, half_angle * M_PI / 180, tip_radius);
}

std::unique_ptr<IndenterSurface> CreateSphere(GeometryKind geometry, double radius)
{
  return std::make_unique<Ball>(geometry, radius);
}

std::unique_ptr<IndenterSurface> CreateFlatPunch(GeometryKind geometry, double radius, double edge_radius)
{
  return std::make_unique<FlatPunch>(geometry, radius, edge_radius);
}

} // namespace mlgimp
