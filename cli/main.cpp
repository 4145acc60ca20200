#include <new>

#include "cli/common/host.hpp"
#include "cli/common/output.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"

namespace biss::cli {
namespace {

ExitStatus run(int argc, char** argv, Host& host) {
  Command command(host);
  add_decode(command);
  add_check(command);
  add_compare(command);
  add_convert(command);
  add_crc(command);
  add_encoders(command);
  add_eds(command);
  add_identify(command);
  add_explain(command);
  add_draw(command);
  add_plan(command);
  add_registers(command);
  add_report(command);
  add_archive(command);
  add_safety(command);
  add_simulate(command);
  add_view(command);
  return command.run(argc, argv);
}

}  // namespace
}  // namespace biss::cli

int main(int argc, char** argv) {
  using namespace biss::cli;
  prepare_process();
  ProcessHost host;
  // Declaring the verbs takes memory too.
  try {
    return static_cast<int>(run(argc, argv, host));
  } catch (const std::bad_alloc&) {
    return static_cast<int>(host.fail(ExitStatus::io, "out of memory"));
  }
}
