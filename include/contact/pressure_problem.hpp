// Pressures that are not negative and close the gaps of a surface, as a problem with bounds on one rank.
#pragma once

#include <vector>

namespace mlgimp
{

/// q >= 0 with A q + gaps - u closing >= 0, one of them zero in each row: q are pressures times the roots of their areas, so that
/// A is symmetric and positive; u is how far the tip travels down, m.
class PressureProblem
{
public:
  virtual ~PressureProblem() = default;
  virtual int Size() const = 0;
  /// y = A q, both [Size()].
  virtual void Multiply(const double *q, double *y) const = 0;
  /// Diagonal of A, [Size()].
  virtual void Diagonal(double *diagonal) const = 0;
  /// Gaps at the end of the step without contact times the roots of areas, m2.
  const std::vector<double> &Gaps() const { return gaps_; }
  /// By which a tip that travels down by 1 closes them; closing . q is the load, N.
  const std::vector<double> &Closing() const { return closing_; }

protected:
  std::vector<double> gaps_, closing_;
};

} // namespace mlgimp
