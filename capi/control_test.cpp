// Registers, commands and data sheets through the C interface: a master reads a simulated encoder.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "biss/eds/advise.hpp"
#include "biss/eds/common_part.hpp"
#include "capi/biss_c_control.h"
#include "capi/test_handles.hpp"

namespace biss::capi {
namespace control_test {

constexpr const char* format = "mt12,st20,nE,nW,crc6";
constexpr std::uint32_t clock_hz = 5'000'000;
constexpr std::int64_t period = 200'000;
constexpr std::int64_t interval = LineReader::interval;

using ControlHandle = Handle<biss_control>;

ControlHandle open_control(std::uint32_t retries = 0) {
  biss_control_setup setup = biss_control_defaults();
  setup.retries = retries;
  return opened(biss_control_init, setup);
}

// An encoder with registers, a master with a session.
class Link {
 public:
  explicit Link(const char* faults = nullptr, std::uint32_t retries = 0)
      : control_(open_control(retries)),
        line_(open_line(line_setup(faults))),
        reader_(line_.get(), master_setup(control_.get())) {}

  biss_control* control() const { return control_.get(); }
  biss_line* line() const { return line_.get(); }
  void put(std::uint32_t bank, std::uint32_t address, std::uint8_t value, bool writable = false) {
    EXPECT_EQ(biss_line_put_register(line_.get(), bank, address, value, writable), BISS_OK);
  }

  // Frames until the access is done. \return how many
  unsigned run() {
    unsigned frames = 0;
    while (!biss_control_done(control_.get()) && frames < 20'000) {
      request();
      ++frames;
    }
    return frames;
  }
  biss_control_outcome outcome() const {
    biss_control_outcome outcome{};
    EXPECT_EQ(biss_control_outcome_of(control_.get(), &outcome), BISS_OK);
    return outcome;
  }
  std::string error() const {
    const biss_control_outcome now = outcome();
    return now.error == nullptr ? "" : now.error;
  }
  std::vector<std::uint8_t> bytes() const {
    std::vector<std::uint8_t> bytes(64);
    std::size_t count = 0;
    EXPECT_EQ(biss_control_bytes(control_.get(), bytes.data(), bytes.size(), &count), BISS_OK);
    bytes.resize(count);
    return bytes;
  }
  biss_reading request() {
    const biss_reading reading = reader_.request();
    EXPECT_EQ(reader_.worst(), BISS_OK);
    return reading;
  }

 private:
  static biss_line_setup line_setup(const char* faults) {
    biss_line_setup setup = biss_line_defaults(named(format), clock_hz);
    setup.interval_ps = interval;
    setup.ma_delay_ps = setup.slo_delay_ps = 100'000;
    setup.registers = true;
    setup.faults = faults;
    return setup;
  }
  static biss_master_setup master_setup(biss_control* control) {
    biss_master_setup setup = biss_master_defaults(named(format), period);
    setup.control = control;
    return setup;
  }

