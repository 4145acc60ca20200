// Faults at a place: `biss decode` finds a fault where `biss simulate` injects it and nowhere else,
// and the truth file lists it.
#include <iterator>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::fault_place_test {

constexpr unsigned payload_bits = 30;
constexpr std::size_t cycles = 8;
constexpr std::size_t struck = 3;

struct Seen {
  std::vector<Row> rows;
  std::vector<Row> truth;
  std::vector<Row> edges;
};

// A line with a delay, without a checksum, so that every bit is visible.
Seen seen_with(const Words& options) {
  const Folder folder;
  const std::string capture = folder.path("line.csv");
  const std::string format = "pos28,nE,nW";
  run_ok(Words("simulate -f {} --clock 2MHz --ma-delay 310ns --slo-delay 160ns --processing 3us "
               "--cycles {} --motion random -o {} --truth {}",
               format, std::to_string(cycles), capture, folder.path("truth.csv")) +
         options);
  return {rows_of(run_ok("decode -f {} {} --to csv", format, capture).out),
          rows_of(content_of(folder.path("truth.csv"))), rows_of(content_of(capture))};
}

TEST(SimulateThen, FormatThatChanges_ReadsBeforeAndAfterWithItsOwn) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  run_ok(
      "simulate -f pos19,nE,nW,crc6 --then pos28,nE,nW,crc6@30 --cycles 50 --fault slo_low@29 "
      "--fault flip@40 -o {} --truth {}",
      capture, folder.path("truth.csv"));
  const auto truth = rows_of(content_of(folder.path("truth.csv")));
  ASSERT_EQ(truth.size(), 50U);
  for (const bool after : {false, true}) {
    const std::string format = after ? "pos28,nE,nW,crc6" : "pos19,nE,nW,crc6";
    const auto rows = rows_of(run("decode {} -f {} --to csv", capture, format).out);
    ASSERT_EQ(rows.size(), 50U);
    for (std::size_t i = after ? 31 : 0; i < (after ? 50U : 29U); ++i) {
      // The cell has commas.
      EXPECT_EQ(truth[i].at("format"), "\"" + format.substr(0, 5));
      if (i == 40) continue;
      EXPECT_EQ(rows[i].at("position"), truth[i].at("position")) << i;
    }
  }
  EXPECT_EQ(truth[40].at("faults"), "flip");
  for (const std::string wrong : {"x@3", "pos5,crc6", "pos5,crc6@0", "pos5+pos5@3", "pos5@100"}) {
    EXPECT_THAT(run("simulate -f pos19,crc6 --then {} -o {}", wrong, capture),
                fails(2, testing::StartsWith("biss: --then: ")));
  }
}

// The payload of a row, first bit first: the bits after START and CDS in `raw`.
std::string payload_of(Row row) {
  std::string bits;
  for (const char digit : row["raw"].substr(2)) {
    const int value = digit <= '9' ? digit - '0' : (digit | 0x20) - 'a' + 10;
    for (int bit = 3; bit >= 0; --bit) bits += static_cast<char>('0' + ((value >> bit) & 1));
  }
  const std::size_t start = bits.find('1');
  return start == std::string::npos ? "" : bits.substr(start + 2, payload_bits);
}

const Seen& undamaged() {
  static const Seen seen = seen_with({});
  return seen;
}

// Whether a cycle is read as without faults.
void expect_others_unchanged(const Seen& seen, std::size_t from = struck) {
  ASSERT_EQ(seen.rows.size(), cycles);
  for (std::size_t i = 0; i < cycles; ++i) {
    if (i >= from && i < from + (from == struck ? 1 : cycles)) continue;
    EXPECT_EQ(payload_of(seen.rows[i]), payload_of(undamaged().rows[i])) << i;
    EXPECT_EQ(seen.truth[i].at("faults"), "");
    EXPECT_EQ(seen.truth[i].at("places"), "");
  }
}

std::string place_text(const std::string& unit, unsigned number) {
  return unit + "=" + std::to_string(number);
}

