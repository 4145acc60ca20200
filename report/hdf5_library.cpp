#include "report/hdf5_library.hpp"

#include <dlfcn.h>

namespace biss::report {
namespace {

bool load(Hdf5Library& library) {
  void* const file = dlopen(hdf5_file, RTLD_NOW | RTLD_LOCAL);
  if (file == nullptr) return false;
#define BISS_HDF5_FUNCTION(NAME)                                               \
  library.NAME = reinterpret_cast<decltype(library.NAME)>(dlsym(file, #NAME)); \
  if (library.NAME == nullptr) return false;
  BISS_HDF5_FUNCTIONS(BISS_HDF5_FUNCTION)
#undef BISS_HDF5_FUNCTION
  // The constants are there after it.
  if (library.H5open() < 0) return false;
#define BISS_HDF5_CONSTANT(NAME)                       \
  const void* const found_##NAME = dlsym(file, #NAME); \
  if (found_##NAME == nullptr) return false;           \
  library.NAME = *static_cast<const hid_t*>(found_##NAME);
  BISS_HDF5_CONSTANTS(BISS_HDF5_CONSTANT)
#undef BISS_HDF5_CONSTANT
  return true;
}

}  // namespace

const char* const hdf5_file = BISS_HDF5_FILE;

const Hdf5Library& hdf5() {
  static const Hdf5Library library = [] {
    Hdf5Library made;
    made.loaded = load(made);
    return made;
  }();
  return library;
}

}  // namespace biss::report
