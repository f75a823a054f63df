// Drag and inertia in the budgets of a run.
#include "program/advice/motion_watch.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

double MotionWatch::ShareOfLoad(double energy) const
{
  const double left = state_.work - state_.drag - state_.inertia;
  return left > 0 ? std::max(0.0, energy / left) : 0;
}

double MotionWatch::ShareOfPlasticWork() const { return state_.flowed_then > 0 ? state_.flowed / state_.flowed_then - 1 : 0; }

void MotionWatch::RecordTip(const Budgets &row)
{
  State &s = state_;
  const double work = row.indenter_work, drag = row.damping_work, inertia = row.kinetic_energy - row.noise_energy;
  if (row.depth > s.depth) {
    const double weight = std::pow(s.depth / row.depth, 4);
    s.work = weight * s.work + work - s.last_work;
    s.drag = weight * s.drag + drag - s.last_drag;
    s.inertia = weight * s.inertia + inertia - s.last_inertia;
    s.depth = row.depth;
  }
  s.last_work = work, s.last_drag = drag, s.last_inertia = inertia;
}

void MotionWatch::RecordFlow(const Budgets &row, double pressure)
{
  constexpr double kMinPressure = 0.9; // of the largest pressure: below, bodies are unloaded, and what they do is of another kind
  const double unspent = row.kinetic_energy + row.damping_work + row.viscous_work;
  const bool rises = pressure > state_.pressure;
  if (pressure < kMinPressure * state_.pressure) return;
  if (rises || unspent > state_.unspent) state_.unspent = unspent, state_.flowed_then = row.plastic_work;
  state_.pressure = std::max(state_.pressure, pressure);
  state_.flowed = row.plastic_work;
}

void MotionWatch::Record(const Budgets &row, double pressure)
{
  RecordTip(row);
  RecordFlow(row, pressure);
}

} // namespace mlgimp
