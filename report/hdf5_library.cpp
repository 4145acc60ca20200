#include "report/hdf5_library.hpp"

#include <dlfcn.h>

#include <stdexcept>
#include <string>

namespace biss::report {
namespace {

void* library() {
  static void* const file = dlopen(hdf5_file, RTLD_NOW | RTLD_LOCAL);
  return file;
}

}  // namespace

const char* const hdf5_file = BISS_HDF5_FILE;

bool load_hdf5() {
  // The constants are there after H5open().
  static const bool loaded = library() != nullptr && BISS_HDF5(H5open)() >= 0;
  return loaded;
}

void* hdf5_symbol(const char* name) {
  void* const symbol = dlsym(library(), name);
  if (symbol == nullptr) throw std::runtime_error(std::string("HDF5: the library has no ") + name);
  return symbol;
}

}  // namespace biss::report
