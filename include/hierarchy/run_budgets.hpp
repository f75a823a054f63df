// The budgets of a run and its failures, over all levels and ranks.
#pragma once

#include "hierarchy/connected_levels.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// What this rank adds up: levels, borders, and points between levels.
std::vector<Budgets *> PartsOfBudgets(ConnectedLevels &levels);

/// The budgets of all levels on this rank, but what only a run knows.
Budgets SumBudgets(ConnectedLevels &levels, const Model &model);

/// Those of all ranks, on every rank. Collective.
PetscErrorCode ReduceBudgets(ConnectedLevels &levels, const Model &model, Budgets *budgets);

/// One line about the first failure that this rank has met; empty where there is none.
std::string DescribeFailure(ConnectedLevels &levels, int dim);

} // namespace mlgimp
