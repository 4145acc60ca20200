// The record of an encoder in the flash of the nRF51, which QEMU models with its controller.
#include <bit>
#include <cstdint>
#include <optional>

#include "biss/configure/encoder_record.hpp"
#include "firmware/boards/cortex_m.hpp"
#include "firmware/boards/nrf51/flash_record.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"

namespace {

using biss::RecordError;
constexpr std::uint32_t page = 0x3'FC00;  // the last one
using Flash = boards::Nrf51FlashRecord<page>;

biss::RecordBytes record_with(std::uint32_t serial) {
  biss::SlaveDescription slave;
  slave.serial = serial;
  return std::bit_cast<biss::RecordBytes>(biss::record_of(slave, {}));
}

// Whether the flash has the record of this encoder, or this is why it has none.
bool has(std::uint32_t serial, std::optional<RecordError> error) {
  biss::RecordBytes bytes{};
  Flash::load(bytes);
  const auto record = biss::read_record(bytes);
  if (!record.ok()) return error == record.error();
  return !error && bytes == record_with(serial);
}

bool keeps() {
  // The flash of QEMU begins with zeros.
  if (!has(0, RecordError::magic)) return false;
  Flash::store(record_with(4711));
  if (!has(4711, std::nullopt)) return false;
  // A flash only clears bits, so this one needs an erased page.
  Flash::store(record_with(0x8000'0001));
  if (!has(0x8000'0001, std::nullopt)) return false;
  // The controller is off: nothing can write to the page.
  boards::at(page + 24) = 0;
  return has(0x8000'0001, std::nullopt);
}

}  // namespace

int firmware_main() {
  const bool good = keeps();
  firmware::write(good ? "kept\n" : "FAILED\n");
  return good ? 0 : 1;
}
