// Signals: those that end a run at once, by one line and the status of the signal, and those that ask it for a checkpoint.
#pragma once

namespace mlgimp
{

/// Call after PetscInitialize, whose handlers print traces. SIGHUP, SIGINT, SIGQUIT, SIGPIPE and, until ListenToOrders, SIGTERM
/// end the program. Only a program of one rank prints the line: mpiexec reports itself what has happened, and by such a signal it
/// also ends the other ranks after an error of one. Results need no care: each file is whole at any moment, or has another name.
void InstallSignals(int ranks);

/// What signals have asked a run for: a checkpoint (SIGUSR1), and then its end (SIGTERM).
enum Order : int { kWriteOrder = 1, kEndOrder = 2 };

/// From now on the first SIGTERM is an order, for TakeOrders; another one ends the program at once.
void ListenToOrders();

/// The orders that this rank has got, as a sum; one to write counts once.
int TakeOrders();

/// Ends the process as the signal ends any program, so that the shell sees why. Call when all is closed.
void EndBy(int signal);

} // namespace mlgimp
