#include "capture/sr_metadata.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "capture/decimal.hpp"

namespace biss::capture {
namespace {

constexpr unsigned max_probes = 8 * max_unit_bytes;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

// Key files write what could not stand there as \s, \n, \t, \r and doubled backslashes.
constexpr std::array<std::pair<char, char>, 5> escapes{
    {{'s', ' '}, {'n', '\n'}, {'t', '\t'}, {'r', '\r'}, {'\\', '\\'}}};

std::string unescaped(std::string_view value) {
  std::string text;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto* const escape = std::find_if(escapes.begin(), escapes.end(), [&](const auto& e) {
      return value[i] == '\\' && i + 1 < value.size() && value[i + 1] == e.first;
    });
    if (escape != escapes.end()) ++i;
    text += escape != escapes.end() ? escape->second : value[i];
  }
  return text;
}

std::string escaped(std::string_view text) {
  std::string value;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto* const escape = std::find_if(escapes.begin(), escapes.end(),
                                            [&](const auto& e) { return text[i] == e.second; });
    // Blanks inside stand as they are.
    const bool plain = text[i] == ' ' && i != 0 && i + 1 != text.size();
    if (escape == escapes.end() || plain) {
      value += text[i];
    } else {
      value += {'\\', escape->first};
    }
  }
  return value;
}

std::optional<unsigned> whole_number(std::string_view text) {
  unsigned number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

class MetadataParser {
 public:
  std::variant<SrMetadata, CaptureError> parse(std::string_view text) {
    while (!text.empty() && !done_) {
      ++line_;
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string_view row = trimmed(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
      if (row.empty() || row.front() == '#' || row.front() == ';') continue;
      if (!take_row(row)) return error_;
    }
    if (!done_ && !complete()) return error_;
    return std::move(found_);
  }

 private:
  bool wrong(const char* expected) {
    error_ = {.cause = CaptureCause::malformed,
              .line = line_,
              .column = 1,
              .expected = expected,
              .part = "metadata"};
    return false;
  }

  bool take_row(std::string_view row) {
    if (row.front() == '[') {
      if (in_device_ && !found_.capture_file.empty()) return done_ = complete();
      in_device_ = row.starts_with("[device ") && row.back() == ']';
      found_ = {};
      probes_.clear();
      has_unit_ = false;
      return true;
    }
    const std::size_t equals = row.find('=');
    if (equals == std::string_view::npos) return wrong("[section] or key=value");
    if (!in_device_) return true;
    return take_key(trimmed(row.substr(0, equals)), trimmed(row.substr(equals + 1)));
  }

  bool take_key(std::string_view key, std::string_view value) {
    if (key == "capturefile") {
      found_.capture_file = unescaped(value);
    } else if (key == "samplerate") {
      found_.layout.rate = parse_sample_rate(value);
      if (found_.layout.rate.count == 0) return wrong("a sample rate of 1 Hz to 4.29 GHz");
    } else if (key == "unitsize") {
      const auto bytes = whole_number(value);
      if (!bytes || *bytes < 1 || *bytes > max_unit_bytes) return wrong("a unitsize of 1 to 8");
      found_.layout.unit_bytes = *bytes;
      has_unit_ = true;
    } else if (key.starts_with("probe")) {
      const auto number = whole_number(key.substr(5));
      if (!number || *number < 1 || *number > max_probes) return wrong("probe1 to probe64");
      probes_[*number] = unescaped(value);
    }
    return true;
  }

  // The device's section has ended: everything must be there, and the probes lie in the sample.
  bool complete() {
    RawLayout& layout = found_.layout;
    if (found_.capture_file.empty()) return wrong("a device with a capturefile of logic samples");
    if (layout.rate.count == 0) return wrong("the samplerate of the device");
    if (!has_unit_) return wrong("the unitsize of the device");
    for (const auto& [number, name] : probes_) layout.lines.push_back({name, number - 1});
    if (layout.lines.empty()) return wrong("the names of the device's probes");
    if (fault_of(layout) != nullptr) return wrong("no more probes than unitsize has bits");
    return true;
  }

  SrMetadata found_;
  std::map<unsigned, std::string> probes_;
  bool in_device_ = false;
  bool has_unit_ = false;
  bool done_ = false;
  std::uint64_t line_ = 0;
  CaptureError error_;
};

}  // namespace

std::variant<SrMetadata, CaptureError> parse_sr_metadata(std::string_view text) {
  return MetadataParser().parse(text);
}

Hertz parse_sample_rate(std::string_view text) {
  text = trimmed(text);
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  std::string unit(trimmed(text.substr(digits)));
  for (char& c : unit) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  if (unit.ends_with("hz")) unit.resize(unit.size() - 2);
  int scale = 0;
  if (unit == "k") scale = 3;
  if (unit == "m") scale = 6;
  if (unit == "g") scale = 9;
  if (scale == 0 && !unit.empty()) return {};
  const auto rate = parse_decimal(text.substr(0, digits), scale);
  if (!rate.ok() || *rate > std::numeric_limits<std::uint32_t>::max()) return {};
  return {static_cast<std::uint32_t>(*rate)};
}

std::string sr_metadata_text(const RawLayout& layout) {
  constexpr std::array<std::pair<std::uint32_t, const char*>, 4> units{
      {{1'000'000'000, " GHz"}, {1'000'000, " MHz"}, {1'000, " kHz"}, {1, " Hz"}}};
  const auto* const unit = std::find_if(
      units.begin(), units.end(), [&](const auto& u) { return layout.rate.count % u.first == 0; });
  std::string text = "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\n";
  text += "total probes=" + std::to_string(layout.lines.size()) + '\n';
  text += "samplerate=" + std::to_string(layout.rate.count / unit->first) + unit->second + '\n';
  text += "total analog=0\n";
  for (const SampleLine& line : layout.lines) {
    text += "probe" + std::to_string(line.bit + 1) + '=' + escaped(line.name) + '\n';
  }
  return text + "unitsize=" + std::to_string(layout.unit_bytes) + '\n';
}

}  // namespace biss::capture
