// The functions of simulators/testbench.h for GHDL, by VHPIDIRECT: its strings, its time in
// femtoseconds, its std_logic. simulators/vhdl/biss_pkg.vhd declares them.
#include <cstdint>
#include <limits>
#include <string>

#include "simulators/testbench.h"

namespace {

// A string as GHDL passes it: its characters and its bounds.
struct GhdlBounds {
  std::int32_t left;
  std::int32_t right;
  std::uint8_t downto;
  std::uint32_t length;
};
struct GhdlString {
  const char* characters;
  const GhdlBounds* bounds;
};

std::string text_of(const GhdlString* text) { return {text->characters, text->bounds->length}; }

constexpr std::int64_t fs_per_ps = 1'000;

std::int64_t as_time(long long deadline_ps) {
  if (deadline_ps < 0 || deadline_ps > std::numeric_limits<std::int64_t>::max() / fs_per_ps) {
    return std::numeric_limits<std::int64_t>::max();
  }
  return deadline_ps * fs_per_ps;
}

// The places of '0', '1', 'L' and 'H' in std_ulogic.
constexpr unsigned char std_0 = 2;
constexpr unsigned char std_1 = 3;
constexpr unsigned char std_l = 6;
constexpr unsigned char std_h = 7;

}  // namespace

extern "C" {

#pragma GCC visibility push(default)

int biss_ghdl_encoder(const GhdlString* name, const GhdlString* settings) {
  return biss_tb_encoder(text_of(name).c_str(), text_of(settings).c_str());
}

int biss_ghdl_master(const GhdlString* name, const GhdlString* settings) {
  return biss_tb_master(text_of(name).c_str(), text_of(settings).c_str());
}

// The next call, as a time; time'high: none.
std::int64_t biss_ghdl_step_encoder(std::int32_t id, std::int64_t now_fs, std::int32_t ma) {
  return as_time(biss_tb_step_encoder(id, now_fs / fs_per_ps, ma));
}

std::int64_t biss_ghdl_step_master(std::int32_t id, std::int64_t now_fs, std::int32_t slo,
                                   std::int32_t request) {
  return as_time(biss_tb_step_master(id, now_fs / fs_per_ps, slo, request));
}

// `position` has 64 bits, the highest first.
void biss_ghdl_value(const GhdlString* name, std::int32_t channel, const unsigned char* position,
                     std::int32_t nE, std::int32_t nW, std::int32_t is_next) {
  std::uint64_t bits = 0;
  bool known = nE >= 0 && nW >= 0;
  for (int k = 0; k < 64; ++k) {
    const unsigned char bit = position[k];
    const bool one = bit == std_1 || bit == std_h;
    known = known && (one || bit == std_0 || bit == std_l);
    bits = bits << 1U | (one ? 1U : 0U);
  }
  const auto number = static_cast<long long>(bits);
  const std::string text = text_of(name);
  if (is_next != 0) {
    biss_tb_next(text.c_str(), channel, number, known ? nE : -1, nW);
  } else {
    biss_tb_value(text.c_str(), channel, number, known ? 1 : 0, nE == 1, nW == 1);
  }
}

void biss_ghdl_compare(const GhdlString* name, const GhdlString* cause) {
  biss_tb_compare(text_of(name).c_str(), text_of(cause).c_str());
}

int biss_ghdl_report(const GhdlString* path) { return biss_tb_report(text_of(path).c_str()); }

#pragma GCC visibility pop

}  // extern "C"
