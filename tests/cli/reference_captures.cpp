#include "tests/cli/reference_captures.hpp"

#include "tests/cli/run_command.hpp"

namespace biss::verbs {
namespace {

struct Known {
  std::string name;
  std::string format;
  double line_delay_ns;
  std::vector<std::string> simulated_by;
};

// The line delays, clocks and faults of the recorded captures.
const std::vector<Known>& known_captures() {
  static const std::vector<Known> all{
      {"hardware_32bit_1MHz",
       "pos32,nE,nW,crc6",
       112,
       {"--clock", "1MHz", "--ma-delay", "56ns", "--slo-delay", "56ns", "--cycles", "1"}},
      {"cores_26bit_1MHz",
       "pos26,nE,nW,crc6",
       8.5,
       {"--clock", "1MHz", "--ma-delay", "4ns", "--slo-delay", "4.5ns", "--cycles", "40"}},
      {"cores_26bit_10MHz_delay200ns",
       "pos26,nE,nW,crc6",
       213.75,
       {"--clock", "10MHz", "--ma-delay", "110ns", "--slo-delay", "103.75ns", "--fault", "nE@10",
        "--fault", "nW@11", "--fault", "flip@9,bit=5", "--fault", "flip@13", "--at-slave",
        "--cycles", "32"}}};
  return all;
}

std::vector<ReferenceFrame> simulate(const Known& known, const std::string& path) {
  std::vector<ReferenceFrame> frames;
  for (const char* extension : {".vcd", ".csv"}) {
    const Words arguments("simulate -f {} -o {} --truth - --motion random", known.format,
                          path + extension);
    frames.clear();
    for (const Row& row : rows_of(run_ok(arguments + known.simulated_by).out)) {
      frames.push_back({.time_ns = std::stod(row.at("time_ns")),
                        .position = std::stoull(row.at("position")),
                        .nE = row.at("nE"),
                        .nW = row.at("nW"),
                        .good = row.at("faults") != "flip"});
    }
  }
  return frames;
}

std::vector<ReferenceFrame> recorded(const std::string& path) {
  std::vector<ReferenceFrame> frames;
  for (const Row& row : rows_of(content_of(path + ".truth.csv"))) {
    frames.push_back({.time_ns = std::stod(row.at("t_first_ma_fall_ns")),
                      .ack_clocks = std::stod(row.at("ack_clocks")),
                      .position = std::stoull(row.at("position_hex"), nullptr, 16),
                      .nE = row.at("nE"),
                      .nW = row.at("nW"),
                      .good = row.at("crc_ok_on_wire") == "1"});
  }
  return frames;
}

}  // namespace

const std::vector<ReferenceCapture>& reference_captures() {
  static const Folder folder;
  static const std::vector<ReferenceCapture> all = [] {
    const char* const shared = std::getenv("BISS_SHARED");
    std::vector<ReferenceCapture> captures;
    for (const Known& known : known_captures()) {
      const std::string path = shared != nullptr
                                   ? std::string(shared) + "/data/captures/" + known.name
                                   : folder.path(known.name);
      captures.push_back({path, known.format, known.line_delay_ns,
                          shared != nullptr ? recorded(path) : simulate(known, path)});
      EXPECT_FALSE(captures.back().frames.empty()) << path;
    }
    return captures;
  }();
  return all;
}

}  // namespace biss::verbs
