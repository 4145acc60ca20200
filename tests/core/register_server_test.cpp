// The encoder's end of the control communication, checked bit by bit with PROTOCOL's vectors and
// rules.
#include "biss/slave/register_server.hpp"
#include "tests/core/control_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::test::register_server_test {

using Server = RegisterServer<TestOwner>;

/// `Count` devices of one slave each.
template <std::size_t Count>
struct Bench {
  std::array<TestRegisters, Count> registers{};
  std::array<Server, Count> servers;

  constexpr explicit Bench(const RegisterServerOptions& options = {})
      : servers(make(options, std::make_index_sequence<Count>{})) {
    for (std::size_t k = 0; k < Count; ++k) servers[k].owner().slaves = &registers[k];
    send_zeros(servers);
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// The index of the first wrong CDS bit; -1: none.
  constexpr int wrong_at(std::string_view cdm, std::string_view cds) {
    const auto at = first_difference(servers, cdm, cds);
    send_zeros(servers);
    return at ? static_cast<int>(*at) : -1;
  }

 private:
  template <std::size_t... K>
  static constexpr std::array<Server, Count> make(const RegisterServerOptions& options,
                                                  std::index_sequence<K...>) {
    return {((void)K, Server({}, options))...};
  }
};

// Headers with their CRC.
constexpr std::string_view read_40 = "1 1 000 1000000 0001";

BISS_TEST(RegisterServer, DerivedVectorsOfOneSlave_AreAnswered) {
  struct Vector {
    std::uint8_t address;
    std::uint8_t value;
    std::string_view cdm;
    std::string_view cds;
  };
  for (const Vector& vector : {
           Vector{0x42, 0x62, "11000100001001111010000000000000",
                  "10000000000000001010110001001000"},
           Vector{0x43, 0x1E, "11000100001101001010000000000000",
                  "10000000000000001010001111010110"},
           Vector{0x7E, 0x69, "11000111111011111010000000000000",
                  "10000000000000001010110100110100"},
       }) {
    Bench<1> bench;
    bench.registers[0].value[vector.address] = vector.value;
    BISS_EXPECT_EQ(bench.wrong_at(vector.cdm, vector.cds), -1) << vector.address;
    BISS_EXPECT_EQ(bench.registers[0].writes, 0);
  }
  Bench<1> bench;
  BISS_EXPECT_EQ(
      bench.wrong_at("11000100000000010110000001010010", "10000000000000000110000001010010"), -1);
  BISS_EXPECT_EQ(bench.registers[0].value[0x40], 0x02);
  BISS_EXPECT_EQ(
      bench.wrong_at("11000000001000000110101010100100", "10000000000000000110101010100100"), -1);
  BISS_EXPECT_EQ(bench.registers[0].value[0x02], 0x55);
  BISS_EXPECT_EQ(bench.registers[0].writes, 2);
}

BISS_TEST(RegisterServer, DerivedVectorOfTheSecondSlave_IsAnsweredThroughTheChain) {
  Bench<2> bench;
  bench.registers[1].value[0x41] = 0x02;
  bench.registers[0].value[0x41] = 0xFF;
  BISS_EXPECT_EQ(
      bench.wrong_at("11001100000111001010000000000000", "11000000000000001010000001010010"), -1);
}

BISS_TEST(RegisterServer, DerivedCommands_AreAcceptedAndExecuted) {
  Bench<2> bench;
  const auto executed = [&](std::size_t device, std::size_t command) {
    return bench.registers[device].addressed[command];
  };
  BISS_EXPECT_EQ(bench.wrong_at("1010000000000010100000001", "1100000000000000 10000000 0"), -1);
  BISS_EXPECT(executed(0, 0) == 1 && executed(1, 0) == 0);
  BISS_EXPECT_EQ(bench.wrong_at("100000000000111111", "110000000000000000"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("100000000001110011", "110000000000000000"), -1);
  for (const TestRegisters& registers : bench.registers) {
    BISS_EXPECT(registers.broadcast[0] == 1 && registers.broadcast[1] == 1);
  }
  // 01: slave 1 no longer takes an ID.
  BISS_EXPECT_EQ(bench.wrong_at("1001000000010011100000001", "1100000000000000 01000000 0"), -1);
  BISS_EXPECT(executed(1, 1) == 1 && executed(0, 1) == 0);
  BISS_EXPECT(!bench.servers[1].control_active(0) && bench.servers[0].control_active(0));
  BISS_EXPECT_EQ(bench.wrong_at("11001100000111001010000000000000", "1"), -1);
  // It still receives the broadcast.
  BISS_EXPECT_EQ(bench.wrong_at("100000000001110011", "1"), -1);
  BISS_EXPECT(bench.servers[1].control_active(0));
  BISS_EXPECT_EQ(
      bench.wrong_at("11001100000111001010000000000000", "1100000000000000 101 00000000 1111"), -1);
}

BISS_TEST(RegisterServer, CommandWithoutEx_OrNotAccepted_IsDropped) {
  Bench<2> bench;
  BISS_EXPECT_EQ(bench.wrong_at("1010000000000010100000000", "1100000000000000 1"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("100000000000111110", "11"), -1);
  // Ones in place of IDA, and no S.
  BISS_EXPECT_EQ(bench.wrong_at("1010000000000010100010001", "1100000000000000 1"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("1010000000000010000000001", "11"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("100000000000111101", "11"), -1);
  bench.registers[0].accepts = false;
  BISS_EXPECT_EQ(bench.wrong_at("1010000000000010100000001", "11"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("100000000000111111", "11"), -1);
  BISS_EXPECT(bench.registers[0].addressed[0] == 0 && bench.registers[0].broadcast[0] == 0);
  BISS_EXPECT(bench.registers[1].addressed[0] == 0 && bench.registers[1].broadcast[0] == 1);
}

BISS_TEST(RegisterServer, BroadcastInReducedFrames_NeedsNoCds) {
  Bench<1> bench;
  for (const char bit : std::string_view("100000000000111111")) bench.servers[0].cdm(bit == '1');
  BISS_EXPECT_EQ(bench.registers[0].broadcast[0], 1);
  // No slave takes an ID without CDS.
  send_zeros(bench.servers);
  for (const char bit : std::string_view("1010000000000010100000001")) {
    bench.servers[0].cdm(bit == '1');
  }
  BISS_EXPECT_EQ(bench.registers[0].addressed[0], 0);
}

BISS_TEST(RegisterServer, FourteenZeros_NotThirteen_LetAHeaderBegin) {
  for (const unsigned zeros : {0U, 1U, 13U, 14U, 15U, 300U}) {
    TestRegisters registers;
    std::array servers{Server({&registers})};
    // From power-up, and after a 1 without meaning.
    for (int round = 0; round < 2; ++round) {
      send_zeros(servers, zeros);
      BISS_EXPECT_EQ(servers[0].idle(), zeros >= 14) << zeros;
      const auto at = first_difference(servers, read_40, zeros < 14 ? "0" : "1");
      BISS_EXPECT(!at) << zeros << ", " << round;
      control_frame(servers, true);
    }
  }
}

BISS_TEST(RegisterServer, WrongHeaderCrc_IsNotAddressed) {
  for (std::size_t flipped = 1; flipped < 16; ++flipped) {
    Bench<1> bench;
    std::array<char, 32> cdm{};
    for (std::size_t i = 0; i < 32; ++i) cdm[i] = "11000100001001110110101010100100"[i];
    cdm[flipped] = cdm[flipped] == '0' ? '1' : '0';
    BISS_EXPECT_EQ(bench.wrong_at({cdm.data(), 32}, "1"), -1) << flipped;
    BISS_EXPECT_EQ(bench.registers[0].writes, 0);
  }
}

BISS_TEST(RegisterServer, HeaderDamagedToFourteenZeros_BeginsAnew) {
  // Write to 0x02 with its last 1 lost: from index 2 on 14 zeros, and W = 1 is a start bit.
  Bench<1> bench;
  BISS_EXPECT_EQ(bench.wrong_at("11000000000000000110101010100100", "10000000000000000100000000"),
                 -1);
  BISS_EXPECT_EQ(bench.registers[0].writes, 0);
}

BISS_TEST(RegisterServer, Refusal_IsREqualsW_AndOldDevicesKeepSilent) {
  for (const auto level : {RegisterProtection::not_available, RegisterProtection::read_only}) {
    const bool readable = level == RegisterProtection::read_only;
    for (const bool inversion : {true, false}) {
      Bench<1> bench({.w_inversion = inversion});
      bench.registers[0].protection.fill(level);
      std::string_view answer = "1000000000000000 101 00000000 1111";
      if (!readable) answer = inversion ? "1000000000000000 11" : "1000000000000000 10";
      BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 101 000000000000 0", answer), -1);
      answer = inversion ? "1000000000000000 00" : "1000000000000000 01";
      BISS_EXPECT_EQ(bench.wrong_at("11000100000000010110000001010010", answer), -1);
      BISS_EXPECT_EQ(bench.registers[0].writes, 0);
    }
  }
}

BISS_TEST(RegisterServer, RAndWThatMeanNothing_AreNoAccess) {
  Bench<1> bench;
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 001 1111 1111 1111 1", "1"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 111 1111 1111 1111 1", "1000000000000000 11"),
                 -1);
  // S is missing.
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 100 1111 1111 1111 1", "1000000000000000 1"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 010 0010 0010 0011 1", "1000000000000000 01"),
                 -1);
  BISS_EXPECT_EQ(bench.registers[0].writes, 0);
}

BISS_TEST(RegisterServer, SequentialRead_CountsUpToTheLastRegister) {
  Bench<1> bench;
  bench.registers[0].value[0x7E] = 0x11;
  bench.registers[0].value[0x7F] = 0x22;
  BISS_EXPECT_EQ(bench.wrong_at("1 1 000 1111110 1111 10 1 000000000000 0 1 000000000000 0 1 0",
                                "1000000000000000 10 1 00010001 1001 0 1 00100010 0011 1"),
                 -1);
  // Don't-care bits may be ones; then another 14 zeros must follow.
  BISS_EXPECT_EQ(bench.wrong_at("1 1 000 1111110 1111 10 1 111111111111 1 1 111111111111 1 1 1",
                                "1000000000000000 10 1 00010001 1001 0 1 00100010 0011 1"),
                 -1);
  bench.registers[0].protection[0x7F] = RegisterProtection::not_available;
  BISS_EXPECT_EQ(bench.wrong_at("1 1 000 1111110 1111 10 1 000000000000 0 1 000000000000 0",
                                "1000000000000000 10 1 00010001 1001 1"),
                 -1);
}

BISS_TEST(RegisterServer, SequentialWrite_EchoesAndStopsAtAProtectedRegister) {
  Bench<1> bench;
  TestRegisters& registers = bench.registers[0];
  registers.protection[0x04] = RegisterProtection::read_only;
  BISS_EXPECT_EQ(bench.wrong_at("1 1 000 0000010 0000 01 1 00010001 1001 0 1 00100010 0011 0 "
                                "1 00110011 0101 0",
                                "1000000000000000 01 1 00010001 1001 0 1 00100010 0011 1"),
                 -1);
  BISS_EXPECT(registers.value[2] == 0x11 && registers.value[3] == 0x22);
  BISS_EXPECT_EQ(registers.value[4], 0);
  BISS_EXPECT_EQ(registers.writes, 2);
}

BISS_TEST(RegisterServer, WriteWithAWrongCrc_IsEchoedAndNotDone) {
  for (std::size_t flipped = 0; flipped < 12; ++flipped) {
    Bench<1> bench;
    std::array<char, 12> byte{};
    for (std::size_t i = 0; i < 12; ++i) byte[i] = "000100011001"[i];
    byte[flipped] = byte[flipped] == '0' ? '1' : '0';
    std::array<char, 47> cdm{};
    std::array<char, 32> cds{};
    for (std::size_t i = 0; i < 47; ++i) {
      cdm[i] = "1100000000100000011000000000000010010001000110"[i % 46];
    }
    for (std::size_t i = 0; i < 32; ++i) cds[i] = "10000000000000000110000000000001"[i];
    for (std::size_t i = 0; i < 12; ++i) cdm[19 + i] = cds[19 + i] = byte[i];
    BISS_EXPECT_EQ(bench.wrong_at({cdm.data(), 46}, {cds.data(), 32}), -1) << flipped;
    BISS_EXPECT_EQ(bench.registers[0].writes, 0) << flipped;
    BISS_EXPECT_EQ(
        bench.wrong_at("11000000001000000110101010100100", "10000000000000000110101010100100"), -1);
  }
}

BISS_TEST(RegisterServer, Busy_DelaysSAndNothingElse) {
  Bench<1> bench;
  bench.registers[0].value[0x40] = 0x11;
  bench.registers[0].value[0x41] = 0x22;
  bench.registers[0].busy_frames = 3;
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 10 1111 000000000000 0 1111 000000000000 0",
                                "1000000000000000 10 0001 00010001 1001 0 0001 00100010 0011"),
                 -1);
  // The master ends the access after two busy frames.
  bench.registers[0].waited = 0;
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 10 11 0 11 000000000", "1000000000000000 10"),
                 -1);
  // The first byte of a write is not delayed.
  bench.registers[0].waited = 0;
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 01 1 00010001 1001 0 1111 00100010 0011 0",
                                "1000000000000000 01 1 00010001 1001 0 0001 00100010 0011"),
                 -1);
  BISS_EXPECT_EQ(bench.registers[0].writes, 2);
}

