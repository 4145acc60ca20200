#include <new>

#include "cli/command_line.hpp"
#include "cli/view/view.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/verbs.hpp"

namespace biss::cli {
namespace {

verbs::ExitStatus run(int argc, char** argv, verbs::Host& host) {
  verbs::Command command(host);
  verbs::add_verbs(command);
  add_view(command);
  return run_command_line(command, argc, argv);
}

}  // namespace
}  // namespace biss::cli

int main(int argc, char** argv) {
  using namespace biss;
  verbs::prepare_process();
  verbs::ProcessHost host;
  // Declaring the verbs takes memory too.
  try {
    return static_cast<int>(cli::run(argc, argv, host));
  } catch (const std::bad_alloc&) {
    return static_cast<int>(host.fail(verbs::ExitStatus::io, "out of memory"));
  }
}