TEST(FaultPlace, FlippedBit_IsThatBitForEveryBit) {
  ASSERT_EQ(undamaged().rows.size(), cycles);
  std::string wanted = payload_of(undamaged().rows[struck]);
  ASSERT_EQ(wanted.size(), payload_bits);
  for (unsigned bit = 0; bit < payload_bits; ++bit) {
    SCOPED_TRACE(bit);
    const Seen seen = seen_with({"--fault", "flip@3,bit=" + std::to_string(bit)});
    std::string flipped = wanted;
    flipped[bit] = flipped[bit] == '0' ? '1' : '0';
    EXPECT_EQ(payload_of(seen.rows[struck]), flipped);
    EXPECT_EQ(seen.truth[struck].at("faults"), "flip");
    EXPECT_EQ(seen.truth[struck].at("places"), "flip@bit=" + std::to_string(bit));
    expect_others_unchanged(seen);
  }
}

TEST(FaultPlace, Burst_BeginsAtThatBit) {
  const std::string wanted = payload_of(undamaged().rows[struck]);
  for (unsigned bit = 0; bit + 1 < payload_bits; ++bit) {
    const Seen seen = seen_with({"--fault", "burst@3," + place_text("bit", bit)});
    const std::string got = payload_of(seen.rows[struck]);
    ASSERT_EQ(got.size(), wanted.size());
    const auto differs = std::mismatch(got.begin(), got.end(), wanted.begin()).first;
    EXPECT_EQ(differs - got.begin(), static_cast<std::ptrdiff_t>(bit));
    EXPECT_GE(std::count_if(wanted.begin(), wanted.end(),
                            [&, i = 0U](char c) mutable { return got[i++] != c; }),
              2);
    EXPECT_EQ(seen.truth[struck].at("places"), "burst@" + place_text("bit", bit));
  }
}

TEST(FaultPlace, StuckLine_SpoilsFromThatBitOn) {
  const std::string wanted = payload_of(undamaged().rows[struck]);
  for (const auto& [kind, level] :
       {std::pair{"slo_low", '0'}, std::pair{"slo_high", '1'}, std::pair{"cut", '1'}}) {
    for (unsigned bit = 0; bit < payload_bits; ++bit) {
      SCOPED_TRACE(std::string(kind) + " at bit " + std::to_string(bit));
      const Seen seen = seen_with({"--fault", std::string(kind) + "@3," + place_text("bit", bit)});
      std::string stuck = wanted;
      std::fill(stuck.begin() + bit, stuck.end(), level);
      EXPECT_EQ(payload_of(seen.rows[struck]), stuck);
      EXPECT_EQ(seen.truth[struck].at("places"), std::string(kind) + "@" + place_text("bit", bit));
      for (std::size_t i = 0; i < struck; ++i) {
        EXPECT_EQ(payload_of(seen.rows[i]), payload_of(undamaged().rows[i]));
      }
    }
  }
}

TEST(FaultPlace, LostClock_LetsTheBitBeforeItCountTwice) {
  // ACK takes 6 clocks of 500 ns, so bit 0 comes with clock 9.
  constexpr unsigned data_clock = 9;
  const std::string wanted = payload_of(undamaged().rows[struck]);
  for (unsigned bit = 1; bit < payload_bits; ++bit) {
    SCOPED_TRACE(bit);
    const Seen seen =
        seen_with({"--fault", "lost_clock@3," + place_text("clock", data_clock + bit)});
    std::string slipped = wanted;
    slipped.insert(bit, 1, wanted[bit - 1]);
    slipped.pop_back();
    EXPECT_EQ(payload_of(seen.rows[struck]), slipped);
    EXPECT_EQ(seen.truth[struck].at("places"),
              "lost_clock@" + place_text("clock", data_clock + bit));
  }
}

// Edges of MA from `begin` ns on, relative to it in clocks of 500 ns.
std::vector<double> ma_edges(const Seen& seen, double begin, double end) {
  std::vector<double> clocks;
  std::string level;
  for (const Row& row : seen.edges) {
    const double time = std::stod(row.at("time_ns"));
    const std::string& now = row.at("MA");
    const bool changed = !now.empty() && now != level;
    if (changed) level = now;
    if (changed && time >= begin && time < end) clocks.push_back((time - begin) / 500);
  }
  return clocks;
}

