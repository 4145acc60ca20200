#include "capture/vcd_words.hpp"

#include <algorithm>
#include <utility>

namespace biss::capture {

VcdIds::VcdIds() : slots_(64) { one_.fill(none); }

bool VcdIds::valid(std::string_view id) {
  return !id.empty() &&
         std::all_of(id.begin(), id.end(), [](char c) { return place(c) < letters; });
}

std::uint64_t VcdIds::pack(std::string_view id) {
  std::uint64_t key = 0;
  for (const char c : id) key = key << 8U | static_cast<unsigned char>(c);
  return key;
}

// The slot of `key`, or the free slot in which it belongs.
std::size_t VcdIds::slot_of(std::uint64_t key) const {
  const std::size_t mask = slots_.size() - 1;
  auto at = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 20U) & mask;
  while (slots_[at].number != none && slots_[at].key != key) at = (at + 1) & mask;
  return at;
}

void VcdIds::grow_slots() {
  const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(slots_.size() * 2));
  for (const Slot& slot : old) {
    if (slot.number != none) slots_[slot_of(slot.key)] = slot;
  }
}

std::uint32_t VcdIds::add_packed(std::uint64_t key) {
  Slot* slot = &slots_[slot_of(key)];
  if (slot->number != none) return slot->number;
  if (++slots_used_ * 2 > slots_.size()) {
    grow_slots();
    slot = &slots_[slot_of(key)];
  }
  *slot = {key, size_};
  return size_++;
}

std::uint32_t VcdIds::add(std::string_view id) {
  if (id.size() > packed_chars) {
    const auto [entry, added] = long_.try_emplace(std::string(id), size_);
    if (added) ++size_;
    return entry->second;
  }
  if (id.size() > 2) return add_packed(pack(id));
  if (two_.empty() && id.size() == 2) two_.assign(std::size_t{letters} * letters, none);
  std::uint32_t& entry = id.size() == 1 ? one_[static_cast<unsigned char>(id[0])]
                                        : two_[place(id[0]) * letters + place(id[1])];
  if (entry == none) entry = size_++;
  return entry;
}

std::uint32_t VcdIds::find(std::string_view id) const {
  if (id.empty()) return none;
  if (id.size() == 1) return find_one(id[0]);
  if (id.size() == 2) return find_two(id.data());
  // A leading NUL would pack like the shorter identifier after it.
  if (id.size() <= packed_chars) return id[0] == 0 ? none : slots_[slot_of(pack(id))].number;
  const auto entry = long_.find(id);
  return entry == long_.end() ? none : entry->second;
}

}  // namespace biss::capture
