// Within the HDF5 writer: the library, which is loaded when the first file is created. A command that
// writes no HDF5 starts without it.
#pragma once

#include <hdf5.h>

namespace biss::report {

/// The name of its file.
extern const char* const hdf5_file;

/// Loads it at the first call; false if it cannot be loaded. Can be called in several threads.
bool load_hdf5();

/// The address of one of its functions or constants. Throws std::runtime_error if it has none of this
/// name. \pre load_hdf5()
void* hdf5_symbol(const char* name);

}  // namespace biss::report

/// A function or constant of the library.
#define BISS_HDF5(NAME) (*reinterpret_cast<decltype(&::NAME)>(::biss::report::hdf5_symbol(#NAME)))
