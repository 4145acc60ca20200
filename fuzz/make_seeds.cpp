// make_seeds FOLDER: writes valid inputs, one folder per target, identical on every machine.
#include <filesystem>
#include <fstream>
#include <random>

#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/dump_text.hpp"
#include "fuzz/frame_formats.hpp"
#include "fuzz/register_seeds.hpp"

namespace {

// The bits of a frame of that format with random position and ACK; every fourth frame is damaged.
// With `lead_clocks` 0 there are a few leading ones.
std::string frame_bytes(std::size_t format_number, std::uint64_t seed,
                        std::uint16_t lead_clocks = 0) {
  std::mt19937_64 random(seed);
  const biss::PlainCodec codec(*biss::parse_format(biss::fuzz::frame_formats[format_number]));
  biss::Frame frame;
  frame.channel_count = codec.format().channel_count;
  frame.lead_clocks = static_cast<std::uint16_t>(2 + random() % 4);
  if (lead_clocks != 0) frame.lead_clocks = lead_clocks;
  frame.ack_clocks = static_cast<std::uint16_t>(1 + random() % 20);
  for (std::size_t k = 0; k < frame.channel_count; ++k) {
    const biss::ChannelFormat& channel = codec.format().channel_list[k];
    frame.channel_list[k].position = random() & biss::low_mask(channel.position_bits());
    frame.channel_list[k].life_counter =
        static_cast<std::uint32_t>(random() & biss::low_mask(channel.life_counter.bits));
  }
  biss::FrameBits bits = *encode_frame(frame, codec);
  if (seed % 4 == 3) bits.flip(random() % bits.size_bits());
  const auto bytes = bits.bytes();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A setup that takes these frames: 10 MHz, up to two clocks of line delay, all clocks sent.
std::string spi_header(std::size_t format_number) {
  constexpr char rising_and_8_quarters = (8 << 3) | 1;
  constexpr char ack_clocks = 100;
  return {static_cast<char>(format_number),
          '\0',
          '\0',
          rising_and_8_quarters,
          '\0',
          ack_clocks,
          '\4',
          '\0'};
}

// A master that accepts these frames, followed by the script: compensation, a clock of 90 ns, any
// line delay up to 12 clocks.
std::string master_header(std::size_t format_number, std::uint64_t seed) {
  constexpr char compensated_script = 1 | 8;
  constexpr char ack_half_clocks = 60;
  constexpr char delay_max_half_clocks = 80;
  return {static_cast<char>(format_number),
          '\2',
          compensated_script,
          ack_half_clocks,
          '\0',
          '\0',
          delay_max_half_clocks,
          static_cast<char>(seed % 100)};
}

// A slave of any timing, and a request of 20 to 83 clocks.
std::string slave_train(std::size_t format_number, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::string train{static_cast<char>(format_number)};
  for (int i = 0; i < 5; ++i) train += static_cast<char>(random() % 256);
  constexpr char half_a_period_and_turn_ma = 4 | 64;
  return train + std::string(2 * (20 + seed), half_a_period_and_turn_ma);
}

// A request of 20 to 83 clocks with some changes of SLO at rising edges; then a pause and another
// request.
std::string replay_train(std::size_t format_number, std::uint64_t seed) {
  constexpr char half_a_period = 4;
  constexpr char turn_both = 3 << 5;
  constexpr char pause = 29;
  std::mt19937_64 random(seed);
  std::string train{static_cast<char>(format_number)};
  for (int i = 0; i < 4; ++i) train += static_cast<char>(random() % 256);
  for (int request = 0; request < 2; ++request) {
    for (std::uint64_t clock = 0; clock < 20 + seed; ++clock) {
      train += half_a_period;
      train += static_cast<char>(half_a_period | (random() % 4 == 0 ? turn_both : 0));
    }
    train += pause;
  }
  return train;
}

// A monitored encoder: good frames until the state is safe, then an event every few frames.
std::string safety_story(std::uint64_t seed) {
  constexpr char good_run = 1;
  std::mt19937_64 random(seed);
  std::string story{'\0', static_cast<char>(seed), static_cast<char>(2 * seed), '\x81'};
  for (int i = 0; i < 16; ++i) {
    story += good_run;
    story += static_cast<char>(i == 0 ? 90 : random() % 8);
    story += static_cast<char>(random() % 256);
    story += static_cast<char>(random() % 256);
  }
  return story;
}

// Any bytes are a line.
std::string line_story(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::string story;
  for (int i = 0; i < 160; ++i) story += static_cast<char>(random() & 0xFFU);
  return story;
}

// A format, and frames whose positions move by small steps; every eighth has a fate of its own.
std::string find_format_story(std::uint64_t seed) {
  constexpr std::size_t header_bytes = 12;
  std::mt19937_64 random(seed);
  std::string story{static_cast<char>(seed)};
  while (story.size() < header_bytes) story += static_cast<char>(random() % 256);
  for (std::uint64_t frame = 0; frame < 12 + seed % 20; ++frame) {
    story += '\0';
    story += static_cast<char>(random() % 64);
    story += static_cast<char>(random() % 8 == 0 ? random() % 256 : 0);
  }
  return story;
}

// The state of a campaign, as its command writes it.
std::string campaign_state(std::uint64_t seed) {
  const std::uint64_t wrong = seed % 5;
  const std::string missed = wrong == 0 ? "" : wrong == 1 ? "7" : "7,65537";
  const std::string counts =
      R"("both":[[6,3],[9,1]],"cpw":[[3,40],[4,9]],"monitor":[[9,8]],"spw":[],"wrong":[[9,)" +
      std::to_string(std::min<std::uint64_t>(wrong, 2)) + "]]";
  const std::string frames = std::to_string(131'072 + 100 * (seed % 2));
  return R"({"biss_campaign":2,"faults":[{"accepted":{)" + counts +
         R"(},"blocks":[[0,2]],"fault":"flips:0.1","fitted":[],"frames":131072,"missed":[)" +
         missed + R"(]},{"accepted":{"both":[],"cpw":[],"monitor":[],"spw":[],"wrong":[]},)" +
         R"("blocks":[[1,2]],"fault":"flips:0.1:fitting","fitted":[["monitor",0,2,6,9],)" +
         R"(["wrong",0,2,6,1]],"frames":65536,"missed":[65600]}],"format":"rxm","frames":)" +
         frames + R"(,"rules":"","seed":)" + std::to_string(seed) + "}\n";
}

struct Target {
  const char* name;
  // An input for the format with the number `k` in frame_formats; empty: none.
  std::string (*make)(std::uint64_t seed, std::size_t k);
};

using namespace biss::fuzz;
using Seed = std::uint64_t;

constexpr Target targets[] = {
    {"format", [](Seed seed, auto k) { return std::string(seed == k ? frame_formats[k] : ""); }},
    {"decode_frame",
     [](Seed seed, auto k) {
       return std::string{static_cast<char>(k), '\0', '\0'} + frame_bytes(k, seed);
     }},
    {"spi", [](Seed seed, auto k) { return spi_header(k) + frame_bytes(k, seed); }},
    {"master", [](Seed seed, auto k) { return master_header(k, seed) + frame_bytes(k, seed, 1); }},
    {"slave", [](Seed seed, auto k) { return slave_train(k, seed); }},
    {"replay", [](Seed seed, auto k) { return replay_train(k, seed); }},
    {"eds", [](Seed seed, auto) { return eds_seed(seed); }},
    {"dump", [](Seed seed, auto) { return std::string(2, '\0') + dump_file_seed(seed); }},
    {"session", [](Seed seed, auto) { return session_seed(seed); }},
    {"server", [](Seed seed, auto) { return server_seed(seed); }},
    {"configure", [](Seed seed, auto) { return configure_seed(seed); }},
    {"listener", [](Seed seed, auto) { return listener_seed(seed); }},
    {"safety", [](Seed seed, auto) { return safety_story(seed); }},
    {"campaign", [](Seed seed, auto) { return campaign_state(seed); }},
    {"find_format", [](Seed seed, auto) { return find_format_story(seed); }},
    {"clean_cycles", [](Seed seed, auto) { return line_story(seed); }},
    {"flow", [](Seed seed, auto) { return line_story(seed); }},
};

// Writes the inputs into a folder of this name, and numbers them.
void write_seeds(const std::filesystem::path& folder, const auto& make) {
  constexpr std::uint64_t seeds_a_target = 64;
  std::filesystem::create_directories(folder);
  for (std::uint64_t seed = 0; seed < seeds_a_target; ++seed) {
    const std::string input = make(seed);
    if (!input.empty()) std::ofstream(folder / std::to_string(seed), std::ios::binary) << input;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path root = argv[1];
  for (const CaptureSeed& each : capture_seeds) write_seeds(root / each.target, each.make);
  for (const Target& each : targets) {
    write_seeds(root / each.name,
                [&](Seed seed) { return each.make(seed, seed % frame_formats.size()); });
  }
  return 0;
}
