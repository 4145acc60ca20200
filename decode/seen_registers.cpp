#include "decode/seen_registers.hpp"

#include <algorithm>

#include "biss/eds/check.hpp"

namespace biss::decode {

void SeenRegisters::take(const SeenAccess& access) {
  const bool written = access.kind == SeenAccess::Kind::write;
  const bool selects = access.address == reg::bsel;
  if (!written && access.kind != SeenAccess::Kind::read) return;
  if (access.outcome != AccessOutcome::ok || !access.data) {
    const bool untouched = access.outcome == AccessOutcome::no_answer ||
                           access.outcome == AccessOutcome::no_such_slave ||
                           access.outcome == AccessOutcome::refused_or_not_addressed;
    if (written && selects && !untouched) selected_.reset();
    return;
  }
  if (selects) selected_ = access.data;
  if (access.address >= reg::bsel) {
    bytes_[direct_begin + access.address - reg::bsel] = access.data;
  } else if (selected_) {
    bytes_[*selected_ * bank_bytes + access.address] = access.data;
  }
}

std::optional<std::uint16_t> SeenRegisters::identifier() const {
  const auto high = direct(reg::bp_id);
  const auto low = direct(reg::bp_id + 1U);
  if (!high || !low) return std::nullopt;
  return static_cast<std::uint16_t>(*high << 8U | *low);
}

std::optional<EdsBank> SeenRegisters::bank(unsigned number) const {
  EdsBank whole{};
  for (std::size_t i = 0; i < bank_bytes; ++i) {
    const auto& byte = bytes_[number * bank_bytes + i];
    if (!byte) return std::nullopt;
    whole[i] = *byte;
  }
  return whole;
}

std::optional<SeenRegisters::EdsJudgement> SeenRegisters::judge_eds() const {
  const auto number = direct(reg::eds_bank);
  if (!number || *number == 0) return std::nullopt;
  const auto common = bank(*number);
  if (!common) return std::nullopt;
  const CommonPart part = parse_common_part(*common);
  std::array<std::optional<EdsBank>, max_channels> profiles;
  EdsImage image;
  image.common = &*common;
  image.eds_bank = number;
  for (std::size_t i = 0; i < std::min<std::size_t>(part.dc_num, max_channels); ++i) {
    if (part.channels[i].bank == *number) continue;
    profiles[i] = bank(part.channels[i].bank);
    if (profiles[i]) image.profiles[i] = &*profiles[i];
  }
  const auto stated = identifier();
  if (stated && *stated != 0)
    image.identifiers[part.sl_off < max_channels ? part.sl_off : 0] = stated;
  EdsJudgement judged;
  check_eds(image, [&](const EdsFinding& found) {
    if (judged.findings++ == 0) judged.first = found;
  });
  return judged;
}

}  // namespace biss::decode
