#include "tests/timing/feature.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace timing_test {

namespace {

using oracle::Line;
using oracle::Time;

constexpr Time nanosecond = 1000;

[[noreturn]] void refuse(const std::string& what) { throw std::runtime_error(what); }

template <class Number>
Number next(std::istream& in, const char* what) {
  Number number{};
  if (!(in >> number)) refuse(std::string("no ") + what);
  return number;
}

std::vector<Time> times_of(std::istream& in) {
  std::vector<Time> times;
  std::string word;
  while (in >> word) {
    const bool relative = word[0] == '+';
    const std::size_t star = word.find('*');
    const long count = star == std::string::npos ? 1 : std::stol(word.substr(star + 1));
    const Time time = std::stoll(word.substr(relative ? 1 : 0)) * nanosecond;
    for (long i = 0; i < count; ++i) {
      times.push_back(relative && !times.empty() ? times.back() + time : time);
    }
  }
  if (!std::is_sorted(times.begin(), times.end())) refuse("times are not in order");
  return times;
}

Line line_of(const std::vector<Time>& times) {
  Line line;
  for (const Time time : times) line.push_back({time, line.size() % 2 == 1});
  return line;
}

oracle::TimeoutKind kind_of(const std::string& word) {
  if (word == "adaptive") return oracle::TimeoutKind::adaptive;
  if (word == "fixed") return oracle::TimeoutKind::fixed;
  if (word == "cycle") return oracle::TimeoutKind::cycle;
  refuse("'" + word + "' is not a kind of timeout");
}

Device device_of(std::istream& in, bool chained) {
  Device device;
  device.timing.chained = chained;
  std::string key;
  const auto time = [&] { return next<Time>(in, "time") * nanosecond; };
  while (in >> key) {
    if (key == "pos") {
      device.position_bits = next<unsigned>(in, "bits");
    } else if (key == "crc") {
      device.crc_bits = next<unsigned>(in, "bits");
    } else if (key == "position") {
      device.position = next<std::uint64_t>(in, "position");
    } else if (key == "sampling") {
      device.timing.sampling = time();
    } else if (key == "start") {
      device.timing.start_min = time();
    } else if (key == "ready") {
      device.timing.ready = time();
    } else if (key == "ack") {
      device.timing.ack_clocks = next<std::size_t>(in, "clocks");
    } else if (key == "busy") {
      device.timing.busy_clocks = next<std::size_t>(in, "clocks");
    } else if (key == "timeout") {
      device.timing.kind = kind_of(next<std::string>(in, "kind"));
      device.timing.timeout = time();
    } else if (key == "static") {
      device.timing.static_timeout = time();
    } else {
      refuse("a slave has no '" + key + "'");
    }
  }
  return device;
}

void read_cdm(std::istream& in, std::vector<oracle::Change>& cdm) {
  Time time = 0;
  while (in >> time) cdm.push_back({time * nanosecond, next<int>(in, "bit") != 0});
}

void read_marks(std::istream& in, std::vector<Mark>& marks) {
  Mark mark{next<Time>(in, "time") * nanosecond, {}};
  std::getline(in >> std::ws, mark.name);
  marks.push_back(mark);
}

void read_pieces(std::istream& in, std::vector<Piece>& pieces) {
  Time from = 0;
  while (in >> from) {
    const Time to = next<Time>(in, "end") * nanosecond;
    pieces.push_back({from * nanosecond, to, next<Time>(in, "step") * nanosecond});
  }
}

void read_line(const std::string& line, Feature& feature) {
  std::istringstream in(line);
  const auto key = next<std::string>(in, "word");
  const auto number = [&] { return next<std::size_t>(in, "slave"); };
  if (key == "feature") {
    std::getline(in >> std::ws, feature.heading);
  } else if (key == "text") {
    std::string text;
    std::getline(in >> std::ws, text);
    feature.text += text + "\n";
  } else if (key == "slave") {
    auto& chain = feature.scenario.chain;
    chain.push_back(device_of(in, !chain.empty()));
  } else if (key == "ma") {
    feature.scenario.ma = line_of(times_of(in));
  } else if (key == "slo") {
    Line& slo = feature.slo[number()];
    slo = line_of(times_of(in));
  } else if (key == "sample") {
    auto& samples = feature.samples[number()];
    samples = times_of(in);
  } else if (key == "cdm") {
    read_cdm(in, feature.cdm[number()]);
  } else if (key == "mark") {
    read_marks(in, feature.marks);
  } else if (key == "draw") {
    read_pieces(in, feature.pieces);
  } else {
    refuse("'" + key + "' begins no line");
  }
}

Feature read_feature(const std::filesystem::path& path) {
  Feature feature;
  feature.file = path.filename().string();
  std::ifstream file(path);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty()) continue;
    try {
      read_line(line, feature);
    } catch (const std::exception& error) {
      refuse(feature.file + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  if (feature.scenario.chain.empty() || feature.slo.size() != feature.scenario.chain.size()) {
    refuse(feature.file + ": not every slave has its SLO");
  }
  return feature;
}

}  // namespace

std::vector<Feature> read_features(const std::string& folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".txt") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Feature> features;
  for (const auto& path : paths) features.push_back(read_feature(path));
  return features;
}

}  // namespace timing_test
