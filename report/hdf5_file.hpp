// Within the HDF5 writer: a file of the library that is written through a FileSink.
#pragma once

#include "report/hdf5_library.hpp"

#include <utility>

#include "report/sink.hpp"

namespace biss::report {

/// An identifier of the library, closed by the destructor.
class Hdf5Id {
 public:
  Hdf5Id() = default;
  Hdf5Id(hid_t id, herr_t (*closer)(hid_t)) : id_(id), close_(closer) {}
  Hdf5Id(Hdf5Id&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Id() { close(); }

  hid_t get() const { return id_; }
  bool good() const { return id_ >= 0; }
  /// False when the library could not close it.
  bool close() {
    const hid_t id = std::exchange(id_, H5I_INVALID_HID);
    return id < 0 || close_(id) >= 0;
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
  herr_t (*close_)(hid_t) = nullptr;
};

/// Bytes before the library's file; MATLAB uses them for its own header.
inline constexpr std::size_t hdf5_user_bytes = 512;

/// Creates a file, with hdf5_user_bytes before it. The sink must outlive it. Only the sink records
/// a failed write: the library continues as if the write had succeeded, because it cannot close a
/// file after an error without leaking memory and printing messages.
Hdf5Id create_hdf5_file(FileSink& sink);

}  // namespace biss::report