TEST(FaultPlace, GlitchAndStuckMa_AreOnTheWireWhereToldToBe) {
  const double begin = std::stod(undamaged().truth[struck].at("time_ns"));
  const double end = std::stod(undamaged().truth[struck + 1].at("time_ns"));
  const std::vector<double> whole = ma_edges(undamaged(), begin, end);
  for (const double clock : {0.2, 12.25, 30.75}) {
    SCOPED_TRACE(clock);
    std::string text = std::to_string(clock);
    while (text.back() == '0') text.pop_back();
    const Seen seen = seen_with({"--fault", "glitch_ma@3,clock=" + text});
    std::vector<double> added;
    const std::vector<double> edges = ma_edges(seen, begin, end);
    std::set_difference(edges.begin(), edges.end(), whole.begin(), whole.end(),
                        std::back_inserter(added));
    ASSERT_GE(added.size(), 2U);
    EXPECT_DOUBLE_EQ(added[0], clock);
    EXPECT_GE(added[1] - added[0], 0.02);
    EXPECT_LE(added[1] - added[0], 0.12001);
    EXPECT_EQ(seen.truth[struck].at("places"), "glitch_ma@clock=" + text);
    const Seen stuck = seen_with({"--fault", "ma_high@3,clock=" + text});
    for (const double edge : ma_edges(stuck, begin, end)) EXPECT_LE(edge, clock);
    EXPECT_EQ(stuck.truth[struck].at("places"), "ma_high@clock=" + text);
  }
}

TEST(FaultPlace, IdleGlitch_LiesBehindTheFrame) {
  const double begin = std::stod(undamaged().truth[struck].at("time_ns"));
  const std::size_t frame = ma_edges(undamaged(), begin, begin + 500 * 50).size() / 2;
  const std::string text = place_text("clock", static_cast<unsigned>(frame) + 3) + ".5";
  const Seen seen = seen_with({"--fault", "glitch_ma_idle@3," + text});
  const std::vector<double> edges = ma_edges(seen, begin, begin + 500 * 60);
  EXPECT_NE(std::find(edges.begin(), edges.end(), static_cast<double>(frame) + 3.5), edges.end());
  EXPECT_EQ(seen.truth[struck].at("places"), "glitch_ma_idle@" + text);
  EXPECT_EQ(seen.rows[struck].at("raw"), undamaged().rows[struck].at("raw"));
}

TEST(FaultPlace, DrawnPlace_IsToldAndGivenBackDoesTheSame) {
  const Seen drawn = seen_with({"--fault", "flip@3", "--fault", "slo_low@5", "--seed", "9"});
  const std::string flip = drawn.truth[struck].at("places");
  const std::string stuck = drawn.truth[5].at("places");
  ASSERT_TRUE(flip.starts_with("flip@bit=")) << flip;
  ASSERT_TRUE(stuck.starts_with("slo_low@clock=")) << stuck;
  const Seen given = seen_with({"--fault", "flip@3," + flip.substr(5), "--seed", "9"});
  EXPECT_EQ(given.rows[struck].at("raw"), drawn.rows[struck].at("raw"));
  EXPECT_EQ(given.truth[struck].at("places"), flip);
}

TEST(FaultPlace, NamedCycle_ComesBeforeTheRate) {
  const Seen seen = seen_with({"--fault", "flip:1", "--fault", "flip@3,bit=29"});
  EXPECT_EQ(seen.truth[struck].at("places"), "flip@bit=29");
  EXPECT_NE(seen.truth[struck + 1].at("places"), "");
}

TEST(FaultPlace, PlaceThatIsNotThere_IsWrongUsageAndWritesNothing) {
  const Folder folder;
  for (const auto& [fault, part] : std::vector<std::pair<std::string, std::string>>{
           {"flip@3,bit=34", "bit 0 to 33"},
           {"swap_ma@3,clock=4", "has no place"},
           {"no_answer:0.1,bit=4", "has no place"},
           {"extra_clock@3,bit=4", "takes a clock"},
           {"cut@3,clock=400", "on this line it takes clock 0 to "},
           {"flip@100", "no cycle 100"},
           {"flip@3,bit=x", "is not KIND:RATE"}}) {
    EXPECT_THAT(run("simulate -f resolute-26 --fault {} -o {} --truth {}", fault,
                    folder.path("line.vcd"), folder.path("truth.csv")),
                fails(2, part))
        << fault;
    EXPECT_EQ(folder.files(), 0U);
  }
}

}  // namespace biss::verbs::fault_place_test
