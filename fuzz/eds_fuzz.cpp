// Data sheets of any bytes: parts are rebuilt as they were parsed, findings name existing fields
// and values, and the derived device is possible.
//
// Input: what is present (bit 0 the common part, 1 the number of its bank, 2 identifiers, 3 and 4
// corrected checksums of common part and profiles, 5…7 overrides), the profiles, the options of
// checking and describing, the bank of the common part. The next byte selects the channels with an
// identifier of two bytes. For each override part and channel, field, value. Then the banks, 64
// bytes each.
#include "biss/eds/check.hpp"
#include "biss/eds/device.hpp"
#include "biss/frame/format_text.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

struct Input {
  EdsBank common{};
  std::array<EdsBank, max_channels> profiles{};
  EdsImage image{};
  EdsCheckOptions check{};
  std::vector<EdsOverride> overrides{};
  bool common_sealed = false;
  bool profiles_sealed = false;
};

// A symbol is from the tables, sometimes empty.
EdsOverride read_override(ByteSource& bytes) {
  const std::uint8_t where = bytes.next();
  EdsOverride made;
  made.part = (where & 1U) != 0 ? EdsPart::bp3 : EdsPart::common;
  made.channel = static_cast<std::uint8_t>(where >> 1U & 0xFU);
  const auto fields = fields_of(made.part);
  const std::size_t row = bytes.next();
  made.symbol = row == 0xFF ? "NONE" : fields[row % fields.size()].symbol;
  const unsigned size = row == 0xFF ? 1U : fields[row % fields.size()].bytes + (where >> 7U);
  for (unsigned i = 0; i < size && i < 4; ++i) made.value = made.value << 8U | bytes.next();
  return made;
}

void read_options(ByteSource& bytes, Input& input) {
  const std::uint8_t check = bytes.next();
  input.check = {.zero_is_absent = (check & 1U) == 0,
                 .ones_are_absent = (check & 2U) == 0,
                 .unnamed_zero = (check & 8U) != 0};
  bytes.next();  // the seeds have a byte here that is not used
}

void read_input(ByteSource bytes, Input& input) {
  const std::uint8_t flags = bytes.next();
  const std::uint8_t present = bytes.next();
  read_options(bytes, input);
  EdsImage& image = input.image;
  const std::uint8_t eds_bank = bytes.next();
  if ((flags & 2U) != 0) image.eds_bank = eds_bank;
  const std::uint8_t identified = (flags & 4U) != 0 ? bytes.next() : std::uint8_t{0};
  for (std::size_t i = 0; i < max_channels; ++i) {
    if ((identified >> i & 1U) != 0) image.identifiers[i] = bytes.next_16();
  }
  for (unsigned i = 0; i < flags >> 5U; ++i) input.overrides.push_back(read_override(bytes));
  input.common_sealed = (flags & 8U) != 0;
  input.profiles_sealed = (flags & 16U) != 0;
  const auto read_bank = [&](EdsBank& bank, bool seal) {
    bytes.fill(bank);
    if (seal) bank = sealed(bank);
    return &bank;
  };
  if ((flags & 1U) != 0) image.common = read_bank(input.common, input.common_sealed);
  for (std::size_t i = 0; i < max_channels; ++i) {
    if ((present >> i & 1U) == 0) continue;
    image.profiles[i] = read_bank(input.profiles[i], input.profiles_sealed);
  }
}

// A profile of unknown layout has only these two fields.
bool is_raw_symbol(std::string_view symbol) {
  return symbol == "BP_VER" || symbol == "BP_ID" || symbol == "CHKSUM";
}

const EdsBank& bank_of(const EdsImage& image, EdsPart part, std::size_t channel) {
  require(channel < max_channels);
  const EdsBank* bank = part == EdsPart::common ? image.common : image.profiles[channel];
  require(bank != nullptr);
  return *bank;
}

bool known_anywhere(std::string_view symbol) {
  return find_field(common_fields, symbol) != nullptr || find_field(bp3_fields, symbol) != nullptr;
}

void check_finding(const EdsImage& image, const EdsFinding& found) {
  const EdsBank& bank = bank_of(image, found.part, found.channel);
  require(!name_of(found.problem).empty() && !text_of(found.problem).empty());
  require(found.against.empty() || known_anywhere(found.against));
  if (found.part == EdsPart::raw) {
    require(is_raw_symbol(found.symbol));
  } else {
    require(found.part != EdsPart::common || found.channel == 0);
    require(found.part == EdsPart::common || profile_part(image, found.channel) == EdsPart::bp3);
    const EdsField* field = find_field(fields_of(found.part), found.symbol);
    require(field != nullptr && found.value == field_value(bank, *field));
  }
  if (found.problem == EdsProblem::checksum) {
    require(found.value != found.expected && found.expected == eds_checksum(bank));
  }
}

/// Whether the checks report no finding.
bool check_findings(const Input& input) {
  std::vector<EdsFinding> all;
  check_eds(
      input.image,
      [&](const EdsFinding& found) {
        check_finding(input.image, found);
        for (const EdsFinding& other : all) {
          require(other.part != found.part || other.channel != found.channel ||
                  other.symbol != found.symbol || other.problem != found.problem);
        }
        require(found.problem != EdsProblem::checksum ||
                !(found.part == EdsPart::common ? input.common_sealed : input.profiles_sealed));
        all.push_back(found);
      },
      input.check);
  require(all.size() < 64 * (1 + max_channels));
  return all.empty();
}

