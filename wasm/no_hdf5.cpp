#include "report/hdf5.hpp"

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
