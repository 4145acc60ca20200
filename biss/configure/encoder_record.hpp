// A record for flash of one encoder: its identity and its data sheet, byte by byte. Format and timing
// are derived from it at each start, by the rules that hold for an encoder on the line. No struct of
// the core is stored, so the record survives new firmware.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/base/big_endian.hpp"
#include "biss/base/result.hpp"
#include "biss/configure/configurator.hpp"

namespace biss {

/// Why bytes are not a record: the first cause that applies.
enum class RecordError : std::uint8_t {
  erased,    ///< all ones: nothing was stored, or power failed after the flash was erased
  magic,     ///< something else is stored, or these bytes are damaged
  version,   ///< another layout, or a damaged number
  length,    ///< as `version`
  checksum,  ///< damaged, or power failed while it was written
};

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(RecordError error) {
  constexpr std::string_view names[] = {"erased", "magic", "version", "length", "checksum"};
  return names[static_cast<std::size_t>(error)];
}

/// The bytes in flash, without padding.
struct EncoderRecord {
  BigEndian<std::uint32_t> magic = 0x4269'5353;  // "BiSS"
  BigEndian<std::uint16_t> version = 1;
  BigEndian<std::uint16_t> length = 156;
  /// Registers 0x78 to 0x7F, 0x44 to 0x47, 0x42 and 0x43, 0x41; 0: the encoder has none.
  BigEndian<std::uint64_t> identity = 0;
  BigEndian<std::uint32_t> serial = 0;
  BigEndian<std::uint16_t> profile = 0;
  std::uint8_t eds_bank = 0;
  /// The parts of the data sheet that are present and sound: 0 none, 1 common, 2 channel as well.
  std::uint8_t parts = 0;
  EdsBank common{};
  EdsBank channel{};
  /// CRC-32 of Ethernet over all bytes before it. It detects every fault within 32 bits, and does
  /// not detect one in 2^32 of all others.
  BigEndian<std::uint32_t> crc = 0;
};

using RecordBytes = std::array<std::uint8_t, sizeof(EncoderRecord)>;
static_assert(sizeof(EncoderRecord) == std::uint16_t{EncoderRecord{}.length});

/// The checksum that belongs in the record. It ignores the one that is there.
constexpr std::uint32_t record_crc(const RecordBytes& bytes) {
  std::uint32_t reg = 0xFFFF'FFFF;
  for (std::size_t i = 0; i < 8 * (bytes.size() - 4); ++i) {
    const bool one = ((reg ^ unsigned{bytes[i / 8]} >> i % 8) & 1U) != 0;
    reg = reg >> 1U ^ (one ? 0xEDB8'8320U : 0U);
  }
  return ~reg;
}

/// \param image of the slave's data sheet: Configurator::image()
constexpr EncoderRecord record_of(const SlaveDescription& slave, const EdsImage& image) {
  EncoderRecord record;
  const DeviceIdentity identity = slave.identity.value_or(DeviceIdentity{});
  record.identity = identity.device << 16U | identity.manufacturer;
  record.serial = slave.serial.value_or(0);
  record.profile = slave.profile.value_or(0);
  record.eds_bank = slave.eds_bank;
  record.parts = image.common == nullptr ? 0 : image.profiles[0] == nullptr ? 1 : 2;
  if (record.parts >= 1) record.common = *image.common;
  if (record.parts == 2) record.channel = *image.profiles[0];
  record.crc = record_crc(std::bit_cast<RecordBytes>(record));
  return record;
}

/// Whether the slave has the registers of the record.
constexpr bool is_of(const EncoderRecord& record, const SlaveDescription& slave) {
  const EncoderRecord other = record_of(slave, {});
  return record.identity == other.identity && record.serial == other.serial &&
         record.profile == other.profile && record.eds_bank == other.eds_bank;
}

constexpr Result<EncoderRecord, RecordError> read_record(const RecordBytes& bytes) {
  const auto record = std::bit_cast<EncoderRecord>(bytes);
  constexpr EncoderRecord good;
  unsigned all = 0xFF;
  for (const std::uint8_t byte : bytes) all &= byte;
  if (all == 0xFF) return failure(RecordError::erased);
  if (record.magic != good.magic) return failure(RecordError::magic);
  if (record.version != good.version) return failure(RecordError::version);
  if (record.length != good.length) return failure(RecordError::length);
  if (record.crc != record_crc(bytes)) return failure(RecordError::checksum);
  return record;
}

/// The configuration of a line with this encoder alone, as a Configurator gives it. A new EDS with
/// the same registers is not noticed: a maker gives an encoder with another frame another profile.
constexpr Result<Configuration, ConfigureFault> configuration_of(const EncoderRecord& record) {
  configure_detail::LineBuilder builder{{}};
  builder.config.slave_count = 1;
  builder.config.slave_list[0].profile = record.profile;
  builder.config.slave_list[0].eds_bank = record.eds_bank;
  EdsImage image{.common = &record.common, .eds_bank = record.eds_bank};
  if (record.parts == 2) image.profiles[0] = &record.channel;
  std::optional<ConfigureFault> fault;
  if (record.parts == 0) builder.add_profile(0, std::nullopt);
  if (record.parts != 0) fault = builder.add_eds(image, 0);
  if (!fault) fault = builder.finish();
  if (fault) return failure(*fault);
  return builder.config;
}

}  // namespace biss
