// Signals that end a run, or ask it for a checkpoint.
#include "program/system/signals.hpp"

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <unistd.h>

namespace mlgimp
{

namespace
{

// A handler can read nothing else than global variables, of these kinds.
volatile std::sig_atomic_t may_print = 0, listens = 0, write_asked = 0, end_asked = 0;
std::atomic<std::int64_t> end_asked_at{0}; // ms

const struct {
  int signal;
  const char *line;
} kEndings[] = {{SIGHUP, "mlgimp: error: ended by SIGHUP: the terminal was closed\n"},
                {SIGINT, "mlgimp: error: ended by SIGINT\n"},
                {SIGQUIT, "mlgimp: error: ended by SIGQUIT\n"},
                {SIGTERM, "mlgimp: error: ended by SIGTERM\n"},
                {SIGPIPE, "mlgimp: error: ended by SIGPIPE: the program that reads the output has ended\n"}};

/// Prints the line and ends the program.
void EndBySignal(int signal)
{
  for (const auto &ending : kEndings)
    if (ending.signal == signal && may_print) (void)!write(STDERR_FILENO, ending.line, std::strlen(ending.line));
  EndBy(signal);
}

std::int64_t Milliseconds()
{
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1000} * now.tv_sec + now.tv_nsec / 1000000;
}

void AskForEnd(int signal)
{
  constexpr std::int64_t kSameSignal = 100; // size; ms: a signal to all processes comes here twice, as mpiexec sends its own on
  if (!listens || (end_asked && Milliseconds() - end_asked_at > kSameSignal)) EndBySignal(signal);
  if (!end_asked) end_asked_at = Milliseconds();
  end_asked = 1;
}

void AskForWriting(int) { write_asked = 1; }

/// Installs a handler, but where the signal is ignored, as nohup wants it.
void Install(int signal, void (*handler)(int))
{
  struct sigaction before {
  }, now{};
  now.sa_handler = handler;
  now.sa_flags = SA_RESTART; // what is being written or read goes on
  sigaction(signal, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(signal, &now, nullptr);
}

} // namespace

void InstallSignals(int ranks)
{
  may_print = ranks == 1;
  for (const auto &ending : kEndings) Install(ending.signal, EndBySignal);
  Install(SIGTERM, AskForEnd);
  Install(SIGUSR1, AskForWriting);
}

void ListenToOrders() { listens = 1; }

int TakeOrders()
{
  int orders = end_asked ? kEndOrder : 0;
  if (write_asked) orders += kWriteOrder, write_asked = 0; // one that comes here just now stays
  return orders;
}

void EndBy(int signal)
{
  std::signal(signal, SIG_DFL);
  raise(signal);
}

} // namespace mlgimp
