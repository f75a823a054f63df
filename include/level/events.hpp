// The log events of a step's phases and their counted flops, for -log_view.
#pragma once

#include "base/petsc.hpp"

namespace mlgimp
{

struct LogEvents {
  PetscLogEvent points_to_grid, halo, grid_update, contact, surface, grid_to_points, coupling, transfer, migrate, sort, balance,
      output;
};

PetscErrorCode RegisterLogEvents(LogEvents *events);
/// The log stage of level l, which hierarchies created one after the other share.
PetscErrorCode RegisterLevelStage(int l, PetscLogStage *stage);

/// Counts what is done until its end as a log event.
class LogScope
{
public:
  explicit LogScope(PetscLogEvent event) : event_(event)
  {
    PetscCallAbort(PETSC_COMM_SELF, PetscLogEventBegin(event_, 0, 0, 0, 0));
  }
  ~LogScope() { PetscCallAbort(PETSC_COMM_SELF, PetscLogEventEnd(event_, 0, 0, 0, 0)); }
  LogScope(const LogScope &) = delete;
  LogScope &operator=(const LogScope &) = delete;

private:
  PetscLogEvent event_;
};

/// Counts what is done until its end in a log stage.
class StageScope
{
public:
  explicit StageScope(PetscLogStage stage) { PetscCallAbort(PETSC_COMM_SELF, PetscLogStagePush(stage)); }
  ~StageScope() { PetscCallAbort(PETSC_COMM_SELF, PetscLogStagePop()); }
  StageScope(const StageScope &) = delete;
  StageScope &operator=(const StageScope &) = delete;
};

/// Calls `work` as a log event.
template <class Work> PetscErrorCode Timed(PetscLogEvent event, Work work)
{
  const LogScope log(event);
  return work();
}

/// Floating-point operations of a sweep for a point, and of the grid's update for a node: counted in the source in the plane, and
/// in space by the same terms.
struct Flops {
  explicit constexpr Flops(int dim)
      : rows(dim == 3 ? 9 : 3), stencil(26 * dim), scatter(rows * (8 + 3 * 16)), gather(3 * rows * 4 * dim * (1 + dim)),
        points_to_grid(stencil + 17 + scatter), spread_change(stencil + dim + rows * (6 * dim + 4 + 3 * 8)), // size
        grid_to_points(stencil + gather + rows * (6 * dim + 24) + 6 * dim), stress(22.5 * dim * dim),        // size
        short_wave(8.75 * dim * dim), node(10 * dim), rates(16 * dim * dim)                                  // size
  {
  }
  double rows, stencil, scatter, gather;
  double points_to_grid, spread_change, grid_to_points, stress, short_wave, node, rates;
};

} // namespace mlgimp