  ControlHandle control_;
  LineHandle line_;
  LineReader reader_;
};

TEST(CControl, Registers_AreReadWhilePositionsComeIn) {
  Link link;
  link.put(0, 0x78, 'B');
  link.put(0, 0x79, 'I');
  ASSERT_EQ(biss_control_read(link.control(), 0, 0x78, 2), BISS_OK);
  EXPECT_FALSE(biss_control_done(link.control()));
  EXPECT_EQ(biss_control_read(link.control(), 0, 0x78, 2), BISS_RUNNING);
  EXPECT_EQ(link.request().cause, BISS_CAUSE_OK);
  // 14 zeros, 18 bits and 14 for each byte, and the last CDS.
  EXPECT_EQ(link.run() + 1U, 61U);
  EXPECT_EQ(link.error(), "");
  EXPECT_EQ(link.bytes(), (std::vector<std::uint8_t>{'B', 'I'}));
  EXPECT_EQ(link.outcome().devices_present, 1U);
  EXPECT_EQ(link.outcome().tries, 1U);
  std::uint8_t byte = 0;
  std::size_t count = 0;
  EXPECT_EQ(biss_control_bytes(link.control(), &byte, 1, &count), BISS_NO_ROOM);
  EXPECT_EQ(count, 2U);
}

TEST(CControl, WrittenBytes_AreInTheRegisters) {
  Link link;
  for (std::uint32_t address = 0x48; address < 0x4C; ++address) link.put(0, address, 0, true);
  std::array<std::uint8_t, 4> bytes{1, 2, 3, 4};
  ASSERT_EQ(biss_control_write(link.control(), 0, 0x48, bytes.data(), bytes.size()), BISS_OK);
  bytes.fill(9);
  link.run();
  EXPECT_EQ(link.error(), "");
  EXPECT_EQ(link.outcome().bytes_done, 4U);
  EXPECT_TRUE(link.bytes().empty());
  std::uint8_t value = 0;
  ASSERT_EQ(biss_line_register(link.line(), 0, 0x4B, &value), BISS_OK);
  EXPECT_EQ(value, 4);
}

TEST(CControl, Failures_HaveTheirCause) {
  Link link;
  link.put(0, 0x48, 1, false);
  const auto error_of = [&](auto begin) {
    EXPECT_EQ(begin(), BISS_OK);
    link.run();
    return link.error();
  };
  const std::uint8_t byte = 1;
  EXPECT_EQ(error_of([&] { return biss_control_read(link.control(), 0, 0x49, 1); }), "refused");
  EXPECT_EQ(error_of([&] { return biss_control_read(link.control(), 3, 0x48, 1); }),
            "no_such_slave");
  EXPECT_EQ(error_of([&] { return biss_control_write(link.control(), 0, 0x48, &byte, 1); }),
            "refused_or_not_addressed");
  EXPECT_EQ(error_of([&] { return biss_control_read(link.control(), 0, 0x48, 2); }),
            "next_unavailable");
  EXPECT_EQ(link.bytes(), std::vector<std::uint8_t>{1});
  for (const std::size_t count : {std::size_t{0}, std::size_t{65}, SIZE_MAX}) {
    EXPECT_EQ(error_of([&] { return biss_control_read(link.control(), 0, 0, count); }),
              "bad_request");
  }
  EXPECT_EQ(error_of([&] { return biss_control_read(link.control(), 8, 0x48, 1); }), "bad_request");
  EXPECT_EQ(error_of([&] { return biss_control_read(link.control(), 0, 128, 1); }), "bad_request");
  EXPECT_EQ(error_of([&] {
              return biss_control_command(link.control(), 1, BISS_COMMAND_USER,
                                          BISS_EXECUTE_ALL_ACCEPT);
            }),
            "not_accepted");
  ASSERT_EQ(biss_control_read(link.control(), 0, 0x48, 1), BISS_OK);
  link.request();
  EXPECT_EQ(biss_control_cancel(link.control()), BISS_OK);
  EXPECT_EQ(link.error(), "cancelled");
  EXPECT_TRUE(biss_control_done(link.control()));
}

TEST(CControl, Commands_SwitchTheChannels) {
  Link link;
  ASSERT_EQ(biss_control_broadcast(link.control(), BISS_COMMAND_CHANNELS), BISS_OK);
  link.run();
  EXPECT_EQ(link.error(), "");
  EXPECT_NE(link.request().cause, BISS_CAUSE_OK);
  ASSERT_EQ(biss_control_command(link.control(), 1, BISS_COMMAND_CHANNELS, BISS_EXECUTE_ALL_ACCEPT),
            BISS_OK);
  link.run();
  EXPECT_EQ(link.outcome().accepted, 1U);
  EXPECT_EQ(link.request().cause, BISS_CAUSE_OK);
}

TEST(CControl, DamagedFrame_IsTriedAgainIfAsked) {
  for (const std::uint32_t retries : {0U, 2U}) {
    Link link("no_answer@25", retries);
    link.put(0, 0x48, 0x5A);
    ASSERT_EQ(biss_control_read(link.control(), 0, 0x48, 1), BISS_OK);
    link.run();
    EXPECT_EQ(link.error(), retries == 0 ? "frame_lost" : "");
    EXPECT_EQ(link.outcome().tries, retries == 0 ? 1U : 2U);
  }
}

// The bits of a session without a biss_master: an encoder that never answers.
TEST(CControl, SessionOfTheCaller_GivesItsBits) {
  const ControlHandle control = open_control();
  ASSERT_EQ(biss_control_read(control.get(), 0, 0x48, 1), BISS_OK);
  std::string bits;
  for (int i = 0; !biss_control_done(control.get()) && i < 100; ++i) {
    bool cdm = false;
    ASSERT_EQ(biss_control_step(control.get(), i * interval, BISS_CDS_ZERO, &cdm), BISS_OK);
    bits += cdm ? '1' : '0';
  }
  // 14 zeros, start, CTS, ID 0, 0x48, then the end at IDL.
  EXPECT_EQ(bits.substr(0, 26), "00000000000000110001001000") << bits;
  biss_control_outcome outcome;
  ASSERT_EQ(biss_control_outcome_of(control.get(), &outcome), BISS_OK);
  EXPECT_STREQ(outcome.error, "no_answer");
}

// ---- Data sheets

// The common part in bank 1, the part of channel 0 in bank 2.
void put_data_sheet(Link& link) {
  const auto advice = advise({.resolution_bits = 20, .turns_bits = 12, .clock = megahertz(5)});
  CommonPart common{.eds_len = 2, .dc_num = 1, .sl_num = 1};
  common.channels[0] = {.bank = 2, .dlen = 34, .format = 0, .cpoly = 0x21};
  const EdsBank banks[] = {sealed(build_bank(common)), bp3_bank_of(*advice)};
  for (std::uint32_t i = 0; i < 64; ++i) {
    link.put(1, i, banks[0][i]);
    link.put(2, i, banks[1][i]);
  }
  link.put(0, 0x40, 0);
  link.put(0, 0x41, 1);
  link.put(0, 0x42, 0x62);
  link.put(0, 0x43, 0x22);
  for (std::uint32_t i = 0; i < 4; ++i) link.put(0, 0x44 + i, static_cast<std::uint8_t>(i + 1));
}

TEST(CEds, DataSheetOfADevice_GivesItsFormat) {
  Link link;
  put_data_sheet(link);
  ASSERT_EQ(biss_control_query(link.control(), 0), BISS_OK);
  biss_device device;
  EXPECT_EQ(biss_control_device(link.control(), &device), BISS_RUNNING);
  const unsigned frames = link.run();
  EXPECT_EQ(link.error(), "");
  ASSERT_EQ(biss_control_device(link.control(), &device), BISS_OK);
  EXPECT_FALSE(device.has_identity);
  EXPECT_TRUE(device.has_serial);
  EXPECT_EQ(device.serial, 0x01020304U);
  EXPECT_TRUE(device.has_common);
  EXPECT_TRUE(device.has_channel[0]);
  EXPECT_FALSE(device.has_channel[1]);
  EXPECT_FALSE(device.eds_unused || device.bank_changed);
  // Of identity, profile, serial number, the bank of the EDS, and its two parts at least.
  EXPECT_GE(link.outcome().tries, 6U);
  EXPECT_EQ(link.outcome().frames, frames);
  biss_format found;
  unsigned remarks = 0;
  const auto count = [](void* user, std::uint32_t, const char* field, const char* remark,
                        std::uint32_t, std::uint32_t) {
    EXPECT_GT(std::string(field).size(), 1U);
    EXPECT_GT(std::string(remark).size(), 5U);
    ++*static_cast<unsigned*>(user);
  };
  ASSERT_EQ(biss_eds_format(&device, clock_hz, &found, count, &remarks), BISS_OK);
  EXPECT_EQ(text_of(found), format);
  EXPECT_GT(remarks, 0U);
  EXPECT_GT(found.timing.ack_max_ps, 0);
  EXPECT_EQ(biss_eds_format(&device, clock_hz, nullptr, nullptr, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_eds_format(&device, 0, &found, nullptr, nullptr), BISS_BAD_SETUP);
}

TEST(CEds, DataSheetThatContradictsItself_IsRefusedWithItsFinding) {
  Link link;
  put_data_sheet(link);
  ASSERT_EQ(biss_control_query(link.control(), 0), BISS_OK);
  link.run();
  biss_device device;
  ASSERT_EQ(biss_control_device(link.control(), &device), BISS_OK);
  biss_format found{};
  std::string said;
  const auto take = [](void* user, std::uint32_t, const char* field, const char* remark,
                       std::uint32_t, std::uint32_t) {
    *static_cast<std::string*>(user) += std::string(field) + ": " + remark + "\n";
  };
  device.channel[0][0x10] = 0x7F;  // MT_CNT
  device.channel[0][63] = static_cast<std::uint8_t>(device.channel[0][63] + 0x7F);
  EXPECT_EQ(biss_eds_format(&device, clock_hz, &found, take, &said), BISS_BAD_EDS);
  EXPECT_NE(said.find("MT_CNT: more counts than its length can distinguish"), std::string::npos)
      << said;
  EXPECT_EQ(found.channel_count, 0U);
}

TEST(CEds, DeviceWithoutADataSheet_HasItsProfileOrNone) {
  Link link;
  biss_device device;
  EXPECT_EQ(biss_control_device(link.control(), &device), BISS_NO_READING);
  link.put(0, 0x42, 0x62);
  link.put(0, 0x43, 0x1C);
  ASSERT_EQ(biss_control_query(link.control(), 0), BISS_OK);
  link.run();
  ASSERT_EQ(biss_control_device(link.control(), &device), BISS_OK);
  biss_format found;
  ASSERT_EQ(biss_eds_format(&device, clock_hz, &found, nullptr, nullptr), BISS_OK);
  EXPECT_EQ(text_of(found), "pos26,nE,nW,crc6");
  device.has_profile = false;
  EXPECT_EQ(biss_eds_format(&device, clock_hz, &found, nullptr, nullptr), BISS_BAD_EDS);
  device.has_common = true;  // 64 zeros: no data channel
  EXPECT_EQ(biss_eds_format(&device, clock_hz, &found, nullptr, nullptr), BISS_BAD_EDS);
}

TEST(CEds, QueryOfADeviceThatIsNotThere_HasItsCause) {
  Link link;
  ASSERT_EQ(biss_control_query(link.control(), 5), BISS_OK);
  link.run();
  EXPECT_EQ(link.error(), "no_such_slave");
  EXPECT_EQ(biss_control_query(link.control(), 8), BISS_BAD_SETUP);
}

TEST(CControl, WrongCalls_AreRefusedByTheirCause) {
  biss_control_setup setup = biss_control_defaults();
  biss_control memory;
  biss_control* control = &memory;
  EXPECT_EQ(biss_control_init(nullptr, &setup), BISS_NULL_ARGUMENT);
  setup.retries = 256;
  EXPECT_EQ(biss_control_init(control, &setup), BISS_BAD_SETUP);
  setup.retries = 0;
  setup.busy_max_ps = -1;
  EXPECT_EQ(biss_control_init(control, &setup), BISS_BAD_SETUP);
  ASSERT_EQ(biss_control_init(control, nullptr), BISS_OK);
  std::array<std::uint8_t, 80> bytes{};
  std::size_t count = 0;
  bool cdm = false;
  biss_control_outcome outcome;
  biss_device device;
  const auto every = [&](biss_control* c) {
    return std::vector<biss_status>{
        biss_control_read(c, 0, 0, 1),
        biss_control_write(c, 0, 0, bytes.data(), 1),
        biss_control_command(c, 1, BISS_COMMAND_USER, BISS_EXECUTE_ALWAYS),
        biss_control_broadcast(c, BISS_COMMAND_USER),
        biss_control_cancel(c),
        biss_control_step(c, 0, BISS_CDS_ONE, &cdm),
        biss_control_outcome_of(c, &outcome),
        biss_control_bytes(c, bytes.data(), 1, &count),
        biss_control_query(c, 0),
        biss_control_device(c, &device)};
  };
  EXPECT_TRUE(biss_control_done(nullptr));
  EXPECT_EQ(biss_control_write(control, 0, 0, nullptr, 1), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_control_write(control, 0, 0, bytes.data(), 65), BISS_NO_ROOM);
  EXPECT_EQ(biss_control_command(control, 256, BISS_COMMAND_USER, BISS_EXECUTE_ALWAYS),
            BISS_BAD_SETUP);
  EXPECT_EQ(biss_control_command(control, 1, static_cast<biss_command>(4), BISS_EXECUTE_ALWAYS),
            BISS_BAD_SETUP);
  EXPECT_EQ(biss_control_command(control, 1, BISS_COMMAND_USER, static_cast<biss_execute>(-1)),
            BISS_BAD_SETUP);
  EXPECT_EQ(biss_control_broadcast(control, static_cast<biss_command>(-1)), BISS_BAD_SETUP);
  EXPECT_EQ(biss_control_step(control, 0, static_cast<biss_cds>(3), &cdm), BISS_BAD_SETUP);
  EXPECT_EQ(biss_control_step(control, 5, BISS_CDS_ZERO, &cdm), BISS_OK);
  EXPECT_EQ(biss_control_step(control, 4, BISS_CDS_ZERO, &cdm), BISS_TIME_BACKWARDS);
  EXPECT_EQ(biss_control_step(control, INT64_MAX, BISS_CDS_ZERO, &cdm), BISS_TIME_RANGE);
  EXPECT_EQ(biss_eds_format(nullptr, 1, nullptr, nullptr, nullptr), BISS_NULL_ARGUMENT);
  biss_master_setup master = biss_master_defaults(named(format), period);
  master.control = control;
  expect_refusals(control, every);
  biss_master opened;
  EXPECT_EQ(biss_master_init(&opened, &master), BISS_BAD_HANDLE);
}

}  // namespace control_test
}  // namespace biss::capi