void check_codecs(const Input& input) {
  const auto check = [](const EdsBank& bank) {
    require(build_bank(parse_common_part(bank)) == bank);
    require(build_bank(parse_bp3_part(bank)) == bank);
    for (const auto fields :
         {std::span<const EdsField>(common_fields), std::span<const EdsField>(bp3_fields)}) {
      EdsBank built{};
      for (const EdsField& field : fields) {
        require(set_field(built, field, field_value(bank, field)));
      }
      require(built == bank);
    }
    const EdsBank good = sealed(bank);
    require(good[eds_checksum_address] == eds_checksum(good));
  };
  check(input.common);
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (input.image.profiles[i] != nullptr) check(input.profiles[i]);
  }
}

// The fields of a channel lie within its data and do not overlap.
void check_channel(const ChannelFormat& channel) {
  require(channel.data_bits >= 1 && channel.data_bits <= max_data_bits);
  std::uint64_t taken = 0;
  const auto take = [&](unsigned shift, unsigned bits) {
    if (bits == 0) return;
    require(shift + bits <= channel.data_bits);
    const std::uint64_t mask = low_mask(bits) << shift;
    require((taken & mask) == 0);
    taken |= mask;
  };
  take(channel.position.shift, channel.position.bits);
  take(channel.multiturn.shift, channel.multiturn.bits);
  take(channel.singleturn.shift, channel.singleturn.bits);
  take(channel.error.shift, channel.error.present ? 1 : 0);
  take(channel.warning.shift, channel.warning.present ? 1 : 0);
  take(channel.life_counter.shift, channel.life_counter.bits);
  require(!channel.position.present() || channel.position_bits() == channel.position.bits);
  require(channel.crc.present() || channel.crc == CrcSpec{});
}

void check_timing(const EdsDevice& device) {
  const DeviceTiming& timing = device.timing;
  require(timing.clock_min.count > 0 && timing.clock_min <= timing.clock_max &&
          timing.clock_max <= biss_clock_max);
  require(timing.ack_max.count > 0 && timing.ack_max <= biss_busy_max);
  require(timing.timeout.time.count > 0 && timing.timeout.rule != TimeoutRule::cycle);
  require(timing.timeout.rule == TimeoutRule::adaptive ||
          timing.timeout.time <= biss_static_timeout_max);
  require(timing.cycle_min.count >= 0 && device.busy_s_clocks <= biss_busy_s_max_clocks);
  for (const Hertz clock : {timing.clock_min, timing.clock_max}) {
    const DeviceTiming there = timing_at(device, clock);
    require(there.ack_max >= timing.ack_max && there.ack_max <= biss_busy_max);
    const AckBounds bounds = ack_bounds(there, period_of(clock));
    require(bounds.min_clocks >= 1 && bounds.min_clocks <= bounds.max_clocks);
  }
}

void check_device(const EdsDevice& device) {
  require(device.format.channel_count >= 1 && device.format.channel_count <= max_channels);
  for (const ChannelFormat& channel : device.format.channels()) check_channel(channel);
  const auto text = format_text(device.format);
  const auto again = parse_format(text.view());
  require(again.ok() && *again == device.format);
  check_timing(device);
}

struct Said {
  std::size_t overridden = 0;
  bool contradicts = false;
};

void check_remark(const EdsImage& image, const EdsRemark& remark, Said& said) {
  require(!text_of(remark.kind).empty());
  require(known_anywhere(remark.symbol));
  require(remark.channel < max_channels || remark.kind == EdsRemarkKind::overridden);
  said.overridden += remark.kind == EdsRemarkKind::overridden ? 1U : 0U;
  said.contradicts = said.contradicts || remark.kind == EdsRemarkKind::disagrees ||
                     remark.kind == EdsRemarkKind::repaired ||
                     remark.kind == EdsRemarkKind::undivided;
  if (remark.kind == EdsRemarkKind::disagrees) require(remark.stored != remark.used);
  if (remark.kind == EdsRemarkKind::repaired) require(remark.stored != remark.used);
  if (remark.kind == EdsRemarkKind::hypothesis)
    require(image.common || remark.part == EdsPart::raw);
}

// Whether every channel has its own BP3 part, and the common part declares this.
bool is_whole(const EdsImage& image) {
  if (image.common == nullptr || channel_count(image) == 0) return false;
  for (std::size_t i = 0; i < channel_count(image); ++i) {
    if (image.profiles[i] == nullptr || profile_part(image, i) != EdsPart::bp3) return false;
  }
  return true;
}

void check_description(const Input& input, bool faultless) {
  Said said;
  const auto listen = [&](const EdsRemark& remark) { check_remark(input.image, remark, said); };
  const auto device = describe_device(input.image, input.overrides, listen);
  if (!device.ok()) {
    const EdsDeviceError error = device.error();
    const bool by_override = error.cause == EdsDeviceCause::unknown_override ||
                             error.cause == EdsDeviceCause::override_unread;
    require(error.index < (by_override ? input.overrides.size() : max_channels));
    require(!text_of(error.cause).empty());
  } else {
    require(said.overridden == input.overrides.size());
    check_device(*device);
  }
  // A data sheet without findings is described without any repair.
  if (faultless && input.overrides.empty() && is_whole(input.image)) {
    require(device.ok() && !said.contradicts);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input;
  read_input(ByteSource(data, size), input);
  check_codecs(input);
  check_description(input, check_findings(input));
  return 0;
}
