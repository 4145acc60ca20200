#include "wasm/command.hpp"

#include <new>
#include <nlohmann/json.hpp>

#include "report/hdf5.hpp"
#include "verbs/common/declared.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/verb.hpp"

namespace biss::wasm {

Request::Request(std::string_view json) {
  const auto object = nlohmann::json::parse(json);
  object.at("words").get_to(words);
  object.at("options").get_to(options);
}

verbs::ExitStatus run_command(std::string_view json) {
  verbs::ProcessHost host;
  try {
    const Request request(json);
    verbs::Command command(host);
    verbs::add_verbs(command, request.words.empty() ? "" : request.words.front());
    return command.run(request.words, request.options);
  } catch (const std::bad_alloc&) {
    return host.fail(verbs::ExitStatus::io, "out of memory");
  }
}

std::string described_verbs() {
  verbs::ProcessHost host;
  verbs::Command command(host);
  verbs::add_verbs(command);
  return verbs::described(command.declared());
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
  sink.fail("this build writes no HDF5; use --to csv");
  return std::make_unique<NoHdf5>();
}

}  // namespace biss::report
