#include "report/hdf5_file.hpp"

#include <cstddef>
#include <span>

namespace biss::report {
namespace {

// H5F_ACC_TRUNC, without the calls that are in this macro.
constexpr unsigned new_file = 0x0002;
constexpr haddr_t most_bytes = haddr_t{1} << 62U;

// The library's record of a file; the part of the library itself comes first.
struct SinkFile {
  H5FD_t common{};
  FileSink* sink = nullptr;
  haddr_t end_of_space = 0;
  haddr_t end_of_file = 0;
};
static_assert(offsetof(SinkFile, common) == 0);

SinkFile& of(H5FD_t* file) { return *reinterpret_cast<SinkFile*>(file); }
const SinkFile& of(const H5FD_t* file) { return *reinterpret_cast<const SinkFile*>(file); }

H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
  const void* sink = BISS_HDF5(H5Pget_driver_info)(access);
  if (sink == nullptr) return nullptr;
  auto* file = new SinkFile;
  file->sink = *static_cast<FileSink* const*>(sink);
  return &file->common;
}

herr_t close_file(H5FD_t* file) {
  delete &of(file);
  return 0;
}

// As in the library's own driver of files: metadata and small data are written in larger pieces.
herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t end_of_space(const H5FD_t* file, H5FD_mem_t) { return of(file).end_of_space; }

herr_t set_end_of_space(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  of(file).end_of_space = end;
  return 0;
}

haddr_t end_of_file(const H5FD_t* file, H5FD_mem_t) { return of(file).end_of_file; }

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* to) {
  of(file).sink->read_at(at, std::span(static_cast<std::byte*>(to), size));
  return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* from) {
  SinkFile& to = of(file);
  to.sink->write_at(at, std::span(static_cast<const std::byte*>(from), size));
  to.end_of_file = std::max(to.end_of_file, at + size);
  return 0;
}

// The last space of a file may have been allocated and not written.
herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  SinkFile& to = of(file);
  if (to.end_of_file >= to.end_of_space) return 0;
  const std::byte last{};
  to.sink->write_at(to.end_of_space - 1, std::span(&last, 1));
  to.end_of_file = to.end_of_space;
  return 0;
}

const H5FD_class_t& driver() {
  static const H5FD_class_t made = [] {
    H5FD_class_t driver{};
    driver.name = "biss";
    driver.maxaddr = most_bytes;
    driver.fc_degree = H5F_CLOSE_STRONG;
    driver.fapl_size = sizeof(FileSink*);
    driver.open = open_file;
    driver.close = close_file;
    driver.query = query;
    driver.get_eoa = end_of_space;
    driver.set_eoa = set_end_of_space;
    driver.get_eof = end_of_file;
    driver.read = read;
    driver.write = write;
    driver.truncate = truncate;
    const H5FD_mem_t one_kind[] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(one_kind), std::end(one_kind), std::begin(driver.fl_map));
    return driver;
  }();
  return made;
}

}  // namespace

Hdf5Id create_hdf5_file(FileSink& sink) {
  if (!load_hdf5()) return {};
  BISS_HDF5(H5Eset_auto2)(H5E_DEFAULT, nullptr, nullptr);
  static const hid_t registered = BISS_HDF5(H5FDregister)(&driver());
  const Hdf5Id access(BISS_HDF5(H5Pcreate)(BISS_HDF5(H5P_CLS_FILE_ACCESS_ID_g)),
                      BISS_HDF5(H5Pclose));
  const Hdf5Id creation(BISS_HDF5(H5Pcreate)(BISS_HDF5(H5P_CLS_FILE_CREATE_ID_g)),
                        BISS_HDF5(H5Pclose));
  FileSink* const target = &sink;
  const bool ready = BISS_HDF5(H5Pset_driver)(access.get(), registered, &target) >= 0 &&
                     BISS_HDF5(H5Pset_userblock)(creation.get(), hdf5_user_bytes) >= 0 &&
                     // No times: the same rows give the same file.
                     BISS_HDF5(H5Pset_obj_track_times)(creation.get(), false) >= 0;
  if (!ready) return {};
  return {BISS_HDF5(H5Fcreate)("table", new_file, creation.get(), access.get()),
          BISS_HDF5(H5Fclose)};
}

}  // namespace biss::report
