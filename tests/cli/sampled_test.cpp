// `biss decode` reads the samples of `biss simulate`: the positions of every cycle, at the default
// rate and at one that divides no clock.
#include <tuple>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::sampled_test {

using Sampled = InFolder;

void expect_true_positions(const Folder& folder, const std::string& capture, const Words& options) {
  SCOPED_TRACE(capture);
  run_ok(Words("simulate -f resolute-26 --cycles 200 --motion random -o {} --truth {}", capture,
               folder.path("truth.csv")) +
         options);
  const std::vector<Row> rows = rows_of(run_ok("decode -f resolute-26 {} --to csv", capture).out);
  EXPECT_EQ(rows.size(), 200U);
  expect_truth(rows, rows_of(content_of(folder.path("truth.csv"))));
}

TEST_F(Sampled, SessionsAndSaleaesCsv_DecodeToTheTruth) {
  for (const std::string clock : {"250kHz", "1MHz", "3MHz", "10MHz"}) {
    SCOPED_TRACE(clock);
    const Words options{"--clock", clock, "--cable", "50m"};
    expect_true_positions(folder, folder.path("line.sr"), options);
    expect_true_positions(folder, folder.path("line.saleae.csv"), options);
  }
  expect_true_positions(folder, folder.path("odd.sr"),
                        "--clock 7MHz --sample-rate 48MHz --cable 20m");
}

// Writes the same cycles as samples of one byte at 50 MHz.
Outcome simulate_samples(const std::string& capture, const Words& more = {}) {
  return run(Words("simulate -f resolute-26 --clock 5MHz --cable 30m --sample-rate 50MHz --motion "
                   "random --fault flip:0.1 -o {}",
                   capture) +
             more);
}

Outcome decode_samples(const std::string& capture, const Words& more) {
  return run(Words("decode -f resolute-26 {} --to csv", capture) + more);
}

// Samples of several bytes with MA and SLO on these bits and noise on all others.
std::string widened(const std::string& samples, unsigned bytes, unsigned ma, unsigned slo) {
  std::string wide;
  std::uint64_t noise = 1;
  for (const char sample : samples) {
    noise = noise * 6'364'136'223'846'793'005U + 1'442'695'040'888'963'407U;
    std::uint64_t word = noise >> 13U;
    for (const auto& [from, to] : {std::pair{0U, ma}, std::pair{1U, slo}}) {
      const std::uint64_t level = (static_cast<std::uint64_t>(sample) >> from) & 1U;
      word = (word & ~(std::uint64_t{1} << to)) | (level << to);
    }
    for (unsigned k = 0; k < bytes; ++k) wide += static_cast<char>(word >> (8 * k));
  }
  return wide;
}

TEST_F(Sampled, RawSamples_DecodeLikeTheSessionOfTheSameCycles) {
  const std::string session = folder.path("line.sr");
  const std::string raw = folder.path("line.bin");
  ASSERT_EQ(simulate_samples(session).status, 0);
  ASSERT_EQ(simulate_samples(raw).status, 0);
  const Outcome wanted = decode_samples(session, {});
  ASSERT_EQ(rows_of(wanted.out).size(), 100U);
  EXPECT_EQ(ok(decode_samples(raw, {"--raw-rate", "50MHz"})).out, wanted.out);
  const Outcome piped = run({"decode", "-f", "resolute-26", "-", "--to", "csv", "--raw-rate",
                             "50MHz", "--ma", "D0", "--slo", "D1"},
                            raw);
  EXPECT_EQ(piped.out, wanted.out) << piped.err;
  const std::string samples = content_of(raw);
  for (const auto& [bytes, ma, slo] :
       {std::tuple{2U, 11U, 3U}, std::tuple{3U, 0U, 23U}, std::tuple{8U, 62U, 63U}}) {
    const std::string wide = folder.file("wide.raw", widened(samples, bytes, ma, slo));
    const Outcome told = ok(
        decode_samples(wide, {"--raw-rate", "50MHz", "--raw-bytes", std::to_string(bytes), "--ma",
                              "D" + std::to_string(ma), "--slo", "D" + std::to_string(slo)}));
    EXPECT_EQ(told.out, wanted.out) << bytes;
  }
}

