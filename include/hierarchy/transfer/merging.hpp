// Siblings that have left a finer level become their parent again.
#pragma once

#include "hierarchy/transfer/point_transfer.hpp"

namespace mlgimp
{

/// Merges the points of a level that came from one split, where all of them are on this level and smaller than usual
/// there. Mass and momentum are kept; F, stress and the rest are means by mass. most_loss: families whose strain energy would
/// change by more than this share of it, as strain varies among them, stay as they are. Collective on `world`.
PetscErrorCode MergeSiblings(MPI_Comm world, Level &level, const PointNumbers &numbers, int ratio, double most_loss,
                             Budgets *budgets);

} // namespace mlgimp
