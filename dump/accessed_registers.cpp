#include "dump/accessed_registers.hpp"

#include "biss/control/register_map.hpp"

namespace biss::dump {

void AccessedRegisters::take(Access access, unsigned address, std::uint8_t byte) {
  if (address == reg::bsel) {
    if (access == Access::read && !bank_) found_bank(byte);
    bank_ = byte;
    waiting_ = {};
  }
  if (address >= first_direct || bank_) {
    dump_.at(bank_.value_or(0), address) = byte;
  } else {
    dump_.without_bank += waiting_[address] ? 0U : 1U;
    waiting_[address] = byte;
  }
}

void AccessedRegisters::take_uncertain_write(unsigned address) {
  if (address != reg::bsel) return;
  bank_.reset();
  waiting_ = {};
}

void AccessedRegisters::found_bank(std::uint8_t bank) {
  for (unsigned address = 0; address < bank_bytes; ++address) {
    if (!waiting_[address]) continue;
    dump_.at(bank, address) = waiting_[address];
    --dump_.without_bank;
  }
}

}  // namespace biss::dump
