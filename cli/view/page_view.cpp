#include "cli/view/page_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace biss::cli {

namespace {

// Of the server, or always in the page.
constexpr std::array<std::string_view, 6> not_of_decode{"FILE",   "--follow", "--no-open",
                                                        "--port", "--page",   "--velocity"};

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                       std::string_view("-._~").find(c) != std::string_view::npos;
    result += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return result;
}

class View {
 public:
  void put(std::string_view name, std::string_view value) {
    text_ += fmt::format("{}{}={}", text_.empty() ? "" : "&", name, escaped(value));
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace

std::string quoted_word(const std::string& word) {
  if (!word.empty() && word.find_first_of(" \t\r\n'\"") == std::string::npos) return word;
  std::string quoted = "\"";
  for (const char c : word) quoted += c == '"' ? "\"'\"'\"" : std::string(1, c);
  return quoted + '"';
}

std::string page_view(const std::vector<Option>& given) {
  View view;
  std::string invert;
  std::string further;
  const auto join = [](std::string& list, char separator, const std::string& more) {
    if (!list.empty()) list += separator;
    list += more;
  };
  for (const Option& option : given) {
    const std::string name = option.name();
    const std::vector<std::string> values = option.values();
    const std::string first = values.empty() ? "" : values.front();
    if (std::find(not_of_decode.begin(), not_of_decode.end(), name) != not_of_decode.end())
      continue;
    if (name == "--format" || name == "--ma" || name == "--slo") {
      view.put(name.substr(2), first);
    } else if (name == "--scale" && (first == "deg" || first == "mm")) {
      view.put("units", first);
    } else if (name == "--invert-ma" || name == "--invert-slo") {
      join(invert, ',', name.substr(9));
    } else {
      join(further, ' ', name);
      // CLI11 notes a flag as one that is true.
      if (values == std::vector<std::string>{"true"}) continue;
      for (const std::string& value : values) join(further, ' ', quoted_word(value));
    }
  }
  if (!invert.empty()) view.put("invert", invert);
  if (!further.empty()) view.put("further", further);
  return view.text();
}

}  // namespace biss::cli
