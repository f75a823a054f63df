// Signals that end a run: one line, and the status of the signal.
#pragma once

namespace mlgimp
{

/// Call after PetscInitialize, whose handlers print traces. Only a program of one rank prints the line: mpiexec tells itself what
/// has happened, and by such a signal it also ends the other ranks after an error of one. Results need no care: each file is
/// whole at any moment, or has another name.
void InstallSignals(int ranks);

} // namespace mlgimp
