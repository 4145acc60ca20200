#include "cli/common/output.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"

int main(int argc, char** argv) {
  using namespace biss::cli;
  prepare_process();
  Command command;
  add_decode(command);
  add_check(command);
  add_compare(command);
  add_conform(command);
  add_crc(command);
  add_encoders(command);
  add_eds(command);
  add_identify(command);
  add_explain(command);
  add_plan(command);
  add_registers(command);
  add_safety(command);
  add_simulate(command);
  return static_cast<int>(command.run(argc, argv));
}
