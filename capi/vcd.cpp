// biss_vcd: a VCD file, written as it goes. It uses the C library alone, because capture/ would
// link its readers too.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cinttypes>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "capi/biss_c_sim.h"
#include "capi/device.hpp"

namespace biss::capi {
namespace {

struct Vcd {
  Vcd(std::FILE* to, std::size_t signals) : file(to), count(signals) { levels.fill(true); }

  std::FILE* file;
  std::size_t count;
  std::array<bool, BISS_VCD_SIGNALS> levels;
  std::int64_t last = 0;
  int error = 0;  // errno of the first failure
};

// The identifiers are the first printable characters.
char id_of(std::size_t signal) { return static_cast<char>('!' + signal); }
static_assert(BISS_VCD_SIGNALS <= '~' - '!');

void put_name(std::FILE* file, const char* name) {
  for (const char* at = name; *at != '\0'; ++at) {
    const auto byte = static_cast<unsigned char>(*at);
    std::fputc(byte <= 0x20 || byte == 0x7F ? '_' : byte, file);
  }
}

void put_header(std::FILE* file, const char* const* names, std::size_t count) {
  std::fputs("$timescale 1ps $end\n$scope module biss $end\n", file);
  for (std::size_t k = 0; k < count; ++k) {
    std::fprintf(file, "$var wire 1 %c ", id_of(k));
    put_name(file, names[k]);
    std::fputs(" $end\n", file);
  }
  std::fputs("$upscope $end\n$enddefinitions $end\n#0\n", file);
  for (std::size_t k = 0; k < count; ++k) std::fprintf(file, "1%c\n", id_of(k));
}

bool are_names(const char* const* names, std::size_t count) {
  return std::all_of(names, names + count,
                     [](const char* name) { return name != nullptr && *name != '\0'; });
}

void put_time(Vcd& vcd, std::int64_t time) {
  if (time == vcd.last) return;
  vcd.last = time;
  std::fprintf(vcd.file, "#%" PRId64 "\n", time);
}

// \return false: the file cannot be written, and errno has the reason
bool is_written(Vcd& vcd) {
  if (std::ferror(vcd.file) == 0) return true;
  if (vcd.error == 0) vcd.error = errno;
  errno = vcd.error;
  return false;
}

}  // namespace

extern "C" {

biss_status biss_vcd_init(biss_vcd* vcd, const char* path, const char* const* names, size_t count) {
  if (const auto wrong = begin_init(vcd, path, names)) return wrong;
  if (count < 1 || count > BISS_VCD_SIGNALS || !are_names(names, count)) return BISS_BAD_SETUP;
  std::FILE* file = std::fopen(path, "wb");
  if (file == nullptr) return BISS_FILE;
  put_header(file, names, count);
  if (std::ferror(file) == 0) return make<Vcd>(vcd, file, count);
  const int error = errno;
  std::fclose(file);
  errno = error;
  return BISS_FILE;
}

biss_status biss_vcd_put(biss_vcd* vcd, int64_t time_ps, size_t signal, bool level) {
  if (const auto wrong = check_call(vcd)) return wrong;
  Vcd& self = thing<Vcd>(vcd);
  if (signal >= self.count) return BISS_BAD_SETUP;
  if (time_ps < 0 || time_ps > BISS_TIME_MAX) return BISS_TIME_RANGE;
  if (time_ps < self.last) return BISS_TIME_BACKWARDS;
  if (self.levels[signal] == level) return BISS_OK;
  self.levels[signal] = level;
  put_time(self, time_ps);
  std::fprintf(self.file, "%c%c\n", level ? '1' : '0', id_of(signal));
  return is_written(self) ? BISS_OK : BISS_FILE;
}

biss_status biss_vcd_close(biss_vcd* vcd, int64_t time_ps) {
  if (vcd == nullptr) return BISS_OK;
  if (!is_open(vcd)) return BISS_BAD_HANDLE;
  Vcd& self = thing<Vcd>(vcd);
  const bool in_range = time_ps >= 0 && time_ps <= BISS_TIME_MAX;
  if (in_range && time_ps > self.last) put_time(self, time_ps);
  const bool written = is_written(self);
  int error = self.error;
  const bool closed = std::fclose(self.file) == 0;
  if (written && !closed) error = errno;
  vcd->mark = 0;
  if (!written || !closed) {
    errno = error;
    return BISS_FILE;
  }
  return in_range ? BISS_OK : BISS_TIME_RANGE;
}

}  // extern "C"

}  // namespace biss::capi
