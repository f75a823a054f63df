// Drag and inertia in the budgets of a run.
#include "program/advice/motion_watch.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

double MotionWatch::ShareOfLoad(Kept part, double factor) const
{
  const double left = numbers_[kWork] - numbers_[kDrag] - numbers_[kInertia];
  return left > 0 ? std::max(0.0, factor * numbers_[part] / left) : 0;
}

double MotionWatch::ShareOfPlasticWork() const
{
  const double before = numbers_[kFlowedThen];
  return before > 0 ? numbers_[kFlowed] / before - 1 : 0;
}

void MotionWatch::RecordTip(const Budgets &row)
{
  const std::array<double, 3> now = {row.indenter_work, row.damping_work, row.kinetic_energy - row.noise_energy};
  if (row.depth > numbers_[kDepth]) {
    const double weight = std::pow(numbers_[kDepth] / row.depth, 4);
    for (int k = 0; k < 3; ++k) numbers_[kWork + k] = weight * numbers_[kWork + k] + now[k] - numbers_[kLastWork + k];
    numbers_[kDepth] = row.depth;
  }
  std::copy(now.begin(), now.end(), numbers_.begin() + kLastWork);
}

void MotionWatch::RecordFlow(const Budgets &row, double pressure)
{
  constexpr double kHeld = 0.9; // of the largest pressure: below, bodies are unloaded, and what they do is of another kind
  const double unspent = row.kinetic_energy + row.damping_work + row.viscous_work;
  const bool rises = pressure > numbers_[kPressure];
  if (pressure < kHeld * numbers_[kPressure]) return;
  if (rises || unspent > numbers_[kUnspent]) numbers_[kUnspent] = unspent, numbers_[kFlowedThen] = row.plastic_work;
  numbers_[kPressure] = std::max(numbers_[kPressure], pressure);
  numbers_[kFlowed] = row.plastic_work;
}

void MotionWatch::Record(const Budgets &row, double pressure)
{
  RecordTip(row);
  RecordFlow(row, pressure);
}

} // namespace mlgimp