BISS_TEST(RegisterServer, BusyBetweenBytes_IsAsAnIcMhm) {
  Bench<1> bench({.busy_frames = 1});
  bench.registers[0].value[0x40] = 0x11;
  bench.registers[0].value[0x41] = 0x22;
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 10 1 000000000000 0 11 000000000000 0 11",
                                "1000000000000000 10 1 00010001 1001 0 01 00100010 0011 0 01 "
                                "00000000 1111"),
                 -1);
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 01 1 00010001 1001 0 11 00100010 0011 0",
                                "1000000000000000 01 1 00010001 1001 0 01 00100010 0011 0"),
                 -1);
}

BISS_TEST(RegisterServer, SequenceBytes_LimitAnAccess) {
  Bench<1> bench({.sequence_bytes = 2});
  BISS_EXPECT_EQ(bench.wrong_at("1100010000000001 10 1 000000000000 0 1 000000000000 0 1 1 1",
                                "1000000000000000 10 1 00000000 1111 0 1 00000000 1111 1"),
                 -1);
}

BISS_TEST(RegisterServer, ChainOfDevices_TakesIdsInOrder) {
  constexpr std::string_view idle_header = "1 0 00000000 00 0011 0";
  BISS_EXPECT_EQ(Bench<1>().wrong_at(idle_header, "100000000"), -1);
  BISS_EXPECT_EQ(Bench<3>().wrong_at(idle_header, "111000000"), -1);
  BISS_EXPECT_EQ(Bench<8>().wrong_at(idle_header, "111111110"), -1);
  BISS_EXPECT_EQ(Bench<9>().wrong_at(idle_header, "111111111"), -1);
  Bench<10> ten;
  BISS_EXPECT_EQ(ten.wrong_at(idle_header, "111111111"), -1);
  for (std::size_t k = 0; k < 10; ++k) {
    ten.registers[k].value[0x40] = static_cast<std::uint8_t>(0x11 * (k + 1));
  }
  constexpr std::string_view ids = "1111111110000000";
  std::array<char, 64> cds{};
  const auto answer = [&](std::string_view rest) {
    for (std::size_t i = 0; i < 16; ++i) cds[i] = ids[i];
    for (std::size_t i = 0; i < rest.size(); ++i) cds[16 + i] = rest[i];
    return std::string_view(cds.data(), 16 + rest.size());
  };
  BISS_EXPECT_EQ(ten.wrong_at("1 1 000 1000000 0001 101", answer("101 00010001 1001")), -1);
  BISS_EXPECT_EQ(ten.wrong_at("1 1 001 1000000 1111 101", answer("101 00100010 0011")), -1);
  BISS_EXPECT_EQ(ten.wrong_at("1 1 010 1000000 1110 101", answer("101 00110011 0101")), -1);
}

