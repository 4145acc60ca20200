#include "biss/control/register_map.hpp"

#include "biss/base/big_endian.hpp"
#include "tests/core/test.hpp"

namespace biss::register_map_test {

// Read from an iC-MHM (AN22): BSEL 0, EDS in bank 2, profile BP3 with 30 bits, no serial number,
// "MHM#D", "iC".
constexpr std::array<std::uint8_t, 8> mhm_device{0x00, 0x02, 0x62, 0x1E, 0xFF, 0xFF, 0xFF, 0xFF};
constexpr std::array<std::uint8_t, 8> mhm_identity{0x4D, 0x48, 0x4D, 0x23, 0x44, 0x00, 0x69, 0x43};

static_assert(from_big_endian(std::span<const std::uint8_t, 8>(mhm_identity)) ==
              0x4D48'4D23'4400'6943U);
static_assert(device_identity(mhm_identity) == DeviceIdentity{0x4D48'4D23'4400U, 0x6943});

BISS_TEST(RegisterMap, Fields_CoverEveryAddressOnce) {
  unsigned next = 0;
  for (const RegisterField& field : register_fields) {
    BISS_EXPECT_EQ(field.address, next);
    for (unsigned i = 0; i < field.bytes; ++i) {
      BISS_EXPECT(register_field(next + i).name == field.name);
    }
    next += field.bytes;
  }
  BISS_EXPECT_EQ(next, 128);
  BISS_EXPECT(register_field(0x40).name == "BSEL" && register_field(0x43).name == "BP_ID");
  BISS_EXPECT(register_field(0x47).name == "DEV_SN" && register_field(0x78).name == "DEV_ID");
  BISS_EXPECT(register_field(0x7F).name == "MFR_ID" && register_field(0x3F).name == "BANK");
  BISS_EXPECT(register_field(0x77).name == "FREE" && register_field(500).name == "MFR_ID");
}

BISS_TEST(RegisterMap, RegistersOfARealDevice_AreRead) {
  const DeviceRegisters device = device_registers(mhm_device);
  BISS_EXPECT_EQ(device.bsel, 0);
  BISS_EXPECT_EQ(device.eds_bank, 2);
  BISS_EXPECT_EQ(device.profile, 0x621E);
  BISS_EXPECT(!device.serial.has_value());
  const DeviceIdentity identity = device_identity(mhm_identity);
  BISS_EXPECT_EQ(identity.device, 0x4D48'4D23'4400U);
  BISS_EXPECT(manufacturer_name(identity.manufacturer) == "iC-Haus");
  BISS_EXPECT(manufacturer_name(0x4C69) == "Lika");
  BISS_EXPECT(!manufacturer_name(0).has_value() && !manufacturer_name(0x4369).has_value());
}

BISS_TEST(RegisterMap, SerialNumbers_AreBigEndianAndMayBeAbsent) {
  const auto serial = [](std::array<std::uint8_t, 4> bytes) { return serial_number(bytes); };
  BISS_EXPECT(serial({1, 2, 3, 4}) == 0x0102'0304U);
  BISS_EXPECT(serial({0xFF, 0xFF, 0xFF, 0xFE}) == 0xFFFF'FFFEU && serial({0, 0, 0, 1}) == 1U);
  BISS_EXPECT(!serial({0, 0, 0, 0}) && !serial({0xFF, 0xFF, 0xFF, 0xFF}));
}

BISS_TEST(RegisterMap, EdsBank_MayBeDoubtful) {
  BISS_EXPECT(eds_presence(0) == EdsPresence::none);
  BISS_EXPECT(eds_presence(0xFF) == EdsPresence::doubtful);
  for (unsigned bank = 1; bank < 0xFF; ++bank) {
    BISS_EXPECT(eds_presence(static_cast<std::uint8_t>(bank)) == EdsPresence::present);
  }
}

BISS_TEST(RegisterMap, Quirks_LieWhereTheySay) {
  for (const VendorRegister& row : map_quirks) {
    BISS_EXPECT(row.first >= reg::bsel && row.last < reg::free && row.first <= row.last);
    BISS_EXPECT(row.contains(row.first) && row.contains(row.last) && !row.contains(row.last + 1U));
    BISS_EXPECT(!row.vendor.empty() && !row.meaning.empty());
  }
}

BISS_TEST(BigEndian, NumbersAndBytes_AreEachOthersInverse) {
  BISS_RANDOM(random, 0xB16E);
  for (unsigned round = 0; round < 100; ++round) {
    const std::uint64_t number = random.next();
    const auto eight = to_big_endian<8>(number);
    BISS_EXPECT_EQ(from_big_endian(std::span<const std::uint8_t, 8>(eight)), number);
    BISS_EXPECT_EQ(eight[0], number >> 56U);
    const auto three = to_big_endian<3>(number);
    BISS_EXPECT(std::equal(three.begin(), three.end(), eight.begin() + 5));
    BISS_EXPECT_EQ(from_big_endian(std::span<const std::uint8_t, 3>(three)), number & 0xFF'FFFFU);
  }
}

}  // namespace biss::register_map_test
