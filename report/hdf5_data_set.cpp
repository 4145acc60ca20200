#include "report/hdf5_data_set.hpp"

#include <bit>
#include <limits>
#include <utility>

namespace biss::report {
namespace {

struct StorageType {
  hid_t (*type)();
  std::size_t bytes;
  const char* matlab;
};

// The blocks are written as they are in memory.
static_assert(std::endian::native == std::endian::little);

// In the order of Hdf5Storage.
constexpr std::array<StorageType, 6> types{{
    {[] { return BISS_HDF5(H5T_IEEE_F64LE_g); }, 8, "double"},
    {[] { return BISS_HDF5(H5T_STD_U64LE_g); }, 8, "uint64"},
    {[] { return BISS_HDF5(H5T_STD_I64LE_g); }, 8, "int64"},
    {[] { return BISS_HDF5(H5T_STD_U8LE_g); }, 1, "uint8"},
    {[] { return BISS_HDF5(H5T_STD_U32LE_g); }, 4, "uint32"},
    {[] { return BISS_HDF5(H5T_STD_U16LE_g); }, 2, "uint16"},
}};

const StorageType& type_of(Hdf5Storage storage) { return types[static_cast<std::size_t>(storage)]; }

}  // namespace

bool put_hdf5_attribute(hid_t object, const char* name, std::string_view text) {
  if (text.empty()) return true;
  const Hdf5Id type(BISS_HDF5(H5Tcopy)(BISS_HDF5(H5T_C_S1_g)), BISS_HDF5(H5Tclose));
  return BISS_HDF5(H5Tset_size)(type.get(), text.size()) >= 0 &&
         put_hdf5_attribute(object, name, type.get(), text.data());
}

bool put_hdf5_attribute(hid_t object, const char* name, hid_t type, const void* value) {
  const Hdf5Id space(BISS_HDF5(H5Screate)(H5S_SCALAR), BISS_HDF5(H5Sclose));
  const Hdf5Id made(
      BISS_HDF5(H5Acreate2)(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
      BISS_HDF5(H5Aclose));
  return made.good() && BISS_HDF5(H5Awrite)(made.get(), type, value) >= 0;
}

Hdf5DataSet::Hdf5DataSet(std::string name, std::string unit, Hdf5Storage storage, std::size_t lanes,
                         bool zero_absent)
    : name_(std::move(name)),
      unit_(std::move(unit)),
      storage_(storage),
      lanes_(lanes),
      says_absent_(!zero_absent && storage != Hdf5Storage::real) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (storage == Hdf5Storage::real) {
    std::memcpy(absent_.data(), &nan, sizeof nan);
  } else if (says_absent_ && storage == Hdf5Storage::wide_signed) {
    const auto least = std::numeric_limits<std::int64_t>::min();
    std::memcpy(absent_.data(), &least, sizeof least);
  } else if (says_absent_) {
    absent_.fill(0xFF);
  }
  block_.resize(lanes * hdf5_block_rows * bytes());
  clear();
}

std::size_t Hdf5DataSet::bytes() const { return type_of(storage_).bytes; }

bool Hdf5DataSet::write(hid_t file, std::uint64_t first_row, std::size_t rows, bool is_last) {
  if (!set_.good() && !create(file, is_last, rows)) return false;
  if (chunked_ && !resize(first_row + rows)) return false;
  // A block without a value is not written: it reads as absent and takes no space.
  if (used_ && !(chunked_ ? write_chunk(first_row) : write_all(rows))) return false;
  if (used_) clear();
  used_ = false;
  return !is_last || set_.close();
}

void Hdf5DataSet::clear() {
  if (bytes() == absent_.size()) {
    for (std::size_t i = 0; i < block_.size(); i += absent_.size()) {
      std::memcpy(block_.data() + i, absent_.data(), absent_.size());
    }
  } else {
    std::memset(block_.data(), absent_[0], block_.size());
  }
}

// `whole`: with all rows of a table; else it grows by blocks.
bool Hdf5DataSet::create(hid_t file, bool whole, std::size_t rows) {
  chunked_ = !whole;
  const std::array<hsize_t, 2> size{lanes_, rows};
  const std::array<hsize_t, 2> most{lanes_, chunked_ ? H5S_UNLIMITED : rows};
  const std::array<hsize_t, 2> chunk{lanes_, hdf5_block_rows};
  const Hdf5Id space(BISS_HDF5(H5Screate_simple)(2, size.data(), most.data()), BISS_HDF5(H5Sclose));
  const Hdf5Id setup(BISS_HDF5(H5Pcreate)(BISS_HDF5(H5P_CLS_DATASET_CREATE_ID_g)),
                     BISS_HDF5(H5Pclose));
  const hid_t type = type_of(storage_).type();
  const bool ready = space.good() && BISS_HDF5(H5Pset_obj_track_times)(setup.get(), false) >= 0 &&
                     BISS_HDF5(H5Pset_fill_value)(setup.get(), type, absent_.data()) >= 0 &&
                     (!chunked_ || BISS_HDF5(H5Pset_chunk)(setup.get(), 2, chunk.data()) >= 0);
  if (!ready) return false;
  set_ = Hdf5Id(BISS_HDF5(H5Dcreate2)(file, name_.c_str(), type, space.get(), H5P_DEFAULT,
                                      setup.get(), H5P_DEFAULT),
                BISS_HDF5(H5Dclose));
  return set_.good() && put_hdf5_attribute(set_.get(), "MATLAB_class", type_of(storage_).matlab) &&
         put_hdf5_attribute(set_.get(), "unit", unit_) &&
         (!says_absent_ || put_hdf5_attribute(set_.get(), "absent_value", type, absent_.data()));
}

bool Hdf5DataSet::resize(std::uint64_t rows) {
  const std::array<hsize_t, 2> size{lanes_, rows};
  return BISS_HDF5(H5Dset_extent)(set_.get(), size.data()) >= 0;
}

bool Hdf5DataSet::write_chunk(std::uint64_t first_row) {
  const std::array<hsize_t, 2> place{0, first_row};
  return BISS_HDF5(H5Dwrite_chunk)(set_.get(), H5P_DEFAULT, 0, place.data(), block_.size(),
                                   block_.data()) >= 0;
}

bool Hdf5DataSet::write_all(std::size_t rows) {
  const std::array<hsize_t, 2> size{lanes_, hdf5_block_rows};
  const std::array<hsize_t, 2> first{0, 0};
  const std::array<hsize_t, 2> part{lanes_, rows};
  const Hdf5Id memory(BISS_HDF5(H5Screate_simple)(2, size.data(), nullptr), BISS_HDF5(H5Sclose));
  return BISS_HDF5(H5Sselect_hyperslab)(memory.get(), H5S_SELECT_SET, first.data(), nullptr,
                                        part.data(), nullptr) >= 0 &&
         BISS_HDF5(H5Dwrite)(set_.get(), type_of(storage_).type(), memory.get(), H5S_ALL,
                             H5P_DEFAULT, block_.data()) >= 0;
}

}  // namespace biss::report