BISS_TEST(RegisterServer, IdNobodyHas_IsSilence) {
  Bench<2> bench;
  BISS_EXPECT_EQ(bench.wrong_at("1 1 010 1000000 1110 101 0000", "11"), -1);
  BISS_EXPECT_EQ(bench.wrong_at("1 1 111 1000000 1101 011 0000", "11"), -1);
}

BISS_TEST(RegisterServer, DeviceOfSeveralSlaves_TakesConsecutiveIds) {
  std::array<TestRegisters, 3> registers{};
  std::array servers{RegisterServer<TestOwner, 3>({registers.data()})};
  registers[1].value[0x40] = 0x22;
  // A predecessor takes the first two IDs.
  for (unsigned i = 0; i < 14; ++i) servers[0].cdm(false);
  std::uint32_t seen = 0;
  for (const char bit : std::string_view("1100110000001010 10 1 000000000000")) {
    if (bit == ' ') continue;
    servers[0].cdm(bit == '1');
    seen = seen << 1U | servers[0].cds(seen == 0 || seen == 1);
  }
  BISS_EXPECT_EQ(seen >> 15U, 0b1111100000000000U);
  // Alone: IDs 0 to 2; the second is silenced, the third moves up.
  send_zeros(servers);
  const auto wrong = [&](std::string_view cdm, std::string_view cds) {
    const auto at = first_difference(servers, cdm, cds);
    send_zeros(servers);
    return at ? static_cast<int>(*at) : -1;
  };
  BISS_EXPECT_EQ(wrong("1 1 001 1000000 1111 101", "1110000000000000 101 00100010 0011"), -1);
  BISS_EXPECT_EQ(wrong("1001000000010011100000001", "1110000000000000 01"), -1);
  BISS_EXPECT(!servers[0].control_active(1) && servers[0].control_active(2));
  registers[2].value[0x40] = 0x33;
  BISS_EXPECT_EQ(wrong("1 1 001 1000000 1111 101", "1100000000000000 101 00110011 0101"), -1);
  BISS_EXPECT_EQ(wrong("1 1 010 1000000 1110 101", "11"), -1);
}

BISS_TEST(RegisterServer, CdsAskedTwice_IsTheSameBit) {
  // Two slaves, so that a second ID could be taken at the first one's index.
  std::array<TestRegisters, 2> registers{};
  std::array servers{RegisterServer<TestOwner, 2>({registers.data()})};
  registers[1].value[0x40] = 0x22;
  send_zeros(servers);
  std::uint32_t seen = 0;
  for (const char bit : std::string_view("1100110000001111 101 000000000000")) {
    if (bit == ' ') continue;
    servers[0].cdm(bit == '1');
    const bool cds = servers[0].cds(false);
    BISS_EXPECT_EQ(servers[0].cds(false), cds);
    seen = seen << 1U | (cds ? 1U : 0U);
  }
  BISS_EXPECT_EQ(seen, 0b1100000000000000'101'00100010'0011U);
}

}  // namespace biss::test::register_server_test
