// Within the HDF5 writer: the library, which is loaded when the first file is created. A command that
// writes no HDF5 starts without it.
#pragma once

#include <hdf5.h>

namespace biss::report {

// The functions of the library that the writer calls, and its constants.
#define BISS_HDF5_FUNCTIONS(EACH) \
  EACH(H5open)                    \
  EACH(H5Aclose)                  \
  EACH(H5Acreate2)                \
  EACH(H5Awrite)                  \
  EACH(H5Dclose)                  \
  EACH(H5Dcreate2)                \
  EACH(H5Dset_extent)             \
  EACH(H5Dwrite)                  \
  EACH(H5Dwrite_chunk)            \
  EACH(H5Eset_auto2)              \
  EACH(H5FDregister)              \
  EACH(H5Fclose)                  \
  EACH(H5Fcreate)                 \
  EACH(H5Pclose)                  \
  EACH(H5Pcreate)                 \
  EACH(H5Pget_driver_info)        \
  EACH(H5Pset_chunk)              \
  EACH(H5Pset_driver)             \
  EACH(H5Pset_fill_value)         \
  EACH(H5Pset_obj_track_times)    \
  EACH(H5Pset_userblock)          \
  EACH(H5Sclose)                  \
  EACH(H5Screate)                 \
  EACH(H5Screate_simple)          \
  EACH(H5Sselect_hyperslab)       \
  EACH(H5Tclose)                  \
  EACH(H5Tcopy)                   \
  EACH(H5Tset_size)
#define BISS_HDF5_CONSTANTS(EACH)   \
  EACH(H5P_CLS_DATASET_CREATE_ID_g) \
  EACH(H5P_CLS_FILE_ACCESS_ID_g)    \
  EACH(H5P_CLS_FILE_CREATE_ID_g)    \
  EACH(H5T_C_S1_g)                  \
  EACH(H5T_IEEE_F64LE_g)            \
  EACH(H5T_STD_I32LE_g)             \
  EACH(H5T_STD_I64LE_g)             \
  EACH(H5T_STD_U16LE_g)             \
  EACH(H5T_STD_U32LE_g)             \
  EACH(H5T_STD_U64LE_g)             \
  EACH(H5T_STD_U8LE_g)

/// The library's functions and constants by their own names.
struct Hdf5Library {
#define BISS_HDF5_FUNCTION(NAME) decltype(&::NAME) NAME = nullptr;
#define BISS_HDF5_CONSTANT(NAME) hid_t NAME = H5I_INVALID_HID;
  BISS_HDF5_FUNCTIONS(BISS_HDF5_FUNCTION)
  BISS_HDF5_CONSTANTS(BISS_HDF5_CONSTANT)
#undef BISS_HDF5_FUNCTION
#undef BISS_HDF5_CONSTANT
  /// All of them are there.
  bool loaded = false;
};

/// The name of its file.
extern const char* const hdf5_file;

/// Loads it at the first call. Can be called in several threads.
const Hdf5Library& hdf5();

}  // namespace biss::report
