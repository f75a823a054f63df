// Signals that end a run.
#include "program/signals.hpp"

#include <csignal>
#include <cstring>
#include <unistd.h>

namespace mlgimp
{

namespace
{

volatile std::sig_atomic_t may_print = 0; // a handler can read nothing else than a global variable

const struct {
  int signal;
  const char *line;
} kEndings[] = {{SIGHUP, "mlgimp: error: ended by SIGHUP: the terminal was closed\n"},
                {SIGINT, "mlgimp: error: ended by SIGINT\n"},
                {SIGQUIT, "mlgimp: error: ended by SIGQUIT\n"},
                {SIGTERM, "mlgimp: error: ended by SIGTERM\n"},
                {SIGPIPE, "mlgimp: error: ended by SIGPIPE: nobody reads the output any more\n"}};

/// Prints the line and lets the signal do what it does to any program, so that the shell sees why it ended.
void EndBySignal(int signal)
{
  for (const auto &ending : kEndings)
    if (ending.signal == signal && may_print) (void)!write(STDERR_FILENO, ending.line, std::strlen(ending.line));
  std::signal(signal, SIG_DFL);
  raise(signal);
}

} // namespace

void InstallSignals(int ranks)
{
  may_print = ranks == 1;
  for (const auto &ending : kEndings) {
    struct sigaction before {
    }, now{};
    now.sa_handler = EndBySignal;
    sigaction(ending.signal, nullptr, &before);
    if (before.sa_handler == SIG_IGN) continue; // as nohup wants it
    sigaction(ending.signal, &now, nullptr);
  }
}

} // namespace mlgimp
