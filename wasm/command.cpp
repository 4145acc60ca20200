// The verbs of the command, run by a page: its own arguments, messages and files.
#include "wasm/command.hpp"

#include <new>

#include "cli/common/host.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"
#ifndef BISS_WASM_QUICK
#include "cli/safety/safety.hpp"
#endif
#include "report/hdf5.hpp"

namespace biss::wasm {

namespace {

// What the quick tests of the page do not use, and what takes long to compile.
void add_further_verbs([[maybe_unused]] cli::Command& command) {
#ifndef BISS_WASM_QUICK
  cli::add_compare(command);
  cli::add_convert(command);
  cli::add_crc(command);
  cli::add_eds(command);
  cli::add_draw(command);
  cli::add_plan(command);
  // Without campaigns, which run for hours, and evidence, which writes folders.
  cli::add_verb_group(command, cli::safety_text(), {cli::safety_analyse()});
  cli::add_simulate(command);
#endif
}

cli::ExitStatus run_verb(std::span<const char* const> arguments, cli::Host& host) {
  cli::Command command(host);
  cli::add_decode(command);
  cli::add_check(command);
  cli::add_encoders(command);
  cli::add_identify(command);
  cli::add_explain(command);
  cli::add_registers(command);
  add_further_verbs(command);
  return command.run(static_cast<int>(arguments.size()), arguments.data());
}

}  // namespace

cli::ExitStatus run_command(std::span<const char* const> arguments) {
  cli::ProcessHost host;
  try {
    return run_verb(arguments, host);
  } catch (const std::bad_alloc&) {
    return host.fail(cli::ExitStatus::io, "out of memory");
  }
}

}  // namespace biss::wasm

namespace biss::report {

namespace {

class NoHdf5 final : public TableWriter {
 public:
  bool row(std::span<const Cell> /*cells*/) override { return false; }
  bool finish() override { return false; }
};

}  // namespace

// HDF5 has no library for WebAssembly.
std::unique_ptr<TableWriter> make_hdf5_writer(std::span<const Column> /*columns*/, FileSink& sink) {
  sink.fail("this build writes no HDF5; take --to csv");
  return std::make_unique<NoHdf5>();
}

}  // namespace biss::report
