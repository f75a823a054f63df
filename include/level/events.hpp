// The log events of a step's phases and their counted flops, for -log_view.
#pragma once

#include "base/petsc.hpp"

namespace mlgimp
{

struct LogEvents {
  PetscLogEvent points_to_grid, halo, grid_update, contact, grid_to_points, coupling, transfer, migrate, sort, balance, output;
};

PetscErrorCode RegisterLogEvents(LogEvents *events);

/// Calls `work` as a log event.
template <class Work> PetscErrorCode Logged(PetscLogEvent event, Work work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(event, 0, 0, 0, 0));
  PetscCall(work());
  PetscCall(PetscLogEventEnd(event, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Floating-point operations per point, counted in the sweeps' source (2D, nine nodes).
inline constexpr double kStencilFlops = 2 * 26, kPointsToGridFlops = kStencilFlops + 17 + 3 * (8 + 3 * 16),
                        kGridToPointsFlops = kStencilFlops + 9 * 24 + 12, kScatterRatesFlops = 8 + 3 * (8 + 3 * 16),
                        kGatherRatesFlops = kStencilFlops + 9 * 24 + 3 * (24 + 8), kStressFlops = 90, kShortWaveFlops = 35,
                        kNodeFlops = 20, kRatesFlops = 8 + 2 * 5 + 1;

} // namespace mlgimp
