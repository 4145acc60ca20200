// The command `biss`: all verbs, `biss view` and `biss emulate`.
#include <new>

#include "cli/command_line.hpp"
#include "cli/live/emulate.hpp"
#include "cli/live/read.hpp"
#include "cli/live/watch.hpp"
#include "cli/view/view.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/verb.hpp"

int main(int argc, char** argv) {
  using namespace biss;
  verbs::prepare_process();
  verbs::ProcessHost host;
  // Declaring the verbs takes memory too.
  try {
    verbs::Command command(host);
    verbs::add_verbs(command);
    cli::add_view(command);
    cli::add_read(command);
    cli::add_emulate(command);
    cli::add_watch(command);
    return static_cast<int>(cli::run_command_line(command, argc, argv));
  } catch (const std::bad_alloc&) {
    return static_cast<int>(host.fail(verbs::ExitStatus::io, "out of memory"));
  }
}
