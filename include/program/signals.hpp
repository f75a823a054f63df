// Signals that end a run: one line, and the status of the signal.
#pragma once

namespace mlgimp
{

/// Call after PetscInitialize, whose handlers print traces, with the rank: the first one prints. Results need no care: each
/// file is whole at any moment, or has another name.
void InstallSignals(int rank);

} // namespace mlgimp