TEST_F(Sampled, RawSamplesInTwoFiles_AreReadAsOne) {
  const std::string raw = folder.path("line.bin");
  ASSERT_EQ(simulate_samples(raw).status, 0);
  const std::string samples = content_of(raw);
  const std::string ma = folder.file("ma.bin", widened(samples, 1, 2, 6));
  const std::string slo = folder.file("slo.bin", widened(samples, 1, 7, 2));
  const Outcome two = run_ok("decode -f resolute-26 --to csv --raw-rate 50MHz --ma {} --slo {}",
                             ma + ":D2", slo + ":D2");
  EXPECT_EQ(two.out, decode_samples(raw, {"--raw-rate", "50MHz"}).out);
}

TEST_F(Sampled, RawSamples_AreReplayed) {
  const std::string raw = folder.path("line.bin");
  const std::string session = folder.path("line.sr");
  ASSERT_EQ(simulate_samples(raw).status, 0);
  ASSERT_EQ(simulate_samples(session).status, 0);
  const auto replay = [&](const std::string& option, const std::string& capture,
                          const Words& more) {
    const std::string out = folder.path("out.csv");
    run_ok(Words("simulate -f resolute-26 {} {} -o {}", option, capture, out) + more);
    return content_of(out);
  };
  const Words told("--raw-rate 50MHz --ma D0");
  EXPECT_EQ(replay("--ma-from", raw, told), replay("--ma-from", session, {}));
  EXPECT_EQ(replay("--slo-from", raw, {"--raw-rate", "50MHz"}), replay("--slo-from", session, {}));
}

TEST_F(Sampled, RawSamplesHalfDescribed_AreRefusedByName) {
  const std::string raw = folder.path("line.bin");
  ASSERT_EQ(simulate_samples(raw).status, 0);
  EXPECT_EQ(content_of(raw).front(), '\3');
  const std::string changes = folder.path("line.vcd");
  run_ok("simulate -f resolute-26 -o {}", changes);
  const auto expect = [&](const std::string& capture, const Words& options, int status,
                          const std::string& part) {
    EXPECT_THAT(decode_samples(capture, options), refuses(status, part));
  };
  expect(raw, {}, 3, "line.bin: the sample rate of raw samples is not known; give --raw-rate");
  expect(raw, {"--raw-bytes", "1"}, 2, "--raw-rate");
  expect(raw, {"--raw-rate", "50MHz", "--raw-bytes", "0"}, 2, "a sample has 1 to 8 bytes");
  expect(raw, {"--raw-rate", "50MHz", "--raw-bytes", "9"}, 2, "--raw-bytes");
  expect(raw, {"--raw-rate", "0Hz"}, 2, "--raw-rate");
  expect(raw, {"--raw-rate", "50MHz", "--ma", "D8"}, 2, "it has D0, D1, D2");
  expect(raw, {"--raw-rate", "50MHz", "--ma", "D1", "--slo", "D1"}, 2, "same line");
  expect(changes, {"--raw-rate", "50MHz"}, 2, "has times of its own");
  EXPECT_THAT(run("simulate -f resolute-26 --raw-rate 50MHz -o {}", folder.path("other.bin")),
              fails(2, "--sample-rate"));
}

TEST_F(Sampled, SampleRateOfAFileOfChanges_IsWrongUsage) {
  EXPECT_THAT(run({"simulate", "-f", "resolute-26", "--sample-rate", "100MHz", "-o",
                   folder.path("line.vcd")}),
              fails(2, "--sample-rate"));
  EXPECT_EQ(folder.files(), 0U);
}

TEST_F(Sampled, SessionOnStandardInput_DecodesTheSame) {
  const std::string capture = folder.path("line.sr");
  run_ok("simulate -f resolute-26 -o {}", capture);
  EXPECT_EQ(run_ok("decode -f resolute-26 {} --to csv", capture).out,
            run({"decode", "-f", "resolute-26", "-", "--to", "csv"}, capture).out);
}

TEST_F(Sampled, SessionCutOff_IsDamaged) {
  const std::string capture = folder.path("line.sr");
  run_ok("simulate -f resolute-26 -o {}", capture);
  const std::string whole = content_of(capture);
  EXPECT_THAT(run({"decode", "-f", "resolute-26",
                   folder.file("cut.sr", whole.substr(0, whole.size() / 2))}),
              fails(3, "cut.sr: is damaged"));
}

}  // namespace biss::verbs::sampled_test
